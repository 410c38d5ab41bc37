//! What CI runs, in its order.

use crate::report::{Findings, Report};
use crate::shell::{cargo, cargo_stdout, run, run_cargo};
use crate::{boards, deps, fault_pages, hil_qemu, lint, no_std, strangers};
use anyhow::{Context, Result};
use serde_json::Value;
use std::process::Stdio;

/// The main job: two arms in one simulated cell.
const MAIN_JOB: &[&str] = &[
    "run",
    "--release",
    "--",
    "run",
    "tasks/two-arms.toml",
    "--json",
];

/// Runs everything. The tests come last, so that the runner's own closing line is the last line
/// of a good run.
pub(crate) fn run_all(report: &mut Report) {
    report.run("lock file", lock_file);
    report.run("deps", deps::check);
    report.run("docs", fault_pages::check);
    report.run("no-std", no_std::check);
    lint::run_all(report);
    report.run("release build", || {
        run_cargo(&["build", "--release", "-p", "mrroc"])
    });
    report.run("main job", main_job);
    report.run("boards", || boards::check(false));
    report.run("hil-qemu", || hil_qemu::check(&[]));
    #[cfg(target_os = "linux")]
    report.run("vcan", vcan);
    report.run("strangers", strangers::check);
    report.run("tests", || run_cargo(&["test", "--workspace"]));
}

/// `Cargo.lock` fits the manifests; every later command then uses what it says.
fn lock_file() -> Result<Findings> {
    let arguments = ["tree", "--locked", "--workspace", "--depth", "0"];
    run(cargo(&arguments).stdout(Stdio::null()), &arguments)
}

fn main_job() -> Result<Findings> {
    let summary = cargo_stdout(MAIN_JOB)?;
    print!("{summary}");
    judge(&summary)
}

/// The suite over `SocketCAN`, unless this is a user's computer that cannot run it.
#[cfg(target_os = "linux")]
fn vcan() -> Result<Findings> {
    match crate::vcan::obstacle() {
        Some(obstacle) if !crate::vcan::required() => {
            println!("skipped: {obstacle}");
            Ok(vec![])
        }
        _ => crate::vcan::run(&[]),
    }
}

/// The summary must be one JSON value that says `"ok": true`.
fn judge(summary: &str) -> Result<Findings> {
    let summary: Value = serde_json::from_str(summary).context("the summary is not JSON")?;
    Ok(match &summary["ok"] {
        Value::Bool(true) => vec![],
        other => vec![format!("the summary says \"ok\": {other}")],
    })
}

#[cfg(test)]
mod test {
    use super::judge;

    #[test]
    fn only_a_true_ok_is_good() {
        assert!(judge("{\"ok\":true,\"seed\":1}\n").unwrap().is_empty());
        for bad in ["{\"ok\":false}", "{\"ok\":\"true\"}", "{}", "[]"] {
            assert_eq!(judge(bad).unwrap().len(), 1, "{bad}");
        }
        assert!(judge("").is_err());
        assert!(judge("running\n{\"ok\":true}").is_err());
    }
}
