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
use clap::error::ErrorKind;
use commands::Cli;
use std::io::Write;
use std::process::ExitCode;

fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => return told(&error),
    };
    match cli.run() {
        Ok(code) => ExitCode::from(code),
        Err(error) => {
            let _ = writeln!(std::io::stderr(), "mrroc: {error}");
            ExitCode::from(error.exit_code())
        }
    }
}

/// What clap has to say: help and version as they are, a mistake in one line like every other.
fn told(error: &clap::Error) -> ExitCode {
    if !error.use_stderr() {
        let _ = error.print();
        return ExitCode::SUCCESS;
    }
    if error.kind() == ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand {
        let _ = error.print();
    } else {
        let line = one_line(&error.to_string());
        let _ = writeln!(std::io::stderr(), "mrroc: {line}");
    }
    ExitCode::from(host::error::exit::USAGE)
}

/// The message without its label, and without usage and hints that follow it.
fn one_line(text: &str) -> String {
    let text = text.strip_prefix("error: ").unwrap_or(text);
    let message = text.split("\n\nUsage:").next().unwrap_or(text);
    let message = message.split("\n\nFor more").next().unwrap_or(message);
    let words: Vec<&str> = message.split_whitespace().collect();
    words.join(" ") + "; --help tells more"
}

#[cfg(test)]
mod test {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn a_mistake_is_one_line() {
        for (arguments, line) in [
            (
                &["mrroc", "home"][..],
                "the following required arguments were not provided: <ROBOTS>...; --help tells more",
            ),
            (
                &["mrroc", "move", "irp6-track", "--joints=1", "--speed=NaN"],
                "invalid value 'NaN' for '--speed <SPEED>': expected a finite number; --help tells more",
            ),
        ] {
            let error = Cli::command().try_get_matches_from(arguments).unwrap_err();
            assert_eq!(one_line(&error.to_string()), line);
        }
    }
}
