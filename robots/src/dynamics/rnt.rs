//! The RNT as a tree: its central leg with the wrist, a serial chain. The three driven legs close
//! loops around it.
//!
//! Base frame: origin in the base's universal joint, z up, the platform hangs below. Joints: tilt about
//! the base's y, tilt about the x that follows, reach along −z of the platform, then the wrist,
//! Z-Y-Z about axes inclined on the platform:
//!
//! ```text
//!   Rp = Y(q1)·X(q2)        p = −(q3 + 0.12)·Rp·z        R = Rp·Y(inclination)·Z(q4)·Y(q5)·Z(q6)
//! ```
//!
//! The driven legs' mass is lumped: the half next to the base is taken as fixed, the half next to the
//! platform as part of it. The turning of the legs about their own base joints is so left out but for
//! that half; their rotors are motors, and belong to the transmission.

use super::assumed::{
    RNT_CROSS_KG, RNT_LEG_KG, RNT_PLATFORM_KG, RNT_SLEEVE_KG, RNT_SPINDLE_KG, RNT_TUBE_KG,
    RNT_WRIST_1_KG, RNT_WRIST_2_KG,
};
use super::body::Shape;
use super::chain::{Chain, Link, Placement};
use super::irp6::{FROM_Y, ONTO_Y};
use crate::description::JointKind::{Prismatic, Revolute};

/// Wrist centre below the platform, m: ASSUMED.
const WRIST_BELOW_M: f64 = 0.12;

/// The frame whose z is the platform's −z and whose x is its x, in the frame of the second tilt, whose
/// x, y, z are the platform's y, z, x.
const DOWN: [[f64; 3]; 3] = [[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]];

const fn turned(axes: [[f64; 3]; 3]) -> Placement {
    Placement {
        position_m: [0.0; 3],
        axes,
    }
}

const fn cylinder(from: [f64; 3], to: [f64; 3], radius: f64) -> Shape {
    Shape::Cylinder { from, to, radius }
}

/// The RNT's central leg and wrist. `inclination_rad`: turn of the wrist's base about the platform's y.
/// The flange's origin is the wrist's centre.
#[must_use]
pub fn rnt_chain(inclination_rad: f64) -> Chain<6> {
    let (s, c) = libm::sincos(inclination_rad);
    let wrist_base = Placement {
        position_m: [0.0, 0.0, WRIST_BELOW_M],
        // Y(inclination), seen along the platform's x, −y, −z
        axes: [[c, 0.0, s], [0.0, -1.0, 0.0], [s, 0.0, -c]],
    };
    Chain {
        links: [
            Link::new(
                "cross",
                Revolute,
                turned(ONTO_Y),
                RNT_CROSS_KG,
                cylinder([0.0, 0.0, -0.08], [0.0, 0.0, 0.08], 0.04),
            ),
            Link::new(
                "sleeve",
                Revolute,
                turned(ONTO_Y),
                RNT_SLEEVE_KG,
                cylinder([0.0, 0.2, 0.0], [0.0, -0.5, 0.0], 0.05),
            ),
            Link::new(
                "platform",
                Prismatic,
                turned(DOWN),
                RNT_PLATFORM_KG + RNT_TUBE_KG + 3.0 * 0.5 * RNT_LEG_KG,
                cylinder([0.0, 0.0, -0.03], [0.0, 0.0, 0.03], 0.18),
            ),
            Link::new(
                "wrist-1",
                Revolute,
                wrist_base,
                RNT_WRIST_1_KG,
                cylinder([0.0, 0.0, -0.06], [0.0, 0.0, 0.06], 0.05),
            ),
            Link::new(
                "wrist-2",
                Revolute,
                turned(ONTO_Y),
                RNT_WRIST_2_KG,
                cylinder([0.0, 0.0, -0.06], [0.0, 0.0, 0.06], 0.04),
            ),
            Link::new(
                "spindle",
                Revolute,
                turned(FROM_Y),
                RNT_SPINDLE_KG,
                cylinder([0.0; 3], [0.0, 0.0, 0.15], 0.04),
            ),
        ],
        flange: Placement::IDENTITY,
    }
}
