//! `mrroc`: the operator's command.
//!
//! One file per subject: [`run`] couples the Master Process with a [`world`], [`observe`] measures,
//! records and draws, [`report`] tells a person, [`commands`] is the command line itself.

mod commands;
mod kin;
mod monitor;
mod observe;
mod record;
mod report;
mod run;
mod world;

use clap::Parser;
use commands::Cli;
use std::io::Write;
use std::process::ExitCode;

fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => {
            let _ = error.print();
            return ExitCode::from(if error.use_stderr() {
                host::error::exit::USAGE
            } else {
                0
            });
        }
    };
    match cli.run() {
        Ok(code) => ExitCode::from(code),
        Err(error) => {
            let _ = writeln!(std::io::stderr(), "mrroc: {error}");
            ExitCode::from(error.exit_code())
        }
    }
}
