//! The chain of the Polycrank: seven cranks, the first three in horizontal planes, the next three in
//! vertical ones, the last a roll.
//!
//! Geometry: a `GraspIt!` model of the robot (`models/robots/Polycrank/Polycrank.xml` of
//! mzbikows/Graspit), standard Denavit–Hartenberg parameters θ, d, a, α. A link's frame here is
//! the Denavit–Hartenberg frame of the joint before its own offsets, turned by θ; d, a and α place the
//! next.

use super::assumed::POLYCRANK_KG;
use super::body::Shape;
use super::chain::{Chain, Link, Placement};
use crate::description::JointKind::Revolute;

/// Height of the first joint's frame on its column, m. Same source.
const COLUMN_M: f64 = 0.925;

/// d and a of every joint, m. Same source.
const OFFSETS: [(f64, f64); 7] = [
    (0.220, -0.299),
    (0.152, 0.180),
    (0.335, 0.0),
    (0.120, 0.151),
    (0.116, 0.151),
    (0.060, 0.0),
    (0.043, 0.0),
];

/// The crank's radius where it is taken for a cylinder, m: ASSUMED.
const RADII: [f64; 7] = [0.07, 0.06, 0.05, 0.04, 0.035, 0.03, 0.025];

/// A quarter turn about x, the α of joints 3 and 6.
const QUARTER: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]];

/// Where the frame after a joint is in the joint's link.
const fn after((d, a): (f64, f64), axes: [[f64; 3]; 3]) -> Placement {
    Placement {
        position_m: [a, 0.0, d],
        axes,
    }
}

const STRAIGHT: [[f64; 3]; 3] = Placement::IDENTITY.axes;

const fn crank(
    name: &'static str,
    placement: Placement,
    mass_kg: f64,
    (d, a): (f64, f64),
    radius: f64,
) -> Link {
    let shape = Shape::Cylinder {
        from: [0.0; 3],
        to: [a, 0.0, d],
        radius,
    };
    Link::new(name, Revolute, placement, mass_kg, shape)
}

const fn chain() -> Chain<7> {
    let [o1, o2, o3, o4, o5, o6, o7] = OFFSETS;
    let [m1, m2, m3, m4, m5, m6, m7] = POLYCRANK_KG;
    let [r1, r2, r3, r4, r5, r6, r7] = RADII;
    Chain {
        links: [
            crank("crank-1", Placement::at(0.0, 0.0, COLUMN_M), m1, o1, r1),
            crank("crank-2", after(o1, STRAIGHT), m2, o2, r2),
            crank("crank-3", after(o2, STRAIGHT), m3, o3, r3),
            crank("crank-4", after(o3, QUARTER), m4, o4, r4),
            crank("crank-5", after(o4, STRAIGHT), m5, o5, r5),
            crank("crank-6", after(o5, STRAIGHT), m6, o6, r6),
            crank("crank-7", after(o6, QUARTER), m7, o7, r7),
        ],
        flange: after(o7, STRAIGHT),
    }
}

/// The Polycrank: base frame at the foot of its column, z up; the flange is the seventh
/// Denavit–Hartenberg frame.
pub const POLYCRANK: Chain<7> = chain();
