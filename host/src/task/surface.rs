//! What stands in the way of tools in a simulated cell: the tables `[[surface]]`.

use super::cell::Cell;
use super::document::Value;
use crate::input::{DataError, Problem};
use nalgebra::Vector3;

/// A square plate, as thick as a tenth of its edge, that a tool can touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceSpec {
    /// Index in [`Cell::robots`] of the robot whose tool it is for.
    pub robot: usize,
    /// The middle of the face that is touched, in that robot's base frame, m.
    pub point_m: [f64; 3],
    /// Out of that face, of length 1.
    pub normal: [f64; 3],
    /// Its edge, m.
    pub edge_m: f64,
    /// N/m
    pub stiffness_n_m: f64,
}

pub(super) fn read(cell: &Cell, value: &Value<'_, '_>) -> Result<SurfaceSpec, DataError> {
    let keys = ["robot", "point_m", "normal", "edge_m", "stiffness_n_m"];
    let fields = value.fields("a surface", &keys)?;
    let across = fields.required("normal")?;
    let direction = Vector3::from(across.triple()?);
    let length = libm::sqrt(direction.dot(&direction));
    if length < 1e-6 {
        return Err(across.error(
            Problem::OutOfRange,
            "a normal without direction",
            "a vector of some length",
            format!("{:?}", direction.as_slice()),
        ));
    }
    Ok(SurfaceSpec {
        robot: super::step::robot(cell, &fields.required("robot")?)?,
        point_m: fields.required("point_m")?.triple()?,
        normal: (direction / length).into(),
        edge_m: fields
            .required("edge_m")?
            .number("0.01 to 10 m", |edge| (0.01..=10.0).contains(&edge))?,
        stiffness_n_m: fields
            .required("stiffness_n_m")?
            .number("100 to 1e6 N/m", |k| (100.0..=1e6).contains(&k))?,
    })
}
