//! The motors' torques in f32 against the same in f64, on every robot that has a chain.

use core::fmt::Debug;

use motion::Angle;
use proptest::prelude::*;
use robots::dynamics::{MotorModel, STANDARD_GRAVITY, Wrench};
use robots::{Motors, Robot, RobotKind, RobotVisitor, TrackRule};

/// A motion inside the limits of motors, by numbers in −1..1, and the greatest difference as a share of what a motor can.
struct Off([[f64; 7]; 3]);

impl RobotVisitor for Off {
    type Output = Option<f64>;
    fn visit<R: Robot<N> + Copy + Debug, const N: usize>(self, robot: R) -> Option<f64> {
        let chain = robot.chain()?;
        let description = robot.description();
        let model = MotorModel::new(description, &chain)?;
        let [at, v, a] = self.0;
        let axes = &description.axes;
        let motors: [Angle; N] = core::array::from_fn(|k| {
            let range = axes[k].motor_position;
            Angle::bound(if range.is_bounded() {
                range.centre() + 0.5 * at[k] * (range.upper - range.lower)
            } else {
                // fifteen thousand turns
                at[k] * 1e5
            })
        });
        #[expect(clippy::cast_possible_truncation, reason = "any number will do")]
        let of = |k: usize, unit: &[f64; 7], limit: f64| (unit[k] * limit) as f32;
        let velocity: [f32; N] = core::array::from_fn(|k| of(k, &v, axes[k].hard_limits.velocity));
        let acceleration: [f32; N] =
            core::array::from_fn(|k| of(k, &a, axes[k].hard_limits.acceleration));
        let exact = Motors(motors.map(Angle::to_f64));
        let joints = robot.joints(&exact).ok()?;
        // beyond the ranges of joints a screw may be at its dead centre
        robot.check_joints(&joints).ok()?;
        let got = model.torques(&motors, &velocity, &acceleration).unwrap();
        let wanted = chain.at(&joints).motor_inverse_dynamics(
            &robot.transmission(&joints).unwrap(),
            &velocity.map(f64::from),
            &acceleration.map(f64::from),
            &STANDARD_GRAVITY,
            &Wrench::NONE,
        );
        let most = (0..N).map(|k| {
            let can =
                axes[k].current_regulator.limit_ma * 1e-3 * axes[k].motor.torque_constant_nm_a;
            (f64::from(got[k]) - wanted[k]).abs() / can
        });
        Some(most.fold(0.0, |most, x| if x > most || x.is_nan() { x } else { most }))
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]
    #[test]
    fn torques_in_f32_are_those_in_f64(unit in prop::array::uniform3(prop::array::uniform7(-1.0..1.0f64))) {
        for kind in RobotKind::ALL {
            if let Some(off) = kind.visit(TrackRule::Keep, Off(unit)) {
                // some 200 roundings of 6e-8, of terms some times what a motor can
                prop_assert!(off < 1e-4, "{kind:?}: {off}");
            }
        }
    }
}

#[test]
fn whoever_has_a_chain_and_no_legs_has_a_model() {
    struct Has;
    impl RobotVisitor for Has {
        type Output = (bool, bool);
        fn visit<R: Robot<N> + Copy + Debug, const N: usize>(self, robot: R) -> (bool, bool) {
            let chain = robot.chain();
            let model = chain.and_then(|chain| MotorModel::new(robot.description(), &chain));
            (robot.chain().is_some(), model.is_some())
        }
    }
    for kind in RobotKind::ALL {
        let (chain, model) = kind.visit(TrackRule::Keep, Has);
        assert_eq!(model, chain && kind != RobotKind::Rnt, "{kind:?}");
    }
}
