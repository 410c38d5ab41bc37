//! The chain of every robot is the robot: the same flange, the same Jacobian.

use proptest::prelude::*;
use robots::{Joints, Robot, RobotKind, RobotVisitor, TrackRule};

struct Same {
    share: [f64; 8],
}

impl RobotVisitor for Same {
    type Output = Result<bool, TestCaseError>;

    fn visit<R: Robot<N>, const N: usize>(self, robot: R) -> Self::Output {
        let Some(chain) = robot.chain() else {
            return Ok(false);
        };
        let axes = robot.description().axes;
        let q = Joints(core::array::from_fn(|k| {
            let range = axes[k].joint_position;
            let (low, high) = if range.lower.is_finite() {
                (range.lower, range.upper)
            } else {
                (-4.0, 4.0)
            };
            low + self.share[k] * (high - low)
        }));
        let posture = chain.at(&q);
        let (theirs, ours) = (robot.forward(&q), posture.flange());
        // a few roundings of lengths of some metres
        prop_assert!((theirs.position - ours.position).norm() < 1e-14);
        prop_assert!((theirs.rotation - ours.rotation).norm() < 1e-14);
        prop_assert!((robot.jacobian(&q) - posture.jacobian()).norm() < 1e-13);
        Ok(true)
    }
}

proptest! {
    #[test]
    fn a_chain_is_its_robot(share in prop::array::uniform8(0.0..1.0f64)) {
        let chains = RobotKind::ALL
            .into_iter()
            .map(|kind| kind.visit(TrackRule::Keep, Same { share }))
            .collect::<Result<Vec<bool>, _>>()?;
        // belt and jaws move nothing but themselves
        prop_assert_eq!(chains.iter().filter(|is| **is).count(), 5);
    }
}
