//! The tripod: three legs and the passive central leg that guides the platform.
//!
//! # Legs
//!
//! The platform stands at R = Y(ty)·X(tx), its origin at c = −r·n with n = R·ẑ. A leg ends at b in the
//! base and at κ·b in the platform (both triangles point the same way, κ = a/B), so with c ⊥ R·κb
//!
//! ```text
//!   L² = |c + R·κb − b|² = r² + (1 + κ²)·B² + 2r·(n·b) − 2κ·(b·R·b)
//!   n·b   = bx·sin ty·cos tx − by·sin tx
//!   b·R·b = bx²·cos ty + bx·by·sin ty·sin tx + by²·cos tx
//! ```
//!
//! and with Q = L² for any two joints x, y: ∂L/∂x = ∂Q/∂x / 2L,
//! ∂²L/∂x∂y = (½·∂²Q/∂x∂y − ∂L/∂x·∂L/∂y) / L.
//!
//! # From legs to joints
//!
//! Summed over the three legs with weights 1, cos φ and sin φ, where the sums of cos φ, sin φ, cos 2φ and
//! sin 2φ over the legs vanish and those of cos 3φ and sin 3φ are 0 and −3,
//!
//! ```text
//!   ⅓ΣL²         = r² + a² + B² − a·B·(cos tx + cos ty)
//!   ⅔ΣL²cos φ/B  =  sin ty·(2r·cos tx + a·sin tx)
//!   ⅔ΣL²sin φ/B  = −2r·sin tx + a·(cos ty − cos tx)
//! ```
//!
//! The first gives r > 0 for any tilts; put into the other two it leaves two equations F(ty, tx) = 0. The
//! symmetric part of their Jacobian is positive definite for all tilts up to [`TILT_RAD`] and all reaches
//! from [`REACH_M`] on: its lesser eigenvalue is at least 0.12 m, as a test finds on a dense grid. For two
//! points q ≠ p of that convex square (q − p)·(F(q) − F(p)) = ∫(q − p)·F'·(q − p) > 0, so F has at
//! most one root there: no other way to assemble the legs exists within these tilts, and what lies beyond
//! them is refused.
//!
//! Newton's method starts from the root for a = 0, so it needs no memory. As measured on a dense grid over all
//! that is known, that start is at most e = 0.123 rad off, and every step takes e to at most 1.1·e²: after
//! four steps rounding is all that is left. Four are the most ever taken in the tests, over the joints' limits
//! and beyond; [`MAX_ITERATIONS`] is twice that, and nothing but legs without a platform need them.

use core::f64::consts::FRAC_PI_4;

use super::assumed::{BASE_RADIUS_M, PLATFORM_RADIUS_M};
use crate::description::Range;
use crate::error::{KinematicError, Quantity};
use crate::planning::{greatest, least};

/// Cosine of 30°.
const COS_30: f64 = 0.866_025_403_784_438_6;
/// Where the legs stand in the base, at 90°, 210° and 330°: x and y, m.
pub(super) const FEET_M: [[f64; 2]; 3] = [
    [0.0, BASE_RADIUS_M],
    [-BASE_RADIUS_M * COS_30, -0.5 * BASE_RADIUS_M],
    [BASE_RADIUS_M * COS_30, -0.5 * BASE_RADIUS_M],
];
/// Platform over base.
const KAPPA: f64 = PLATFORM_RADIUS_M / BASE_RADIUS_M;

/// Tilts up to which the tripod is known, rad; beyond, another assembly may exist.
pub(super) const TILT_RAD: Range = Range {
    lower: -FRAC_PI_4,
    upper: FRAC_PI_4,
};
/// Reaches for which the tripod is known, m.
pub(super) const REACH_M: Range = Range {
    lower: 0.5,
    upper: 1.7,
};
/// Leg lengths that a screw could have at all, m: what is used (the motors' limits) with 0.1 m on both
/// sides.
pub(super) const LEG_M: Range = Range {
    lower: 0.5,
    upper: 1.7,
};

/// The most steps of Newton's method.
pub(super) const MAX_ITERATIONS: u32 = 8;
/// A step this short is the last, rad: the error it leaves is of the order of its square.
const LAST_STEP_RAD: f64 = 1e-7;
/// How well the joints found give the legs asked for, m.
const VERIFY_M: f64 = 1e-12;

/// A leg's length with its derivatives by ty, tx, r.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Leg {
    /// L, m.
    pub(super) length: f64,
    /// ∂L/∂q, m/rad, m/rad, 1.
    pub(super) first: [f64; 3],
    /// ∂²L/∂q∂q, symmetric.
    pub(super) second: [[f64; 3]; 3],
}

impl Leg {
    /// Rate of the length where the joints move at `rates`.
    pub(super) fn rate(&self, rates: &[f64; 3]) -> f64 {
        dot(&self.first, rates)
    }

    /// Σ ∂²L/∂q∂q·q̇·q̇ where the joints move at `rates`.
    pub(super) fn curvature(&self, rates: &[f64; 3]) -> f64 {
        dot(&self.second.map(|row| dot(&row, rates)), rates)
    }
}

fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    let ([a0, a1, a2], [b0, b1, b2]) = (a, b);
    a0 * b0 + a1 * b1 + a2 * b2
}

/// Sine and cosine of both tilts, and the reach.
#[derive(Clone, Copy, Debug)]
struct Platform {
    sy: f64,
    cy: f64,
    sx: f64,
    cx: f64,
    r: f64,
}

impl Platform {
    fn at([ty, tx, r]: [f64; 3]) -> Self {
        let ((sy, cy), (sx, cx)) = (libm::sincos(ty), libm::sincos(tx));
        Self { sy, cy, sx, cx, r }
    }

    fn length(&self, [bx, by]: [f64; 2]) -> f64 {
        let Self { sy, cy, sx, cx, r } = *self;
        let along = bx * sy * cx - by * sx;
        let turned = bx * bx * cy + bx * by * sy * sx + by * by * cx;
        let radii = BASE_RADIUS_M * BASE_RADIUS_M + PLATFORM_RADIUS_M * PLATFORM_RADIUS_M;
        libm::sqrt(r * r + radii + 2.0 * (r * along - KAPPA * turned))
    }

    fn leg(&self, foot: [f64; 2]) -> Leg {
        let Self { sy, cy, sx, cx, r } = *self;
        let [bx, by] = foot;
        let length = self.length(foot);
        // halves of the derivatives of Q
        let q = [
            r * bx * cy * cx - KAPPA * (bx * by * cy * sx - bx * bx * sy),
            r * (-bx * sy * sx - by * cx) - KAPPA * (bx * by * sy * cx - by * by * sx),
            r + bx * sy * cx - by * sx,
        ];
        let q_yy = -r * bx * sy * cx + KAPPA * (bx * bx * cy + bx * by * sy * sx);
        let q_xx = r * (by * sx - bx * sy * cx) + KAPPA * (bx * by * sy * sx + by * by * cx);
        let q_yx = -r * bx * cy * sx - KAPPA * bx * by * cy * cx;
        let q_yr = bx * cy * cx;
        let q_xr = -bx * sy * sx - by * cx;
        let first = q.map(|q| q / length);
        let mut second = [[q_yy, q_yx, q_yr], [q_yx, q_xx, q_xr], [q_yr, q_xr, 1.0]];
        for (row, a) in second.iter_mut().zip(first) {
            for (q, b) in row.iter_mut().zip(first) {
                *q = (*q - a * b) / length;
            }
        }
        Leg {
            length,
            first,
            second,
        }
    }
}

/// The joint or leg that is outside what is known of the tripod.
fn outside(axis: usize, quantity: Quantity, value: f64, range: Range) -> KinematicError {
    // screws are in mm in messages
    let unit = match quantity {
        Quantity::ScrewLength => 1e3,
        Quantity::Joint | Quantity::Motor | Quantity::ScrewAngle => 1.0,
    };
    KinematicError::Limit {
        axis,
        name: super::data::NAMES.get(axis).copied().unwrap_or(""),
        quantity,
        value: value * unit,
        lower: range.lower * unit,
        upper: range.upper * unit,
    }
}

fn known(
    values: [f64; 3],
    ranges: [Range; 3],
    quantity: Quantity,
) -> Result<[f64; 3], KinematicError> {
    for (axis, (value, range)) in values.into_iter().zip(ranges).enumerate() {
        if !range.contains(value) {
            return Err(outside(axis, quantity, value, range));
        }
    }
    Ok(values)
}

/// The legs at tilt about y, tilt about x (rad) and reach (m).
///
/// # Errors
/// [`KinematicError::Limit`] of a joint outside [`TILT_RAD`] or [`REACH_M`], or a leg outside [`LEG_M`].
pub(super) fn legs(joints: [f64; 3]) -> Result<[Leg; 3], KinematicError> {
    let joints = known(joints, [TILT_RAD, TILT_RAD, REACH_M], Quantity::Joint)?;
    let platform = Platform::at(joints);
    let legs = FEET_M.map(|foot| platform.leg(foot));
    known(
        legs.map(|leg| leg.length),
        [LEG_M; 3],
        Quantity::ScrewLength,
    )?;
    Ok(legs)
}

/// Tilt about y, tilt about x (rad) and reach (m) at leg lengths (m), with the number of Newton's steps.
///
/// # Errors
/// [`KinematicError::Limit`] of a leg outside [`LEG_M`]; [`KinematicError::Unreachable`] where no
/// platform within [`TILT_RAD`] and [`REACH_M`] joins the legs.
pub(super) fn assembled(lengths: [f64; 3]) -> Result<([f64; 3], u32), KinematicError> {
    let equations = Equations::of(known(lengths, [LEG_M; 3], Quantity::ScrewLength)?);
    let mut tilts = equations.start().ok_or(KinematicError::Unreachable)?;
    let mut steps = 0;
    let mut settled = false;
    while !settled && steps < MAX_ITERATIONS {
        let step = equations.step(tilts).ok_or(KinematicError::Unreachable)?;
        settled = step.iter().all(|s| s.abs() < LAST_STEP_RAD);
        for (tilt, step) in tilts.iter_mut().zip(step) {
            // a root is within TILT_RAD, so a step beyond cannot be meant
            *tilt = greatest(least(*tilt + step, TILT_RAD.upper), TILT_RAD.lower);
        }
        steps += 1;
    }
    let [ty, tx] = tilts;
    let reach = equations
        .platform(tilts)
        .filter(|platform| settled && REACH_M.contains(platform.r))
        .ok_or(KinematicError::Unreachable)?
        .r;
    let platform = Platform::at([ty, tx, reach]);
    for (foot, length) in FEET_M.into_iter().zip(lengths) {
        let off = (platform.length(foot) - length).abs();
        if off.is_nan() || off > VERIFY_M {
            return Err(KinematicError::Unreachable);
        }
    }
    Ok(([ty, tx, reach], steps))
}

/// The weighted sums of the legs' squares, as the module's page has them.
#[derive(Clone, Copy, Debug)]
struct Equations {
    /// ⅓·ΣL² − a² − B², m².
    square: f64,
    /// ⅔·ΣL²·cos φ / B, m.
    cosine: f64,
    /// ⅔·ΣL²·sin φ / B, m.
    sine: f64,
}

const AREA_M2: f64 = PLATFORM_RADIUS_M * BASE_RADIUS_M;

impl Equations {
    /// sin φ is 1, −½, −½, and cos φ is 0, −cos 30°, cos 30°.
    fn of(lengths: [f64; 3]) -> Self {
        let [l0, l1, l2] = lengths.map(|l| l * l);
        let radii = BASE_RADIUS_M * BASE_RADIUS_M + PLATFORM_RADIUS_M * PLATFORM_RADIUS_M;
        Self {
            square: (l0 + l1 + l2) / 3.0 - radii,
            cosine: (l2 - l1) * COS_30 / (1.5 * BASE_RADIUS_M),
            sine: (l0 - 0.5 * (l1 + l2)) / (1.5 * BASE_RADIUS_M),
        }
    }

    /// The platform at these tilts with the reach the first equation gives; nothing where there is none.
    fn platform(&self, [ty, tx]: [f64; 2]) -> Option<Platform> {
        let mut platform = Platform::at([ty, tx, 0.0]);
        let square = self.square + AREA_M2 * (platform.cx + platform.cy);
        platform.r = libm::sqrt(square);
        (square > 0.0).then_some(platform)
    }

    /// The tilts for a platform of no size, brought within [`TILT_RAD`].
    fn start(&self) -> Option<[f64; 2]> {
        let r = self.platform([0.0, 0.0])?.r;
        let most = libm::sin(TILT_RAD.upper);
        let angle = |sine: f64| libm::asin(greatest(least(sine, most), -most));
        let tx = angle(-self.sine / (2.0 * r));
        let ty = angle(self.cosine / (2.0 * r * libm::cos(tx)));
        Some([ty, tx])
    }

    /// Newton's step for F; nothing where there is no reach.
    fn step(&self, tilts: [f64; 2]) -> Option<[f64; 2]> {
        let Platform { sy, cy, sx, cx, r } = self.platform(tilts)?;
        let a = PLATFORM_RADIUS_M;
        let f = [
            sy * (2.0 * r * cx + a * sx) - self.cosine,
            2.0 * r * sx - a * (cy - cx) + self.sine,
        ];
        // r follows the tilts by the first equation
        let (r_y, r_x) = (-AREA_M2 * sy / (2.0 * r), -AREA_M2 * sx / (2.0 * r));
        let yy = cy * (2.0 * r * cx + a * sx) + 2.0 * sy * cx * r_y;
        let yx = sy * (a * cx - 2.0 * r * sx) + 2.0 * sy * cx * r_x;
        let xy = a * sy + 2.0 * sx * r_y;
        let xx = 2.0 * r * cx - a * sx + 2.0 * sx * r_x;
        // positive with the symmetric part of F'; a reach so short that this is not known is refused in the end
        let determinant = yy * xx - yx * xy;
        let [f_y, f_x] = f;
        Some([
            (yx * f_x - xx * f_y) / determinant,
            (xy * f_y - yy * f_x) / determinant,
        ])
    }
}

/// x of Σ rows·x = values, by Cramer's rule.
///
/// # Errors
/// [`KinematicError::Singular`] where the rows are dependent: nowhere within [`TILT_RAD`].
pub(super) fn solved(rows: &[[f64; 3]; 3], values: [f64; 3]) -> Result<[f64; 3], KinematicError> {
    let [a, b, c] = rows.map(nalgebra::Vector3::from);
    let [x, y, z] = values;
    let (bc, ca, ab) = (b.cross(&c), c.cross(&a), a.cross(&b));
    let determinant = a.dot(&bc);
    if determinant == 0.0 {
        return Err(KinematicError::Singular);
    }
    Ok(((bc * x + ca * y + ab * z) / determinant).into())
}

#[cfg(test)]
mod test {
    use super::*;

    /// Errors (rad) of the start and of Newton's first steps, at worst over all that is known.
    #[test]
    fn newton_squares_the_error_from_the_first_step_on() {
        let mut worst = [0.0_f64; 5];
        for i in -44..=44 {
            for j in -44..=44 {
                for k in 0..=24 {
                    let truth = [f64::from(i).to_radians(), f64::from(j).to_radians()];
                    let [ty, tx] = truth;
                    let r = 0.5 + 0.05 * f64::from(k);
                    let Ok(legs) = legs([ty, tx, r]) else {
                        continue;
                    };
                    let equations = Equations::of(legs.map(|leg| leg.length));
                    let mut tilts = equations.start().unwrap();
                    for worst in &mut worst {
                        for (tilt, truth) in tilts.iter().zip(truth) {
                            *worst = greatest(*worst, (tilt - truth).abs());
                        }
                        let step = equations.step(tilts).unwrap();
                        tilts = [tilts[0] + step[0], tilts[1] + step[1]];
                    }
                }
            }
        }
        // the documentation's claims: the start, and e ← 1.1·e², down to rounding
        assert!((0.1..0.123).contains(&worst[0]), "{worst:?}");
        for pair in worst.windows(2) {
            assert!(pair[1] < 1.1 * pair[0] * pair[0] + 1e-14, "{worst:?}");
        }
    }
}
