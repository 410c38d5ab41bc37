//! `mrroc robot report`: how near a configuration is to singularities and limits, or, without one, what a robot
//! can do in the whole of its ranges.
//!
//! ```text
//!   --joints …  {"name","length_m","singular_values":[…],"manipulability","condition","near_singular",
//!                "axes":[{"name","joint":[to lower, to upper],"motor":[…]},…],
//!                "nearest_joint":{"axis","share"},"nearest_motor":{…},"legs":{"singular_values":[…],"condition"}}
//!   without     {"name","length_m","samples","driveable","sampled":[[from, to],…],"flange_m":[[x, x],[y, y],[z, z]],
//!                "tool_m":[…],"manipulability":{"worst","median"},"near_singular","legs":{"worst_condition"},
//!                "work_area":{"centre_m","size_m","clearance_m"}}
//! ```
//!
//! Singular values are those of the flange's Jacobian, its linear rows divided by `length_m`, the length of the
//! default tool (1 m without one): as many as there are axes, at most six. Manipulability is their product, the
//! condition the greatest over the least, null where that is 0. A distance to a limit is null where there is none,
//! and negative outside. `legs`, of the RNT alone, are the singular values of ∂(leg lengths)/∂(tilt, tilt, reach),
//! a radian being worth a metre; `work_area` is in its base's frame.

#[cfg(test)]
mod test;

use std::io::{self, Write};

use clap::Args;
use process::{End, exit};
use robots::report::{Margin, Posture, posture, singular_values};
use robots::rnt::{WORK_AREA_CENTRE_M, WORK_AREA_CLEARANCE_M, WORK_AREA_SIZE_M};
use robots::{AxisDescription, JointKind, Joints, KinematicError, Range, Rnt, RobotKind};
use robots::{Robot, RobotVisitor, TrackRule};
use serde_json::{Value, json};

use crate::commands::{finite, robot};
use crate::jsonl::write_line;

/// Points of the ranges that are looked at.
const SAMPLES: u32 = 4096;
/// ASSUMED: the least singular value below which a configuration counts as near a singularity: joints turn twenty
/// times as fast as the tool.
const NEAR_SINGULAR: f64 = 0.05;
/// The bases of the sequence of samples, one an axis (J. H. Halton, 1960).
const BASES: [u32; 7] = [2, 3, 5, 7, 11, 13, 17];

#[derive(Debug, Args)]
pub(super) struct Report {
    /// The robot's name, such as irp6-track
    robot: String,
    /// Joint positions, rad or m, separated by commas; without them, the whole workspace
    #[arg(long, value_delimiter = ',', allow_hyphen_values = true, value_parser = finite)]
    joints: Vec<f64>,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

impl Report {
    /// # Errors
    /// There is no such robot; the joints are not as many as its axes; a motor or leg cannot get there; or `out`
    /// cannot be written.
    pub(super) fn run(self, out: &mut dyn Write) -> Result<(), End> {
        let kind = robot(&self.robot)?;
        let json = self.json;
        let answer = kind.visit(TrackRule::Keep, Asked { kind, report: self })?;
        let written = if json {
            write_line(out, &answer)
        } else {
            as_text(out, &answer, 0)
        };
        written.map_err(|error| End::new(exit::IO, format!("stdout: {error}")))
    }
}

struct Asked {
    kind: RobotKind,
    report: Report,
}

impl RobotVisitor for Asked {
    type Output = Result<Value, End>;

    fn visit<R: Robot<N>, const N: usize>(self, robot: R) -> Result<Value, End> {
        let Self { kind, report } = self;
        if report.joints.is_empty() {
            return Ok(workspace(kind, &robot));
        }
        let joints = <[f64; N]>::try_from(report.joints)
            .map_err(|given| End::usage(format!("{kind} has {N} joints, not {}", given.len())))?;
        at(kind, &robot, &Joints(joints))
            .map_err(|error| End::new(exit::REFUSED, format!("{kind}: {error}")))
    }
}

/// The length that turning is compared with, m.
fn length<const N: usize>(robot: &impl Robot<N>) -> f64 {
    let [x, y, z] = robot.description().tool_offset_m;
    let length = libm::sqrt(x * x + y * y + z * z);
    if length > 0.0 { length } else { 1.0 }
}

/// The singular values that a robot of N axes can have, greatest first.
fn values<const N: usize>(posture: &Posture) -> Vec<f64> {
    posture.singular_values.iter().take(N).copied().collect()
}

fn least(values: &[f64]) -> f64 {
    values.last().copied().unwrap_or(0.0)
}

/// Greatest over least; nothing where the least is 0.
fn condition(values: &[f64]) -> Option<f64> {
    let ratio = values.first()? / values.last()?;
    ratio.is_finite().then_some(ratio)
}

/// The singular values of the RNT's legs; nothing for other robots.
fn legs(kind: RobotKind, joints: &[f64]) -> Option<[f64; 3]> {
    if kind != RobotKind::Rnt {
        return None;
    }
    let joints = Joints(joints.try_into().ok()?);
    Rnt.leg_jacobian(&joints).ok().map(singular_values)
}

fn at<const N: usize>(
    kind: RobotKind,
    robot: &impl Robot<N>,
    joints: &Joints<N>,
) -> Result<Value, KinematicError> {
    let length_m = length(robot);
    let posture = posture(robot, joints, length_m)?;
    let motors = robot.motors(joints)?;
    let axes = &robot.description().axes;
    let values = values::<N>(&posture);
    let margin = |margin: Option<Margin>| {
        let Margin { axis, share } = margin?;
        Some(json!({ "axis": axes.get(axis)?.name, "share": share }))
    };
    let of_axes = axes
        .iter()
        .zip(joints.0)
        .zip(motors.0)
        .map(|((axis, joint), motor)| {
            json!({
                "name": axis.name,
                "joint": distances(joint, axis.joint_position),
                "motor": distances(motor, axis.motor_position),
            })
        });
    let mut answer = json!({
        "name": robot.description().name,
        "length_m": length_m,
        "manipulability": values.iter().product::<f64>(),
        "condition": condition(&values),
        "near_singular": least(&values) < NEAR_SINGULAR,
        "singular_values": values,
        "axes": of_axes.collect::<Vec<_>>(),
        "nearest_joint": margin(posture.joints),
        "nearest_motor": margin(posture.motors),
    });
    if let Some(values) = legs(kind, &joints.0) {
        answer["legs"] = json!({ "singular_values": values, "condition": condition(&values) });
    }
    Ok(answer)
}

/// From the lower and to the upper end; nothing where a range has no such end.
fn distances(value: f64, range: Range) -> [Option<f64>; 2] {
    [value - range.lower, range.upper - value].map(|d| d.is_finite().then_some(d))
}

/// Where an axis is sampled: in its range, or in a turn or metre of an endless one.
fn sampled(axis: &AxisDescription) -> Range {
    let half = match axis.kind {
        JointKind::Revolute => core::f64::consts::PI,
        JointKind::Prismatic => 0.5,
    };
    if axis.joint_position.is_bounded() {
        axis.joint_position
    } else {
        Range {
            lower: -half,
            upper: half,
        }
    }
}

/// The digits of `number` to a base, mirrored behind the point: evenly spread in 0..1.
fn radical_inverse(mut number: u32, base: u32) -> f64 {
    let (mut value, mut digit) = (0.0, 1.0);
    while number > 0 {
        digit /= f64::from(base);
        value += digit * f64::from(number % base);
        number /= base;
    }
    value
}

/// Least and greatest of every coordinate.
struct Extent([[f64; 2]; 3]);

impl Extent {
    const NONE: Self = Self([[f64::INFINITY, f64::NEG_INFINITY]; 3]);

    fn add(&mut self, point: &[f64]) {
        for ([low, high], x) in self.0.iter_mut().zip(point) {
            *low = if *x < *low { *x } else { *low };
            *high = if *x > *high { *x } else { *high };
        }
    }
}

fn workspace<const N: usize>(kind: RobotKind, robot: &impl Robot<N>) -> Value {
    let description = robot.description();
    let ranges = description.axes.each_ref().map(sampled);
    let (length_m, tool) = (length(robot), description.default_tool());
    let (mut flange, mut tip) = (Extent::NONE, Extent::NONE);
    let mut manipulabilities = Vec::new();
    let (mut near_singular, mut worst_legs) = (0_u32, 0.0);
    for sample in 1..=SAMPLES {
        let unit: [f64; N] =
            core::array::from_fn(|k| radical_inverse(sample, BASES[k % BASES.len()]));
        let joints = Joints(core::array::from_fn(|k| {
            ranges[k].lower + unit[k] * (ranges[k].upper - ranges[k].lower)
        }));
        let inside = robot
            .motors(&joints)
            .and_then(|motors| robot.check_motors(&motors));
        let Ok(posture) = inside.and_then(|()| posture(robot, &joints, length_m)) else {
            continue;
        };
        let pose = robot.forward(&joints);
        flange.add(pose.position.as_slice());
        tip.add((pose * tool).position.as_slice());
        let values = values::<N>(&posture);
        near_singular += u32::from(least(&values) < NEAR_SINGULAR);
        manipulabilities.push(values.iter().product::<f64>());
        if let Some(legs) = legs(kind, &joints.0) {
            let condition = condition(&legs).unwrap_or(f64::INFINITY);
            worst_legs = if condition > worst_legs {
                condition
            } else {
                worst_legs
            };
        }
    }
    manipulabilities.sort_unstable_by(f64::total_cmp);
    let driveable = manipulabilities.len();
    let share =
        f64::from(near_singular) / f64::from(u32::try_from(driveable.max(1)).unwrap_or(u32::MAX));
    let mut answer = json!({
        "name": description.name,
        "length_m": length_m,
        "samples": SAMPLES,
        "driveable": driveable,
        "sampled": ranges.map(|range| [range.lower, range.upper]).to_vec(),
        "flange_m": flange.0,
        "tool_m": tip.0,
        "manipulability": {
            "worst": manipulabilities.first(),
            "median": manipulabilities.get(driveable / 2),
        },
        "near_singular": share,
    });
    if kind == RobotKind::Rnt {
        answer["legs"] = json!({ "worst_condition": worst_legs });
        answer["work_area"] = json!({
            "centre_m": WORK_AREA_CENTRE_M,
            "size_m": WORK_AREA_SIZE_M,
            "clearance_m": WORK_AREA_CLEARANCE_M,
        });
    }
    answer
}

/// The same for people: a line a value, below the name of what it belongs to.
fn as_text(out: &mut dyn Write, value: &Value, depth: usize) -> io::Result<()> {
    let Value::Object(fields) = value else {
        return Ok(());
    };
    let indent = 2 * depth;
    if let Some(name) = fields.get("name") {
        writeln!(out, "{:1$}{2}", "", indent.saturating_sub(1), plain(name))?;
    }
    for (name, value) in fields.iter().filter(|(name, _)| *name != "name") {
        let item = name.replace('_', " ");
        match value {
            Value::Object(_) => {
                writeln!(out, "{:indent$}{item}", "")?;
                as_text(out, value, depth + 1)?;
            }
            Value::Array(values) if values.iter().any(Value::is_object) => {
                writeln!(
                    out,
                    "{:indent$}{item}, each from its lower and to its upper limit",
                    ""
                )?;
                for value in values {
                    as_text(out, value, depth + 1)?;
                }
            }
            other => writeln!(out, "{:indent$}{item:20} {}", "", plain(other))?,
        }
    }
    Ok(())
}

fn plain(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        Value::Null => "none".into(),
        Value::Array(values) if values.iter().any(Value::is_array) => {
            values.iter().map(plain).collect::<Vec<_>>().join("; ")
        }
        Value::Array(values) => values.iter().map(plain).collect::<Vec<_>>().join(" "),
        Value::Number(number) => number
            .as_f64()
            .filter(|_| number.is_f64())
            .map_or_else(|| number.to_string(), |x| format!("{x:.6}")),
        other => other.to_string(),
    }
}
