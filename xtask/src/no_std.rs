//! The crates of the microcontroller, built for one.

use crate::deps::no_std_packages;
use crate::report::Findings;
use crate::shell::{cargo_stdout, root, run_cargo};
use anyhow::{Context, Result, ensure};
use std::path::Path;
use std::process::Command;

/// Cortex-M4F: the weakest processor the firmware is meant for.
const TARGET: &str = "thumbv7em-none-eabihf";

/// Builds for the bare-metal target if it is installed. In any case no dependency may have its
/// `std` feature switched on.
pub(crate) fn check() -> Result<Findings> {
    let mut findings = std_features()?;
    if installed()? {
        let mut arguments = vec!["build", "--release", "--target", TARGET];
        arguments.extend(no_std_packages().flat_map(|package| ["-p", package]));
        findings.extend(run_cargo(&arguments)?);
    } else {
        eprintln!(
            "no-std: NOT BUILT, only the dependencies' features were checked: the standard \
             library of {TARGET} is not installed (rustup target add {TARGET})"
        );
    }
    Ok(findings)
}

fn installed() -> Result<bool> {
    let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let output = Command::new(rustc)
        .args(["--print", "sysroot"])
        .current_dir(root())
        .output()
        .context("cannot start rustc")?;
    ensure!(
        output.status.success(),
        "rustc --print sysroot: {}",
        output.status
    );
    let sysroot = String::from_utf8(output.stdout)?;
    Ok(Path::new(sysroot.trim())
        .join("lib/rustlib")
        .join(TARGET)
        .join("lib")
        .is_dir())
}

/// Dependencies that would pull in the standard library. This works without the target.
fn std_features() -> Result<Findings> {
    let mut arguments = vec![
        "tree",
        "--target",
        TARGET,
        "--edges",
        "normal,features,no-proc-macro",
        "--prefix",
        "none",
    ];
    arguments.extend(no_std_packages().flat_map(|package| ["-p", package]));
    Ok(with_std(&cargo_stdout(&arguments)?))
}

fn with_std(tree: &str) -> Findings {
    let mut found: Vec<&str> = tree
        .lines()
        .filter_map(|line| {
            line.split_once(" feature \"std\"")
                .map(|(package, _)| package)
        })
        .collect();
    found.sort_unstable();
    found.dedup();
    found
        .into_iter()
        .map(|package| format!("{package} is built with its std feature"))
        .collect()
}

#[cfg(test)]
mod test {
    use super::*;

    #[test]
    fn a_std_feature_is_found_once() {
        let tree = "serde feature \"std\"\nserde feature \"derive\"\nserde feature \"std\" (*)\n\
                    libm v0.2.16\n";
        assert_eq!(with_std(tree), ["serde is built with its std feature"]);
        assert_eq!(
            with_std("libm v0.2.16\nlibm feature \"default\"\n"),
            [""; 0]
        );
    }
}
