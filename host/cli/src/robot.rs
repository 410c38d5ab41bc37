//! `mrroc robot report` is in `report`; `mrroc robot show`: what is known about a robot, each number with its unit and its source or the
//! word ASSUMED; as text, as one JSON object, or as a URDF file of its rigid-body model.
//!
//! ```text
//!   --json   {"name","long_name","robot":[…],"axes":[{"name","kind","parameters":[…]},…],"links":[…],"assumed":[…]}
//!            a parameter: {"item","values":[…],"unit","source"}; a value is null where a range has no end
//!            a link: {"name","kind","position_m","axes","mass_kg","centre_m","inertia_kg_m2","geometry","source"}:
//!            the sources of its place and of its mass
//!            an assumed number: {"item","value","unit","why"}: of every robot
//!   --urdf   XML, `robots::urdf`
//! ```

mod parameters;
mod report;
#[cfg(test)]
mod test;

use std::io::{self, Write};

use clap::{Args, Subcommand};
use process::{End, exit};
use robots::dynamics::{Chain, Inertia};
use robots::urdf::{joint_limits, write_urdf};
use robots::{Assumed, JointKind, RobotKind, RobotVisitor, Source, TrackRule};
use serde_json::{Value, json};

use crate::commands::robot;
use crate::jsonl::write_line;
use parameters::Parameter;

/// What is known about the robots
#[derive(Debug, Args)]
pub(crate) struct Robot {
    #[command(subcommand)]
    question: Question,
}

#[derive(Debug, Subcommand)]
enum Question {
    /// Axes, limits, constants and masses of a robot, with units and sources
    Show(Show),
    /// Singularities and limits at a configuration, or over the whole workspace
    Report(report::Report),
}

#[derive(Debug, Args)]
struct Show {
    /// The robot's name, such as irp6-track
    robot: String,
    /// Print the rigid-body model as a URDF file
    #[arg(long, conflicts_with = "json")]
    urdf: bool,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

impl Robot {
    /// Prints what was asked for.
    ///
    /// # Errors
    /// There is no such robot, it has no answer, or `out` cannot be written.
    pub(crate) fn run(self, out: &mut dyn Write) -> Result<(), End> {
        let show = match self.question {
            Question::Show(show) => show,
            Question::Report(report) => return report.run(out),
        };
        let kind = robot(&show.robot)?;
        kind.visit(TrackRule::Keep, Answer { kind, show, out })
    }
}

struct Answer<'a> {
    kind: RobotKind,
    show: Show,
    out: &'a mut dyn Write,
}

impl RobotVisitor for Answer<'_> {
    type Output = Result<(), End>;

    fn visit<R: robots::Robot<N>, const N: usize>(self, robot: R) -> Result<(), End> {
        let Self { kind, show, out } = self;
        let chain = robot.chain();
        let written = if show.urdf {
            let Some(chain) = &chain else {
                let what =
                    format!("{kind} has no links that move one another: there is no URDF of it");
                return Err(End::usage(what));
            };
            urdf(kind, &robot, chain).and_then(|text| out.write_all(text.as_bytes()))
        } else if show.json {
            write_line(out, &as_json(&robot, chain.as_ref()))
        } else {
            as_text(&robot, chain.as_ref(), out)
        };
        written.map_err(|error| End::new(exit::IO, format!("stdout: {error}")))
    }
}

/// What a tree of links leaves out of a robot.
const fn left_out(kind: RobotKind) -> &'static str {
    match kind {
        RobotKind::Rnt => {
            "; the tree part of the robot, central leg and wrist: the three driven legs close loops and are lumped \
             into it, and what these joints can do is not what their motors can"
        }
        RobotKind::Irp6Track
        | RobotKind::Irp6Postument
        | RobotKind::Polycrank
        | RobotKind::Irp6Arm
        | RobotKind::Conveyor
        | RobotKind::Irp6TrackGripper
        | RobotKind::Irp6PostumentGripper => "",
    }
}

fn urdf<const N: usize>(
    kind: RobotKind,
    robot: &impl robots::Robot<N>,
    chain: &Chain<N>,
) -> io::Result<String> {
    let description = robot.description();
    let limits = joint_limits(description, &robot.motor_slopes());
    let comment = format!(
        "{}: joints relative, link against link; geometry: {}; masses and shapes are {ASSUMED}{}",
        description.long_name,
        description.sources.geometry.name(),
        left_out(kind)
    );
    let mut text = String::new();
    write_urdf(&mut text, description.name, &comment, &limits, chain).map_err(io::Error::other)?;
    Ok(text)
}

const ASSUMED: &str = Source::Assumed.name();

const fn kind(kind: JointKind) -> &'static str {
    match kind {
        JointKind::Revolute => "revolute",
        JointKind::Prismatic => "prismatic",
    }
}

fn as_json<const N: usize>(robot: &impl robots::Robot<N>, chain: Option<&Chain<N>>) -> Value {
    let description = robot.description();
    let axes = description.axes.iter().map(|axis| {
        json!({
            "name": axis.name,
            "kind": kind(axis.kind),
            "parameters": parameters::of_axis(axis, &description.sources),
        })
    });
    let links = chain.iter().flat_map(|chain| &chain.links).map(|link| {
        let body = link.body();
        let Inertia {
            xx,
            yy,
            zz,
            xy,
            xz,
            yz,
        } = body.inertia;
        json!({
            "name": link.name,
            "kind": kind(link.kind),
            "position_m": link.placement.position_m,
            "axes": link.placement.axes,
            "mass_kg": body.mass_kg,
            "centre_m": body.centre_m,
            "inertia_kg_m2": [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]],
            "geometry": description.sources.geometry.name(),
            "source": ASSUMED,
        })
    });
    json!({
        "name": description.name,
        "long_name": description.long_name,
        "robot": parameters::of_robot(description),
        "axes": axes.collect::<Vec<_>>(),
        "links": links.collect::<Vec<_>>(),
        "assumed": assumed().map(|number| {
            let Assumed { item, value, unit, why } = *number;
            json!({ "item": item, "value": value, "unit": unit, "why": why })
        }).collect::<Vec<_>>(),
    })
}

fn as_text<const N: usize>(
    robot: &impl robots::Robot<N>,
    chain: Option<&Chain<N>>,
    out: &mut dyn Write,
) -> io::Result<()> {
    let description = robot.description();
    writeln!(out, "{}: {}", description.name, description.long_name)?;
    table(out, &parameters::of_robot(description))?;
    for (k, axis) in description.axes.iter().enumerate() {
        writeln!(out, "\naxis {}: {}, {}", k + 1, axis.name, kind(axis.kind))?;
        table(out, &parameters::of_axis(axis, &description.sources))?;
    }
    if let Some(chain) = chain {
        links(out, chain, description.sources.geometry)?;
    }
    writeln!(out, "\nASSUMED, of every robot: nobody has published these")?;
    for Assumed {
        item,
        value,
        unit,
        why,
    } in assumed()
    {
        writeln!(out, "  {item}: {value} {unit}   {why}")?;
    }
    Ok(())
}

/// Numbers that nobody has published, of the robots and of their links.
fn assumed() -> impl Iterator<Item = &'static Assumed> {
    robots::ASSUMED.iter().chain(robots::dynamics::ASSUMED)
}

fn links<const N: usize>(
    out: &mut dyn Write,
    chain: &Chain<N>,
    geometry: Source,
) -> io::Result<()> {
    writeln!(
        out,
        "\nlinks, each in the frame before it; z is the joint's axis; places: {}",
        geometry.name()
    )?;
    for link in &chain.links {
        let [x, y, z] = link.placement.position_m;
        let body = link.body();
        let [cx, cy, cz] = body.centre_m;
        let Inertia { xx, yy, zz, .. } = body.inertia;
        writeln!(
            out,
            "  {:12} at {x} {y} {z} m   {} kg, centre {cx} {cy} {cz} m, \
             inertia {xx:.4} {yy:.4} {zz:.4} kg·m²   {ASSUMED}",
            link.name, body.mass_kg
        )?;
    }
    let [x, y, z] = chain.flange.position_m;
    writeln!(out, "  {:12} at {x} {y} {z} m", "flange")
}

fn table(out: &mut dyn Write, parameters: &[Parameter]) -> io::Result<()> {
    for parameter in parameters {
        let values: Vec<String> = parameter.values.iter().map(f64::to_string).collect();
        let quantity = format!("{} {}", values.join(" "), parameter.unit);
        let (item, source) = (parameter.item, parameter.source.name());
        writeln!(out, "  {item:34} {quantity:40} {source}")?;
    }
    Ok(())
}
