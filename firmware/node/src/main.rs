//! `mrroc-node`: the controller node of one robot as a process, in real time.
//!
//! The node is [`firmware::Node`], the very same that runs on a microcontroller and in lock step;
//! here is only its rim: a clock, buses, and what people read.
//!
//! | module | one line |
//! |---|---|
//! | [`args`] | the command line |
//! | [`ports`] | the node's ports on real buses |
//! | [`answers`] | on a hub: waiting for drives whose answers are late |
//! | [`beat`] | the node's time: exact instants, whatever the operating system does |
//! | [`panel`] | the switch beside the node: path stop, then torque off |
//! | [`report`] | what the node says, in words and as JSON |
//! | [`printer`] | output that never blocks the servo loop |
//! | [`run`] | the loop |
#![forbid(unsafe_code)]

mod answers;
mod args;
mod beat;
mod panel;
mod ports;
mod printer;
mod report;
mod run;
mod state;

use std::process::ExitCode;

fn main() -> ExitCode {
    let result = args::parse(std::env::args_os()).and_then(|args| {
        // before there are threads
        args.priority.map_or(Ok(()), process::take_priority)?;
        run::run(&args)
    });
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(end) => end.tell("mrroc-node"),
    }
}
