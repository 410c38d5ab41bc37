//! The chains of the IRp-6.
//!
//! Frames as in [`crate::irp6`]: in the arm's plane x forward, z up, y along the axes of shoulder, elbow
//! and T. A link's z is its joint's axis, so the frames of those three have z along that y, x up and y
//! along the link: the turn [`ONTO_Y`] of the plane's frame, which takes z to y, x to z and y to x.
//!
//! The joints are relative, link against link. The parallelograms that drive them by absolute angles
//! belong to [`super::Transmission`]; their bars' mass is part of the arms'.

use super::assumed::{CARRIAGE_KG, COLUMN_KG, LOWER_ARM_KG, N_KG, T_KG, UPPER_ARM_KG, V_KG};
use super::body::Shape;
use super::chain::{Chain, Link, Placement};
use crate::description::JointKind::{Prismatic, Revolute};
use crate::irp6::data::{LOWER_ARM_M, UPPER_ARM_M, WRIST_M};

/// Takes x, y, z to z, x, y.
pub(super) const ONTO_Y: [[f64; 3]; 3] = [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

/// The turn back: takes x, y, z to y, z, x.
pub(super) const FROM_Y: [[f64; 3]; 3] = [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]];

/// A quarter turn about z: the upper arm stands square on the lower one at q = 0.
const QUARTER: [[f64; 3]; 3] = [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];

const fn turned(axes: [[f64; 3]; 3], y: f64) -> Placement {
    Placement {
        position_m: [0.0, y, 0.0],
        axes,
    }
}

/// A cylinder from the link's origin along its y axis.
const fn beam(length: f64, radius: f64) -> Shape {
    Shape::Cylinder {
        from: [0.0; 3],
        to: [0.0, length, 0.0],
        radius,
    }
}

/// The carriage on the track: a box below the column, whose foot is 0.7 m under the shoulder.
const CARRIAGE: Link = Link::new(
    "carriage",
    Prismatic,
    turned(ONTO_Y, 0.0),
    CARRIAGE_KG,
    Shape::Box {
        centre: [-0.825, 0.0, 0.0],
        size: [0.25, 0.6, 0.6],
    },
);

const fn column(placement: Placement) -> Link {
    let shape = Shape::Cylinder {
        from: [0.0, 0.0, -0.7],
        to: [0.0; 3],
        radius: 0.12,
    };
    Link::new("column", Revolute, placement, COLUMN_KG, shape)
}

const LOWER_ARM: Link = Link::new(
    "lower-arm",
    Revolute,
    turned(ONTO_Y, 0.0),
    LOWER_ARM_KG,
    beam(LOWER_ARM_M, 0.06),
);

const UPPER_ARM: Link = Link::new(
    "upper-arm",
    Revolute,
    turned(QUARTER, LOWER_ARM_M),
    UPPER_ARM_KG,
    beam(UPPER_ARM_M, 0.05),
);

const T: Link = Link::new(
    "wrist-t",
    Revolute,
    Placement::at(0.0, UPPER_ARM_M, 0.0),
    T_KG,
    beam(WRIST_M, 0.04),
);

/// V turns about the link before it: its z is T's y.
const fn v(mass_kg: f64, shape: Shape) -> Link {
    Link::new("wrist-v", Revolute, turned(ONTO_Y, WRIST_M), mass_kg, shape)
}

const V: Link = v(
    V_KG,
    Shape::Cylinder {
        from: [0.0, 0.0, -0.05],
        to: [0.0, 0.0, 0.05],
        radius: 0.04,
    },
);

/// The flange with the gripper on it.
const N: Link = Link::new(
    "wrist-n",
    Revolute,
    turned(FROM_Y, 0.0),
    N_KG,
    Shape::Cylinder {
        from: [0.0; 3],
        to: [0.0, 0.0, 0.25],
        radius: 0.035,
    },
);

/// V of the arm that has no N and carries the gripper itself, along its x.
const V_WITH_TOOL: Link = v(
    V_KG + N_KG,
    Shape::Cylinder {
        from: [0.0; 3],
        to: [0.25, 0.0, 0.0],
        radius: 0.04,
    },
);

/// The IRp-6 on its track: the base frame and the flange are those of [`crate::Irp6Track`].
pub const IRP6_TRACK: Chain<7> = Chain {
    links: [
        CARRIAGE,
        column(turned(FROM_Y, 0.0)),
        LOWER_ARM,
        UPPER_ARM,
        T,
        V,
        N,
    ],
    flange: Placement::IDENTITY,
};

/// The IRp-6 on its postument: frames of [`crate::Irp6Postument`].
pub const IRP6_POSTUMENT: Chain<6> = Chain {
    links: [column(Placement::IDENTITY), LOWER_ARM, UPPER_ARM, T, V, N],
    flange: Placement::IDENTITY,
};

/// The IRp-6 without the axis N: its flange is that of [`crate::Irp6Postument`] at N = 0.
pub const IRP6_ARM: Chain<5> = Chain {
    links: [
        column(Placement::IDENTITY),
        LOWER_ARM,
        UPPER_ARM,
        T,
        V_WITH_TOOL,
    ],
    flange: turned(FROM_Y, 0.0),
};
