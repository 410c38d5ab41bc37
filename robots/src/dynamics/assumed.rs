//! The masses nobody has published: chosen by us, and shown as such.
//!
//! Each link is taken for a homogeneous cylinder or box of its mass
//! ([`Link::shape`](super::Link::shape)), which gives centre and inertia by
//! [`Body::homogeneous`](super::Body::homogeneous); the shapes' radii and edges are ASSUMED like the
//! masses, their lengths are those of the kinematics.

use crate::assumed::Assumed;

pub(super) const CARRIAGE_KG: f64 = 60.0;
pub(super) const COLUMN_KG: f64 = 30.0;
pub(super) const LOWER_ARM_KG: f64 = 8.0;
pub(super) const UPPER_ARM_KG: f64 = 6.0;
pub(super) const T_KG: f64 = 2.0;
pub(super) const V_KG: f64 = 1.5;
pub(super) const N_KG: f64 = 1.5;
pub(super) const RNT_CROSS_KG: f64 = 4.0;
pub(super) const RNT_SLEEVE_KG: f64 = 10.0;
pub(super) const RNT_TUBE_KG: f64 = 6.0;
pub(super) const RNT_PLATFORM_KG: f64 = 12.0;
pub(super) const RNT_LEG_KG: f64 = 8.0;
pub(super) const RNT_WRIST_1_KG: f64 = 3.0;
pub(super) const RNT_WRIST_2_KG: f64 = 2.0;
pub(super) const RNT_SPINDLE_KG: f64 = 12.0;
pub(super) const POLYCRANK_KG: [f64; 7] = [12.0, 8.0, 6.0, 3.0, 2.5, 1.0, 0.5];

const fn mass(item: &'static str, value: f64, why: &'static str) -> Assumed {
    Assumed {
        item,
        value,
        unit: "kg",
        why,
    }
}

const fn crank(item: &'static str, value: f64) -> Assumed {
    mass(
        item,
        value,
        "a direct-drive arm of this size that lifts 2 kg at 0.9 m",
    )
}

/// Every ASSUMED mass of the chains, for the products that show them.
pub const ASSUMED: &[Assumed] = &[
    mass(
        "IRp-6 carriage on the track, with the drives it carries",
        CARRIAGE_KG,
        "a steel box of 0.6 m × 0.6 m × 0.25 m, mostly empty",
    ),
    mass(
        "IRp-6 column",
        COLUMN_KG,
        "a cast column of 0.7 m with the drives of both arms",
    ),
    mass(
        "IRp-6 lower arm, with the bars of its parallelogram",
        LOWER_ARM_KG,
        "as the simulated plant has had it",
    ),
    mass(
        "IRp-6 upper arm, with the bars of its parallelogram",
        UPPER_ARM_KG,
        "as the simulated plant has had it",
    ),
    mass("IRp-6 wrist T", T_KG, "part of the 5 kg of wrist and tool"),
    mass("IRp-6 wrist V", V_KG, "part of the 5 kg of wrist and tool"),
    mass(
        "IRp-6 wrist N with the gripper",
        N_KG,
        "part of the 5 kg of wrist and tool; MRROC++ weighs the tools: 13.18 N and 10.8 N",
    ),
    crank("Polycrank crank 1", POLYCRANK_KG[0]),
    crank("Polycrank crank 2", POLYCRANK_KG[1]),
    crank("Polycrank crank 3", POLYCRANK_KG[2]),
    crank("Polycrank crank 4", POLYCRANK_KG[3]),
    crank("Polycrank crank 5", POLYCRANK_KG[4]),
    crank("Polycrank crank 6", POLYCRANK_KG[5]),
    crank("Polycrank crank 7", POLYCRANK_KG[6]),
    mass(
        "RNT cross of the central leg",
        RNT_CROSS_KG,
        "a forged cross of 0.16 m",
    ),
    mass(
        "RNT sleeve of the central leg",
        RNT_SLEEVE_KG,
        "a steel tube of 0.7 m",
    ),
    mass(
        "RNT sliding tube of the central leg",
        RNT_TUBE_KG,
        "moves with the platform",
    ),
    mass(
        "RNT platform",
        RNT_PLATFORM_KG,
        "a steel disc with three joints",
    ),
    mass(
        "RNT driven leg, one of three",
        RNT_LEG_KG,
        "screw, nut and tube; half of it moves with the platform",
    ),
    mass(
        "RNT wrist, first turn",
        RNT_WRIST_1_KG,
        "a harmonic drive of 100:1 with its motor",
    ),
    mass(
        "RNT wrist, second turn",
        RNT_WRIST_2_KG,
        "a harmonic drive of 100:1 with its motor",
    ),
    mass(
        "RNT spindle, on the wrist's third turn",
        RNT_SPINDLE_KG,
        "a milling spindle for wood",
    ),
];
