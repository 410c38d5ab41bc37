//! How near a configuration is to where motion gets difficult: singularities and limits.

use crate::error::KinematicError;
use crate::robot::Robot;
use crate::space::Joints;

/// Passes of [`singular_values`] over all pairs of rows. Jacobi's method converges quadratically: six rows
/// take five or six passes.
const MOST_PASSES: u32 = 12;
/// Rows whose cosine is smaller are orthogonal.
const ORTHOGONAL: f64 = 1e-15;

/// The singular values of a matrix given by its rows, greatest first; where there are more rows than
/// columns the last are 0.
///
/// One-sided Jacobi: two rows at a time are turned in their plane until they are orthogonal, which leaves
/// the singular values as they are; in the end they are the rows' lengths (M. R. Hestenes, 1958). Small ones
/// keep their digits relative to the greatest one. A NaN goes through.
#[must_use]
pub fn singular_values<const M: usize, const N: usize>(mut rows: [[f64; N]; M]) -> [f64; M] {
    let mut turned = true;
    let mut passes = 0;
    while turned && passes < MOST_PASSES {
        turned = false;
        for second in 1..M {
            for first in 0..second {
                if let Ok([p, q]) = rows.get_disjoint_mut([first, second]) {
                    turned |= orthogonalise(p, q);
                }
            }
        }
        passes += 1;
    }
    let mut values = rows.map(|row| libm::sqrt(dot(&row, &row)));
    values.sort_unstable_by(|a, b| b.total_cmp(a));
    values
}

fn dot<const N: usize>(a: &[f64; N], b: &[f64; N]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Turns two rows in their plane until they are orthogonal; whether that took a turn.
///
/// With ζ = (q² − p²)/2p·q, the tangent t of the lesser of both angles is the root of t² + 2ζt − 1 nearest
/// to 0.
fn orthogonalise<const N: usize>(p: &mut [f64; N], q: &mut [f64; N]) -> bool {
    let (pp, qq, pq) = (dot(p, p), dot(q, q), dot(p, q));
    let parallel = pq.abs() > ORTHOGONAL * libm::sqrt(pp * qq);
    if parallel {
        let zeta = (qq - pp) / (2.0 * pq);
        let t = libm::copysign(1.0, zeta) / (zeta.abs() + libm::sqrt(1.0 + zeta * zeta));
        let c = 1.0 / libm::sqrt(1.0 + t * t);
        for (p, q) in p.iter_mut().zip(q) {
            (*p, *q) = (c * (*p - t * *q), c * (t * *p + *q));
        }
    }
    parallel
}

/// Where a value stands in its range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Margin {
    /// Index of the axis, in axis order.
    pub axis: usize,
    /// Distance to the nearer limit over half of the range: 1 in the middle, 0 on a limit, negative
    /// outside.
    pub share: f64,
}

/// The least margin of all axes; the first of several. `None` for no axes.
fn least_margin(margins: impl Iterator<Item = f64>) -> Option<Margin> {
    let mut least: Option<Margin> = None;
    for (axis, share) in margins.enumerate() {
        if least.is_none_or(|least| share < least.share) {
            least = Some(Margin { axis, share });
        }
    }
    least
}

fn share(value: f64, range: crate::Range) -> f64 {
    let half = 0.5 * (range.upper - range.lower);
    1.0 - (value - range.centre()).abs() / half
}

/// How a configuration stands to the singularities of the flange's Jacobian, and to the limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Posture {
    /// The singular values of the Jacobian, greatest first, its linear rows divided by the length given:
    /// 1/s per rad/s or m/s.
    pub singular_values: [f64; 6],
    /// The joint nearest to a limit.
    pub joints: Option<Margin>,
    /// The motor nearest to a limit.
    pub motors: Option<Margin>,
}

impl Posture {
    /// The least singular value: the flange's speed in the worst direction for joints that move at speed 1.
    /// 0 in a singularity.
    #[must_use]
    pub fn dexterity(&self) -> f64 {
        let [.., least] = self.singular_values;
        least
    }

    /// Yoshikawa's manipulability √det(J·Jᵀ): the product of the singular values.
    #[must_use]
    pub fn manipulability(&self) -> f64 {
        self.singular_values.iter().product()
    }

    /// Greatest over least singular value: 1 at best, infinite in a singularity.
    #[must_use]
    pub fn condition(&self) -> f64 {
        let [greatest, .., least] = self.singular_values;
        greatest / least
    }
}

/// The posture of a robot at `joints`. `length_m` is the length at which turning by 1 rad is held to be
/// worth moving by as much: usually that of the tool.
///
/// # Errors
/// As [`Robot::motors`].
pub fn posture<const N: usize>(
    robot: &impl Robot<N>,
    joints: &Joints<N>,
    length_m: f64,
) -> Result<Posture, KinematicError> {
    let motors = robot.motors(joints)?;
    let jacobian = robot.jacobian(joints);
    let mut rows = [[0.0; N]; 6];
    for (k, (row, from)) in rows.iter_mut().zip(jacobian.row_iter()).enumerate() {
        for (to, from) in row.iter_mut().zip(from.iter()) {
            *to = if k < 3 { from / length_m } else { *from };
        }
    }
    let axes = &robot.description().axes;
    let of_joints = joints.0.iter().zip(axes);
    let of_motors = motors.0.iter().zip(axes);
    Ok(Posture {
        singular_values: singular_values(rows),
        joints: least_margin(of_joints.map(|(q, axis)| share(*q, axis.joint_position))),
        motors: least_margin(of_motors.map(|(m, axis)| share(*m, axis.motor_position))),
    })
}
