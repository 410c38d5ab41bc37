//! The board of a cell, and the cutter that works on it.
//!
//! ```toml
//! [cell.board]
//! robot = "rnt"                       # whose spindle works on it
//! position_m = [-0.15, -0.10, -1.30]  # its corner in the robot's base frame; z: its surface
//! turn_rad = 0.0                      # about the base's z, from there
//! size_m = [0.30, 0.20]
//! thickness_m = 0.018
//! cutter = { v = { tip_m = 1e-4, angle_rad = 1.0 } }   # or { flat_m = 3e-3 }, { ball_m = 6e-3 }
//! ```

use super::cell::Cell;
use super::document::{Fields, Value};
use super::step::robot;
use crate::input::DataError;
use motion::Pose;
use motion::pose::exp;
use nalgebra::Vector3;

/// What cuts. Its shank is as thick as the cutter is wide at most.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cutter {
    /// A flat end mill of this diameter, m.
    Flat(f64),
    /// A ball end of this diameter, m.
    Ball(f64),
    /// An engraving cutter: diameter of its flat tip, m, and the angle between its sides, rad.
    V {
        /// m
        tip_m: f64,
        /// rad
        angle_rad: f64,
    },
}

/// A board that is engraved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Board {
    /// Index in [`Cell::robots`] of the robot whose spindle works on it.
    pub robot: usize,
    /// Its corner: x and y along its edges, z out of the surface that is engraved.
    pub t_base_board: Pose,
    /// Along x and y, m.
    pub size_m: [f64; 2],
    /// m
    pub thickness_m: f64,
    /// What cuts.
    pub cutter: Cutter,
}

/// The tool as it stands on a board: z into it, and x along the base's −x, where the RNT's wrist is far from
/// its singularity.
#[must_use]
pub fn t_board_tool_rotation() -> Pose {
    Pose {
        position: Vector3::zeros(),
        rotation: exp(Vector3::new(0.0, core::f64::consts::PI, 0.0)),
    }
}

pub(super) fn read(cell: &Cell, value: &Value<'_, '_>) -> Result<Board, DataError> {
    let known = [
        "robot",
        "position_m",
        "turn_rad",
        "size_m",
        "thickness_m",
        "cutter",
    ];
    let fields = value.fields("a board", &known)?;
    let turn = match fields.optional("turn_rad") {
        Some(value) => value.number("-3.2 to 3.2", |a| a.abs() <= 3.2)?,
        None => 0.0,
    };
    let size = fields.required("size_m")?;
    let mut size_m = [0.0; 2];
    for (slot, side) in size_m.iter_mut().zip(size.numbers(2)?) {
        if !(0.01..=2.0).contains(&side) {
            return Err(size.error(
                crate::input::Problem::OutOfRange,
                "a side of the board out of range",
                "0.01 to 2 m",
                side.to_string(),
            ));
        }
        *slot = side;
    }
    Ok(Board {
        robot: robot(cell, &fields.required("robot")?)?,
        t_base_board: Pose {
            position: fields.required("position_m")?.triple()?.into(),
            rotation: exp(Vector3::new(0.0, 0.0, turn)),
        },
        size_m,
        thickness_m: fields
            .required("thickness_m")?
            .number("0.001 to 0.2", |t| (0.001..=0.2).contains(&t))?,
        cutter: cutter(&fields)?,
    })
}

fn cutter(fields: &Fields<'_, '_>) -> Result<Cutter, DataError> {
    let value = fields.required("cutter")?;
    let cutter = value.fields("a cutter", &["flat_m", "ball_m", "v"])?;
    let (key, value) = cutter.exactly_one(&["flat_m", "ball_m", "v"])?;
    let diameter =
        |value: &Value<'_, '_>| value.number("1e-4 to 0.05", |d| (1e-4..=0.05).contains(&d));
    Ok(match key {
        "flat_m" => Cutter::Flat(diameter(&value)?),
        "ball_m" => Cutter::Ball(diameter(&value)?),
        _ => {
            let v = value.fields("an engraving cutter", &["tip_m", "angle_rad"])?;
            Cutter::V {
                tip_m: v
                    .required("tip_m")?
                    .number("0 to 0.01", |t| (0.0..=0.01).contains(&t))?,
                angle_rad: v
                    .required("angle_rad")?
                    .number("0.1 to 3", |a| (0.1..=3.0).contains(&a))?,
            }
        }
    })
}
