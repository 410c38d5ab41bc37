//! Limits for planning in joint space, such that the motors' limits hold.
//!
//! # Slopes
//!
//! A leg's end P moves at Ṗ, and its length at u·Ṗ, u the leg's unit vector from the foot b. The reach
//! moves P by −n: |∂L/∂r| ≤ 1. A tilt about the unit vector w through the base's origin moves it by w × P:
//! |∂L/∂t| = |w·(P × u)| = |w·(b × u)|, since P − b is along u: at most b's distance from the axis. About y
//! that is |bx|; about the platform's x, (cos ty, 0, −sin ty), it is √(B² − bx²·cos²ty).
//!
//! # Curvatures
//!
//! [`CURVATURES`] bound |∂²L/∂q∂q| over the joints' limits, where legs are in theirs; [`THIRD`] and
//! [`THIRD_REACH`] bound |∂³L/∂q∂q∂q| over all that is known of the tripod. They are maxima over dense
//! grids, with margins of 3 % and more; tests sample them again.

use motion::AxisLimits;

use super::assumed::{BASE_RADIUS_M, TILT_DEGREES, WRIST_RATIO};
use super::data::LEG_RAD_PER_M;
use super::tripod::{FEET_M, legs};
use crate::description::RobotDescription;
use crate::error::KinematicError;
use crate::planning::{self, UNLIMITED, VelocityFactor, cap, greatest};
use crate::space::Joints;

/// Bounds of |∂²L/∂q∂q| by ty, tx, r: m/rad², 1/rad, 1/m. The legs at 210° and 330° mirror each other.
const CURVATURES: [[[f64; 3]; 3]; 3] = [
    [[0.0, 0.0, 0.0], [0.0, 0.23, 0.062], [0.0, 0.062, 0.16]],
    SIDE_CURVATURES,
    SIDE_CURVATURES,
];
const SIDE_CURVATURES: [[f64; 3]; 3] = [
    [0.20, 0.255, 0.065],
    [0.255, 0.42, 0.042],
    [0.065, 0.042, 0.168],
];

/// Bound of every |∂³L/∂q∂q∂q|, in m and rad, but the one by r alone.
const THIRD: f64 = 0.95;
/// By how much |∂³L/∂r³| may be greater, 1/m².
const THIRD_REACH: f64 = 1.75;

/// Parts of a line, each with one sample in its middle.
const PARTS: u32 = 16;

/// Bounds of |∂L/∂q| of every leg by ty, tx, r over the joints' limits.
fn slopes() -> [[f64; 3]; 3] {
    let cos = libm::cos(TILT_DEGREES.to_radians());
    FEET_M.map(|[bx, _]| {
        let from_x2 = BASE_RADIUS_M * BASE_RADIUS_M - bx * bx * cos * cos;
        [bx.abs(), libm::sqrt(from_x2), 1.0]
    })
}

/// C(k, j) as `per_joint[j][k]`.
fn per_joint() -> [[f64; 6]; 6] {
    let legs = slopes().map(|row| row.map(|s| s * LEG_RAD_PER_M));
    let [[ay, ax, ar], [by, bx, br], [cy, cx, cr]] = legs;
    [
        [ay, by, cy, 0.0, 0.0, 0.0],
        [ax, bx, cx, 0.0, 0.0, 0.0],
        [ar, br, cr, 0.0, 0.0, 0.0],
        [0.0, 0.0, 0.0, WRIST_RATIO, 0.0, 0.0],
        [0.0, 0.0, 0.0, 0.0, WRIST_RATIO, 0.0],
        [0.0, 0.0, 0.0, 0.0, 0.0, WRIST_RATIO],
    ]
}

/// See [`crate::Robot::motor_slopes`].
pub(super) fn motor_slopes() -> [f64; 6] {
    let [[leg_1, ..], [_, leg_2, ..], [_, _, leg_3, ..], ..] = per_joint();
    [leg_1, leg_2, leg_3, WRIST_RATIO, WRIST_RATIO, WRIST_RATIO]
}

/// See [`crate::Robot::joint_limits_for_planning`].
pub(super) fn joint_limits(robot: &RobotDescription<6>, factor: VelocityFactor) -> [AxisLimits; 6] {
    let curved = |rates: &[f64; 6]| {
        let mut curved = [0.0; 6];
        for (curved, leg) in curved.iter_mut().zip(&CURVATURES) {
            for (row, a) in leg.iter().zip(rates) {
                for (bound, b) in row.iter().zip(rates) {
                    *curved += LEG_RAD_PER_M * bound * a * b;
                }
            }
        }
        curved
    };
    planning::shared_limits(&robot.axes, &per_joint(), curved, factor)
}

/// See [`crate::Robot::limits_along`].
///
/// The line is cut into [`PARTS`]; |L'| and |L''| along it are sampled in the middle of each, and the
/// most they can be beside the samples is half a part times the bound of the next derivative.
///
/// # Errors
/// [`KinematicError::NotFinite`], or [`KinematicError::Limit`] where the line leaves what is known of the
/// tripod.
pub(super) fn limits_along(
    robot: &RobotDescription<6>,
    from: &Joints<6>,
    to: &Joints<6>,
    factor: VelocityFactor,
) -> Result<Option<AxisLimits>, KinematicError> {
    let Some(direction) = planning::direction(from, to)? else {
        return Ok(None);
    };
    let ([y, x, r, ..], [dy, dx, dr, ..]) = (from.0, direction);
    legs([y, x, r])?;
    legs([y + dy, x + dx, r + dr])?;
    let half_part = 0.5 / f64::from(PARTS);
    let (mut slope, mut curvature) = ([0.0; 3], [0.0; 3]);
    let mut part = 0;
    while part < PARTS {
        let s = (2.0 * f64::from(part) + 1.0) * half_part;
        let here = legs([y + s * dy, x + s * dx, r + s * dr])?;
        for ((slope, curvature), leg) in slope.iter_mut().zip(&mut curvature).zip(here) {
            *slope = greatest(*slope, leg.rate(&[dy, dx, dr]).abs());
            *curvature = greatest(*curvature, leg.curvature(&[dy, dx, dr]).abs());
        }
        part += 1;
    }
    let (all, reach) = (dy.abs() + dx.abs() + dr.abs(), dr.abs());
    let third = THIRD * all * all * all + THIRD_REACH * reach * reach * reach;
    let mut limits = UNLIMITED;
    for (k, (axis, dq)) in robot.axes.iter().zip(direction).enumerate() {
        let (motor, bend) = match slope.get(k).zip(curvature.get(k)) {
            Some((slope, curvature)) => {
                let bend = curvature + half_part * third;
                let most = slope + half_part * bend;
                (most * LEG_RAD_PER_M, bend * LEG_RAD_PER_M)
            }
            None => (dq.abs() * WRIST_RATIO, 0.0),
        };
        cap(&mut limits, axis, factor, [motor, bend, dq]);
    }
    Ok(Some(limits))
}

#[cfg(test)]
mod test {
    use super::*;
    use proptest::prelude::*;

    fn raise(most: &mut f64, value: f64) {
        *most = greatest(*most, value.abs());
    }

    #[test]
    fn curvatures_are_bounded_over_the_workspace_with_three_percent_to_spare() {
        let mut most = [[[0.0_f64; 3]; 3]; 3];
        for i in -70..=70 {
            for j in -70..=70 {
                for k in 0..=60 {
                    let (ty, tx) = (0.5 * f64::from(i), 0.5 * f64::from(j));
                    let r = 0.8 + 0.01 * f64::from(k);
                    let Ok(legs) = legs([ty.to_radians(), tx.to_radians(), r]) else {
                        continue;
                    };
                    for (most, leg) in most.iter_mut().zip(legs) {
                        if !(0.60..=1.60).contains(&leg.length) {
                            continue;
                        }
                        for (most, row) in most.iter_mut().zip(leg.second) {
                            for (most, value) in most.iter_mut().zip(row) {
                                raise(most, value);
                            }
                        }
                    }
                }
            }
        }
        for (most, bounds) in most.iter().flatten().zip(CURVATURES.iter().flatten()) {
            for (most, bound) in most.iter().zip(bounds) {
                assert!(*most <= bound / 1.03 + 1e-15, "{most} {bound}");
                // and a bound is not much more than what it bounds
                assert!(*bound <= 1.15 * most + 1e-15, "{most} {bound}");
            }
        }
    }

    #[test]
    fn third_derivatives_are_bounded_over_all_that_is_known() {
        let h = 1e-4;
        let (mut most, mut reach) = (0.0_f64, 0.0_f64);
        for i in -44..=44 {
            for j in -44..=44 {
                for k in 1..60 {
                    let here = [
                        f64::from(i).to_radians(),
                        f64::from(j).to_radians(),
                        0.5 + 0.02 * f64::from(k),
                    ];
                    for axis in 0..3 {
                        let at = |by: f64| {
                            let mut q = here;
                            q[axis] += by;
                            legs(q)
                        };
                        let (Ok(minus), Ok(plus)) = (at(-h), at(h)) else {
                            continue;
                        };
                        for (plus, minus) in plus.iter().zip(minus) {
                            for (x, (p, m)) in plus.second.iter().zip(minus.second).enumerate() {
                                for (y, (p, m)) in p.iter().zip(m).enumerate() {
                                    let third = (p - m) / (2.0 * h);
                                    if [axis, x, y] == [2, 2, 2] {
                                        raise(&mut reach, third);
                                    } else {
                                        raise(&mut most, third);
                                    }
                                }
                            }
                        }
                    }
                }
            }
        }
        assert!(most * 1.03 <= THIRD && THIRD <= most * 1.5, "{most}");
        assert!(
            reach * 1.03 <= THIRD + THIRD_REACH && THIRD + THIRD_REACH <= reach * 1.5,
            "{reach}"
        );
    }

    /// The robot with motors and joints so fast that only curvature limits it.
    fn fast() -> RobotDescription<6> {
        let mut robot = crate::rnt::data::DESCRIPTION;
        for axis in &mut robot.axes {
            axis.hard_limits.velocity = 1e6;
            axis.planning_limits.velocity = 1e6;
            axis.joint_velocity = 20.0;
        }
        robot
    }

    /// The share of the hard acceleration left to curvature, m/s² of a leg.
    fn room(robot: &RobotDescription<6>) -> f64 {
        let [leg, ..] = robot.axes;
        planning::CURVATURE_SHARE * leg.hard_limits.acceleration / LEG_RAD_PER_M
    }

    /// A point of the joints' box from numbers in 0..1.
    fn inside([y, x, r]: [f64; 3]) -> [f64; 3] {
        let tilt = |u: f64| (2.0 * u - 1.0) * TILT_DEGREES.to_radians();
        [tilt(y), tilt(x), 0.8 + 0.6 * r]
    }

    fn driveable(q: [f64; 3]) -> Option<[super::super::tripod::Leg; 3]> {
        let legs = legs(q).ok()?;
        let good = legs.iter().all(|leg| (0.60..=1.60).contains(&leg.length));
        good.then_some(legs)
    }

    proptest! {
        // a constant share of the box of joints is off the legs' screws, however many cases are asked for
        #![proptest_config(ProptestConfig { max_global_rejects: u32::MAX, ..ProptestConfig::default() })]

        #[test]
        fn curvature_takes_its_share_of_a_line_and_no_more(
            from in prop::array::uniform3(0.0..1.0f64), to in prop::array::uniform3(0.0..1.0f64),
        ) {
            let (from, to) = (inside(from), inside(to));
            prop_assume!(driveable(from).is_some() && driveable(to).is_some());
            let robot = fast();
            let wide = |[y, x, r]: [f64; 3]| Joints([y, x, r, 0.0, 0.0, 0.0]);
            let limits = limits_along(&robot, &wide(from), &wide(to), VelocityFactor::FULL);
            let v = limits.unwrap().unwrap().v;
            let d: [f64; 3] = core::array::from_fn(|k| to[k] - from[k]);
            let mut most = 0.0;
            for step in 0..=400 {
                let s = f64::from(step) / 400.0;
                for leg in legs(core::array::from_fn(|k| from[k] + s * d[k])).unwrap() {
                    raise(&mut most, leg.curvature(&d) * v * v);
                }
            }
            prop_assert!(most <= room(&robot) * (1.0 + 1e-9), "{most}");
            // a joint's own ceiling, or a sixth of what there is: at most 2.5 times too slow, where a long
            // line bends little and the bound of the third derivative is most of the bound
            let ceiling = d.iter().any(|d| (d * v).abs() > 19.99);
            prop_assert!(ceiling || most > room(&robot) / 6.0, "{most}");
        }

        #[test]
        fn curvature_takes_its_share_of_any_motion_and_no_more(
            at in prop::array::uniform3(0.0..1.0f64), signs in prop::array::uniform3(-1.0..1.0f64),
        ) {
            let Some(legs) = driveable(inside(at)) else {
                return Err(TestCaseError::reject("motor limits"));
            };
            let robot = fast();
            let [y, x, r, ..] = joint_limits(&robot, VelocityFactor::FULL);
            let [sy, sx, sr] = signs.map(f64::signum);
            for leg in legs {
                let bend = leg.curvature(&[sy * y.v, sx * x.v, sr * r.v]).abs();
                prop_assert!(bend <= room(&robot) * (1.0 + 1e-9), "{bend}");
            }
        }
    }

    #[test]
    fn curvature_is_the_limit_of_a_fast_robot() {
        let robot = fast();
        let [y, x, r, ..] = joint_limits(&robot, VelocityFactor::FULL).map(|limit| limit.v);
        let rates = [y, x, r];
        let used = |k: usize| {
            let rows = CURVATURES[k].map(|row| row[0] * y + row[1] * x + row[2] * r);
            rows.iter()
                .zip(rates)
                .map(|(row, rate)| row * rate)
                .sum::<f64>()
        };
        // the worse legs use all of their share
        assert!((used(1) / room(&robot) - 1.0).abs() < 1e-9, "{}", used(1));
        assert!(used(0) < room(&robot));
    }
}
