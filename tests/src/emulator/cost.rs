//! What a servo step costs in instructions, by what the node is doing, and what the ECP's work costs below it:
//! counted outside, by a plugin of the emulator, between the functions `mrroc_step_begins` and `mrroc_step_ends`,
//! and `mrroc_work_begins` and `mrroc_work_ends` without the ticks that preempt it.

use super::elf::Image;
use super::golden::Figure;
use super::machine::Setup;
use super::node::{EmulatedNode, Life, in_process};
use super::tape::Recorder;
use super::traces::boot;
use crate::coordinator::{Coordinator, speeds};
use hil_sim::drive::DriveFault;
use motion::Pose;
use nalgebra::Vector3;
use protocol::message::{
    Corner, Instruction, NodeState, PATH_BATCH, PathElement, PoseMessage, PosePath, PoseReference,
    PoseSpeeds, Reply, Request, ServoLaw, StopKind,
};
use robots::{Irp6Postument, Joints, Robot, RobotKind};
use std::fmt::Write as _;
use std::path::Path;

/// A fifth of the 170 000 instructions that a millisecond has at 170 MHz, one a cycle.
const TARGET: u64 = 34_000;
/// Half of the 2 720 000 that 16 ms have: the time from an order to its plan.
const WORK: u64 = 1_360_000;
/// A hundredth of a millisecond.
const INTERPOLATION: u64 = 1700;
/// Per cent by which compilers may differ.
const BAND: u64 = 5;

/// Median and worst of the servo steps of each phase, for one law.
///
/// # Errors
/// What went wrong.
pub fn measure(
    kind: RobotKind,
    (name, law): (&str, ServoLaw),
    image: &Path,
    plugin: &Path,
) -> Result<(Vec<Figure>, Life), String> {
    let marks = marks(
        image,
        &[("begin", "mrroc_step_begins"), ("end", "mrroc_step_ends")],
    )?;
    let (counts, states, life) = count(kind, law, image, plugin, &marks, work)?;
    if counts.len() != states.len() {
        return Err(format!("{} steps, {} counts", states.len(), counts.len()));
    }
    Ok((figures(name, &counts, &states), life))
}

/// What the ECP's work costs, of an order: motions of motors, lines, and a streamed path with rounded corners, curves
/// and arcs.
///
/// # Errors
/// What went wrong.
pub fn plans(kind: RobotKind, image: &Path, plugin: &Path) -> Result<Vec<Figure>, String> {
    let marks = marks(
        image,
        &[
            ("begin", "mrroc_work_begins"),
            ("end", "mrroc_work_ends"),
            ("pause", "mrroc_tick_begins"),
            ("resume", "mrroc_tick_ends"),
        ],
    )?;
    let law = ServoLaw::DrivePosition;
    let (mut counts, _, life) = count(kind, law, image, plugin, &marks, paths)?;
    counts.sort_unstable();
    let median = counts.get(counts.len() / 2).copied().unwrap_or(0);
    let worst = counts.last().copied().unwrap_or(0);
    println!("{} orders of {} steps", counts.len(), life.steps);
    Ok(vec![
        Figure::new("work_median", median, BAND).at_most(WORK),
        Figure::new("work_worst", worst, BAND).at_most(WORK),
    ])
}

/// Addresses of functions of the image, as the plugin wants them; each is a function of its own.
fn marks(image: &Path, wanted: &[(&str, &str)]) -> Result<String, String> {
    let symbols = Image::read(image)?;
    let mut addresses = Vec::new();
    let mut out = String::new();
    for (role, name) in wanted {
        let address = symbols.address(name);
        let address = address.ok_or_else(|| format!("the image has no {name}"))?;
        if addresses.contains(&address) {
            return Err(format!("{name} is one function with another mark"));
        }
        addresses.push(address);
        // a string takes everything
        let _ = write!(out, ",{role}={address:#x}");
    }
    Ok(out)
}

/// What the interpolation of all axes costs alone, position in the drive.
///
/// # Errors
/// What went wrong.
pub fn interpolation(kind: RobotKind, image: &Path, plugin: &Path) -> Result<Vec<Figure>, String> {
    let symbols = Image::read(image)?;
    let step = symbols
        .symbols
        .iter()
        .find(|(name, _)| name.contains("12interpolator4step") && name.contains("E4stepC"));
    let (_, step) = step.ok_or("the image has no step of the interpolator")?;
    let law = ServoLaw::DrivePosition;
    let marks = format!(",begin={step:#x}");
    let (mut counts, _, _) = count(kind, law, image, plugin, &marks, work)?;
    counts.sort_unstable();
    let median = counts.get(counts.len() / 2).copied().unwrap_or(0);
    let worst = counts.last().copied().unwrap_or(0);
    Ok(vec![
        Figure::new("interpolation_median", median, BAND).at_most(INTERPOLATION),
        Figure::new("interpolation_worst", worst, BAND).at_most(INTERPOLATION),
    ])
}

/// Instructions of every call, the state after every step, and how it ended.
fn count(
    kind: RobotKind,
    law: ServoLaw,
    image: &Path,
    plugin: &Path,
    marks: &str,
    work: impl FnOnce(Coordinator, RobotKind),
) -> Result<(Vec<u64>, Vec<NodeState>, Life), String> {
    let counts = std::env::temp_dir().join(format!("mrroc-counts-{}", std::process::id()));
    let setup = Setup {
        image: image.to_owned(),
        plugin: Some(format!(
            "{}{marks},out={}",
            plugin.display(),
            counts.display()
        )),
    };
    let mut boot = boot(kind, 3);
    boot.station.law = law;
    let (_, drives) = in_process(&boot).map_err(|error| error.to_string())?;
    let (node, handle) = EmulatedNode::boot(&setup, &boot).map_err(|error| error.to_string())?;
    let (recorder, recording) = Recorder::new(Box::new(node), boot.clone());
    work(
        Coordinator::with_node(&boot, Box::new(recorder), &drives),
        kind,
    );
    let life = handle.finish()?;
    let text = std::fs::read_to_string(&counts).map_err(|error| error.to_string())?;
    let _ = std::fs::remove_file(&counts);
    let counts: Vec<u64> = text.lines().filter_map(|line| line.parse().ok()).collect();
    let states: Vec<_> = recording.tape().steps.iter().map(|s| s.state).collect();
    Ok((counts, states, life))
}

/// Homing, a move, a stop on the path, a quick stop, a drive that falls silent.
fn work(mut c: Coordinator, kind: RobotKind) {
    c.enable();
    c.home();
    let by = |c: &mut Coordinator, rad: f64| {
        c.begin(Instruction::MoveMotors {
            target: core::iter::repeat_n(rad, kind.axes()).collect(),
            relative: true,
            speeds: speeds(kind.axes(), 0.5, 0.5),
        })
    };
    by(&mut c, 10.0);
    c.finish("a move");
    for stop in [StopKind::Path, StopKind::Quick] {
        by(&mut c, -10.0);
        for _ in 0..20 {
            c.macrostep();
        }
        c.stop(stop);
        c.recover();
    }
    by(&mut c, -10.0);
    for _ in 0..20 {
        c.macrostep();
    }
    if let Some(robot) = c.cell.robot_mut(0) {
        robot.inject(0, Some(DriveFault::Silent));
    }
    c.wait_for(NodeState::Faulted);
    for _ in 0..50 {
        c.macrostep();
    }
    let epoch = c.epoch();
    let _ = c.try_request(&Request::Release { epoch });
}

/// A posture of the postument in the middle of its reach, rad.
const POSTURE: [f64; 6] = [0.0, -1.57, 0.0, 1.2, 1.57, -1.57];

/// Homing, a move, a line, and a path of everything a path may have, to the same robot.
fn paths(mut c: Coordinator, kind: RobotKind) {
    c.enable();
    c.home();
    c.execute(Instruction::MoveJoints {
        target: POSTURE.into_iter().collect(),
        relative: false,
        speeds: speeds(kind.axes(), 0.8, 0.8),
    });
    let speeds = PoseSpeeds {
        velocity_m_s: 0.15,
        angular_velocity_rad_s: 0.5,
        acceleration_m_s2: 1.0,
        angular_acceleration_rad_s2: 2.0,
    };
    c.execute(Instruction::MovePose {
        target: PoseMessage {
            position_m: [-0.03, -0.03, 0.0],
            rotation_rad: [0.0; 3],
        },
        reference: PoseReference::Tool,
        path: PosePath::Line,
        speeds,
    });
    let joints = Joints(POSTURE);
    let arm = Irp6Postument;
    let line = Pose::from_rotation_vector(Vector3::new(-0.03, -0.03, 0.0), Vector3::zeros());
    let begin = arm.forward(&joints) * arm.description().default_tool() * line;
    let begun = c.begin(Instruction::FollowPath { speeds });
    assert_eq!(begun, Reply::Accepted, "a path");
    let elements = elements(&begin);
    let mut next = 0;
    while let Some(rest) = elements.get(next..)
        && !rest.is_empty()
    {
        let epoch = c.epoch();
        let batch = rest.iter().take(PATH_BATCH).copied().collect();
        let first = u32::try_from(next).unwrap_or(u32::MAX);
        let reply = c.request(&Request::Path {
            epoch,
            first,
            elements: batch,
        });
        let Reply::Path { next: wanted, .. } = reply else {
            panic!("{reply:?}")
        };
        next = usize::try_from(wanted).unwrap_or(usize::MAX);
    }
    c.finish("a path");
}

/// Lines that meet in rounded corners, arcs, and a curve through points 2 mm apart, in the plane of the tool.
fn elements(begin: &Pose) -> Vec<PathElement> {
    let to = |x: f64, y: f64| {
        let to = *begin * Pose::from_rotation_vector(Vector3::new(x, y, 0.0), Vector3::zeros());
        PoseMessage {
            position_m: to.position.into(),
            rotation_rad: to.rotation_vector().into(),
        }
    };
    let corner = Corner {
        metres: 0.001,
        radians: 0.01,
    };
    let mut out = Vec::new();
    for k in 0..6 {
        let x = 0.01 * f64::from(k);
        let line = |x, y| PathElement::Line {
            to: to(x, y),
            corner,
        };
        out.extend([line(x, 0.01), line(x + 0.005, 0.01), line(x + 0.005, 0.0)]);
        out.push(PathElement::Arc {
            via_m: to(x + 0.0075, -0.0025).position_m,
            to: to(x + 0.01, 0.0),
            corner,
        });
    }
    for k in 0..30 {
        let angle = 0.2 * f64::from(k);
        let (x, y) = (0.06 - 0.002 * f64::from(k), 0.01 * libm::sin(angle));
        out.push(PathElement::Through(to(x, y)));
    }
    out.push(PathElement::End);
    out
}

/// A period is two steps: SYNC, and half a period later the servos.
fn figures(law: &str, counts: &[u64], states: &[NodeState]) -> Vec<Figure> {
    let mut out = Vec::new();
    for (name, state) in [
        ("homing", NodeState::Synchronising),
        ("holding", NodeState::Holding),
        ("moving", NodeState::Moving),
        ("stopping", NodeState::Stopping),
        ("faulted", NodeState::Faulted),
    ] {
        let mut periods: Vec<u64> = counts
            .chunks_exact(2)
            .zip(states.chunks_exact(2))
            .filter(|(_, states)| states.contains(&state))
            .map(|(counts, _)| counts.iter().sum())
            .collect();
        periods.sort_unstable();
        let median = periods.get(periods.len() / 2).copied().unwrap_or(0);
        let worst = periods.last().copied().unwrap_or(0);
        out.push(Figure::new(format!("{law}_{name}_median"), median, BAND).at_most(TARGET));
        out.push(Figure::new(format!("{law}_{name}_worst"), worst, BAND).at_most(TARGET));
    }
    out
}
