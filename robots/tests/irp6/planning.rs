//! Planning limits keep the motors' limits, and are not needlessly low.

use motion::AxisLimits;
use proptest::prelude::*;
use robots::{Irp6Postument, Irp6Track, JointMotion, Joints, Robot, VelocityFactor};

use super::{driveable, patient};

/// Velocity, acceleration and jerk of every motor, the jerk by differences along the cubic motion.
fn motor_derivatives<const N: usize>(
    robot: &impl Robot<N>,
    position: &Joints<N>,
    v: &[f64; N],
    a: &[f64; N],
    j: &[f64; N],
) -> Option<[[f64; N]; 3]> {
    let h = 1e-5;
    let at = |t: f64| {
        robot
            .motor_motion(&JointMotion {
                position: Joints(core::array::from_fn(|k| {
                    position.0[k] + v[k] * t + a[k] * t * t / 2.0 + j[k] * t * t * t / 6.0
                })),
                velocity: core::array::from_fn(|k| v[k] + a[k] * t + j[k] * t * t / 2.0),
                acceleration: core::array::from_fn(|k| a[k] + j[k] * t),
            })
            .ok()
    };
    let (minus, here, plus) = (at(-h)?, at(0.0)?, at(h)?);
    let jerk = core::array::from_fn(|k| (plus.acceleration[k] - minus.acceleration[k]) / (2.0 * h));
    Some([here.velocity, here.acceleration, jerk])
}

/// Motors' use of their hard limits, 1 where used up.
fn use_of_limits<const N: usize>(
    robot: &impl Robot<N>,
    derivatives: &[[f64; N]; 3],
    factor: VelocityFactor,
) -> [f64; 3] {
    let mut most = [0.0_f64; 3];
    for (k, axis) in robot.description().axes.iter().enumerate() {
        let hard = axis.hard_limits;
        let limits = [hard.velocity * factor.value(), hard.acceleration, hard.jerk];
        for i in 0..3 {
            let share = derivatives[i][k].abs() / limits[i];
            if share > most[i] {
                most[i] = share;
            }
        }
    }
    most
}

fn box_holds<const N: usize>(
    robot: &impl Robot<N>,
    unit: &[f64; 7],
    signs: &[f64; 21],
    factor: VelocityFactor,
) -> Result<(), TestCaseError> {
    let Some(q) = driveable(robot, unit) else {
        return Err(TestCaseError::reject("motor limits"));
    };
    let limits = robot.joint_limits_for_planning(factor);
    let pick = |from: usize, of: fn(&AxisLimits) -> f64| {
        core::array::from_fn::<f64, N, _>(|k| signs[from + k] * of(&limits[k]))
    };
    let (v, a, j) = (pick(0, |l| l.v), pick(7, |l| l.a), pick(14, |l| l.j));
    let Some(derivatives) = motor_derivatives(robot, &q, &v, &a, &j) else {
        return Ok(());
    };
    let [velocity, acceleration, jerk] = use_of_limits(robot, &derivatives, factor);
    prop_assert!(velocity <= 0.95 + 1e-9, "velocity {velocity}");
    prop_assert!(
        acceleration <= 2.0 / 3.0 + 1e-9,
        "acceleration {acceleration}"
    );
    // a tenth planned and at most a tenth by curvature
    prop_assert!(jerk <= 0.2, "jerk {jerk}");
    for (k, axis) in robot.description().axes.iter().enumerate() {
        prop_assert!(limits[k].v <= axis.joint_velocity);
        prop_assert!(limits[k].a <= axis.joint_acceleration);
        prop_assert!(limits[k].v > 0.0 && limits[k].j > 0.0 && limits[k].j.is_finite());
    }
    Ok(())
}

/// The greatest use of motor limits and of joint ceilings along the line at `scale` times its limits.
fn use_along<const N: usize>(
    robot: &impl Robot<N>,
    from: &Joints<N>,
    to: &Joints<N>,
    factor: VelocityFactor,
    scale: [f64; 3],
) -> Option<([f64; 3], [f64; 2])> {
    let limits = robot.limits_along(from, to, factor).ok()??;
    let d: [f64; N] = core::array::from_fn(|k| to.0[k] - from.0[k]);
    let (mut motors, mut ceilings) = ([0.0_f64; 3], [0.0_f64; 2]);
    let raise = |most: &mut f64, used: f64| {
        if used.abs() > *most {
            *most = used.abs();
        }
    };
    for step in 0..=40 {
        let s = f64::from(step) / 40.0;
        let q = Joints(core::array::from_fn(|k| from.0[k] + s * d[k]));
        for sign in [-1.0, 1.0] {
            let v = d.map(|d| d * limits.v * scale[0]);
            let a = d.map(|d| d * limits.a * scale[1] * sign);
            let j = d.map(|d| d * limits.j * scale[2] * sign);
            let used = use_of_limits(robot, &motor_derivatives(robot, &q, &v, &a, &j)?, factor);
            motors
                .iter_mut()
                .zip(used)
                .for_each(|(most, used)| raise(most, used));
            for (k, axis) in robot.description().axes.iter().enumerate() {
                raise(&mut ceilings[0], v[k] / axis.joint_velocity);
                raise(&mut ceilings[1], a[k] / axis.joint_acceleration);
            }
        }
    }
    Some((motors, ceilings))
}

fn line_holds<const N: usize>(
    robot: &impl Robot<N>,
    from: &[f64; 7],
    to: &[f64; 7],
    factor: VelocityFactor,
) -> Result<(), TestCaseError> {
    let (Some(from), Some(to)) = (driveable(robot, from), driveable(robot, to)) else {
        return Err(TestCaseError::reject("motor limits"));
    };
    let Some((motors, ceilings)) = use_along(robot, &from, &to, factor, [1.0; 3]) else {
        return Ok(());
    };
    let [velocity, acceleration, jerk] = motors;
    prop_assert!(velocity <= 0.95 + 1e-9, "velocity {velocity}");
    prop_assert!(
        acceleration <= 2.0 / 3.0 + 1e-9,
        "acceleration {acceleration}"
    );
    prop_assert!(jerk <= 0.2, "jerk {jerk}");
    prop_assert!(
        ceilings.iter().all(|used| *used <= 1.0 + 1e-9),
        "{ceilings:?}"
    );
    Ok(())
}

/// One joint moves by a tenth of its range: 2.1 times the speed would break a hard limit or a joint
/// ceiling somewhere.
fn single_axis_is_not_timid<const N: usize>(
    robot: &impl Robot<N>,
    from: &[f64; 7],
    axis: usize,
    factor: VelocityFactor,
) -> Result<(), TestCaseError> {
    let Some(k) = (axis + N).checked_sub(7) else {
        return Ok(()); // the track this robot has not
    };
    let Some(a) = driveable(robot, from) else {
        return Err(TestCaseError::reject("motor limits"));
    };
    let range = robot.description().axes[k].joint_position;
    let mut b = a;
    let tenth = 0.1 * (range.upper - range.lower);
    b.0[k] += if a.0[k] < range.centre() {
        tenth
    } else {
        -tenth
    };
    let Some((motors, ceilings)) = use_along(robot, &a, &b, factor, [2.1, 0.0, 0.0]) else {
        return Ok(());
    };
    let broken = motors[0] > 1.0 || motors[1] > 1.0 || ceilings[0] > 1.0;
    prop_assert!(broken, "axis {axis}: {motors:?} {ceilings:?}");
    // acceleration by itself reaches the planning ceiling, a sixth of the hard limit, or the joint's
    let Some((motors, ceilings)) = use_along(robot, &a, &b, factor, [0.0, 1.0, 0.0]) else {
        return Ok(());
    };
    let reached = motors[1] > 0.16 || ceilings[1] > 0.99;
    prop_assert!(reached, "axis {axis}: {motors:?} {ceilings:?}");
    Ok(())
}

fn factors() -> impl Strategy<Value = VelocityFactor> {
    prop_oneof![Just(0.05), Just(0.2), Just(0.5), Just(1.0)]
        .prop_map(|f| VelocityFactor::new(f).unwrap())
}

/// Corners of the box half of the time: that is where limits break.
fn signs() -> impl Strategy<Value = [f64; 21]> {
    let corner = prop::collection::vec(prop_oneof![Just(-1.0), Just(1.0)], 21);
    let inside = prop::collection::vec(-1.0..1.0f64, 21);
    prop_oneof![corner, inside].prop_map(|v| v.try_into().unwrap())
}

proptest! {
    #![proptest_config(patient())]

    #[test]
    fn any_motion_in_the_box_keeps_the_motors_limits(
        unit in prop::array::uniform7(0.0..1.0f64), signs in signs(), factor in factors(),
    ) {
        box_holds(&Irp6Postument, &unit, &signs, factor)?;
        box_holds(&Irp6Track::KEEP, &unit, &signs, factor)?;
    }

    #[test]
    fn a_line_within_its_limits_keeps_the_motors_limits(
        from in prop::array::uniform7(0.0..1.0f64), to in prop::array::uniform7(0.0..1.0f64),
        factor in factors(),
    ) {
        line_holds(&Irp6Postument, &from, &to, factor)?;
        line_holds(&Irp6Track::KEEP, &from, &to, factor)?;
    }

    #[test]
    fn a_single_axis_line_is_at_most_twice_too_slow(
        from in prop::array::uniform7(0.2..0.8f64), axis in 0..7usize, factor in factors(),
    ) {
        single_axis_is_not_timid(&Irp6Postument, &from, axis, factor)?;
        single_axis_is_not_timid(&Irp6Track::KEEP, &from, axis, factor)?;
    }
}

#[test]
fn sharing_costs_only_those_who_share() {
    let limits = Irp6Track::KEEP.joint_limits_for_planning(VelocityFactor::DEFAULT);
    let slopes = Irp6Track::KEEP.motor_slopes();
    // 47.5 rad/s of the motor, alone on it
    for k in [0, 1, 6] {
        assert!(
            (limits[k].v * slopes[k] - 47.5).abs() < 1e-9,
            "{}",
            limits[k].v
        );
    }
    // V's motor: 128·(q̇2 + q̇3 + q̇4) + 76.8·q̇5 is its whole budget
    let used = 128.0 * (limits[2].v + limits[3].v + limits[4].v) + 76.8 * limits[5].v;
    assert!((used - 47.5).abs() < 1e-9, "{used}");
    for k in [2, 3, 4, 5] {
        let share = limits[k].v * slopes[k] / 47.5;
        assert!(
            (0.2..0.35).contains(&share),
            "axis {k} keeps {share} of its own motor"
        );
    }
}

#[test]
fn slopes_are_the_gears() {
    let slopes = Irp6Track::KEEP.motor_slopes();
    let crank = 140.0 * 2.0 * core::f64::consts::PI / 5.0;
    let expected = [
        1_570.796_326_794_896_6,
        158.0,
        crank,
        crank,
        128.0,
        76.8,
        288.8845,
    ];
    for (got, expected) in slopes.iter().zip(expected) {
        assert!((got - expected).abs() < 1e-4, "{got} {expected}");
    }
}

#[test]
fn factors_are_shares() {
    for bad in [0.0, -0.1, 1.000_001, f64::NAN, f64::INFINITY] {
        assert_eq!(VelocityFactor::new(bad), None);
    }
    assert_eq!(VelocityFactor::new(0.2), Some(VelocityFactor::DEFAULT));
    assert_eq!(VelocityFactor::new(1.0), Some(VelocityFactor::FULL));
}

#[test]
fn a_line_of_no_length_has_no_limits() {
    let q = Joints([0.0, -1.57, 0.0, 1.56, 1.57, -1.57]);
    assert_eq!(
        Irp6Postument.limits_along(&q, &q, VelocityFactor::DEFAULT),
        Ok(None)
    );
}
