//! The IRp-6 on its track: seven axes, the first of them redundant.
//!
//! The track carries the whole arm along y. A pose alone does not say how far: a [`TrackRule`] does.

use motion::Pose;
use nalgebra::{ArrayStorage, SMatrix, Vector3};

use super::data::{column, lower_arm, machine, track, upper_arm, wrist_n, wrist_t, wrist_v};
use super::{arm, inverse};
use crate::along::{JointsAlong, PoseAlong};
use crate::description::{HomingSequence, Range, RobotDescription};
use crate::dynamics::{Chain, IRP6_TRACK};
use crate::error::{KinematicError, Quantity};
use crate::gearing::finite;
use crate::robot::{Inverse, Robot};
use crate::sources::Sources;
use crate::space::Joints;

/// The IRp-6 on its track: track, column, lower arm, upper arm, T, V, N.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Irp6Track {
    /// Where the inverse puts the track. Node and coordinator of one robot must have the same.
    pub rule: TrackRule,
}

impl Irp6Track {
    /// With the track left where it is.
    pub const KEEP: Self = Self {
        rule: TrackRule::Keep,
    };
    /// With the track in front of the flange.
    pub const IN_FRONT: Self = Self {
        rule: TrackRule::InFront,
    };
}

/// Which of the infinitely many configurations of track and arm an inverse gives.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum TrackRule {
    /// The track stays where `near` has it; whoever wants it elsewhere says so by `near`.
    #[default]
    Keep,
    /// The track stands beside the flange, d0 = y, so that the column looks straight ahead
    /// (q1 = 0), as far as the track goes; d0 depends on the pose alone.
    ///
    /// A straight line or path can begin only where the track stands by this rule already: a move of
    /// the joints to a pose brings it there.
    ///
    /// Towards the ends of the track d0 leaves y on a curve with continuous curvature that begins
    /// [`BEND_M`] before the end: d0 stays at the end from [`BEND_M`] beyond it.
    InFront,
}

impl TrackRule {
    /// All of them.
    pub const ALL: [Self; 2] = [Self::Keep, Self::InFront];

    /// The name commands and files use.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Keep => "keep",
            Self::InFront => "in-front",
        }
    }

    /// d0, m, for a flange at `y` in the base frame; `kept` is where the track stands.
    fn along(self, y: f64, kept: f64, range: Range) -> f64 {
        match self {
            Self::Keep => kept,
            Self::InFront => {
                let middle = range.centre();
                if y < middle {
                    -bent(-y, -range.lower)
                } else {
                    bent(y, range.upper)
                }
            }
        }
    }
}

impl TrackRule {
    /// By how much of y the track goes on with the flange: nothing, or all of it, or something that changes.
    fn share(self, y: f64, range: Range) -> Option<f32> {
        let beyond = |end: f64| libm::fabs(y - end) - BEND_M;
        match self {
            Self::InFront if beyond(range.lower) <= 0.0 || beyond(range.upper) <= 0.0 => None,
            Self::InFront if range.contains(y) => Some(1.0),
            Self::Keep | Self::InFront => Some(0.0),
        }
    }
}

/// Half the length of the curve on which the track comes to its end, m.
pub const BEND_M: f64 = 0.05;

/// y below `end`, and `end` above, joined with C2 over 2·[`BEND_M`].
///
/// On the curve, with v from 0 to 1, the slope falls as 1 − (3v² − 2v³), whose integral is
/// v − v³ + v⁴/2.
fn bent(y: f64, end: f64) -> f64 {
    let begin = end - BEND_M;
    let v = (y - begin) / (2.0 * BEND_M);
    if v <= 0.0 {
        y
    } else if v < 1.0 {
        begin + 2.0 * BEND_M * (v - v * v * v + 0.5 * v * v * v * v)
    } else {
        end
    }
}

static DESCRIPTION: RobotDescription<7> = RobotDescription {
    name: "irp6-track",
    long_name: "IRp-6 on its track",
    sources: Sources::IRP6,
    servo_step_us: 2000,
    macrostep: 10,
    axes: [
        track(machine(0.0, 25_000, 200.0)),
        column(machine(-10.819, 15_000, 200.0)),
        lower_arm(machine(-4.012, 18_000, 100.0)),
        upper_arm(machine(-6.219, 10_000, 120.0)),
        wrist_t(machine(158.997, 10_000, 170.0)),
        wrist_v(machine(479.5, 10_000, 110.0)),
        wrist_n(machine(769.7, 10_000, 11.0)),
    ],
    homing: HomingSequence {
        order: [2, 3, 4, 5, 6, 0, 1],
        ramp_steps: 10,
        stop_steps: 250,
        settle_steps: 25,
        debounce_steps: 3,
    },
    tool_offset_m: [0.0, 0.0, 0.25],
    base_position_m: [0.0, 0.0, 0.0],
    cartesian_velocity: 5.0,
    cartesian_acceleration: 5.0,
};

fn joined(along: f64, [q1, q2, q3, q4, q5, q6]: [f64; 6]) -> Joints<7> {
    Joints([along, q1, q2, q3, q4, q5, q6])
}

impl Robot<7> for Irp6Track {
    fn description(&self) -> &'static RobotDescription<7> {
        &DESCRIPTION
    }

    fn forward(&self, joints: &Joints<7>) -> Pose {
        let [along, arm @ ..] = &joints.0;
        let from_shoulder = arm::forward(arm);
        Pose {
            position: from_shoulder.position + Vector3::new(0.0, *along, 0.0),
            ..from_shoulder
        }
    }

    fn inverse(&self, flange: &Pose, near: &Joints<7>) -> Result<Inverse<7>, KinematicError> {
        finite(&near.0)?;
        finite(flange.position.as_slice())?;
        let [kept, near_arm @ ..] = near.0;
        let [track, axes @ ..] = &DESCRIPTION.axes;
        let range = track.joint_position;
        let along = self.rule.along(flange.position.y, kept, range);
        if !range.contains(along) {
            return Err(KinematicError::Limit {
                axis: 0,
                name: track.name,
                quantity: Quantity::Joint,
                value: along,
                lower: range.lower,
                upper: range.upper,
            });
        }
        let from_shoulder = Pose {
            position: flange.position - Vector3::new(0.0, along, 0.0),
            rotation: flange.rotation,
        };
        let found = inverse::solve(&from_shoulder, &near_arm, axes, 1)?;
        let all = found.iter().map(|arm| joined(along, arm));
        Inverse::new(all, near).ok_or(KinematicError::Unreachable)
    }

    fn inverse_near(&self, flange: &Pose, near: &Joints<7>) -> Result<Joints<7>, KinematicError> {
        let [kept, near_arm @ ..] = near.0;
        let [track, axes @ ..] = &DESCRIPTION.axes;
        let range = track.joint_position;
        let along = self.rule.along(flange.position.y, kept, range);
        let from_shoulder = Pose {
            position: flange.position - Vector3::new(0.0, along, 0.0),
            rotation: flange.rotation,
        };
        match inverse::continuing(&from_shoulder, &near_arm, axes) {
            Some(plain) if range.contains(along) => Ok(joined(along, plain.joints)),
            _ => self
                .inverse(flange, near)
                .map(|solution| solution.nearest()),
        }
    }

    fn inverse_along(
        &self,
        flange: &PoseAlong,
        near: &Joints<7>,
    ) -> Result<JointsAlong<7>, KinematicError> {
        let [kept, near_arm @ ..] = near.0;
        let [track, axes @ ..] = &DESCRIPTION.axes;
        let range = track.joint_position;
        let y = flange.pose.position.y;
        let along = self.rule.along(y, kept, range);
        let mut arm = *flange;
        arm.pose.position.y -= along;
        let plain = inverse::continuing(&arm.pose, &near_arm, axes);
        let Some(plain) = plain.filter(|_| range.contains(along)) else {
            return self
                .inverse(&flange.pose, near)
                .map(|solution| JointsAlong::at(solution.nearest()));
        };
        let share = self.rule.share(y, range);
        let rates = share.and_then(|share| {
            let mut carried = [0.0; 3];
            for (carried, arm) in carried.iter_mut().zip(&mut arm.linear) {
                *carried = share * arm.y;
                arm.y -= *carried;
            }
            let mut out = [[0.0; 7]; 3];
            let all = plain.rates(&arm)?.into_iter().zip(carried);
            for (out, ([q1, q2, q3, q4, q5, q6], along)) in out.iter_mut().zip(all) {
                *out = [along, q1, q2, q3, q4, q5, q6];
            }
            Some(out)
        });
        Ok(JointsAlong {
            position: joined(along, plain.joints),
            rates,
        })
    }

    fn chain(&self) -> Option<Chain<7>> {
        Some(IRP6_TRACK)
    }

    fn jacobian(&self, joints: &Joints<7>) -> SMatrix<f64, 6, 7> {
        let [_, arm @ ..] = &joints.0;
        let [a, b, c, d, e, f] = arm::jacobian(arm);
        let along = [0.0, 1.0, 0.0, 0.0, 0.0, 0.0];
        SMatrix::from_array_storage(ArrayStorage([along, a, b, c, d, e, f]))
    }
}
