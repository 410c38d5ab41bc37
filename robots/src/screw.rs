//! A link driven by a ball screw across a triangle.
//!
//! ```text
//!            shoulder S ────────▶ link, at angle t below the horizontal
//!              /  \
//!    crank p  /    \  frame r, fixed in the column
//!            /      \
//!   nut pivot ═══════ motor pivot
//!           screw, length l
//! ```
//!
//! The crank is rigid on the link, so the angle between crank and frame is t plus a constant. By the
//! law of cosines, with θ that angle measured so that it is π when the triangle is folded flat,
//!
//! ```text
//!   l² = p² + r² + 2pr·cos θ,   θ = t + ψ,   S = p² + r²,   D = 2pr
//! ```
//!
//! which expands to the published form l² = S + μ·cos t − ν·sin t with μ = D·cos ψ, ν = D·sin ψ. The
//! assembled machine lives on −π < θ < 0, where l grows with θ and the relation is one to one; both
//! ends are dead centres. Differentiating l² three times gives the chain rule:
//!
//! ```text
//!   l'   = −D·sin θ / 2l
//!   l''  = (−D·cos θ / 2 − l'²) / l
//!   l''' = (D·sin θ − 6·l'·l'') / 2l
//! ```
//!
//! l' is the distance from the shoulder to the screw's line: at most the crank p, reached where crank
//! and screw are at right angles (cos θ = −p/r), falling to both sides. l'' falls over the whole of
//! −π < θ < 0. Both facts turn bounds over an interval into evaluations at a few points.

use core::f64::consts::PI;

use crate::error::Quantity;

/// The triangle, by the coefficients that are published, and the screw in it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScrewTriangle {
    /// S = p² + r², mm².
    pub sum_of_squares_mm2: f64,
    /// μ: the coefficient of cos t, mm².
    pub cosine_mm2: f64,
    /// ν: the coefficient of −sin t, mm².
    pub sine_mm2: f64,
    /// Length of the screw where the motor stands at its synchronisation offset, mm.
    pub reference_length_mm: f64,
    /// Motor turn for a lengthening of the screw, rad/mm: 2π over the lead.
    pub rad_per_mm: f64,
}

/// Motor travel from the synchronisation offset as a function of the gear coordinate x, with its
/// derivatives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Travel {
    /// m, rad.
    pub travel: f64,
    /// dm/dx, rad/rad or rad/m.
    pub first: f64,
    /// d²m/dx², rad/rad² or rad/m².
    pub second: f64,
    /// d³m/dx³, rad/rad³ or rad/m³.
    pub third: f64,
}

/// A value outside what a gear can do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct OutOfRange {
    pub(crate) quantity: Quantity,
    pub(crate) value: f64,
    pub(crate) lower: f64,
    pub(crate) upper: f64,
}

impl ScrewTriangle {
    /// D = 2pr, mm².
    pub(crate) fn amplitude(&self) -> f64 {
        libm::sqrt(self.cosine_mm2 * self.cosine_mm2 + self.sine_mm2 * self.sine_mm2)
    }

    /// ψ, rad.
    pub(crate) fn phase(&self) -> f64 {
        libm::atan2(self.sine_mm2, self.cosine_mm2)
    }

    /// The crank p, mm: the shorter of the two sides at the shoulder.
    #[must_use]
    pub fn crank_mm(&self) -> f64 {
        let (s, d) = (self.sum_of_squares_mm2, self.amplitude());
        // r² − p², from (r² − p²)² = S² − D²
        let difference = libm::sqrt((s - d) * (s + d));
        libm::sqrt(0.5 * (s - difference))
    }

    /// The link angles between the two dead centres, rad.
    #[must_use]
    pub fn angles(&self) -> (f64, f64) {
        let phase = self.phase();
        (-PI - phase, -phase)
    }

    /// The screw lengths between the two dead centres, mm.
    #[must_use]
    pub fn lengths_mm(&self) -> (f64, f64) {
        let (s, d) = (self.sum_of_squares_mm2, self.amplitude());
        (libm::sqrt(s - d), libm::sqrt(s + d))
    }

    /// Motor travel at link angle `t`, rad.
    pub(crate) fn travel(&self, t: f64) -> Result<Travel, OutOfRange> {
        let (lower, upper) = self.angles();
        if !(lower < t && t < upper) {
            return Err(OutOfRange {
                quantity: Quantity::ScrewAngle,
                value: t,
                lower,
                upper,
            });
        }
        let theta = t + self.phase();
        let (d, sin, cos) = (self.amplitude(), libm::sin(theta), libm::cos(theta));
        // the published form keeps every digit of its coefficients
        let length = libm::sqrt(
            self.sum_of_squares_mm2 + self.cosine_mm2 * libm::cos(t) - self.sine_mm2 * libm::sin(t),
        );
        let first = -0.5 * d * sin / length;
        let second = (-0.5 * d * cos - first * first) / length;
        let third = (0.5 * d * sin - 3.0 * first * second) / length;
        let g = self.rad_per_mm;
        Ok(Travel {
            travel: g * (length - self.reference_length_mm),
            first: g * first,
            second: g * second,
            third: g * third,
        })
    }

    /// Link angle, rad, at a motor travel from the synchronisation offset, rad.
    pub(crate) fn angle(&self, travel: f64) -> Result<f64, OutOfRange> {
        let length = travel / self.rad_per_mm + self.reference_length_mm;
        let (lower, upper) = self.lengths_mm();
        if !(lower < length && length < upper) {
            return Err(OutOfRange {
                quantity: Quantity::ScrewLength,
                value: length,
                lower,
                upper,
            });
        }
        let cos = (length * length - self.sum_of_squares_mm2) / self.amplitude();
        Ok(-libm::acos(cos) - self.phase())
    }

    /// The least and greatest dm/dt over link angles between `a` and `b`, rad/rad.
    pub(crate) fn slopes(&self, a: f64, b: f64) -> Result<(f64, f64), OutOfRange> {
        let (at_a, at_b) = (self.travel(a)?.first, self.travel(b)?.first);
        let (low, high) = if at_a < at_b {
            (at_a, at_b)
        } else {
            (at_b, at_a)
        };
        let crank = self.crank_mm();
        let frame = 0.5 * self.amplitude() / crank;
        let square = -libm::acos(-crank / frame) - self.phase();
        let peak_inside = (a <= square && square <= b) || (b <= square && square <= a);
        Ok((low, if peak_inside { self.steepest() } else { high }))
    }

    /// The greatest dm/dt of the triangle at all, rad/rad: screw and crank at right angles.
    pub(crate) fn steepest(&self) -> f64 {
        self.rad_per_mm * self.crank_mm()
    }

    /// The greatest |d²m/dt²| of the triangle at all, rad/rad²: at the folded dead centre.
    pub(crate) fn most_curved(&self) -> f64 {
        self.rad_per_mm * 0.5 * self.amplitude() / self.lengths_mm().0
    }

    /// The greatest |d²m/dt²| over link angles between `a` and `b`, rad/rad².
    pub(crate) fn curvature(&self, a: f64, b: f64) -> Result<f64, OutOfRange> {
        let (at_a, at_b) = (self.travel(a)?.second.abs(), self.travel(b)?.second.abs());
        Ok(if at_a < at_b { at_b } else { at_a })
    }
}

#[cfg(test)]
mod test {
    use super::*;
    use crate::irp6::data::{LOWER_ARM_SCREW, UPPER_ARM_SCREW};
    use proptest::prelude::*;

    // Sides of the mechanism, mm: crank, and the motor pivot behind and below the shoulder.
    const CRANK: f64 = 140.0;
    const BEHIND: f64 = 157.5;
    const BELOW: f64 = 183.0;

    fn screws() -> [ScrewTriangle; 2] {
        [LOWER_ARM_SCREW, UPPER_ARM_SCREW]
    }

    #[test]
    fn published_coefficients_are_the_triangle() {
        assert!((CRANK * CRANK + BEHIND * BEHIND + BELOW * BELOW - 77_895.25).abs() < 1e-9);
        for (screw, mounting_rad) in [(LOWER_ARM_SCREW, -1.309_181_4), (UPPER_ARM_SCREW, PI)] {
            assert_eq!(screw.sum_of_squares_mm2.to_bits(), 77_895.25_f64.to_bits());
            // crank 140 mm to the coefficients' printed digits
            assert!(
                (screw.crank_mm() - CRANK).abs() < 1e-4,
                "{}",
                screw.crank_mm()
            );
            for t in [-2.0_f64, -1.5, -0.5, 0.0, 0.5] {
                // nut pivot on the crank, motor pivot in the column; x forward, z up
                let a = t + mounting_rad;
                let (x, z) = (CRANK * libm::cos(a) + BEHIND, -CRANK * libm::sin(a) + BELOW);
                let l2 = screw.sum_of_squares_mm2 + screw.cosine_mm2 * libm::cos(t)
                    - screw.sine_mm2 * libm::sin(t);
                // half a unit of the last printed digit (0.005 mm²) on each coefficient
                assert!(
                    (l2 - (x * x + z * z)).abs() < 0.015,
                    "{l2} {}",
                    x * x + z * z
                );
            }
        }
        // vertical lower arm, level upper arm
        let reference = |screw: ScrewTriangle, t: f64| {
            screw.travel(t).unwrap().travel / screw.rad_per_mm + screw.reference_length_mm
        };
        assert!((reference(LOWER_ARM_SCREW, -PI / 2.0) - 220.3374).abs() < 5e-5);
        assert!((reference(UPPER_ARM_SCREW, 0.0) - 183.8348).abs() < 5e-5);
        // strokes at the ends of the joint ranges
        assert!((reference(LOWER_ARM_SCREW, (-130.0_f64).to_radians()) - 127.5).abs() < 0.1);
        assert!((reference(LOWER_ARM_SCREW, (-50.0_f64).to_radians()) - 307.5).abs() < 0.1);
        assert!((reference(UPPER_ARM_SCREW, (-25.0_f64).to_radians()) - 127.6).abs() < 0.1);
        assert!((reference(UPPER_ARM_SCREW, 40.0_f64.to_radians()) - 277.6).abs() < 0.1);
    }

    #[test]
    fn outside_the_dead_centres_there_is_no_answer() {
        for screw in screws() {
            let (low, high) = screw.angles();
            let (short, long) = screw.lengths_mm();
            for t in [low - 1e-9, high + 1e-9, low, high, f64::NAN] {
                assert_eq!(screw.travel(t).unwrap_err().quantity, Quantity::ScrewAngle);
            }
            for l in [short - 1e-6, long + 1e-6, -200.0, 0.0, f64::NAN] {
                let travel = (l - screw.reference_length_mm) * screw.rad_per_mm;
                assert_eq!(
                    screw.angle(travel).unwrap_err().quantity,
                    Quantity::ScrewLength
                );
            }
        }
    }

    proptest! {
        #[test]
        fn travel_and_angle_are_inverse(which in 0..2usize, u in 0.02..0.98f64) {
            let screw = screws()[which];
            let (low, high) = screw.angles();
            let t = low + u * (high - low);
            let back = screw.angle(screw.travel(t).unwrap().travel).unwrap();
            // acos loses 1/sin θ ≤ 16 of the 1e-15 near the ends
            prop_assert!((back - t).abs() < 1e-12, "{t} {back}");
        }

        #[test]
        fn derivatives_are_those_of_the_travel(which in 0..2usize, u in 0.05..0.95f64) {
            let screw = screws()[which];
            let (low, high) = screw.angles();
            let t = low + u * (high - low);
            let h = 1e-5;
            let (m, p) = (screw.travel(t - h).unwrap(), screw.travel(t + h).unwrap());
            let c = screw.travel(t).unwrap();
            // central differences: h²·f'''/6 and rounding/h, relative to slopes of hundreds
            prop_assert!(((p.travel - m.travel) / (2.0 * h) - c.first).abs() < 1e-5);
            prop_assert!(((p.first - m.first) / (2.0 * h) - c.second).abs() < 1e-5);
            prop_assert!(((p.second - m.second) / (2.0 * h) - c.third).abs() < 1e-4);
        }

        #[test]
        fn bounds_over_an_interval_hold_and_are_tight(
            which in 0..2usize, u in 0.01..0.99f64, v in 0.01..0.99f64,
        ) {
            let screw = screws()[which];
            let (low, high) = screw.angles();
            let (a, b) = (low + u * (high - low), low + v * (high - low));
            let (least, greatest) = screw.slopes(a, b).unwrap();
            let curvature = screw.curvature(a, b).unwrap();
            let mut seen = (f64::INFINITY, 0.0, 0.0);
            for i in 0..=400 {
                let at = screw.travel(a + (b - a) * f64::from(i) / 400.0).unwrap();
                prop_assert!(at.first >= least - 1e-9 && at.first <= greatest + 1e-9);
                prop_assert!(at.second.abs() <= curvature + 1e-9);
                seen = (
                    if at.first < seen.0 { at.first } else { seen.0 },
                    if at.first > seen.1 { at.first } else { seen.1 },
                    if at.second.abs() > seen.2 { at.second.abs() } else { seen.2 },
                );
            }
            // 400 samples come within a thousandth of the peak
            prop_assert!(seen.0 <= least + 1e-9);
            prop_assert!(seen.1 >= greatest * 0.999, "{seen:?} {greatest}");
            prop_assert!(seen.2 >= curvature - 1e-9);
        }
    }
}
