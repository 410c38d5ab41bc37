//! Collects the failures of every check, to print them last.

use anyhow::Result;
use std::process::ExitCode;

/// What a check found wrong: one line each; empty if nothing.
pub(crate) type Findings = Vec<String>;

/// The failures so far.
#[derive(Debug, Default)]
pub(crate) struct Report {
    failures: Vec<String>,
}

impl Report {
    /// Runs one check. An error is a failure of its own: a check that could not be done has not
    /// passed.
    pub(crate) fn run(&mut self, name: &str, check: impl FnOnce() -> Result<Findings>) {
        eprintln!("== {name}");
        match check() {
            Ok(findings) => {
                self.failures
                    .extend(findings.iter().map(|f| format!("{name}: {}", one_line(f))));
            }
            Err(error) => self
                .failures
                .push(format!("{name}: {}", one_line(&format!("{error:#}")))),
        }
    }

    /// Prints the failures, if any, and says how it went.
    pub(crate) fn finish(self) -> ExitCode {
        if self.failures.is_empty() {
            return ExitCode::SUCCESS;
        }
        eprintln!("\n{} failed:", self.failures.len());
        for failure in &self.failures {
            eprintln!("  {failure}");
        }
        ExitCode::FAILURE
    }
}

/// A finding takes one line, even if the message inside it does not.
fn one_line(message: &str) -> String {
    message
        .lines()
        .map(str::trim)
        .filter(|l| !l.is_empty())
        .collect::<Vec<_>>()
        .join(" / ")
}

#[cfg(test)]
mod test {
    use super::*;
    use anyhow::anyhow;

    #[test]
    fn every_check_runs_and_every_failure_is_kept_on_its_line() {
        let mut report = Report::default();
        report.run("a", || Err(anyhow!("first\n  second\n")));
        report.run("b", || Ok(vec![]));
        report.run("c", || Ok(vec!["x".into(), "y".into()]));
        assert_eq!(report.failures, ["a: first / second", "c: x", "c: y"]);
    }
}
