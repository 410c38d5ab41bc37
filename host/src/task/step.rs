//! The steps of a task.

use super::document::{Document, Fields, Value, one_of};
use super::{Action, Cell, Coordination, Move, Replay, Step, Target, Tight, cell};
use crate::input::{DataError, LoadError, Problem, position, shown};
use motion::pose::Pose;
use nalgebra::Vector3;
use protocol::message::{PosePath, PoseReference};

/// The longest wait of a task, s.
const LONGEST_WAIT_S: f64 = 3600.0;

/// Speeds of a motion whose task says nothing, as fractions of the ceilings: the defaults of
/// MRROC++'s smooth generator for axes; for poses 0.1 m/s and 0.1 m/s², which it leaves to the task.
pub(super) const AXIS_SPEED: (f64, f64) = (0.15, 0.02);
pub(super) const POSE_SPEED: (f64, f64) = (0.02, 0.02);

pub(super) fn read(
    document: &Document<'_>,
    cell: &Cell,
    value: &Value<'_, '_>,
) -> Result<Step, DataError> {
    let fields = value.fields(
        "a step",
        &[
            "name",
            "home",
            "trj",
            "coordination",
            "move",
            "wait",
            "tight",
            "path",
            "engrave",
            "regulator",
        ],
    )?;
    let (key, value) = fields.exactly_one(&[
        "home",
        "trj",
        "move",
        "wait",
        "tight",
        "path",
        "engrave",
        "regulator",
    ])?;
    if key != "trj"
        && let Some(stray) = fields.optional("coordination")
    {
        return Err(stray.error(
            Problem::Conflict,
            "`coordination` of a step that replays nothing",
            "a step with `trj`",
            format!("`{key}`"),
        ));
    }
    let action = match key {
        "home" => Action::Home {
            robots: robots(cell, &value, 1)?,
        },
        "trj" => replay(document, cell, &fields, &value)?,
        "move" => Action::Move {
            moves: moves(cell, &value)?,
        },
        "wait" => Action::Wait {
            seconds: value
                .fields("a wait", &["seconds"])?
                .required("seconds")?
                .number("greater than 0, at most 3600", |s| {
                    s > 0.0 && s <= LONGEST_WAIT_S
                })?,
        },
        "tight" => Action::Tight(tight(cell, &value)?),
        "engrave" => Action::Engrave(super::engrave::read(document, cell, &value)?),
        "path" => Action::Path(super::path::read(document, cell, &value)?),
        _ => {
            let fields = value.fields("a choice of regulator", &["robot", "law"])?;
            Action::Regulator {
                robot: robot(cell, &fields.required("robot")?)?,
                law: fields
                    .required("law")?
                    .choice("servo law", &cell::SERVO_LAWS)?,
            }
        }
    };
    let name = match fields.optional("name") {
        Some(value) => value.text()?.to_owned(),
        None => action.describe(cell),
    };
    Ok(Step {
        name,
        line: position(document.text, fields.span.start).0,
        action,
    })
}

pub(super) fn robot(cell: &Cell, value: &Value<'_, '_>) -> Result<usize, DataError> {
    let name = value.text()?;
    find(cell, name).map_err(|expected| {
        value.error(Problem::UnknownName, "unknown robot", expected, shown(name))
    })
}

/// The index of a robot, or the names there are.
fn find(cell: &Cell, name: &str) -> Result<usize, String> {
    cell.robot(name).ok_or_else(|| {
        let names: Vec<&str> = cell.robots.iter().map(|r| r.name.as_str()).collect();
        one_of(&names)
    })
}

fn robots(cell: &Cell, value: &Value<'_, '_>, least: usize) -> Result<Vec<usize>, DataError> {
    let mut robots = Vec::new();
    for entry in value.list()? {
        let index = robot(cell, &entry)?;
        if robots.contains(&index) {
            return Err(twice(&entry));
        }
        robots.push(index);
    }
    if robots.len() < least {
        return Err(value.error(
            Problem::WrongCount,
            "too few robots",
            format!("at least {least}"),
            robots.len().to_string(),
        ));
    }
    Ok(robots)
}

fn twice(value: &Value<'_, '_>) -> DataError {
    value.error(
        Problem::Conflict,
        "a robot twice in one step",
        "every robot once",
        "the same again",
    )
}

fn replay(
    document: &Document<'_>,
    cell: &Cell,
    fields: &Fields<'_, '_>,
    value: &Value<'_, '_>,
) -> Result<Action, DataError> {
    let coordination = match fields.optional("coordination") {
        Some(value) => value.choice(
            "coordination",
            &[("none", Coordination::None), ("loose", Coordination::Loose)],
        )?,
        None => Coordination::None,
    };
    let mut replays: Vec<Replay> = Vec::new();
    for entry in value.entries()? {
        let robot = find(cell, entry.name).map_err(|expected| {
            document.error(
                &entry.span,
                Problem::UnknownName,
                "unknown robot",
                expected,
                shown(entry.name),
            )
        })?;
        replays.push(one_replay(document, cell, robot, &entry.value)?);
    }
    let Some(first) = replays.first() else {
        return Err(value.error(
            Problem::WrongCount,
            "a step that replays nothing",
            "a robot and its trajectory",
            "none",
        ));
    };
    let nodes = first.trajectory.nodes.len();
    let other = replays.iter().find(|r| r.trajectory.nodes.len() != nodes);
    if let (Coordination::Loose, Some(other)) = (coordination, other) {
        return Err(value.error(
            Problem::Conflict,
            "trajectories of different lengths in loose coordination",
            format!("{nodes} nodes each"),
            other.trajectory.nodes.len().to_string(),
        ));
    }
    Ok(Action::Replay {
        replays,
        coordination,
    })
}

fn one_replay(
    document: &Document<'_>,
    cell: &Cell,
    robot: usize,
    value: &Value<'_, '_>,
) -> Result<Replay, DataError> {
    let path = document.resolve(value.text()?);
    let axes = cell.robots.get(robot).map_or(0, cell::RobotSpec::axes);
    match crate::trj::load(&path, document.files, axes) {
        Ok(trajectory) => Ok(Replay {
            robot,
            path,
            trajectory,
        }),
        Err(LoadError::Data(error)) => Err(error),
        Err(LoadError::Input(error)) => Err(value.error(
            Problem::Unreadable,
            "cannot read the trajectory",
            "a .trj file",
            error.to_string(),
        )),
    }
}

fn moves(cell: &Cell, value: &Value<'_, '_>) -> Result<Vec<Move>, DataError> {
    if !value.is_list() {
        return Ok(vec![one_move(cell, value)?]);
    }
    let mut moves: Vec<Move> = Vec::new();
    for entry in value.list()? {
        let one = one_move(cell, &entry)?;
        if moves.iter().any(|other| other.robot == one.robot) {
            return Err(twice(&entry));
        }
        moves.push(one);
    }
    if moves.is_empty() {
        return Err(value.error(
            Problem::WrongCount,
            "a step that moves nothing",
            "at least one motion",
            "none",
        ));
    }
    Ok(moves)
}

fn one_move(cell: &Cell, value: &Value<'_, '_>) -> Result<Move, DataError> {
    let fields = value.fields(
        "a motion",
        &[
            "robot",
            "joints",
            "motors",
            "pose",
            "relative",
            "path",
            "speed",
            "acceleration",
            "until_force_n",
        ],
    )?;
    let robot = robot(cell, &fields.required("robot")?)?;
    let axes = cell.robots.get(robot).map_or(0, cell::RobotSpec::axes);
    let (key, target) = fields.exactly_one(&["joints", "motors", "pose"])?;
    let relative = match fields.optional("relative") {
        Some(value) => value.boolean()?,
        None => false,
    };
    let path = fields.optional("path");
    if key != "pose"
        && let Some(path) = &path
    {
        return Err(path.error(
            Problem::Conflict,
            "`path` of a motion of the axes",
            "a motion to a `pose`",
            format!("`{key}`"),
        ));
    }
    let target = match key {
        "joints" => Target::Joints {
            values: target.numbers(axes)?,
            relative,
        },
        "motors" => Target::Motors {
            values: target.numbers(axes)?,
            relative,
        },
        _ => Target::Pose {
            pose: pose(&target, relative)?,
            reference: if relative {
                PoseReference::Tool
            } else {
                PoseReference::Base
            },
            path: match path {
                Some(value) => value.choice(
                    "path",
                    &[("line", PosePath::Line), ("joint", PosePath::Joint)],
                )?,
                None => PosePath::Line,
            },
        },
    };
    let (velocity, acceleration) = match target {
        Target::Pose { .. } => POSE_SPEED,
        Target::Joints { .. } | Target::Motors { .. } => AXIS_SPEED,
    };
    let fraction = |key, default| match fields.optional(key) {
        Some(value) => value.number("greater than 0, at most 1", |v| v > 0.0 && v <= 1.0),
        None => Ok(default),
    };
    let until_force_n = match fields.optional("until_force_n") {
        None => None,
        Some(value) => Some(until_force_n(cell, robot, &target, &value)?),
    };
    Ok(Move {
        robot,
        target,
        velocity: fraction("speed", velocity)?,
        acceleration: fraction("acceleration", acceleration)?,
        until_force_n,
    })
}

/// The change of a force that ends a motion, N: of one on a line, by a robot that feels it.
fn until_force_n(
    cell: &Cell,
    robot: usize,
    target: &Target,
    value: &Value<'_, '_>,
) -> Result<f64, DataError> {
    let line = PosePath::Line;
    let on_a_line = matches!(target, Target::Pose { path, .. } if *path == line);
    let spec = cell.robots.get(robot);
    if !on_a_line || spec.is_none_or(|robot| robot.force_bus.is_none()) {
        let got = if on_a_line {
            "a robot without a force sensor"
        } else {
            "another way"
        };
        return Err(value.error(
            Problem::Conflict,
            "a motion until a force",
            "a `pose` on a \"line\", and `force_bus` of its robot",
            got,
        ));
    }
    value.number("greater than 0, at most 1000 N", |n| n > 0.0 && n <= 1000.0)
}

fn pose(value: &Value<'_, '_>, relative: bool) -> Result<Pose, DataError> {
    let fields = value.fields("a pose", &["position_m", "rotation_rad"])?;
    // an increment may leave out what does not change
    let triple = |key| match fields.optional(key) {
        Some(value) => value.triple(),
        None if relative => Ok([0.0; 3]),
        None => fields.required(key)?.triple(),
    };
    Ok(Pose::from_rotation_vector(
        Vector3::from(triple("position_m")?),
        Vector3::from(triple("rotation_rad")?),
    ))
}

fn tight(cell: &Cell, value: &Value<'_, '_>) -> Result<Tight, DataError> {
    let fields = value.fields(
        "a carried object",
        &[
            "robots",
            "displacement_m",
            "axis",
            "angle_rad",
            "centre_m",
            "duration_s",
        ],
    )?;
    let robots = robots(cell, &fields.required("robots")?, 2)?;
    let vector = |key| match fields.optional(key) {
        Some(value) => value.triple(),
        None => Ok([0.0; 3]),
    };
    let displacement_m = vector("displacement_m")?;
    let rotation_rad = match fields.optional("angle_rad") {
        None => {
            together(&fields, "axis", "angle_rad")?;
            together(&fields, "centre_m", "angle_rad")?;
            [0.0; 3]
        }
        Some(angle) => {
            let angle = angle.number("−π to π", |v| v.abs() <= std::f64::consts::PI)?;
            fields.required("centre_m")?;
            let axis = fields.required("axis")?;
            let direction = Vector3::from(axis.triple()?);
            let length = libm::sqrt(direction.dot(&direction));
            if length < 1e-6 {
                return Err(axis.error(
                    Problem::OutOfRange,
                    "an axis without direction",
                    "a vector of some length",
                    format!("{:?}", direction.as_slice()),
                ));
            }
            (direction * (angle / length)).into()
        }
    };
    let nothing = displacement_m
        .iter()
        .chain(&rotation_rad)
        .all(|v| v.abs() <= 0.0);
    if nothing {
        return Err(value.error(
            Problem::Missing,
            "a carried object that stays",
            "`displacement_m` or `angle_rad` other than zero",
            "none",
        ));
    }
    Ok(Tight {
        robots,
        displacement_m,
        rotation_rad,
        centre_m: vector("centre_m")?,
        duration_s: fields
            .required("duration_s")?
            .number("0.1 to 600", |s| (0.1..=600.0).contains(&s))?,
    })
}

/// A key that means nothing without another.
pub(super) fn together(
    fields: &Fields<'_, '_>,
    key: &'static str,
    needs: &str,
) -> Result<(), DataError> {
    match fields.optional(key) {
        None => Ok(()),
        Some(value) => Err(value.error(
            Problem::Missing,
            format!("`{key}` without `{needs}`"),
            format!("`{needs}`"),
            "none",
        )),
    }
}
