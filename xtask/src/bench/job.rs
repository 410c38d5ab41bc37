//! The main job, simulated as fast as it goes.

use super::workload::stdout;
use crate::shell::root;
use anyhow::{Result, anyhow, ensure};
use serde_json::Value;
use std::path::Path;
use std::process::Command;
use std::time::Instant;

const TASK: &str = "tasks/two-arms.toml";
const RUNS: usize = 5;
/// Linux counts the time of processes in hundredths of a second towards user space, on every
/// architecture.
const TICKS_PER_S: f64 = 100.0;

/// How fast the main job was simulated.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Job {
    /// What was simulated, s.
    pub(super) simulated_s: f64,
    /// Simulated per wall second, of each run, sorted.
    pub(super) wall: Vec<f64>,
    /// Simulated per second of one core, likewise; empty where the system does not say.
    pub(super) core: Vec<f64>,
}

impl Job {
    /// The figure the target is for: per second of one core if known.
    pub(super) fn figure(&self) -> f64 {
        let core = median(&self.core);
        if core.is_nan() {
            median(&self.wall)
        } else {
            core
        }
    }
}

/// The one in the middle of sorted numbers.
pub(super) fn median(sorted: &[f64]) -> f64 {
    sorted.get(sorted.len() / 2).copied().unwrap_or(f64::NAN)
}

/// Runs the main job several times.
pub(super) fn measure(mrroc: &Path) -> Result<Job> {
    let mut job = Job {
        simulated_s: 0.0,
        wall: Vec::new(),
        core: Vec::new(),
    };
    for run in 1..=RUNS {
        eprintln!("   main job: {run} of {RUNS}");
        let (began, cpu_before_s) = (Instant::now(), children_cpu_s());
        let mut command = Command::new(mrroc);
        let text = stdout(
            command
                .args(["run", TASK, "--json", "-q"])
                .current_dir(root()),
        )?;
        let wall_s = began.elapsed().as_secs_f64();
        let cpu_s = children_cpu_s()
            .zip(cpu_before_s)
            .map(|(after, before)| after - before);
        let summary: Value = serde_json::from_str(&text)?;
        ensure!(
            summary.get("ok") == Some(&Value::Bool(true)),
            "{TASK} did not end well"
        );
        let simulated_s = summary.get("duration_s").and_then(Value::as_f64);
        job.simulated_s = simulated_s.ok_or_else(|| anyhow!("no duration_s in the summary"))?;
        job.wall.push(job.simulated_s / wall_s);
        job.core
            .extend(cpu_s.filter(|s| *s > 0.0).map(|s| job.simulated_s / s));
    }
    job.wall.sort_by(f64::total_cmp);
    job.core.sort_by(f64::total_cmp);
    Ok(job)
}

/// Time that processes we started, and that have ended, kept cores busy, s; Linux only.
fn children_cpu_s() -> Option<f64> {
    cpu_s_of(&std::fs::read_to_string("/proc/self/stat").ok()?)
}

/// The same from the text of `/proc/self/stat`: fields 16 (cutime) and 17 (cstime) of proc(5).
fn cpu_s_of(stat: &str) -> Option<f64> {
    // the second field, the name in parentheses, may hold anything
    let (_, rest) = stat.rsplit_once(')')?;
    let mut fields = rest.split_whitespace().skip(13);
    let mut ticks = || fields.next()?.parse::<f64>().ok();
    Some((ticks()? + ticks()?) / TICKS_PER_S)
}

#[cfg(test)]
mod test {
    use super::*;

    #[test]
    fn the_time_of_children_is_read_whatever_the_process_is_called() {
        let stat = "7 (a) b) S 4 5 6 7 8 9 10 11 12 13 14 15 150 25 18 19";
        assert_eq!(cpu_s_of(stat), Some(1.75));
        assert_eq!(cpu_s_of("7 (a) S 4"), None);
    }

    #[test]
    fn the_figure_is_per_core_if_known() {
        let mut job = Job {
            simulated_s: 1.0,
            wall: vec![1.0, 2.0, 9.0],
            core: vec![3.0, 4.0, 5.0],
        };
        assert!((job.figure() - 4.0).abs() < 1e-12);
        job.core.clear();
        assert!((job.figure() - 2.0).abs() < 1e-12);
    }
}
