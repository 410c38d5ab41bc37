//! `mrroc`: the operator's command.
//!
//! One file per subject: [`run`] couples the Master Process with a [`world`], [`observe`] measures,
//! records and draws, [`report`] tells a person, [`load`] counts what buses carry, [`commands`] is the command line itself.

mod commands;
mod dbc;
mod eds;
mod jsonl;
mod kin;
mod load;
mod monitor;
mod node;
mod observe;
mod plan;
mod record;
mod replay;
mod report;
mod robot;
mod run;
mod world;

use clap::Parser;
use clap::error::ErrorKind;
use commands::Cli;
use process::{End, exit};
use std::process::ExitCode;

const PROGRAM: &str = "mrroc";

fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => return told(&error),
    };
    match cli.run() {
        Ok(code) => ExitCode::from(code),
        Err(end) => end.tell(PROGRAM),
    }
}

/// What clap has to say: help in colour where there is any, a mistake in one line.
fn told(error: &clap::Error) -> ExitCode {
    let code = if !error.use_stderr() {
        exit::OK
    } else if error.kind() == ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand {
        exit::USAGE
    } else {
        return End::from(error).tell(PROGRAM);
    };
    let _ = error.print();
    ExitCode::from(code)
}
