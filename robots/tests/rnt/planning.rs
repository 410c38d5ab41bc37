//! Planning limits keep the motors' limits, and are not needlessly low.

use motion::AxisLimits;
use proptest::prelude::*;
use robots::rnt::HOME;
use robots::{JointMotion, Joints, KinematicError, Motors, Rnt, Robot, VelocityFactor};

use super::{driveable, patient};

/// Velocity, acceleration and jerk of every motor, the jerk by differences along the cubic motion.
fn motor_derivatives(position: &Joints<6>, [v, a, j]: &[[f64; 6]; 3]) -> Option<[[f64; 6]; 3]> {
    let h = 1e-5;
    let at = |t: f64| {
        Rnt.motor_motion(&JointMotion {
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

/// The greatest use any motor makes of its hard limits, 1 where used up.
fn use_of_limits(derivatives: &[[f64; 6]; 3], factor: VelocityFactor) -> [f64; 3] {
    let mut most = [0.0_f64; 3];
    for (k, axis) in Rnt.description().axes.iter().enumerate() {
        let hard = axis.hard_limits;
        let limits = [hard.velocity * factor.value(), hard.acceleration, hard.jerk];
        for i in 0..3 {
            let share = derivatives[i][k].abs() / limits[i];
            most[i] = if share > most[i] { share } else { most[i] };
        }
    }
    most
}

/// Velocity within its share; acceleration: the plan's 0.4 and the curvature's sixth; jerk: the plan's
/// fifth and at most a twentieth by curvature.
fn within_shares([velocity, acceleration, jerk]: [f64; 3]) -> bool {
    velocity <= 0.95 + 1e-9 && acceleration <= 0.4 + 1.0 / 6.0 + 1e-9 && jerk <= 0.25
}

/// The greatest use of motor limits and of joint ceilings along the line at `scale` times its limits.
fn use_along(
    from: &Joints<6>,
    to: &Joints<6>,
    factor: VelocityFactor,
    scale: [f64; 3],
) -> ([f64; 3], [f64; 2]) {
    let limits = Rnt.limits_along(from, to, factor).unwrap().unwrap();
    let d: [f64; 6] = core::array::from_fn(|k| to.0[k] - from.0[k]);
    let (mut motors, mut ceilings) = ([0.0_f64; 3], [0.0_f64; 2]);
    let raise = |most: &mut f64, used: f64| {
        *most = if used.abs() > *most {
            used.abs()
        } else {
            *most
        }
    };
    for step in 0..=40 {
        let s = f64::from(step) / 40.0;
        let q = Joints(core::array::from_fn(|k| from.0[k] + s * d[k]));
        for sign in [-1.0, 1.0] {
            let motion = [
                d.map(|d| d * limits.v * scale[0]),
                d.map(|d| d * limits.a * scale[1] * sign),
                d.map(|d| d * limits.j * scale[2] * sign),
            ];
            let Some(derivatives) = motor_derivatives(&q, &motion) else {
                continue;
            };
            for (most, used) in motors.iter_mut().zip(use_of_limits(&derivatives, factor)) {
                raise(most, used);
            }
            for (k, axis) in Rnt.description().axes.iter().enumerate() {
                raise(&mut ceilings[0], motion[0][k] / axis.joint_velocity);
                raise(&mut ceilings[1], motion[1][k] / axis.joint_acceleration);
            }
        }
    }
    (motors, ceilings)
}

fn factors() -> impl Strategy<Value = VelocityFactor> {
    prop_oneof![Just(0.05), Just(0.2), Just(0.5), Just(1.0)]
        .prop_map(|f| VelocityFactor::new(f).unwrap())
}

/// Corners of the box half of the time: that is where limits break.
fn signs() -> impl Strategy<Value = [[f64; 6]; 3]> {
    let corner = prop::collection::vec(prop_oneof![Just(-1.0), Just(1.0)], 18);
    let inside = prop::collection::vec(-1.0..1.0f64, 18);
    prop_oneof![corner, inside]
        .prop_map(|v| core::array::from_fn(|i| core::array::from_fn(|k| v[6 * i + k])))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1000, ..patient() })]
    #[test]
    fn any_motion_in_the_box_keeps_the_motors_limits(
        unit in prop::array::uniform6(0.0..1.0f64), signs in signs(), factor in factors(),
    ) {
        let Some(q) = driveable(&unit) else {
            return Err(TestCaseError::reject("motor limits"));
        };
        let limits = Rnt.joint_limits_for_planning(factor);
        let pick = |i: usize, of: fn(&AxisLimits) -> f64| {
            core::array::from_fn(|k| signs[i][k] * of(&limits[k]))
        };
        let motion = [pick(0, |l| l.v), pick(1, |l| l.a), pick(2, |l| l.j)];
        let used = use_of_limits(&motor_derivatives(&q, &motion).unwrap(), factor);
        prop_assert!(within_shares(used), "{used:?}");
        for (limit, axis) in limits.iter().zip(&Rnt.description().axes) {
            prop_assert!(0.0 < limit.v && limit.v <= axis.joint_velocity);
            prop_assert!(0.0 < limit.a && limit.a <= axis.joint_acceleration);
            prop_assert!(0.0 < limit.j && limit.j.is_finite());
        }
    }

    #[test]
    fn a_line_within_its_limits_keeps_the_motors_limits(
        from in prop::array::uniform6(0.0..1.0f64), to in prop::array::uniform6(0.0..1.0f64),
        factor in factors(),
    ) {
        let (Some(from), Some(to)) = (driveable(&from), driveable(&to)) else {
            return Err(TestCaseError::reject("motor limits"));
        };
        let (motors, ceilings) = use_along(&from, &to, factor, [1.0; 3]);
        prop_assert!(within_shares(motors), "{motors:?}");
        prop_assert!(ceilings.iter().all(|used| *used <= 1.0 + 1e-9), "{ceilings:?}");
    }

    #[test]
    fn a_short_line_of_one_joint_is_at_most_a_fifth_too_slow(
        unit in prop::array::uniform6(0.2..0.8f64), axis in 0..6usize, factor in factors(),
    ) {
        let Some(a) = driveable(&unit) else {
            return Err(TestCaseError::reject("motor limits"));
        };
        let range = Rnt.description().axes[axis].joint_position;
        let mut b = a;
        let tenth = 0.1 * (range.upper - range.lower);
        b.0[axis] += if a.0[axis] < range.centre() { tenth } else { -tenth };
        // the velocity's share of 0.95, and a tenth for what lies between the samples
        let (motors, ceilings) = use_along(&a, &b, factor, [1.2, 0.0, 0.0]);
        let broken = motors[0] > 1.0 || motors[1] > 1.0 / 6.0 || ceilings[0] > 1.0;
        prop_assert!(broken, "axis {axis}: {motors:?} {ceilings:?}");
        // acceleration by itself reaches nine tenths of the planning ceiling, or the joint's
        let (motors, ceilings) = use_along(&a, &b, factor, [0.0, 1.0, 0.0]);
        let reached = motors[1] > 0.36 || ceilings[1] > 0.99;
        prop_assert!(reached, "axis {axis}: {motors:?} {ceilings:?}");
    }

    #[test]
    fn a_line_across_the_workspace_is_at_most_twice_too_slow(
        from in prop::array::uniform6(0.0..1.0f64), to in prop::array::uniform6(0.0..1.0f64),
    ) {
        let (Some(from), Some(to)) = (driveable(&from), driveable(&to)) else {
            return Err(TestCaseError::reject("motor limits"));
        };
        let factor = VelocityFactor::FULL;
        let (motors, ceilings) = use_along(&from, &to, factor, [2.0, 0.0, 0.0]);
        let broken = motors[0] > 1.0 || motors[1] > 1.0 / 6.0 || ceilings[0] > 1.0;
        prop_assert!(broken, "{motors:?} {ceilings:?}");
    }
}

#[test]
fn slopes_bound_the_legs_everywhere_and_are_reached() {
    // every |∂L/∂q| over the joints' limits, leg by leg
    let mut most = [[0.0_f64; 3]; 3];
    for i in -35..=35 {
        for j in -35..=35 {
            for k in 0..=30 {
                let mut q = HOME;
                q.0[0] = f64::from(i).to_radians();
                q.0[1] = f64::from(j).to_radians();
                q.0[2] = 0.8 + 0.02 * f64::from(k);
                for (most, row) in most.iter_mut().zip(Rnt.leg_jacobian(&q).unwrap()) {
                    for (most, slope) in most.iter_mut().zip(row) {
                        *most = if slope.abs() > *most {
                            slope.abs()
                        } else {
                            *most
                        };
                    }
                }
            }
        }
    }
    // closed forms of the documentation: |bx|; √(B² − bx²·cos²35°), B where bx is 0; 1
    let bx = 0.4 * libm::cos(30.0_f64.to_radians());
    let cos = libm::cos(35.0_f64.to_radians());
    let side = libm::sqrt(0.16 - bx * bx * cos * cos);
    for (row, bounds) in most
        .iter()
        .zip([[0.0, 0.4, 1.0], [bx, side, 1.0], [bx, side, 1.0]])
    {
        for (seen, bound) in row.iter().zip(bounds) {
            // held, and no more than a hundredth of it given away
            assert!(
                *seen <= bound + 1e-12 && *seen >= 0.99 * bound,
                "{seen} {bound}"
            );
        }
    }
    let slopes = Rnt.motor_slopes();
    let per_m = core::f64::consts::TAU / 0.010;
    for (slope, expected) in slopes
        .iter()
        .zip([0.0, side * per_m, per_m, 100.0, 100.0, 100.0])
    {
        assert!((slope - expected).abs() < 1e-9, "{slopes:?}");
    }
}

#[test]
fn what_moves_the_legs_shares_them_and_the_wrist_keeps_all() {
    let limits = Rnt.joint_limits_for_planning(VelocityFactor::FULL);
    // leg 2: the tilts and the reach together use what it has, 0.95 · 300 rad/s
    let per_m = core::f64::consts::TAU / 0.010;
    let used = per_m * (0.4 * limits[1].v + limits[2].v);
    assert!(used <= 285.0 + 1e-9, "{used}");
    let used = per_m * (0.346_410_2 * limits[0].v + 0.282 * limits[1].v + limits[2].v);
    assert!((200.0..285.2).contains(&used), "{used}");
    for limit in &limits[3..] {
        assert!((limit.v - 2.5).abs() < 1e-12 && (limit.a - 10.0).abs() < 1e-12);
    }
}

#[test]
fn the_way_from_where_homing_ends_keeps_the_motors_limits() {
    let parked = Rnt.joints(&Motors([0.0; 6])).unwrap();
    let (motors, ceilings) = use_along(&parked, &HOME, VelocityFactor::FULL, [1.0; 3]);
    assert!(within_shares(motors), "{motors:?}");
    assert!(
        ceilings.iter().all(|used| *used <= 1.0 + 1e-9),
        "{ceilings:?}"
    );
}

#[test]
fn a_line_out_of_what_is_known_is_refused() {
    let mut far = HOME;
    // 45.3°: all but the end is inside 45°
    far.0[0] = 0.79;
    for (from, to) in [(HOME, far), (far, HOME)] {
        assert!(matches!(
            Rnt.limits_along(&from, &to, VelocityFactor::FULL),
            Err(KinematicError::Limit { axis: 0, .. })
        ));
    }
    assert_eq!(
        Rnt.limits_along(&HOME, &HOME, VelocityFactor::FULL),
        Ok(None)
    );
}
