//! The workloads of the bench `cost` of the tests: timed by itself, counted by callgrind.

use anyhow::{Context, Result, anyhow, ensure};
use serde_json::Value;
use std::io::ErrorKind;
use std::path::Path;
use std::process::{Command, Stdio};

/// What one workload costs.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Workload {
    pub(super) name: String,
    /// Units of work measured.
    pub(super) units: u64,
    pub(super) mean_ns: f64,
    pub(super) median_ns: f64,
    pub(super) p99_ns: f64,
    pub(super) worst_ns: f64,
    /// Instructions per unit, on average; nothing without valgrind.
    pub(super) instructions: Option<f64>,
}

impl Workload {
    fn read(line: &str) -> Result<Self> {
        let value: Value = serde_json::from_str(line)?;
        let number = |key: &str| {
            value
                .get(key)
                .and_then(Value::as_f64)
                .ok_or_else(|| anyhow!("no {key} in {line}"))
        };
        Ok(Self {
            name: value
                .get("workload")
                .and_then(Value::as_str)
                .ok_or_else(|| anyhow!("no workload in {line}"))?
                .to_owned(),
            units: value
                .get("units")
                .and_then(Value::as_u64)
                .ok_or_else(|| anyhow!("no units in {line}"))?,
            mean_ns: number("mean_ns")?,
            median_ns: number("median_ns")?,
            p99_ns: number("p99_ns")?,
            worst_ns: number("worst_ns")?,
            instructions: None,
        })
    }
}

/// Times every workload, and counts its instructions.
pub(super) fn measure(bench: &Path) -> Result<Vec<Workload>> {
    eprintln!("   workloads: time");
    let stdout = stdout(Command::new(bench).arg("--bench"))?;
    let mut workloads = stdout
        .lines()
        .map(Workload::read)
        .collect::<Result<Vec<_>>>()?;
    for workload in &mut workloads {
        eprintln!("   {}: instructions", workload.name);
        workload.instructions = instructions(bench, &workload.name)?;
        if workload.instructions.is_none() {
            break;
        }
    }
    Ok(workloads)
}

/// Instructions per unit of work; nothing without valgrind.
fn instructions(bench: &Path, name: &str) -> Result<Option<f64>> {
    let file = std::env::temp_dir().join(format!("mrroc-cost-{}.callgrind", std::process::id()));
    let out = format!("--callgrind-out-file={}", file.display());
    let mut valgrind = Command::new("valgrind");
    valgrind
        .args(["-q", "--tool=callgrind", "--collect-atstart=no"])
        // the one function of the bench inside which measured work happens
        .args(["--toggle-collect=*measured_work*", &out])
        .arg(bench)
        .args(["--only", name, "--once"])
        .stderr(Stdio::null());
    let output = match valgrind.output() {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
        output => output.context("cannot start valgrind")?,
    };
    ensure!(
        output.status.success(),
        "valgrind of {name}: {}",
        output.status
    );
    let text = std::fs::read_to_string(&file)
        .with_context(|| format!("cannot read what callgrind wrote of {name}"))?;
    let _ = std::fs::remove_file(&file);
    let done = Workload::read(String::from_utf8_lossy(&output.stdout).trim())?;
    let counted = totals(&text).ok_or_else(|| anyhow!("callgrind counted nothing in {name}"))?;
    #[expect(clippy::cast_precision_loss, reason = "counts far below 2^53")]
    Ok(Some(counted as f64 / done.units as f64))
}

/// Instructions in a file of callgrind.
fn totals(text: &str) -> Option<u64> {
    let line = text
        .lines()
        .find_map(|line| line.strip_prefix("totals: "))?;
    line.trim().parse().ok()
}

/// Runs something to its end; what it prints.
pub(super) fn stdout(command: &mut Command) -> Result<String> {
    let name = command.get_program().to_string_lossy().into_owned();
    let output = command
        .stderr(Stdio::inherit())
        .output()
        .with_context(|| format!("cannot start {name}"))?;
    ensure!(output.status.success(), "{name}: {}", output.status);
    String::from_utf8(output.stdout).with_context(|| format!("output of {name}"))
}

#[cfg(test)]
mod test {
    use super::*;

    #[test]
    fn a_line_of_the_bench_is_read() {
        let line =
            r#"{"workload":"w","units":3,"mean_ns":2,"median_ns":1.5,"p99_ns":4,"worst_ns":9}"#;
        let workload = Workload::read(line).unwrap();
        assert_eq!((workload.name.as_str(), workload.units), ("w", 3));
        assert_eq!(workload.median_ns.to_bits(), 1.5_f64.to_bits());
        assert!(Workload::read(r#"{"workload":"w"}"#).is_err());
    }

    #[test]
    fn the_count_is_the_total_of_the_file() {
        assert_eq!(
            totals("summary: 1\nfn=x\n1 2\ntotals: 25094409\n"),
            Some(25_094_409)
        );
        assert_eq!(totals("summary: 1\n"), None);
    }
}
