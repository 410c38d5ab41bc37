//! What is printed: one Markdown table, what it was measured on, and the targets.

use super::job::{Job, median};
use super::workload::Workload;
use anyhow::Result;
use serde_json::{Value, json};
use std::fmt::Write as _;

/// A servo step of six axes costs at most this, ns.
const STEP_NS: f64 = 5000.0;
/// One core simulates two arms at least so many times faster than real time.
const FACTOR: f64 = 100.0;

/// What it was measured on.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Machine {
    cpu: String,
    rustc: String,
}

impl Machine {
    pub(super) fn this() -> Result<Self> {
        let cpu = std::fs::read_to_string("/proc/cpuinfo").ok();
        let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
        let version = super::workload::stdout(std::process::Command::new(rustc).arg("--version"))?;
        Ok(Self {
            cpu: cpu
                .as_deref()
                .and_then(model)
                .unwrap_or(std::env::consts::ARCH)
                .to_owned(),
            rustc: version.trim().to_owned(),
        })
    }
}

/// The model in the text of `/proc/cpuinfo`.
fn model(cpuinfo: &str) -> Option<&str> {
    let line = cpuinfo
        .lines()
        .find(|line| line.starts_with("model name"))?;
    Some(line.split_once(':')?.1.trim())
}

/// Everything measured.
#[derive(Clone, Debug)]
pub(super) struct Measured {
    pub(super) machine: Machine,
    pub(super) workloads: Vec<Workload>,
    pub(super) job: Job,
}

impl Measured {
    pub(super) fn markdown(&self) -> String {
        let mut text = String::new();
        let mut line = |line: &str| text.extend([line, "\n"]);
        line("| work | instructions, mean | ns, mean | median | p99 | worst |");
        line("|---|---:|---:|---:|---:|---:|");
        for w in &self.workloads {
            let counted = w
                .instructions
                .map_or_else(|| "–".into(), |n| format!("{n:.0}"));
            line(&format!(
                "| {} | {counted} | {:.0} | {:.0} | {:.0} | {:.0} |",
                w.name, w.mean_ns, w.median_ns, w.p99_ns, w.worst_ns
            ));
        }
        line("");
        for (name, factors) in [
            ("second of one core", &self.job.core),
            ("wall second", &self.job.wall),
        ] {
            if let [least, .., most] = factors.as_slice() {
                line(&format!(
                    "Main job: {:.0} simulated seconds per {name} (median of {}; {least:.0} to \
                     {most:.0}), {:.1} s simulated.",
                    median(factors),
                    factors.len(),
                    self.job.simulated_s,
                ));
            }
        }
        line("");
        self.targets()
            .iter()
            .for_each(|target| line(&target.sentence()));
        line("");
        line(&format!(
            "{}, {}, profile release. Times: wall clock, of each piece of work the fastest of 15 \
             identical replays. {}.",
            self.machine.cpu,
            self.machine.rustc,
            self.counter(),
        ));
        text
    }

    pub(super) fn json(&self) -> Value {
        let workload = |w: &Workload| {
            json!({
                "workload": w.name, "units": w.units, "instructions": w.instructions,
                "mean_ns": w.mean_ns, "median_ns": w.median_ns, "p99_ns": w.p99_ns,
                "worst_ns": w.worst_ns,
            })
        };
        let target = |t: &Target| json!({ "target": t.what, "met": t.met, "got": t.got });
        json!({
            "cpu": self.machine.cpu,
            "rustc": self.machine.rustc,
            "workloads": self.workloads.iter().map(workload).collect::<Vec<_>>(),
            "job": {
                "simulated_s": self.job.simulated_s,
                "per_wall_second": self.job.wall,
                "per_core_second": self.job.core,
            },
            "targets": self.targets().iter().map(target).collect::<Vec<_>>(),
        })
    }

    fn counter(&self) -> &'static str {
        if self.workloads.iter().all(|w| w.instructions.is_some()) {
            "Instructions: callgrind, over the same work"
        } else {
            "Instructions: not measured (needs valgrind)"
        }
    }

    /// The targets, and how they were met: the step by the workload that costs most.
    fn targets(&self) -> Vec<Target> {
        let steps = || {
            self.workloads
                .iter()
                .filter(|w| w.name.starts_with("node-"))
        };
        let worst = |ns: fn(&Workload) -> f64| steps().map(ns).max_by(f64::total_cmp);
        let step = |what, ns: fn(&Workload) -> f64| {
            let got = worst(ns).unwrap_or(f64::NAN);
            Target {
                what,
                met: got <= STEP_NS,
                got: format!("{:.1} µs", got / 1000.0),
            }
        };
        let factor = self.job.figure();
        vec![
            step("servo step ≤ 5 µs, mean", |w| w.mean_ns),
            step("servo step ≤ 5 µs, p99", |w| w.p99_ns),
            step("servo step ≤ 5 µs, worst", |w| w.worst_ns),
            Target {
                what: "two arms ≥ 100 × real time",
                met: factor >= FACTOR,
                got: format!("{factor:.0} ×"),
            },
        ]
    }
}

/// A target, and what was got.
#[derive(Clone, Debug, PartialEq)]
struct Target {
    what: &'static str,
    met: bool,
    got: String,
}

impl Target {
    fn sentence(&self) -> String {
        let verdict = if self.met { "met" } else { "missed" };
        let mut text = String::new();
        let _ = write!(text, "- {}: {verdict} ({})", self.what, self.got);
        text
    }
}

#[cfg(test)]
mod test {
    use super::*;

    fn measured(step_ns: f64, factor: f64, instructions: Option<f64>) -> Measured {
        let workload = |name: &str, ns| Workload {
            name: name.into(),
            units: 1,
            mean_ns: ns,
            median_ns: ns,
            p99_ns: ns,
            worst_ns: ns,
            instructions,
        };
        Measured {
            machine: Machine {
                cpu: "C".into(),
                rustc: "R".into(),
            },
            workloads: vec![workload("node-a", step_ns), workload("mp-step", 1e9)],
            job: Job {
                simulated_s: 9.0,
                wall: vec![1.0; 5],
                core: vec![factor; 5],
            },
        }
    }

    #[test]
    fn targets_are_met_or_missed_by_what_was_measured() {
        let met = |m: &Measured| m.targets().iter().map(|t| t.met).collect::<Vec<_>>();
        assert_eq!(met(&measured(5000.0, 100.0, None)), [true; 4]);
        assert_eq!(met(&measured(5001.0, 99.9, None)), [false; 4]);
        assert_eq!(met(&measured(f64::NAN, f64::NAN, None)), [false; 4]);
    }

    #[test]
    fn the_table_says_what_was_not_measured() {
        let with = measured(1.0, 200.0, Some(321.4)).markdown();
        assert!(with.contains("| node-a | 321 | 1 |") && with.contains("callgrind"));
        let without = measured(1.0, 200.0, None).markdown();
        assert!(without.contains("| node-a | – |") && without.contains("not measured"));
    }

    #[test]
    fn the_processor_is_the_first_named() {
        assert_eq!(
            model("x : 1\nmodel name\t: A B\nmodel name\t: C\n"),
            Some("A B")
        );
        assert_eq!(model("x : 1\n"), None);
    }
}
