//! Format, clippy, rustdoc and the text rules.

use crate::report::{Findings, Report};
use crate::shell::{cargo, root, run, run_cargo};
use crate::text;
use anyhow::Result;

/// Runs all of them.
pub(crate) fn run_all(report: &mut Report) {
    report.run("text", || text::check(&root()));
    report.run("format", || run_cargo(&["fmt", "--all", "--check"]));
    report.run("clippy", || {
        run_cargo(&[
            "clippy",
            "--workspace",
            "--all-targets",
            "--",
            "-D",
            "warnings",
        ])
    });
    report.run("rustdoc", rustdoc);
}

fn rustdoc() -> Result<Findings> {
    let arguments = ["doc", "--workspace", "--no-deps"];
    let flags = std::env::var("RUSTDOCFLAGS").unwrap_or_default();
    run(
        cargo(&arguments).env("RUSTDOCFLAGS", format!("{flags} -D warnings")),
        &arguments,
    )
}
