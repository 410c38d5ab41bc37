//! What a servo step costs in instructions, by what the node is doing: counted outside, by a plugin of the
//! emulator, between the functions `mrroc_step_begins` and `mrroc_step_ends`.

use super::elf::Image;
use super::golden::Figure;
use super::machine::Setup;
use super::node::{EmulatedNode, Life, in_process};
use super::tape::Recorder;
use super::traces::boot;
use crate::coordinator::{Coordinator, speeds};
use hil_sim::drive::DriveFault;
use protocol::message::{Instruction, NodeState, Request, ServoLaw, StopKind};
use robots::RobotKind;
use std::path::Path;

/// A fifth of the 170 000 instructions that a millisecond has at 170 MHz, one a cycle.
const TARGET: u64 = 34_000;
/// A hundredth.
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
    let symbols = Image::read(image)?;
    let address = |name: &str| {
        symbols
            .address(name)
            .ok_or_else(|| format!("the image has no {name}"))
    };
    let (begin, end) = (address("mrroc_step_begins")?, address("mrroc_step_ends")?);
    if begin == end {
        return Err("both marks are one function".into());
    }
    let (counts, states, life) = count(kind, law, image, plugin, begin, end)?;
    if counts.len() != states.len() {
        return Err(format!("{} steps, {} counts", states.len(), counts.len()));
    }
    Ok((figures(name, &counts, &states), life))
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
    let (mut counts, _, _) = count(kind, law, image, plugin, *step, 0)?;
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
    begin: u64,
    end: u64,
) -> Result<(Vec<u64>, Vec<NodeState>, Life), String> {
    let counts = std::env::temp_dir().join(format!("mrroc-counts-{}", std::process::id()));
    let setup = Setup {
        image: image.to_owned(),
        plugin: Some(format!(
            "{},begin={begin:#x},end={end:#x},out={}",
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
