//! A quick test that joints are well inside their ranges, for every servo step.
//!
//! From motors to joints it goes as [`Robot::joints`](crate::Robot::joints) does, but in f32, with what is constant
//! found once. It can only accept: what it does not accept is decided by that function and
//! [`Robot::check_joints`](crate::Robot::check_joints), in f64. So the decision is theirs always, and a microcontroller needs them only near a limit.
//!
//! What f32 is off, with its unit 2⁻²⁴ = 6e-8: a travel of 10⁴ rad 6e-4 rad of the motor, through the smallest ratio of a
//! gear, 87, 7e-6 rad of a joint; a direct drive that has limits turns less than one turn between them. A screw's length l of 400 mm 5e-5 mm, so l² 0.04 mm²,
//! and its cosine, that over an amplitude of 4e4 mm², 1e-6; with a sine of at least 0.0447 the angle is off by
//! 2.4e-5 rad. A joint held by parallelograms is a difference of two: less than a tenth of [`MARGIN`] remains.

use motion::Angle;

use crate::description::{AxisDescription, Gearing, Reference, RobotDescription};

/// Nearer to a limit than this nothing is accepted, rad or m.
const MARGIN: f64 = 1e-3;
/// A screw nearer to a dead centre than this is not judged: the cosine of the angle at the shoulder, 2.6°.
const MOST_COSINE: f32 = 0.999;

/// How a gear coordinate follows from motor travel.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Gear {
    /// x for a rad of travel, rad/rad or m/rad.
    Linear { per_rad: f32 },
    /// The same of the travel less that of the axis before.
    OnPrevious { per_rad: f32 },
    /// A screw: −acos((l² − sum)·`per_amplitude`) − phase, with its length l in mm.
    Screw {
        mm_per_rad: f32,
        reference_mm: f32,
        sum_mm2: f32,
        per_amplitude: f32,
        phase: f32,
    },
    /// Not judged here.
    Other,
}

/// One axis.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Guarded {
    /// The motor's angle at no travel.
    origin: Angle,
    gear: Gear,
    /// The joint is x less this, and less x of the axis before if `in_plane`; rad or m.
    offset: f32,
    in_plane: bool,
    /// The range of the joint, narrowed by the margin.
    lower: f32,
    upper: f32,
}

impl Guarded {
    fn new(axis: &AxisDescription) -> Self {
        let gear = match axis.gearing {
            Gearing::Linear { ratio } => Gear::Linear {
                per_rad: narrow(1.0 / ratio),
            },
            Gearing::OnPrevious { ratio } => Gear::OnPrevious {
                per_rad: narrow(1.0 / ratio),
            },
            Gearing::Screw(screw) => Gear::Screw {
                mm_per_rad: narrow(1.0 / screw.rad_per_mm),
                reference_mm: narrow(screw.reference_length_mm),
                sum_mm2: narrow(screw.sum_of_squares_mm2),
                per_amplitude: narrow(1.0 / screw.amplitude()),
                phase: narrow(screw.phase()),
            },
            Gearing::Quadratic(_) => Gear::Other,
        };
        let (gear, offset) = match axis.reference {
            Reference::Joint => (gear, 0.0),
            Reference::ArmPlane { offset } => (gear, offset),
            Reference::Leg { .. } => (Gear::Other, 0.0),
        };
        Self {
            origin: Angle::bound(axis.synchro_motor_position),
            gear,
            offset: narrow(offset),
            in_plane: matches!(axis.reference, Reference::ArmPlane { .. }),
            lower: narrow(axis.joint_position.lower + MARGIN),
            upper: narrow(axis.joint_position.upper - MARGIN),
        }
    }
}

/// The quick test of one robot: see the [module](self).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointGuard<const N: usize> {
    axes: [Guarded; N],
}

impl<const N: usize> JointGuard<N> {
    /// Of a robot whose joints follow from its description alone, but for legs and quadratic gears: with these nothing
    /// is accepted.
    #[must_use]
    pub fn new(description: &RobotDescription<N>) -> Self {
        Self {
            axes: description.axes.each_ref().map(Guarded::new),
        }
    }

    /// Is every joint inside its range for sure, where the motors are at these angles?
    #[must_use]
    pub fn accepts(&self, motors: &[Angle; N]) -> bool {
        let (mut previous_travel, mut previous_x) = (0.0, 0.0);
        for (axis, motor) in self.axes.iter().zip(motors) {
            let travel = rad(motor.since(axis.origin));
            let x = match axis.gear {
                Gear::Linear { per_rad } => travel * per_rad,
                Gear::OnPrevious { per_rad } => (travel - previous_travel) * per_rad,
                Gear::Screw {
                    mm_per_rad,
                    reference_mm,
                    sum_mm2,
                    per_amplitude,
                    phase,
                } => {
                    let length = travel * mm_per_rad + reference_mm;
                    let cosine = (length * length - sum_mm2) * per_amplitude;
                    if !(length > 0.0 && libm::fabsf(cosine) < MOST_COSINE) {
                        return false;
                    }
                    -libm::acosf(cosine) - phase
                }
                Gear::Other => return false,
            };
            let in_plane = if axis.in_plane { previous_x } else { 0.0 };
            let joint = x - in_plane - axis.offset;
            // what is not a number is not inside
            if !(joint > axis.lower && joint < axis.upper) {
                return false;
            }
            (previous_travel, previous_x) = (travel, x);
        }
        true
    }
}

#[expect(clippy::cast_possible_truncation, reason = "24 bits are enough")]
const fn narrow(x: f64) -> f32 {
    x as f32
}

/// A difference of angles, rad.
#[expect(clippy::cast_precision_loss, reason = "24 bits are enough")]
fn rad(quanta: i64) -> f32 {
    /// 2⁻⁴⁰
    const PER_QUANTUM: f32 = 1.0 / 1_099_511_627_776.0;
    quanta as f32 * PER_QUANTUM
}
