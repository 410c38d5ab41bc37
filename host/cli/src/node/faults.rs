//! The first fault and the signals before it: as a table, as JSON, as a picture.

use host::error::fault_text;
use host::mp::arm::{arm, unit_rad};
use host::plot::{CurveDiagram, CurvesPlot, Picture};
use protocol::maintenance::{AxisSample, FaultRecord, Sample};
use protocol::units::UNITS_PER_INCREMENT;
use robots::RobotKind;
use serde_json::{Value, json};
use std::fmt::Write as _;

/// What one axis did, in the units it is shown in.
#[derive(Debug)]
struct Axis {
    name: String,
    /// Units per increment.
    scale: f64,
}

/// A record with its samples.
#[derive(Debug)]
pub(super) struct Found {
    robot: String,
    record: FaultRecord,
    samples: Vec<Sample>,
    axes: Vec<Axis>,
    unit: &'static str,
}

impl Found {
    /// Of a robot; of one that is not known here positions are in increments.
    pub(super) fn new(robot: &str, record: FaultRecord, samples: Vec<Sample>) -> Self {
        let count = samples.iter().map(|sample| sample.axes.len()).max();
        let count = count.unwrap_or(0);
        let known = RobotKind::from_name(robot).ok().map(arm);
        let known = known.filter(|arm| arm.axes().len() == count);
        #[expect(clippy::cast_precision_loss, reason = "a thousand")]
        let units = UNITS_PER_INCREMENT as f64;
        let (axes, unit) = if let Some(arm) = known {
            let axis = |axis: &robots::AxisDescription| Axis {
                name: axis.name.into(),
                scale: units * unit_rad(axis),
            };
            (arm.axes().iter().map(axis).collect(), "rad")
        } else {
            let axis = |k: usize| Axis {
                name: format!("axis {}", k + 1),
                scale: 1.0,
            };
            ((0..count).map(axis).collect(), "increments")
        };
        Self {
            robot: robot.into(),
            record,
            samples,
            axes,
            unit,
        }
    }

    /// Time of a sample, s; the fault is at 0.
    fn time(&self, sample: &Sample) -> f64 {
        let step = f64::from(sample.step) - f64::from(self.record.fault.step);
        step * f64::from(self.record.servo_step_us) / 1e6
    }

    /// The values of an axis over time.
    fn series(&self, k: usize, of: impl Fn(&Axis, &AxisSample) -> f64) -> Vec<[f64; 2]> {
        let Some(axis) = self.axes.get(k) else {
            return Vec::new();
        };
        let point = |sample: &Sample| Some([self.time(sample), of(axis, sample.axes.get(k)?)]);
        self.samples.iter().filter_map(point).collect()
    }

    fn actual(&self, k: usize) -> Vec<[f64; 2]> {
        self.series(k, |axis, sample| f64::from(sample.actual) * axis.scale)
    }

    fn error(&self, k: usize) -> Vec<[f64; 2]> {
        self.series(k, |axis, sample| f64::from(sample.error) * 0.1 * axis.scale)
    }

    fn current(&self, k: usize) -> Vec<[f64; 2]> {
        self.series(k, |_, sample| f64::from(sample.current_ma) * 1e-3)
    }

    fn when(&self) -> String {
        let record = &self.record;
        let since_start = f64::from(record.fault.step) * f64::from(record.servo_step_us) / 1e6;
        let span = match (self.samples.first(), self.samples.last()) {
            (Some(first), Some(last)) => self.time(last) - self.time(first),
            _ => 0.0,
        };
        let interrupted = match record.instruction {
            0 => "no instruction".into(),
            id => format!("instruction {id}"),
        };
        let later = match record.later {
            0 => String::new(),
            1 => "; one fault later, not recorded".into(),
            later => format!("; {later} faults later, not recorded"),
        };
        format!(
            "{since_start:.3} s after start {}, it interrupted {interrupted}; {} samples of the last {span:.3} s{later}",
            record.boot,
            self.samples.len()
        )
    }

    pub(super) fn text(&self, name: &str, cleared: bool) -> String {
        let code = self.record.fault.cause.code();
        let mut text = format!(
            "{name}: {}\n  {}\n  see docs/faults/{code}.md\n\n",
            fault_text(&self.record.fault),
            self.when()
        );
        let unit = self.unit;
        let head = [
            format!("actual [{unit}]"),
            format!("demand [{unit}]"),
            format!("error [{unit}]"),
            "greatest".into(),
            "current [A]".into(),
            "greatest".into(),
        ];
        let mut row = |name: &str, cells: [String; 6]| {
            // writing to a String cannot fail
            let _ = write!(text, "  {name:<20}");
            for cell in cells {
                let _ = write!(text, "{cell:>18}");
            }
            text.push('\n');
        };
        row("when it came", head);
        for (k, axis) in self.axes.iter().enumerate() {
            let [actual, error, current] = [self.actual(k), self.error(k), self.current(k)];
            let mark = if self.record.fault.axis.map(usize::from) == Some(k) {
                " <-"
            } else {
                ""
            };
            let cells = [
                last(&actual),
                last(&actual) + last(&error),
                last(&error),
                greatest(&error),
                last(&current),
                greatest(&current),
            ];
            row(
                &format!("{}{mark}", axis.name),
                cells.map(|value| format!("{value:.4}")),
            );
        }
        if cleared {
            text.push_str("\n  the record is cleared\n");
        }
        text
    }

    pub(super) fn json(&self, cleared: bool) -> Value {
        let record = &self.record;
        let fault = &record.fault;
        let samples: Vec<Value> = self
            .samples
            .iter()
            .map(|sample| {
                let axes: Vec<Value> = sample
                    .axes
                    .iter()
                    .map(|axis| {
                        json!({
                            "actual_increments": axis.actual,
                            "error_increments": f64::from(axis.error) * 0.1,
                            "current_ma": axis.current_ma,
                        })
                    })
                    .collect();
                json!({
                    "step": sample.step,
                    "t_s": self.time(sample),
                    "state": format!("{:?}", sample.state),
                    "fault": sample.fault,
                    "axes": axes,
                })
            })
            .collect();
        json!({
            "robot": self.robot,
            "fault": {
                "code": fault.cause.code(),
                "name": format!("{:?}", fault.cause),
                "text": fault.cause.text(),
                "axis": fault.axis.map(|axis| u16::from(axis) + 1),
                "step": fault.step,
                "during": format!("{:?}", fault.during),
                "instruction": record.instruction,
                "page": format!("docs/faults/{}.md", fault.cause.code()),
            },
            "record": format!("{:08x}", record.record),
            "boot": record.boot,
            "later": record.later,
            "servo_step_us": record.servo_step_us,
            "axes": self.axes.iter().map(|axis| json!({
                "name": axis.name, "unit": self.unit, "per_increment": axis.scale,
            })).collect::<Vec<_>>(),
            "samples": samples,
            "cleared": cleared,
        })
    }

    /// Positions from where they were at the fault, following errors, currents, over time.
    pub(super) fn picture(&self) -> Picture {
        let axes = || 0..self.axes.len();
        let from_fault = |k| {
            let series = self.actual(k);
            let end = last(&series);
            series.into_iter().map(|[t, q]| [t, q - end]).collect()
        };
        let diagram = |y_name: String, curves| CurveDiagram {
            y_name,
            limit: None,
            curves,
        };
        let unit = self.unit;
        Picture::from(&CurvesPlot {
            title: format!("{}: {}", self.robot, fault_text(&self.record.fault)),
            names: self.axes.iter().map(|axis| axis.name.clone()).collect(),
            x_name: "time, the fault at 0 [s]".into(),
            diagrams: vec![
                diagram(format!("moved [{unit}]"), axes().map(from_fault).collect()),
                diagram(
                    format!("following error [{unit}]"),
                    axes().map(|k| self.error(k)).collect(),
                ),
                diagram(
                    "current [A]".into(),
                    axes().map(|k| self.current(k)).collect(),
                ),
            ],
        })
    }
}

fn last(series: &[[f64; 2]]) -> f64 {
    series.last().map_or(0.0, |[_, value]| *value)
}

/// The value farthest from 0.
fn greatest(series: &[[f64; 2]]) -> f64 {
    let farther = |most: f64, value: f64| {
        if value.abs() > most.abs() {
            value
        } else {
            most
        }
    };
    series
        .iter()
        .fold(0.0, |most, [_, value]| farther(most, *value))
}
