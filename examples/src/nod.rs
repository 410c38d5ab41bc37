//! A motion as a function of time, and nothing else.

use core::f64::consts::TAU;

/// The joint that nods: T, which tilts the wrist.
pub const WRIST: usize = 3;

/// A macrostep, s.
pub const STEP_S: f64 = 0.02;

/// How long a nod lasts, s.
pub const DURATION_S: f64 = 6.0;

/// Its amplitude, rad.
const AMPLITUDE_RAD: f64 = 0.08;

/// Three nods under a raised cosine: angle (rad), velocity (rad/s) and acceleration (rad/s²) after
/// `t` seconds; exactly zero up to 0 and from [`DURATION_S`] on, because a motion that ends other than
/// at rest is a fault.
///
/// ½(1 − cos Ωt)·sin 3Ωt = ½ sin 3Ωt − ¼ sin 2Ωt − ¼ sin 4Ωt with Ω = 2π/[`DURATION_S`], all three
/// values of which vanish at both ends, so that it joins rest smoothly.
#[must_use]
pub fn nod(t: f64) -> [f64; 3] {
    let mut y = [0.0; 3];
    if t > 0.0 && t < DURATION_S {
        for (share, k) in [(0.5, 3.0), (-0.25, 2.0), (-0.25, 4.0)] {
            let (a, w) = (AMPLITUDE_RAD * share, k * TAU / DURATION_S);
            let (sin, cos) = libm::sincos(w * t);
            y[0] += a * sin;
            y[1] += a * w * cos;
            y[2] -= a * w * w * sin;
        }
    }
    y
}

#[cfg(test)]
mod test {
    use super::*;

    #[test]
    fn a_nod_begins_and_ends_at_rest() {
        for t in [-1.0, 0.0, DURATION_S, DURATION_S + 1.0] {
            assert_eq!(
                nod(t).map(f64::to_bits),
                [0.0; 3].map(f64::to_bits),
                "at {t} s"
            );
        }
        // beside the ends the acceleration is not yet off zero by more than its greatest slope,
        // jerk 1.5·AMPLITUDE·Ω²·3Ω = 0.41 rad/s³, allows
        for t in [1e-6, DURATION_S - 1e-6] {
            assert!(nod(t)[2].abs() < 0.5e-6, "{:?}", nod(t));
        }
    }

    #[test]
    fn velocity_and_acceleration_are_its_derivatives() {
        const H: f64 = 1e-4;
        for k in 1..600 {
            let t = f64::from(k) * 0.01;
            let [before, now, after] = [nod(t - H), nod(t), nod(t + H)];
            for (of, derivative) in [(0, 1), (1, 2)] {
                let difference = (after[of] - before[of]) / (2.0 * H);
                // h²/6 of the third derivative, which is below 20 of either: 3·10⁻⁸
                assert!((difference - now[derivative]).abs() < 1e-7, "at {t} s");
            }
        }
        // they are not the zeros that would pass as well: ω = π at the crest of the cosine
        assert!((nod(3.0)[1] + AMPLITUDE_RAD * core::f64::consts::PI).abs() < 1e-12);
    }
}
