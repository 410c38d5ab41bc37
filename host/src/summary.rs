//! What a run came to: for machines (`--json`) and for people (a table).
//!
//! Everything but [`MachinePart`] is a function of the task, its seed and the inputs, and is the
//! same on every machine; [`MachinePart`] depends on the clock on the wall.

use process::Lateness;
use serde::{Serialize, Serializer};
use std::fmt;

mod engraving;
mod table;
pub use engraving::{EngravingSummary, PathErrors};
use table::Table;
#[cfg(test)]
mod test;

/// The outcome of a run. Serialises to the object that `--json` prints; numbers that could not be
/// measured are `null`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// Did every step end as it should, without faults or violated limits?
    pub ok: bool,
    /// Why not, in one line.
    pub error: Option<String>,
    /// The task's title.
    pub title: String,
    /// How long it took in bus time, s.
    pub duration_s: f64,
    /// What depends on this machine.
    #[serde(flatten)]
    pub machine: MachinePart,
    /// The task's seed.
    pub seed: u64,
    /// One per robot, in the order of the cell.
    pub robots: Vec<RobotSummary>,
    /// One per bus, in the order of the cell.
    pub buses: Vec<BusSummary>,
    /// One per step that began, in order.
    pub steps: Vec<StepSummary>,
    /// The board, if one was engraved in the simulation.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub engraving: Option<EngravingSummary>,
}

/// What depends on the machine and its clock.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct MachinePart {
    /// How long it took by the wall clock, s.
    pub wall_s: f64,
    /// Bus time per wall time: above 1 is faster than real time; 0 if not measured.
    pub realtime_factor: f64,
    /// How late the Master Process was called; where time is not its own.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub called: Option<Called>,
}

/// How late a process was called, as JSON.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Called(pub Lateness);

impl Serialize for Called {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Self(late) = self;
        let us = |permille| late.percentile(permille).as_micros();
        let value = serde_json::json!({
            "calls": late.calls(), "overruns": late.overruns(),
            "lateness_us": {"p50": us(500), "p99": us(990), "p99_9": us(999), "max": us(1000)},
            "lateness_histogram_us": late.histogram(),
        });
        value.serialize(serializer)
    }
}

impl MachinePart {
    /// From the two durations, s.
    #[must_use]
    pub fn measured(duration_s: f64, wall_s: f64) -> Self {
        Self {
            called: None,
            wall_s,
            realtime_factor: if wall_s > 0.0 {
                duration_s / wall_s
            } else {
                0.0
            },
        }
    }
}

/// What became of one robot.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct RobotSummary {
    /// Its name in the cell.
    pub name: String,
    /// Its kind.
    pub kind: String,
    /// Servo law at the end.
    pub servo: String,
    /// Servo step, s.
    pub servo_step_s: f64,
    /// Servo steps it made.
    pub servo_steps: u64,
    /// Set-points beyond a limit of position, velocity, acceleration or jerk.
    pub limit_violations: u64,
    /// Faults it latched.
    pub faults: u64,
    /// Greatest following error over all axes, rad of the motor shaft.
    pub following_error_max: f64,
    /// The axis that had it, from 1; 0 if there was none.
    pub following_error_axis: usize,
    /// Greatest following error of each axis, rad of the motor shaft.
    pub following_error_max_rad: Vec<f64>,
    /// Greatest distance of a set-point from the commanded path, m, over straight lines, streamed
    /// paths and carried objects.
    pub setpoint_path_error_max_m: Option<f64>,
    /// The same of the simulated mechanics; unknown on hardware.
    pub actual_path_error_max_m: Option<f64>,
}

/// What one bus carried.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct BusSummary {
    /// Its name in the cell.
    pub name: String,
    /// Frames on the wire.
    pub frames: u64,
    /// Share of time it was busy, 0 to 1, over the whole run; unknown where only one participant's
    /// frames are seen.
    pub load_mean: Option<f64>,
    /// The same over the busiest window.
    pub load_max: Option<f64>,
    /// The window, s.
    pub load_window_s: f64,
    /// Longest time from a frame's posting to its end on the wire, s.
    pub latency_max_s: Option<f64>,
}

/// What became of one step.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StepSummary {
    /// Its name.
    pub name: String,
    /// When it began, s of bus time from the beginning of the run.
    pub start_s: f64,
    /// How long it took, s.
    pub duration_s: f64,
    /// Did it end as it should?
    pub ok: bool,
    /// How the path was followed, if it is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub path: Option<PathSummary>,
}

/// How a path was followed, by its set-points; what they are not published for is unknown.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PathSummary {
    /// Elements that were streamed, the end not counted.
    pub points: usize,
    /// Length of the way of the tool's origin, m.
    pub length_m: f64,
    /// From the first set-point that moved to the last, s.
    pub moving_s: Option<f64>,
    /// Way per time while it moved, m/s; on a way back, too.
    pub feed_mean_m_s: Option<f64>,
    /// Greatest way per servo step, m/s.
    pub feed_max_m_s: Option<f64>,
    /// Greatest distance of a set-point from the curve, m.
    pub setpoint_path_error_max_m: Option<f64>,
}

impl Summary {
    /// The object that `--json` prints, on one line without its end.
    ///
    /// # Errors
    /// None for a summary whose numbers are finite; others print as `null`.
    pub fn to_json(&self) -> Result<String, serde_json::Error> {
        serde_json::to_string(self)
    }

    /// The same without what depends on the machine: byte-identical for equal runs.
    ///
    /// # Errors
    /// As [`Summary::to_json`].
    pub fn to_reproducible_json(&self) -> Result<String, serde_json::Error> {
        let mut value = serde_json::to_value(self)?;
        if let Some(object) = value.as_object_mut() {
            object.remove("wall_s");
            object.remove("realtime_factor");
            object.remove("called");
        }
        serde_json::to_string(&value)
    }
}

/// The tables for people.
/// A figure, or a dash.
fn known(value: Option<f64>, text: impl Fn(f64) -> String) -> String {
    value.map_or_else(|| "–".to_owned(), text)
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let verdict = match (&self.error, self.ok) {
            (_, true) => "ok".to_owned(),
            (Some(error), false) => format!("failed: {error}"),
            (None, false) => "failed".to_owned(),
        };
        writeln!(f, "{}: {verdict}", self.title)?;
        write!(
            f,
            "{:.3} s of bus time, seed {}",
            self.duration_s, self.seed
        )?;
        if self.machine.realtime_factor > 0.0 {
            write!(
                f,
                ", {:.3} s on the wall: {} real time",
                self.machine.wall_s,
                factor(self.machine.realtime_factor)
            )?;
        }
        writeln!(f)?;
        if let Some(Called(lateness)) = &self.machine.called {
            writeln!(f, "called {lateness}")?;
        }
        if !self.robots.is_empty() {
            write!(f, "\n{}", self.robot_table())?;
        }
        if !self.buses.is_empty() {
            write!(f, "\n{}", self.bus_table())?;
        }
        if !self.steps.is_empty() {
            write!(f, "\n{}", self.step_table())?;
        }
        if self.steps.iter().any(|step| step.path.is_some()) {
            write!(f, "\n{}", self.path_table())?;
        }
        if let Some(engraving) = &self.engraving {
            write!(f, "\n{}", engraving_table(engraving))?;
        }
        Ok(())
    }
}

impl Summary {
    fn robot_table(&self) -> Table {
        let mut table = Table::new(&[
            "robot",
            "servo",
            "steps",
            "following error",
            "set-point path error",
            "actual path error",
            "limits broken",
            "faults",
        ]);
        for robot in &self.robots {
            let error = if robot.following_error_axis == 0 {
                "–".to_owned()
            } else {
                format!(
                    "{:.4} rad (axis {})",
                    robot.following_error_max, robot.following_error_axis
                )
            };
            table.row(vec![
                robot.name.clone(),
                robot.servo.clone(),
                robot.servo_steps.to_string(),
                error,
                length(robot.setpoint_path_error_max_m),
                length(robot.actual_path_error_max_m),
                robot.limit_violations.to_string(),
                robot.faults.to_string(),
            ]);
        }
        table
    }

    fn bus_table(&self) -> Table {
        let mut table = Table::new(&["bus", "frames", "mean load", "max load", "max latency"]);
        for bus in &self.buses {
            table.row(vec![
                bus.name.clone(),
                bus.frames.to_string(),
                known(bus.load_mean, |load| format!("{:.1} %", 100.0 * load)),
                known(bus.load_max, |load| {
                    let window_ms = 1e3 * bus.load_window_s;
                    format!("{:.1} % in {window_ms:.0} ms", 100.0 * load)
                }),
                known(bus.latency_max_s, |s| format!("{:.0} µs", 1e6 * s)),
            ]);
        }
        table
    }

    fn step_table(&self) -> Table {
        let mut table = Table::new(&["step", "began", "took", ""]);
        for step in &self.steps {
            table.row(vec![
                step.name.clone(),
                format!("{:.2} s", step.start_s),
                format!("{:.2} s", step.duration_s),
                if step.ok { "ok" } else { "failed" }.to_owned(),
            ]);
        }
        table
    }

    fn path_table(&self) -> Table {
        let mut table = Table::new(&[
            "path",
            "points",
            "length",
            "moved",
            "mean feed",
            "max feed",
            "set-point path error",
        ]);
        let speed = |value| known(value, |v| format!("{:.1} mm/s", 1e3 * v));
        for step in &self.steps {
            let Some(path) = &step.path else { continue };
            table.row(vec![
                step.name.clone(),
                path.points.to_string(),
                format!("{:.3} m", path.length_m),
                known(path.moving_s, |s| format!("{s:.2} s")),
                speed(path.feed_mean_m_s),
                speed(path.feed_max_m_s),
                length(path.setpoint_path_error_max_m),
            ]);
        }
        table
    }
}

fn engraving_table(board: &EngravingSummary) -> Table {
    let mut table = Table::new(&["engraving", "", ""]);
    let mut row = |what: &str, first: String, second: String| {
        table.row(vec![what.to_owned(), first, second]);
    };
    row(
        "cut",
        format!("{:.3} m in {:.1} s", board.cut_m, board.cut_s),
        format!("at most {:.1} mm/s", 1e3 * board.feed_max_m_s),
    );
    row(
        "wood",
        format!("{:.3} cm³", 1e6 * board.removed_m3),
        format!("{} deep", length(Some(board.depth_m))),
    );
    for (what, errors) in [
        ("path error, set-points", &board.setpoints),
        ("path error, mechanics", &board.mechanics),
    ] {
        row(
            what,
            format!("at most {}", length(Some(errors.max_m))),
            format!("rms {}", length(Some(errors.rms_m))),
        );
    }
    let (margin, joint) = board.joint_margin;
    let (share, motor) = board.motor_velocity_share;
    row(
        "margins",
        format!("{:.0} % of the half range (joint {joint})", 100.0 * margin),
        format!("{:.0} % of the velocity (motor {motor})", 100.0 * share),
    );
    let contacts = |count: u64, what: &str| match count {
        0 => format!("never {what}"),
        1 => format!("once {what}"),
        _ => format!("{count} times {what}"),
    };
    row(
        "tool",
        contacts(board.stalled, "in the wood with the spindle at rest"),
        contacts(board.collisions, "touching what it must not"),
    );
    table
}

/// A length in the unit that suits it.
fn length(metres: Option<f64>) -> String {
    match metres {
        None => "–".to_owned(),
        Some(m) if m.abs() <= 0.0 => "0 µm".to_owned(),
        Some(m) if m.abs() < 1e-9 => "< 0.001 µm".to_owned(),
        Some(m) if m.abs() < 1e-3 => format!("{:.3} µm", 1e6 * m),
        Some(m) => format!("{:.3} mm", 1e3 * m),
    }
}

fn factor(factor: f64) -> String {
    if factor < 10.0 {
        format!("{factor:.2}×")
    } else {
        format!("{factor:.0}×")
    }
}
