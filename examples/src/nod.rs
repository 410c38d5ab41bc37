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
