//! `mrroc plan path`: what a robot's node would make of a path file, without the robot.

mod ride;
#[cfg(test)]
mod test;

use std::io::{self, Write};
use std::path::PathBuf;

use clap::Args;
use host::error::Error;
use host::input::Files;
use host::path::Reference;
use host::plot::{self, CurveDiagram, CurvesPlot, Picture};
use host::task::{self, PathStep};
use robots::{Joints, Robot, RobotKind, RobotVisitor, TrackRule};
use serde::Serialize;

use super::answer::Answer;
use super::cad::OnBoard;
use super::error::PlanError;
use crate::commands::{feed, finite, robot};
use crate::jsonl::write_line;
use ride::{Load, Moment, Ride, ride};

/// Distance of points at which the greatest curvature is looked for, m.
const CURVATURE_STEP_M: f64 = 2e-4;

const EXAMPLE: &str = "\
Example:
  mrroc plan path irp6-postument tasks/rose.csv --relative --from 0,-1.6,0.1,1.3,1.39,-1.84 --plot rose.png

Loads are those at the ends of macrosteps, 20 ms apart, as shares of what the node plans with.";

/// A tool along a path file, at the speed the robot's node chooses
///
/// Runs the node's own generator: feed, curvature, and how near every joint comes to the limits of velocity
/// and acceleration, at the velocity factor that a cell has without a word. Nothing moves.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLE)]
pub(super) struct PathPlan {
    /// The robot.
    robot: String,
    /// Points x,y,z or x,y,z,rx,ry,rz (.csv), lines, arcs and points (.toml), a program (.ngc) or a
    /// drawing (.dxf, .svg).
    file: PathBuf,
    /// Joints where the path begins, rad or m; without it, where homing ends.
    #[arg(long, value_delimiter = ',', allow_hyphen_values = true, value_parser = finite)]
    from: Option<Vec<f64>>,
    /// Greatest speed of the tool, m/s (0.05 without it).
    #[arg(long, value_name = "M_S", allow_negative_numbers = true, value_parser = feed)]
    feed: Option<f64>,
    /// The path is from where the tool is, along the axes of the base frame.
    #[arg(long)]
    relative: bool,
    /// Print the ride as one JSON value.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    on_board: OnBoard,
    /// Draw feed, curvature and loads (.svg or .png); may be given several times
    #[arg(long, value_name = "FILE")]
    plot: Vec<PathBuf>,
}

/// The JSON of a ride. A curvature that is not finite is null.
#[derive(Debug, Serialize)]
struct RideAnswer<'a> {
    elements: usize,
    length_m: f64,
    duration_s: f64,
    feed_programmed_m_s: f64,
    feed_mean_m_s: f64,
    feed_peak_m_s: f64,
    curvature_max_1_m: f64,
    curvature_max_at_s_m: f64,
    from: &'a [f64],
    t_s: Vec<f64>,
    s_m: Vec<f64>,
    v_m_s: Vec<f64>,
    a_m_s2: Vec<f64>,
    curvature_1_m: Vec<f64>,
    joints: Vec<JointAnswer<'a>>,
}

#[derive(Debug, Serialize)]
struct JointAnswer<'a> {
    name: &'a str,
    velocity_share_max: f64,
    velocity_share_max_at_s_m: f64,
    acceleration_share_max: f64,
    acceleration_share_max_at_s_m: f64,
    velocity_share: &'a [f64],
    acceleration_share: &'a [f64],
}

impl PathPlan {
    /// Plans the path and tells it.
    pub(super) fn run(self, out: &mut dyn Write) -> Result<(), PlanError> {
        let kind = robot(&self.robot)?;
        for path in &self.plot {
            plot::check_name(path)?;
        }
        let reference = if self.relative {
            Reference::Start
        } else {
            Reference::Base
        };
        let path = match self.on_board.program(&self.file)? {
            Some(program) => program.tool_path(&self.file).map_err(Error::from)?,
            None => task::path::load(&self.file, &Files::on_disk()).map_err(Error::from)?,
        };
        let step = PathStep::new(0, path, reference, self.feed);
        let riding = Riding {
            plan: &self,
            kind,
            step: &step,
        };
        let ride = match kind.visit(TrackRule::Keep, riding)? {
            Ok(ride) => ride,
            Err(why) => {
                let message = format!("{}: error: {kind}: {why}", self.file.display());
                if self.json {
                    let answer = Answer::None {
                        error: "refused",
                        axis: None,
                        message: message.clone(),
                    };
                    write_line(out, &answer)?;
                }
                return Err(PlanError::Refused(message));
            }
        };
        let answer = answer(&ride, asked(step.speeds.velocity_m_s));
        let title = format!("{}, {kind}", self.file.display());
        if !self.plot.is_empty() {
            let picture = Picture::from(&drawn(&title, &answer));
            for path in &self.plot {
                plot::save(&picture, path)?;
            }
        }
        if self.json {
            write_line(out, &answer)?;
        } else {
            table(out, &title, self.from.is_none(), &answer)?;
        }
        Ok(())
    }

    fn joints<const N: usize>(&self, kind: RobotKind) -> Result<Option<Joints<N>>, PlanError> {
        let Some(from) = &self.from else {
            return Ok(None);
        };
        let joints = <[f64; N]>::try_from(from.as_slice());
        joints.map(|joints| Some(Joints(joints))).map_err(|_| {
            let got = from.len();
            PlanError::Usage(format!("--from: {kind} has {N} joints (got {got})"))
        })
    }
}

/// Takes a robot along the path.
struct Riding<'a> {
    plan: &'a PathPlan,
    kind: RobotKind,
    step: &'a PathStep,
}

impl RobotVisitor for Riding<'_> {
    type Output = Result<Result<Ride, String>, PlanError>;

    fn visit<R: Robot<N> + Copy, const N: usize>(self, robot: R) -> Self::Output {
        let from = self.plan.joints(self.kind)?;
        Ok(ride(robot, self.step, from))
    }
}

/// The shortest decimal number that travels as this one: what was asked for.
fn asked(travels: f32) -> f64 {
    travels.to_string().parse().unwrap_or(travels.into())
}

fn answer(ride: &Ride, programmed: f64) -> RideAnswer<'_> {
    let each = |of: fn(&Moment) -> f64| -> Vec<f64> { ride.moments.iter().map(of).collect() };
    let s_m = each(|moment| moment.s_m);
    let v_m_s = each(|moment| moment.v_m_s);
    let course = &ride.streamed.course;
    let curvature = course
        .samples(CURVATURE_STEP_M)
        .filter_map(|s| Some((course.at(s)?.curvature(), s)));
    let (curvature_max_1_m, curvature_max_at_s_m) = greatest(curvature);
    let duration_s = ride.moments.last().map_or(0.0, |moment| moment.t_s);
    let length_m = course.length_m();
    RideAnswer {
        elements: ride.streamed.marks.len(),
        length_m,
        duration_s,
        feed_programmed_m_s: programmed,
        feed_mean_m_s: length_m / duration_s,
        feed_peak_m_s: greatest(pairs(&v_m_s, &s_m)).0,
        curvature_max_1_m,
        curvature_max_at_s_m,
        from: &ride.from,
        joints: ride.joints.iter().map(|load| joint(load, &s_m)).collect(),
        t_s: each(|moment| moment.t_s),
        a_m_s2: each(|moment| moment.a_m_s2),
        curvature_1_m: each(|moment| moment.curvature_1_m),
        s_m,
        v_m_s,
    }
}

fn joint<'a>(load: &'a Load, s_m: &[f64]) -> JointAnswer<'a> {
    let (velocity, velocity_at) = greatest(pairs(&load.velocity, s_m));
    let (acceleration, acceleration_at) = greatest(pairs(&load.acceleration, s_m));
    JointAnswer {
        name: load.name,
        velocity_share_max: velocity,
        velocity_share_max_at_s_m: velocity_at,
        acceleration_share_max: acceleration,
        acceleration_share_max_at_s_m: acceleration_at,
        velocity_share: &load.velocity,
        acceleration_share: &load.acceleration,
    }
}

fn pairs<'a>(a: &'a [f64], b: &'a [f64]) -> impl Iterator<Item = (f64, f64)> + 'a {
    a.iter().copied().zip(b.iter().copied())
}

/// The first of the greatest values that are not negative, and where it is.
fn greatest(values: impl Iterator<Item = (f64, f64)>) -> (f64, f64) {
    values.fold(
        (0.0, 0.0),
        |most, value| {
            if value.0 > most.0 { value } else { most }
        },
    )
}

fn table(out: &mut dyn Write, title: &str, homed: bool, ride: &RideAnswer<'_>) -> io::Result<()> {
    let from: Vec<String> = ride.from.iter().map(|q| format!("{q:.4}")).collect();
    let place = if homed { " (where homing ends)" } else { "" };
    writeln!(out, "{title}")?;
    writeln!(out, "begins at joints {}{place}", from.join(", "))?;
    let (length, duration) = (ride.length_m, ride.duration_s);
    writeln!(
        out,
        "{} elements, {length:.4} m in {duration:.2} s",
        ride.elements
    )?;
    let (mean, peak) = (ride.feed_mean_m_s, ride.feed_peak_m_s);
    let programmed = ride.feed_programmed_m_s;
    writeln!(
        out,
        "feed: mean {mean:.4} m/s, peak {peak:.4} m/s, programmed {programmed:.4} m/s"
    )?;
    let (curvature, at) = (ride.curvature_max_1_m, ride.curvature_max_at_s_m);
    writeln!(
        out,
        "greatest curvature {curvature:.2} 1/m at s = {at:.4} m\n"
    )?;
    let head = ["velocity", "at s [m]", "acceleration", "at s [m]"];
    let [v, v_at, a, a_at] = head;
    writeln!(
        out,
        "{:<16}{v:>14}{v_at:>12}{a:>16}{a_at:>12}",
        "largest share"
    )?;
    for joint in &ride.joints {
        writeln!(
            out,
            "{:<16}{:>14.4}{:>12.4}{:>16.4}{:>12.4}",
            joint.name,
            joint.velocity_share_max,
            joint.velocity_share_max_at_s_m,
            joint.acceleration_share_max,
            joint.acceleration_share_max_at_s_m
        )?;
    }
    Ok(())
}

fn drawn(title: &str, ride: &RideAnswer<'_>) -> CurvesPlot {
    let over_s = |values: &[f64]| -> Vec<[f64; 2]> {
        pairs(&ride.s_m, values)
            .map(|(s, value)| [s, value])
            .collect()
    };
    let diagram = |y_name: &str, limit, curves| CurveDiagram {
        y_name: y_name.into(),
        limit,
        curves,
    };
    let joints = ride.joints.iter();
    let velocity = joints.clone().map(|joint| over_s(joint.velocity_share));
    let acceleration = joints.clone().map(|joint| over_s(joint.acceleration_share));
    let feed = vec![over_s(&ride.v_m_s)];
    CurvesPlot {
        title: title.into(),
        names: joints.map(|joint| joint.name.into()).collect(),
        x_name: "along the path [m]".into(),
        diagrams: vec![
            diagram("feed [m/s]", Some(ride.feed_programmed_m_s), feed),
            diagram("curvature [1/m]", None, vec![over_s(&ride.curvature_1_m)]),
            diagram("velocity [share]", Some(1.0), velocity.collect()),
            diagram("acceleration [share]", Some(1.0), acceleration.collect()),
        ],
    }
}
