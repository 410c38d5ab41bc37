//! Forward kinematics and Jacobian of the six axes from the column on.

use core::f64::consts::FRAC_PI_2;

use motion::Pose;
use nalgebra::{Matrix3, Vector3};

use super::data::{LOWER_ARM_M, UPPER_ARM_M, WRIST_M};

/// Sine and cosine of every absolute angle t1 … t6 of the module's page.
#[derive(Clone, Copy, Debug)]
struct Angles {
    s: [f64; 6],
    c: [f64; 6],
}

impl Angles {
    fn of([q1, q2, q3, q4, q5, q6]: &[f64; 6]) -> Self {
        let t3 = q3 + q2 + FRAC_PI_2;
        let t = [*q1, *q2, t3, q4 + t3, *q5, *q6];
        // the same bits as sine and cosine by themselves, from one reduction of the angle
        let both = t.map(libm::sincos);
        Self {
            s: both.map(|(s, _)| s),
            c: both.map(|(_, c)| c),
        }
    }
}

/// Z(t) from sine and cosine.
pub(crate) fn about_z(s: f64, c: f64) -> Matrix3<f64> {
    Matrix3::new(c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0)
}

/// Y(t) from sine and cosine.
pub(crate) fn about_y(s: f64, c: f64) -> Matrix3<f64> {
    Matrix3::new(c, 0.0, s, 0.0, 1.0, 0.0, -s, 0.0, c)
}

/// X(t) from sine and cosine.
pub(crate) fn about_x(s: f64, c: f64) -> Matrix3<f64> {
    Matrix3::new(1.0, 0.0, 0.0, 0.0, c, -s, 0.0, s, c)
}

/// Flange in the frame of the shoulder.
pub(super) fn forward(joints: &[f64; 6]) -> Pose {
    let Angles {
        s: [s1, s2, s3, s4, s5, s6],
        c: [c1, c2, c3, c4, c5, c6],
    } = Angles::of(joints);
    let r = LOWER_ARM_M * c2 + UPPER_ARM_M * c3 + WRIST_M * c4;
    let h = -(LOWER_ARM_M * s2 + UPPER_ARM_M * s3 + WRIST_M * s4);
    // Z(t1)·Y(t4) of a vector: forward and upward in the arm's plane, and across
    let turned = |ahead: f64, across: f64, up: f64| {
        let (out, up) = (c4 * ahead + s4 * up, c4 * up - s4 * ahead);
        Vector3::new(c1 * out - s1 * across, s1 * out + c1 * across, up)
    };
    // N, O, A are X(t5)·Y(t6) of z, x, y: by Π
    let n = turned(s6, -s5 * c6, c5 * c6);
    let o = turned(c6, s5 * s6, -c5 * s6);
    let a = turned(0.0, c5, s5);
    Pose {
        position: Vector3::new(c1 * r, s1 * r, h),
        rotation: Matrix3::from_columns(&[n, o, a]),
    }
}

/// Columns (linear; angular) of the geometric Jacobian, in axis order.
///
/// A joint that turns about the unit vector w through the point o moves the flange at
/// (w × (p − o); w). Column: w = z through the base; lower arm, upper arm, T: w = Z(t1)·y through
/// shoulder, elbow and wrist, because a relative joint carries all links after it; V and N: lines
/// through the flange itself, so they only turn it.
pub(super) fn jacobian(joints: &[f64; 6]) -> [[f64; 6]; 6] {
    let Angles {
        s: [s1, s2, s3, s4, s5, _],
        c: [c1, c2, c3, c4, c5, _],
    } = Angles::of(joints);
    // in the arm's plane: what lies beyond shoulder, elbow and wrist
    let (r4, h4) = (WRIST_M * c4, -WRIST_M * s4);
    let (r3, h3) = (r4 + UPPER_ARM_M * c3, h4 - UPPER_ARM_M * s3);
    let (r2, h2) = (r3 + LOWER_ARM_M * c2, h3 - LOWER_ARM_M * s2);
    // y × (r, 0, h) = (h, 0, −r)
    let swing = |r: f64, h: f64| [c1 * h, s1 * h, -r, -s1, c1, 0.0];
    let turn = |w: Vector3<f64>| [0.0, 0.0, 0.0, w.x, w.y, w.z];
    let to_t = about_z(s1, c1) * about_y(s4, c4);
    [
        [-s1 * r2, c1 * r2, 0.0, 0.0, 0.0, 1.0],
        swing(r2, h2),
        swing(r3, h3),
        swing(r4, h4),
        turn(to_t * Vector3::x()),
        turn(to_t * about_x(s5, c5) * Vector3::y()),
    ]
}
