//! The quick test of joints against the exact one, on every kind.

use core::fmt::Debug;

use motion::Angle;
use proptest::prelude::*;
use robots::description::{Gearing, Reference};
use robots::{JointGuard, Joints, Motors, Robot, RobotKind, RobotVisitor, TrackRule};

/// Joints from numbers in 0..1 that reach so far beyond each end of a range, or not so far, rad or m.
struct Around {
    unit: [f64; 7],
    beyond: f64,
}

/// Did the quick test accept, and could it have?
impl RobotVisitor for Around {
    type Output = (bool, bool);
    fn visit<R: Robot<N> + Copy + Debug, const N: usize>(self, robot: R) -> (bool, bool) {
        let axes = &robot.description().axes;
        let joints = Joints(core::array::from_fn(|k| {
            let range = axes[k].joint_position;
            if range.is_bounded() {
                let (lower, upper) = (range.lower - self.beyond, range.upper + self.beyond);
                lower + self.unit[k] * (upper - lower)
            } else {
                (self.unit[k] - 0.5) * 1000.0
            }
        }));
        let judged = axes.iter().all(|axis| {
            !matches!(axis.gearing, Gearing::Quadratic(_))
                && !matches!(axis.reference, Reference::Leg { .. })
        });
        let Ok(motors) = robot.motors(&joints) else {
            return (false, false);
        };
        let angles = motors.0.map(Angle::bound);
        let accepted = JointGuard::new(robot.description()).accepts(&angles);
        if accepted {
            let exact = robot.joints(&Motors(angles.map(Angle::to_f64))).unwrap();
            robot.check_joints(&exact).unwrap();
        }
        // two screws held by parallelograms may fold where the motors never go
        (
            accepted,
            judged && (accepted || robot.check_motors(&motors).is_ok()),
        )
    }
}

proptest! {
    #[test]
    fn what_it_accepts_is_inside(unit in prop::array::uniform7(0.0..1.0f64), logarithm in -9.0..-1.0f64) {
        for kind in RobotKind::ALL {
            kind.visit(TrackRule::Keep, Around { unit, beyond: libm::exp(logarithm) });
        }
    }

    /// Its margin is 1e-3: what is farther inside, and f32 is a tenth of it off at most.
    #[test]
    fn what_is_well_inside_is_accepted(unit in prop::array::uniform7(0.0..1.0f64)) {
        for kind in RobotKind::ALL {
            let (accepted, judged) = kind.visit(TrackRule::Keep, Around { unit, beyond: -1.1e-3 });
            prop_assert_eq!(accepted, judged, "{:?}", kind);
        }
    }
}

#[test]
fn at_a_limit_and_without_a_number_nothing_is_accepted() {
    struct AtLimits;
    impl RobotVisitor for AtLimits {
        type Output = ();
        fn visit<R: Robot<N> + Copy + Debug, const N: usize>(self, robot: R) {
            let guard = JointGuard::new(robot.description());
            let axes = &robot.description().axes;
            let endless = axes.iter().all(|axis| !axis.joint_position.is_bounded());
            for end in [Angle::MIN, Angle::MAX] {
                assert_eq!(guard.accepts(&[end; N]), endless);
            }
            let centre = Joints(core::array::from_fn(|k| axes[k].joint_position.centre()));
            for (k, axis) in axes.iter().enumerate() {
                for end in [axis.joint_position.lower, axis.joint_position.upper] {
                    let mut joints = centre;
                    joints.0[k] = end;
                    if let Ok(motors) = robot.motors(&joints) {
                        let angles = motors.0.map(Angle::bound);
                        assert!(!guard.accepts(&angles), "{k} {end}");
                    }
                }
            }
        }
    }
    for kind in RobotKind::ALL {
        kind.visit(TrackRule::Keep, AtLimits);
    }
}
