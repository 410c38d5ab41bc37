//! The RNT: a serial-parallel robot of high rigidity, for milling, polishing and engraving.
//!
//! That such a robot was driven by MRROC++ is published; its dimensions are not. **Every number of it is
//! ASSUMED** and listed in [`crate::ASSUMED`], and so is the kind of its mechanism: a tripod of three
//! ball-screw legs (universal, prismatic, spherical) with a passive central leg (universal, prismatic)
//! which fixes the platform, and a spherical wrist on it.
//!
//! # Geometry
//!
//! Frame of the base: origin in the middle of the legs' feet, z up; the robot hangs down. X, Y, Z are the
//! turns about the axes.
//!
//! ```text
//!   joints   q1 = ty, q2 = tx       tilts of the central leg about y and x, rad
//!            q3 = r                 its length, the reach, m
//!            q4, q5, q6 = w1…w3     wrist Z-Y-Z, rad
//!   platform Rp = Y(ty)·X(tx),      origin −r·n, n = Rp·ẑ
//!   wrist    its three axes meet at −(r + d)·n; its base is Rp·Y(μ), μ = 120°
//!   flange   R = Rp·Y(μ)·Z(w1)·Y(w2)·Z(w3), origin in the wrist's centre; the tool along its z
//! ```
//!
//! At all tilts and wrist angles zero the flange's z points 60° from straight down.
//!
//! # Motors
//!
//! Motors 1 to 3 drive the legs at 90°, 210° and 330°: each depends on tilts and reach together, so motor k
//! is not the motor of joint k. Motors 4 to 6 drive the wrist's joints.
//!
//! Motors are 0 where homing ends: legs 0.86 m long, 22 mm longer than where the central leg would be pushed
//! together (no tilt, reach 0.823 m; a single leg gets as short as 0.60 m where the platform tilts), the wrist
//! 5° from its lower limits. [`HOME`] is a posture to start work from.
//!
//! # Work area
//!
//! A vertical spindle (flange's z along the base's −z, its x along the base's −x, as at home) reaches every
//! point of a board of [`WORK_AREA_SIZE_M`] around [`WORK_AREA_CENTRE_M`]. There the tilts are within 19.2°,
//! the reach between 1.03 m and 1.134 m, legs between 0.99 m and 1.31 m, w1 and w3 within 19.8°, and w2 between
//! 40.8° and 80.0°: |sin w2| ≥ 0.65. A quarter of the way from the middle of every range to its limits is
//! left everywhere, also 20 mm into the board, [`WORK_AREA_CLEARANCE_M`] above it, and with the spindle turned
//! about its own axis by up to half a turn.

mod arm;
pub(crate) mod assumed;
mod data;
mod inverse;
mod planning;
mod tripod;

use motion::{AxisLimits, Pose};
use nalgebra::{ArrayStorage, SMatrix};

use crate::description::RobotDescription;
use crate::dynamics::{Chain, Legs, Transmission, rnt_chain};
use crate::error::KinematicError;
use crate::gearing::{self, finite};
use crate::planning::VelocityFactor;
use crate::robot::{Inverse, Robot};
use crate::space::{JointMotion, Joints, MotorMotion, Motors};
use data::DESCRIPTION;
use tripod::Leg;

/// The RNT: three legs, three axes of the wrist.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rnt;

/// No tilt, reach 1.1 m, the spindle straight down: w2 = 60°.
pub const HOME: Joints<6> = Joints([0.0, 0.0, 1.1, 0.0, core::f64::consts::FRAC_PI_3, 0.0]);

/// ASSUMED: the middle of the work area's surface in the base's frame, m.
pub const WORK_AREA_CENTRE_M: [f64; 3] = [0.0, 0.0, -1.30];
/// ASSUMED: the work area's size along the base's x and y, m.
pub const WORK_AREA_SIZE_M: [f64; 2] = [0.8, 0.6];
/// ASSUMED: how high above the work area the tip of the spindle may be led, m.
pub const WORK_AREA_CLEARANCE_M: f64 = 0.10;

/// Positions of the description's gears in the place of joints: legs, m, and wrist, rad.
fn with_legs(legs: &[Leg; 3], [.., w1, w2, w3]: [f64; 6]) -> Joints<6> {
    let [a, b, c] = legs;
    Joints([a.length, b.length, c.length, w1, w2, w3])
}

impl Rnt {
    /// Lengths of the legs at 90°, 210° and 330°, m.
    ///
    /// # Errors
    /// As [`Robot::motors`].
    pub fn legs(&self, joints: &Joints<6>) -> Result<[f64; 3], KinematicError> {
        finite(&joints.0)?;
        let [ty, tx, reach, ..] = joints.0;
        Ok(tripod::legs([ty, tx, reach])?.map(|leg| leg.length))
    }

    /// ∂L/∂(ty, tx, r): a row a leg, m/rad, m/rad and m/m. Its singular values tell how far the tripod is
    /// from a parallel singularity: see [`crate::report::singular_values`].
    ///
    /// # Errors
    /// As [`Robot::motors`].
    pub fn leg_jacobian(&self, joints: &Joints<6>) -> Result<[[f64; 3]; 3], KinematicError> {
        finite(&joints.0)?;
        let [ty, tx, reach, ..] = joints.0;
        Ok(tripod::legs([ty, tx, reach])?.map(|leg| leg.first))
    }

    /// Tilt about y, tilt about x (rad) and reach (m) at leg lengths (m), with the number of Newton's
    /// steps that took. Needs no memory of an earlier position.
    ///
    /// # Errors
    /// As [`Robot::joints`].
    pub fn assembled(&self, legs: [f64; 3]) -> Result<([f64; 3], u32), KinematicError> {
        finite(&legs)?;
        tripod::assembled(legs)
    }
}

impl Robot<6> for Rnt {
    fn description(&self) -> &'static RobotDescription<6> {
        &DESCRIPTION
    }

    fn forward(&self, joints: &Joints<6>) -> Pose {
        arm::forward(&joints.0)
    }

    fn inverse(&self, flange: &Pose, near: &Joints<6>) -> Result<Inverse<6>, KinematicError> {
        let found = inverse::solve(flange, &near.0, &DESCRIPTION.axes)?;
        Inverse::new(found.iter().map(Joints), near).ok_or(KinematicError::Unreachable)
    }

    fn inverse_near(&self, flange: &Pose, near: &Joints<6>) -> Result<Joints<6>, KinematicError> {
        match inverse::continuing(flange, &near.0, &DESCRIPTION.axes) {
            Some(joints) => Ok(Joints(joints)),
            None => self
                .inverse(flange, near)
                .map(|solution| solution.nearest()),
        }
    }

    fn chain(&self) -> Option<Chain<6>> {
        Some(rnt_chain(assumed::WRIST_MOUNT_RAD))
    }

    fn jacobian(&self, joints: &Joints<6>) -> SMatrix<f64, 6, 6> {
        SMatrix::from_array_storage(ArrayStorage(arm::jacobian(&joints.0)))
    }

    fn transmission(&self, joints: &Joints<6>) -> Result<Transmission<6>, KinematicError> {
        finite(&joints.0)?;
        let [ty, tx, reach, ..] = joints.0;
        let legs = tripod::legs([ty, tx, reach])?;
        let rows = legs.map(|leg| leg.first);
        let by_length = [
            tripod::solved(&rows, [1.0, 0.0, 0.0])?,
            tripod::solved(&rows, [0.0, 1.0, 0.0])?,
            tripod::solved(&rows, [0.0, 0.0, 1.0])?,
        ];
        let coupling = Legs::new(by_length, legs.map(|leg| leg.second));
        Transmission::of_legs(&DESCRIPTION, &with_legs(&legs, joints.0), &coupling)
    }

    fn joints(&self, motors: &Motors<6>) -> Result<Joints<6>, KinematicError> {
        let Joints([a, b, c, w1, w2, w3]) = gearing::joints(&DESCRIPTION, motors)?;
        let ([ty, tx, reach], _) = tripod::assembled([a, b, c])?;
        Ok(Joints([ty, tx, reach, w1, w2, w3]))
    }

    fn motors(&self, joints: &Joints<6>) -> Result<Motors<6>, KinematicError> {
        finite(&joints.0)?;
        let [ty, tx, reach, ..] = joints.0;
        let legs = tripod::legs([ty, tx, reach])?;
        gearing::motors(&DESCRIPTION, &with_legs(&legs, joints.0))
    }

    fn motor_motion(&self, motion: &JointMotion<6>) -> Result<MotorMotion<6>, KinematicError> {
        finite(&motion.position.0)?;
        let [ty, tx, reach, ..] = motion.position.0;
        let [dy, dx, dr, v1, v2, v3] = motion.velocity;
        let [ddy, ddx, ddr, a1, a2, a3] = motion.acceleration;
        let legs = tripod::legs([ty, tx, reach])?;
        let [va, vb, vc] = legs.map(|leg| leg.rate(&[dy, dx, dr]));
        let [aa, ab, ac] =
            legs.map(|leg| leg.rate(&[ddy, ddx, ddr]) + leg.curvature(&[dy, dx, dr]));
        gearing::motor_motion(
            &DESCRIPTION,
            &JointMotion {
                position: with_legs(&legs, motion.position.0),
                velocity: [va, vb, vc, v1, v2, v3],
                acceleration: [aa, ab, ac, a1, a2, a3],
            },
        )
    }

    fn joint_motion(&self, motion: &MotorMotion<6>) -> Result<JointMotion<6>, KinematicError> {
        let legs_motion = gearing::joint_motion(&DESCRIPTION, motion)?;
        let [a, b, c, w1, w2, w3] = legs_motion.position.0;
        let [va, vb, vc, v1, v2, v3] = legs_motion.velocity;
        let [aa, ab, ac, a1, a2, a3] = legs_motion.acceleration;
        let ([ty, tx, reach], _) = tripod::assembled([a, b, c])?;
        let legs = tripod::legs([ty, tx, reach])?;
        let rows = legs.map(|leg| leg.first);
        let rates = tripod::solved(&rows, [va, vb, vc])?;
        let [ca, cb, cc] = legs.map(|leg| leg.curvature(&rates));
        let [ddy, ddx, ddr] = tripod::solved(&rows, [aa - ca, ab - cb, ac - cc])?;
        let [dy, dx, dr] = rates;
        let velocity = [dy, dx, dr, v1, v2, v3];
        let acceleration = [ddy, ddx, ddr, a1, a2, a3];
        finite(&velocity)?;
        finite(&acceleration)?;
        Ok(JointMotion {
            position: Joints([ty, tx, reach, w1, w2, w3]),
            velocity,
            acceleration,
        })
    }

    /// The bound over the joints' limits; the legs' motors are each moved by several joints, and the first
    /// (at 90°) not by the tilt about y at all.
    fn motor_slopes(&self) -> [f64; 6] {
        planning::motor_slopes()
    }

    fn joint_limits_for_planning(&self, factor: VelocityFactor) -> [AxisLimits; 6] {
        planning::joint_limits(&DESCRIPTION, factor)
    }

    fn limits_along(
        &self,
        from: &Joints<6>,
        to: &Joints<6>,
        factor: VelocityFactor,
    ) -> Result<Option<AxisLimits>, KinematicError> {
        planning::limits_along(&DESCRIPTION, from, to, factor)
    }
}
