//! The controller node as an image on an emulated microcontroller: built, examined, and run in the loop
//! with the simulated world.

use crate::no_std::{BareMetal, TARGET, bare_metal};
use crate::report::Findings;
use crate::shell::{root, run, run_cargo};
use anyhow::{Context, Result};
use std::ffi::OsString;
use std::path::Path;
use std::process::{Command, Stdio};

/// The board.
const BOARD: &str = "firmware/boards/qemu-mps2-an386";
/// Its binary.
const IMAGE: &str = "mrroc-qemu";
/// Where images are built, in the root.
const BUILD: &str = "target/boards";
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
    let Some(BareMetal {
        mut cargo,
        more,
        name,
    }) = bare_metal()?
    else {
        return Ok(vec![format!(
            "the target is missing: rustup target add {TARGET}"
        )]);
    };
    let build = root().join(BUILD).join(name);
    // the sizes of stack frames are asked of any compiler by a flag that is not stable yet
    let flags = format!("target.{TARGET}.rustflags=['-Zemit-stack-sizes']");
    let mut line = vec!["build", "--release", "--locked", "--config", flags.as_str()];
    line.extend(more);
    cargo
        .current_dir(root().join(BOARD))
        .env("RUSTC_BOOTSTRAP", "1")
        .args(&line)
        .arg("--target-dir")
        .arg(&build);
    let mut findings = run(&mut cargo, &line)?;
    let plugin = build.join("steps.so");
    findings.extend(compile(&root().join(PLUGIN), &plugin)?);
    if !findings.is_empty() {
        return Ok(findings);
    }
    let image = build.join(TARGET).join("release").join(IMAGE);
    let golden = root().join(BOARD).join("golden").join(name);
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
