//! The motion planner beside other planners: `cargo xtask bench-motion`.
//!
//! What it is compared with, Ruckig (C++) and rsruckig, is no dependency of the product: `xtask/peers`
//! is a package of its own, outside the workspace and its lock file. This fetches what that package
//! needs, builds it and runs it. It needs a C++ compiler with C++20, and, to count instructions,
//! valgrind; on Linux or another POSIX system.
//!
//! ```text
//! cargo xtask bench-motion                                   20 000 cases of each class, and cost
//! cargo xtask bench-motion --cases 1000000                   the full run
//! cargo xtask bench-motion --classes R,T --only cost --json
//! cargo xtask bench-motion -- --help                         all arguments
//! ```
//!
//! The same package has an oracle, which says what Ruckig says to generated cases, a line of JSON each:
//! `cargo run --release --bin oracle -- --class S --count 1000` in `xtask/peers`.

use crate::bench::built;
use crate::report::Findings;
use crate::shell::{cargo, root};
use anyhow::{Context, Result};
use std::ffi::OsString;
use std::process::{Command, Output};

const MANIFEST: &str = "xtask/peers/Cargo.toml";

/// Fetches, builds and runs the comparison, which gets the arguments.
pub(crate) fn run(arguments: &[OsString]) -> Result<Findings> {
    let fetched = cargo(&["fetch", "--manifest-path", MANIFEST])
        .output()
        .context("cannot start cargo fetch")?;
    if let Some(finding) = not_fetched(&fetched) {
        return Ok(vec![finding]);
    }
    let build = ["build", "--release", "--manifest-path", MANIFEST];
    let compare = built(&[&build[..], &["--bin", "compare"]].concat(), "compare")?;
    let status = Command::new(compare)
        .args(arguments)
        .current_dir(root())
        .status()
        .context("cannot start the comparison")?;
    Ok(if status.success() {
        vec![]
    } else {
        vec![format!("the comparison: {status}")]
    })
}

/// What cargo could not fetch, in one line.
fn not_fetched(output: &Output) -> Option<String> {
    if output.status.success() {
        return None;
    }
    let said = String::from_utf8_lossy(&output.stderr);
    Some(format!(
        "cannot fetch the planners to compare with: {}",
        reason(&said)
    ))
}

/// The lines of cargo that say what failed: each cause is indented below `error:`.
fn reason(said: &str) -> String {
    let lines: Vec<_> = said
        .lines()
        .map(str::trim)
        .skip_while(|line| !line.starts_with("error:"))
        .filter(|line| !line.is_empty() && *line != "Caused by:")
        .map(|line| line.trim_start_matches("error: "))
        .take(2)
        .collect();
    if lines.is_empty() {
        said.lines()
            .last()
            .unwrap_or("cargo says nothing")
            .to_owned()
    } else {
        lines.join(": ")
    }
}

#[cfg(test)]
mod test {
    use super::reason;

    #[test]
    fn a_failed_fetch_is_told_by_its_error_and_the_first_cause() {
        let said = "  Downloading crates ...\nerror: failed to download `ruckig v0.19.4`\n\n\
                    Caused by:\n  unable to get packages from source\n\nCaused by:\n  more\n";
        assert_eq!(
            reason(said),
            "failed to download `ruckig v0.19.4`: unable to get packages from source"
        );
        assert_eq!(reason("killed\n"), "killed");
        assert_eq!(reason(""), "cargo says nothing");
    }
}
