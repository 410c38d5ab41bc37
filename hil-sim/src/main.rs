//! `mrroc-hil-sim`: drives and mechanics of robots as a process, in real time.

#![forbid(unsafe_code)]

mod command;

use std::process::ExitCode;

fn main() -> ExitCode {
    let result = command::args::parse(std::env::args_os()).and_then(|args| {
        // before there are threads
        args.priority.map_or(Ok(()), process::take_priority)?;
        command::run(&args)
    });
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(end) => end.tell("mrroc-hil-sim"),
    }
}
