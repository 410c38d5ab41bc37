//! What the parts that run again and again cost: a servo step of a node, a step of the Master
//! Process, a message, a frame.
//!
//! | module | one line |
//! |---|---|
//! | [`timing`] | how a piece of work is timed, or counted by an instrument around this process |
//! | [`capture`] | a real run of a simulated cell, its inputs kept |
//! | [`node`] | the inputs of a node given to a fresh node |
//! | [`master`] | the inputs of the Master Process given to a fresh one |
//! | [`wire`] | messages to frames and back |
//!
//! ```text
//! cargo bench -p mrroc-tests --bench cost              every workload, a JSON line each
//! cost --only node-csp-line                            one of them
//! cost --only node-csp-line --once                     its work done once, for an instrument
//! ```
//! What is replayed is checked: the frames sent must be those of the run, to the byte.

mod capture;
mod master;
mod node;
mod timing;
mod wire;

use std::process::ExitCode;
use timing::{Cost, Mode};

/// The names of the workloads, in the order in which they are reported.
const WORKLOADS: [&str; 11] = [
    "node-csp-hold",
    "node-csp-joints",
    "node-csp-line",
    "node-cst-original-line",
    "node-cst-feed-forward-line",
    "mp-step",
    "feedback-encode-decode-classic",
    "feedback-encode-decode-fd",
    "command-encode-decode-classic",
    "command-encode-decode-fd",
    "frame-exact-length",
];

fn main() -> ExitCode {
    let (mut only, mut mode) = (None, Mode::Time);
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--only" => only = arguments.next(),
            "--once" => mode = Mode::Once,
            "--list" => {
                for name in WORKLOADS {
                    println!("{name}");
                }
                return ExitCode::SUCCESS;
            }
            // what cargo passes to every bench
            "--bench" => {}
            other => {
                eprintln!("cost: unknown argument {other} (--only NAME, --once or --list)");
                return ExitCode::from(2);
            }
        }
    }
    if let Some(name) = only.as_deref().filter(|name| !WORKLOADS.contains(name)) {
        eprintln!("cost: there is no workload {name} (see --list)");
        return ExitCode::from(2);
    }
    for name in WORKLOADS {
        if only.as_deref().is_none_or(|only| only == name) {
            println!("{}", run(name, mode).json(name));
        }
    }
    ExitCode::SUCCESS
}

fn run(name: &str, mode: Mode) -> Cost {
    match name {
        "mp-step" => master::cost(mode),
        _ if name.starts_with("node-") => node::cost(name, mode),
        _ => wire::cost(name, mode),
    }
}
