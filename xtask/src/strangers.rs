//! Other people's tools against our programs: `tests/strangers`, in a Python environment of its own.

use crate::report::Findings;
use crate::shell::{root, run_cargo};
use anyhow::{Context, Result};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Where the tests are, from the root.
pub(crate) const TESTS: &str = "tests/strangers";

/// Those of them that need a SocketCAN, as `unittest` names them in their folder.
#[cfg(target_os = "linux")]
pub(crate) const ON_VCAN: &str = "test_drive.DriveOnVcan";

/// Names the folder of the programs to the tests.
pub(crate) const PROGRAMS_IN: &str = "MRROC_BIN";

/// The tests leave nothing beside themselves.
pub(crate) const NO_BYTECODE: &str = "PYTHONDONTWRITEBYTECODE";

/// What they run, built as the other tests are.
const PROGRAMS: &[&[&str]] = &[
    &[
        "build",
        "-p",
        "mrroc",
        "-p",
        "mrroc-hil-sim",
        "-p",
        "mrroc-node",
    ],
    &["build", "-p", "mrroc-bus", "--example", "hub"],
];

/// Without Python it is a failure, if this is in the environment.
const REQUIRED: &str = "MRROC_STRANGERS";

/// What is missing where there are no [`tools`].
pub(crate) const NO_PYTHON: &str = "there is no python3 with the modules venv and ensurepip";

/// Says why the tests do not run. That is a failure only where they must: nothing of ours needs them.
pub(crate) fn not_run(obstacle: &str) -> Findings {
    let told = format!("strangers not run: {obstacle}");
    eprintln!("{told}");
    let required = std::env::var_os(REQUIRED).is_some();
    required.then_some(told).into_iter().collect()
}

/// The Python of an environment with the tools as `requirements.txt` pins them; none without Python.
pub(crate) fn tools() -> Result<Option<PathBuf>> {
    let environment = python().map(environment).transpose()?;
    Ok(environment.as_deref().map(program))
}

/// Installs the tools, builds the programs, runs the tests.
pub(crate) fn check() -> Result<Findings> {
    let Some(python) = tools()? else {
        return Ok(not_run(NO_PYTHON));
    };
    let mut findings = vec![];
    for arguments in PROGRAMS {
        findings.extend(run_cargo(arguments)?);
    }
    if !findings.is_empty() {
        return Ok(findings);
    }
    let mut tests = Command::new(python);
    tests
        .current_dir(root())
        .args(["-m", "unittest", "discover", "--start-directory", TESTS])
        .env(NO_BYTECODE, "1")
        .env(PROGRAMS_IN, programs());
    let status = tests.status().context("cannot start the tests")?;
    if !status.success() {
        findings.push(format!("{TESTS}: {status}"));
    }
    Ok(findings)
}

/// The first Python that can make environments.
fn python() -> Option<&'static str> {
    ["python3", "python"].into_iter().find(|name| {
        let asked = Command::new(name)
            .args(["-c", "import venv, ensurepip"])
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .status();
        asked.is_ok_and(|status| status.success())
    })
}

/// The folder of cargo's output.
fn target() -> PathBuf {
    std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| root().join("target"), PathBuf::from)
}

/// The folder of the programs.
fn programs() -> PathBuf {
    target().join("debug")
}

/// The environment, made anew when the pinned versions have changed.
fn environment(python: &str) -> Result<PathBuf> {
    let folder = target().join("strangers");
    let pinned = root().join(TESTS).join("requirements.txt");
    let wanted = fs::read(&pinned).with_context(|| format!("{}", pinned.display()))?;
    let mark = folder.join("requirements.txt");
    if fs::read(&mark).is_ok_and(|installed| installed == wanted) {
        return Ok(folder);
    }
    step(
        Command::new(python)
            .args(["-m", "venv", "--clear"])
            .arg(&folder),
    )?;
    step(
        Command::new(program(&folder))
            .args(["-m", "pip", "install", "--quiet"])
            .args(["--disable-pip-version-check", "--requirement"])
            .arg(&pinned),
    )?;
    fs::write(&mark, wanted).with_context(|| format!("{}", mark.display()))?;
    Ok(folder)
}

/// The environment's Python.
fn program(environment: &Path) -> PathBuf {
    let folder = if cfg!(windows) { "Scripts" } else { "bin" };
    environment.join(folder).join("python")
}

fn step(command: &mut Command) -> Result<()> {
    let status = command
        .status()
        .with_context(|| format!("cannot start {command:?}"))?;
    anyhow::ensure!(status.success(), "{command:?}: {status}");
    Ok(())
}
