//! The controller node as an image on an emulated microcontroller: built, examined, and run in the loop
//! with the simulated world.

use crate::image::{Board, Built};
use crate::report::Findings;
use crate::shell::{root, run_cargo};
use anyhow::{Context, Result};
use std::ffi::OsString;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// The board.
const BOARD: Board = Board {
    folder: "firmware/boards/qemu-mps2-an386",
    image: "mrroc-qemu",
    features: &[],
};
/// Built with it: says whether memory is copied and cleared as it should be.
const MEMORY: &str = "mrroc-qemu-memory";
/// For how long that may take.
const MEMORY_TAKES: Duration = Duration::from_secs(60);
/// Counts instructions.
const PLUGIN: &str = "firmware/boards/tools/steps.c";
/// What must be installed beside Rust.
const EMULATOR: &str = "qemu-system-arm";

/// Builds the image and the plugin, then lets `hil-qemu` of the tests examine and run it.
pub(crate) fn check(arguments: &[OsString]) -> Result<Findings> {
    for program in [EMULATOR, "cc"] {
        if !starts(program) {
            return Ok(vec![format!(
                "{program} is missing: install it, Debian's packages are qemu-system-arm and gcc"
            )]);
        }
    }
    let Built {
        image,
        build,
        golden,
    } = match BOARD.build()? {
        Ok(built) => built,
        Err(findings) => return Ok(findings),
    };
    let plugin = build.join("steps.so");
    let mut findings = compile(&root().join(PLUGIN), &plugin)?;
    findings.extend(memory(&image.with_file_name(MEMORY))?);
    if !findings.is_empty() {
        return Ok(findings);
    }
    let text = |path: &Path| path.display().to_string();
    let (image, plugin, golden) = (text(&image), text(&plugin), text(&golden));
    let mut line = vec![
        "run",
        "--release",
        "-p",
        "mrroc-tests",
        "--bin",
        "hil-qemu",
        "--",
        &image,
        "--plugin",
        &plugin,
        "--golden",
        &golden,
    ];
    let arguments: Vec<_> = arguments.iter().map(|a| a.to_string_lossy()).collect();
    line.extend(arguments.iter().map(AsRef::as_ref));
    run_cargo(&line)
}

fn starts(program: &str) -> bool {
    Command::new(program)
        .arg("--version")
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status()
        .is_ok_and(|status| status.success())
}

/// Runs the image that ends with success if memory is copied and cleared as it should be.
fn memory(image: &Path) -> Result<Findings> {
    let mut child = Command::new(EMULATOR)
        .args(["-M", "mps2-an386", "-display", "none", "-monitor", "none"])
        .args(["-serial", "none", "-nodefaults"])
        .args(["-semihosting-config", "enable=on,target=native"])
        .arg("-kernel")
        .arg(image)
        .stdin(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .context("cannot start the emulator")?;
    let begun = Instant::now();
    let ended = loop {
        match child.try_wait()? {
            Some(status) if status.success() => return Ok(vec![]),
            Some(status) => break status.to_string(),
            None if begun.elapsed() > MEMORY_TAKES => {
                child.kill()?;
                child.wait()?;
                break format!("no end in {} s", MEMORY_TAKES.as_secs());
            }
            None => std::thread::sleep(Duration::from_millis(20)),
        }
    };
    Ok(vec![format!(
        "{MEMORY}: memory is not copied or cleared as it should be: {ended}"
    )])
}

fn compile(source: &Path, plugin: &Path) -> Result<Findings> {
    let status = Command::new("cc")
        .args([
            "-O2", "-Wall", "-Wextra", "-Werror", "-fPIC", "-shared", "-o",
        ])
        .arg(plugin)
        .arg(source)
        .status()
        .context("cannot start cc")?;
    Ok(if status.success() {
        vec![]
    } else {
        vec![format!("cc {PLUGIN}: {status}")]
    })
}
