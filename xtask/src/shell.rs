//! Starting cargo from the root of the workspace.

use crate::report::Findings;
use anyhow::{Context, Result};
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// The root of the workspace.
pub(crate) fn root() -> PathBuf {
    let own = Path::new(env!("CARGO_MANIFEST_DIR"));
    own.parent().unwrap_or(own).to_path_buf()
}

/// The cargo that started us, to be run at the root.
pub(crate) fn cargo(arguments: &[&str]) -> Command {
    let program = std::env::var_os("CARGO").unwrap_or_else(|| OsString::from("cargo"));
    let mut command = Command::new(program);
    command.args(arguments).current_dir(root());
    command
}

/// Runs cargo with our own output streams; a bad exit is a finding.
pub(crate) fn run_cargo(arguments: &[&str]) -> Result<Findings> {
    run(&mut cargo(arguments), arguments)
}

/// Runs a prepared cargo command with our own output streams.
pub(crate) fn run(command: &mut Command, arguments: &[&str]) -> Result<Findings> {
    let line = arguments.join(" ");
    let status = command
        .status()
        .with_context(|| format!("cannot start cargo {line}"))?;
    Ok(if status.success() {
        vec![]
    } else {
        vec![format!("cargo {line}: {status}")]
    })
}

/// Runs cargo and returns its standard output; a bad exit is an error.
pub(crate) fn cargo_stdout(arguments: &[&str]) -> Result<String> {
    let line = arguments.join(" ");
    let output = cargo(arguments)
        .stderr(Stdio::inherit())
        .output()
        .with_context(|| format!("cannot start cargo {line}"))?;
    anyhow::ensure!(output.status.success(), "cargo {line}: {}", output.status);
    String::from_utf8(output.stdout).with_context(|| format!("output of cargo {line}"))
}
