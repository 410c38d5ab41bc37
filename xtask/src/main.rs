//! Every command of CI, typed: `cargo xtask <command>`.
//!
//! | module | one line |
//! |---|---|
//! | [`deps`] | who may import whom, and what the `no_std` crates must declare |
//! | [`lint`] | format, clippy, rustdoc and the text rules |
//! | [`text`] | what no file of the repository may contain |
//! | [`fault_pages`] | every fault code has its page, every page its code |
//! | [`no_std`] | the crates of the microcontroller, built for one |
//! | [`image`] | the image of a board, built |
//! | [`boards`] | the images of boards that one can buy |
//! | [`hil_qemu`] | the node as an image on an emulated microcontroller |
//! | [`mod@bench`] | what a step, a message and the main job cost |
//! | [`bench_motion`] | the motion planner beside other planners, fetched on demand |
//! | [`mod@vcan`] | the HIL suite over SocketCAN, on this kernel or one of its own |
//! | [`strangers`] | other people's tools against our programs |
//! | [`ci`] | every check above, the build, the main job and the tests |
//!
//! A command runs all of its checks, whatever fails on the way, and prints the failures last, one
//! line each. Exit code 0: all passed; 1: some failed; 2: wrong usage.

mod bench;
mod bench_motion;
mod boards;
mod ci;
mod deps;
mod fault_pages;
mod hil_qemu;
mod image;
mod lint;
mod no_std;
mod report;
mod shell;
mod strangers;
mod text;
#[cfg(target_os = "linux")]
mod vcan;

use clap::{Parser, Subcommand};
use report::Report;
use std::ffi::OsString;
use std::process::ExitCode;

/// Every command of CI, typed.
#[derive(Parser)]
#[command(name = "cargo xtask", version, disable_help_subcommand = true)]
struct Cli {
    #[command(subcommand)]
    command: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Check who imports whom
    Deps {
        /// Print the table as Markdown instead
        #[arg(long)]
        print: bool,
    },
    /// Check format, clippy, rustdoc and the text rules
    Lint,
    /// Check that fault codes and their pages agree
    Docs,
    /// Build the microcontroller's crates for a bare-metal target
    NoStd,
    /// Build the image of every board that one can buy and examine it: panics, heap, sizes
    Boards {
        /// Accept the figures
        #[arg(long)]
        bless: bool,
    },
    /// Run the node's image on an emulated microcontroller, in the loop with the simulated world
    ///
    /// The arguments are those of the comparison: --traces N, --task TASK.toml, --log, --bless; `-- --help`
    /// tells more. It needs qemu-system-arm and a C compiler.
    HilQemu {
        /// Passed to the comparison
        #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
        arguments: Vec<OsString>,
    },
    /// Measure what a step, a message and the main job cost
    Bench {
        /// Print one JSON object instead of a Markdown table
        #[arg(long)]
        json: bool,
    },
    /// Measure the motion planner beside Ruckig and rsruckig, fetched and built on demand
    ///
    /// The arguments are those of the comparison: --cases N (of each class, 20000), --classes
    /// R,T,S,N,H,E, --seed N, --axes N, --only correctness or cost, --json; `-- --help` tells more. It
    /// needs a C++ compiler, and valgrind to count instructions. Nothing of it is part of the build.
    BenchMotion {
        /// Passed to the comparison
        #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
        arguments: Vec<OsString>,
    },
    /// Run the HIL suite over SocketCAN, on this kernel or one of its own (Linux)
    #[cfg(target_os = "linux")]
    Vcan {
        /// Passed to the test harness: parts of names, for instance
        #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
        arguments: Vec<String>,
    },
    /// Run python-canopen, python-can and cantools against our programs (fetched; needs Python)
    Strangers,
    /// Run everything CI runs, in its order
    Ci,
}

fn main() -> ExitCode {
    let mut report = Report::default();
    match Cli::parse().command {
        Task::Deps { print: true } => print!("{}", deps::markdown()),
        Task::Deps { print: false } => report.run("deps", deps::check),
        Task::Lint => lint::run_all(&mut report),
        Task::Docs => report.run("docs", fault_pages::check),
        Task::NoStd => report.run("no-std", no_std::check),
        Task::Boards { bless } => report.run("boards", || boards::check(bless)),
        Task::HilQemu { arguments } => {
            report.run("hil-qemu", || hil_qemu::check(&arguments));
        }
        Task::Bench { json } => report.run("bench", || bench::run(json)),
        Task::BenchMotion { arguments } => {
            report.run("bench-motion", || bench_motion::run(&arguments));
        }
        #[cfg(target_os = "linux")]
        Task::Vcan { arguments } => report.run("vcan", || vcan::run(&arguments)),
        Task::Strangers => report.run("strangers", strangers::check),
        Task::Ci => ci::run_all(&mut report),
    }
    report.finish()
}

#[cfg(test)]
mod test {
    use super::Cli;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }
}
