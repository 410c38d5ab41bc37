//! The crates of the microcontroller, built for one.

use crate::deps::no_std_packages;
use crate::report::Findings;
use crate::shell::{cargo, cargo_stdout, root, run};
use anyhow::{Context, Result, ensure};
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Cortex-M4F: the weakest processor the firmware is meant for.
pub(crate) const TARGET: &str = "thumbv7em-none-eabihf";

/// The linker that comes with Rust, where it does.
const HOST_LINKER: &str = "x86_64-unknown-linux-gnu/bin/rust-lld";

/// Where a system's own Rust lives, which comes with the sources of the standard library.
const SYSTEM: &str = "/usr";

/// `1`: build `core` from sources even where the target's library is installed, as a machine without rustup does.
const FROM_SOURCES: &str = "MRROC_BUILD_STD";

/// `core` as the target's installed library has it: without overflow checks of its own, of which nobody has shown that
/// none can be reached, and for speed, the arithmetic of f64 above all.
const CORE: [&str; 9] = [
    "-Zbuild-std=core",
    "--config",
    "profile.release.package.core.overflow-checks=false",
    "--config",
    "profile.release.package.core.opt-level=3",
    "--config",
    "profile.release.package.compiler_builtins.overflow-checks=false",
    "--config",
    "profile.release.package.compiler_builtins.opt-level=3",
];

/// A way to build for [`TARGET`].
pub(crate) struct BareMetal {
    /// The cargo.
    pub(crate) cargo: Command,
    /// What else its command line needs.
    pub(crate) more: Vec<&'static str>,
    /// Where `core` comes from: names what differs.
    pub(crate) name: &'static str,
}

/// Builds for the bare-metal target: with its standard library where that is installed, else with
/// `core` compiled from a toolchain's sources. No dependency may have its `std` feature on.
pub(crate) fn check() -> Result<Findings> {
    let mut findings = std_features()?;
    if let Some(BareMetal {
        mut cargo,
        mut more,
        ..
    }) = bare_metal()?
    {
        if !more.is_empty() {
            more.extend(["--target-dir", "target/core"]);
        }
        findings.extend(build(&mut cargo, &more)?);
    } else {
        findings.push(format!(
            "not built: neither the standard library of {TARGET} (rustup target add {TARGET}) nor \
             sources of core (rustup component add rust-src) are installed"
        ));
    }
    Ok(findings)
}

/// Our cargo where the target's library is installed, else one of a toolchain with the sources of `core`;
/// nothing if there is neither.
pub(crate) fn bare_metal() -> Result<Option<BareMetal>> {
    let own = sysroot()?;
    let from_sources = std::env::var_os(FROM_SOURCES).is_some_and(|value| value == "1");
    if !from_sources && own.join("lib/rustlib").join(TARGET).join("lib").is_dir() {
        return Ok(Some(BareMetal {
            cargo: cargo(&[]),
            more: vec![],
            name: "rustup",
        }));
    }
    let with_sources = [own, PathBuf::from(SYSTEM)]
        .into_iter()
        .find(|r| r.join("lib/rustlib/src/rust/library/core").is_dir());
    let Some(toolchain) = with_sources else {
        return Ok(None);
    };
    let mut cargo = toolchain_cargo(&toolchain)?;
    if !toolchain.join("lib/rustlib").join(HOST_LINKER).is_file() {
        // a system's own Rust has its linker elsewhere
        cargo.env("CARGO_TARGET_THUMBV7EM_NONE_EABIHF_LINKER", "ld.lld");
    }
    Ok(Some(BareMetal {
        cargo,
        more: CORE.to_vec(),
        name: "build-std",
    }))
}

fn build(cargo: &mut Command, more: &[&str]) -> Result<Findings> {
    let mut arguments = vec!["build", "--release", "--target", TARGET];
    arguments.extend(more);
    arguments.extend(no_std_packages().flat_map(|package| ["-p", package]));
    run(cargo.args(&arguments), &arguments)
}

/// The cargo of the toolchain at this root with its own compiler, allowed to build `core`.
fn toolchain_cargo(toolchain: &Path) -> Result<Command> {
    let programs = toolchain.join("bin");
    let mut path = OsString::from(&programs);
    if let Some(rest) = std::env::var_os("PATH") {
        path.push(":");
        path.push(rest);
    }
    let cargo = programs.join("cargo");
    ensure!(cargo.is_file(), "{} is missing", cargo.display());
    let mut command = Command::new(cargo);
    command
        .current_dir(root())
        .env("PATH", path)
        .env("RUSTC", programs.join("rustc"))
        .env("RUSTC_BOOTSTRAP", "1");
    Ok(command)
}

fn sysroot() -> Result<PathBuf> {
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
    Ok(PathBuf::from(String::from_utf8(output.stdout)?.trim()))
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
