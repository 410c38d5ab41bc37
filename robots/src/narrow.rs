//! Gears in f32, with what is constant found once: what a servo step computes with.
//!
//! As [`crate::gearing`], which is f64, but for legs and quadratic gears. Of a screw's triangle the length l follows from
//! the travel, and all else from the cosine of θ: with `s = √(1 − cos²θ)`, l' = D·s/2l, l'' = (−D·cos θ/2 − l'²)/l (see [`crate::screw`]).
//!
//! What f32 is off, with its unit 2⁻²⁴ = 6e-8: a travel of 10⁴ rad 6e-4 rad of the motor, through the smallest ratio of a
//! gear, 87, 7e-6 rad of a joint. A screw's length l of 400 mm 5e-5 mm, so l² 0.04 mm², and its cosine, that over an
//! amplitude of 4e4 mm², 1e-6; with a sine of at least 0.0447 the angle is off by 2.4e-5 rad.

use motion::Angle;

use crate::description::{AxisDescription, Gearing, Reference};

/// A screw nearer to a dead centre than this is not judged: the cosine of the angle at the shoulder, 2.6°.
const MOST_COSINE: f32 = 0.999;

/// A screw across a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Screw {
    mm_per_rad: f32,
    reference_mm: f32,
    sum_mm2: f32,
    amplitude_mm2: f32,
    per_amplitude: f32,
    phase: f32,
}

/// How a gear coordinate follows from motor travel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Gear {
    /// x for a rad of travel, rad/rad or m/rad.
    Linear { per_rad: f32 },
    /// The same of the travel less that of the axis before.
    OnPrevious { per_rad: f32 },
    /// −acos((l² − sum)/amplitude) − phase, with the screw's length l in mm.
    Screw(Screw),
}

/// Where a gear stands, and how it moves its motor there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Geared {
    /// The gear coordinate, rad or m.
    pub(crate) x: f32,
    /// ∂x/∂m of its own motor: 1/m'.
    pub(crate) reduction: f32,
    /// m'', rad/rad².
    pub(crate) curvature: f32,
}

/// One axis from its motor to its joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Axis {
    /// The motor's angle at no travel.
    origin: Angle,
    pub(crate) gear: Gear,
    /// The joint is x less this, and less x of the axis before if `in_plane`; rad or m.
    pub(crate) offset: f32,
    pub(crate) in_plane: bool,
}

impl Axis {
    /// `None` with a leg or a quadratic gear.
    pub(crate) fn new(axis: &AxisDescription) -> Option<Self> {
        let gear = match axis.gearing {
            Gearing::Linear { ratio } => Gear::Linear {
                per_rad: narrow(1.0 / ratio),
            },
            Gearing::OnPrevious { ratio } => Gear::OnPrevious {
                per_rad: narrow(1.0 / ratio),
            },
            Gearing::Screw(screw) => Gear::Screw(Screw {
                mm_per_rad: narrow(1.0 / screw.rad_per_mm),
                reference_mm: narrow(screw.reference_length_mm),
                sum_mm2: narrow(screw.sum_of_squares_mm2),
                amplitude_mm2: narrow(screw.amplitude()),
                per_amplitude: narrow(1.0 / screw.amplitude()),
                phase: narrow(screw.phase()),
            }),
            Gearing::Quadratic(_) => return None,
        };
        let offset = match axis.reference {
            Reference::Joint => 0.0,
            Reference::ArmPlane { offset } => offset,
            Reference::Leg { .. } => return None,
        };
        Some(Self {
            origin: Angle::bound(axis.synchro_motor_position),
            gear,
            offset: narrow(offset),
            in_plane: matches!(axis.reference, Reference::ArmPlane { .. }),
        })
    }

    /// Does the motor's travel hold that of the axis before?
    pub(crate) const fn on_previous(&self) -> bool {
        matches!(self.gear, Gear::OnPrevious { .. })
    }

    /// Travel from the synchronisation offset: exact, and then f32, rad.
    #[inline]
    pub(crate) fn travel(&self, motor: Angle) -> f32 {
        rad(motor.since(self.origin))
    }

    /// The joint of this gear coordinate and that of the axis before.
    #[inline]
    pub(crate) fn joint(&self, x: f32, previous_x: f32) -> f32 {
        let in_plane = if self.in_plane { previous_x } else { 0.0 };
        x - in_plane - self.offset
    }
}

impl Gear {
    /// The gear coordinate at this travel and that of the axis before, rad; `None` near a screw's dead centres.
    #[inline]
    pub(crate) fn x(&self, travel: f32, previous: f32) -> Option<f32> {
        match self {
            Self::Linear { per_rad } => Some(travel * per_rad),
            Self::OnPrevious { per_rad } => Some((travel - previous) * per_rad),
            Self::Screw(screw) => {
                let (_, cosine) = screw.triangle(travel)?;
                Some(screw.angle(cosine))
            }
        }
    }

    /// The same with how it moves its motor there.
    #[inline]
    pub(crate) fn at(&self, travel: f32, previous: f32) -> Option<Geared> {
        let (x, reduction, curvature) = match self {
            Self::Linear { per_rad } => (travel * per_rad, *per_rad, 0.0),
            Self::OnPrevious { per_rad } => ((travel - previous) * per_rad, *per_rad, 0.0),
            Self::Screw(screw) => {
                let (length, cosine) = screw.triangle(travel)?;
                let sine = libm::sqrtf((1.0 - cosine) * (1.0 + cosine));
                let half = 0.5 * screw.amplitude_mm2;
                let first = half * sine / length;
                let second = (-half * cosine - first * first) / length;
                let reduction = screw.mm_per_rad / first;
                (screw.angle(cosine), reduction, second / screw.mm_per_rad)
            }
        };
        Some(Geared {
            x,
            reduction,
            curvature,
        })
    }
}

impl Screw {
    /// Its length, mm, and the cosine of θ.
    #[inline]
    fn triangle(&self, travel: f32) -> Option<(f32, f32)> {
        let length = travel * self.mm_per_rad + self.reference_mm;
        let cosine = (length * length - self.sum_mm2) * self.per_amplitude;
        (length > 0.0 && libm::fabsf(cosine) < MOST_COSINE).then_some((length, cosine))
    }

    #[inline]
    fn angle(&self, cosine: f32) -> f32 {
        -libm::acosf(cosine) - self.phase
    }
}

/// Sine and cosine of an angle, rad, to 1.5e-7 within some turns; libm's compute in f64.
///
/// The angle less a multiple k of π/2, taken away in two parts of which the first has 8 bits, so that k times it is exact;
/// then Taylor's series: within π/4 what is left out is below (π/4)¹¹/11! = 2e-9 and (π/4)¹²/12! = 1e-10.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_precision_loss,
    reason = "some quarters of a turn"
)]
pub(crate) fn sine_cosine(x: f32) -> (f32, f32) {
    /// 201/128, and what is left of π/2.
    const QUARTER: [f32; 2] = [1.570_312_5, 4.838_268e-4];
    let half = if x < 0.0 { -0.5 } else { 0.5 };
    let k = (x * core::f32::consts::FRAC_2_PI + half) as i32;
    let [most, rest] = QUARTER;
    let r = (x - k as f32 * most) - k as f32 * rest;
    let s = r * r;
    let sine =
        r + r * s * (-1.0 / 6.0 + s * (1.0 / 120.0 + s * (-1.0 / 5040.0 + s * (1.0 / 362_880.0))));
    let cosine = 1.0
        + s * (-0.5
            + s * (1.0 / 24.0
                + s * (-1.0 / 720.0 + s * (1.0 / 40_320.0 + s * (-1.0 / 3_628_800.0)))));
    match k & 3 {
        0 => (sine, cosine),
        1 => (cosine, -sine),
        2 => (-sine, -cosine),
        _ => (-cosine, sine),
    }
}

/// The nearest float of 32 bits.
#[expect(clippy::cast_possible_truncation, reason = "24 bits are enough")]
pub(crate) const fn narrow(x: f64) -> f32 {
    x as f32
}

/// A difference of angles, rad.
#[expect(clippy::cast_precision_loss, reason = "24 bits are enough")]
pub(crate) fn rad(quanta: i64) -> f32 {
    /// 2⁻⁴⁰
    const PER_QUANTUM: f32 = 1.0 / 1_099_511_627_776.0;
    quanta as f32 * PER_QUANTUM
}

#[cfg(test)]
mod test {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn sine_and_cosine_are_those_of_f64(x in -20.0..20.0f32) {
            let (s, c) = sine_cosine(x);
            let (sine, cosine) = libm::sincos(f64::from(x));
            // two roundings of the result, and of the angle within a quarter of a turn
            prop_assert!((f64::from(s) - sine).abs() < 1.5e-7, "{s} {sine}");
            prop_assert!((f64::from(c) - cosine).abs() < 1.5e-7, "{c} {cosine}");
        }
    }

    #[test]
    fn no_angle_has_no_sine() {
        let (s, c) = sine_cosine(f32::NAN);
        assert!(s.is_nan() && c.is_nan());
        assert_eq!(sine_cosine(0.0), (0.0, 1.0));
    }
}
