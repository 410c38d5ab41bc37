//! Derivatives of the joints on a path against differences of the joints themselves.

use motion::Pose;
use motion::path::PathPoint;
use motion::twist::Twist;
use nalgebra::Vector3;
use proptest::prelude::*;
use robots::{Irp6Arm, Irp6Postument, Irp6Track, Joints, PoseAlong, Robot};

use super::{patient, within_limits};

/// Where differences are taken, m of the parameter; with paths as here their error is below 1e-6 of the derivatives.
const STEP: f64 = 1e-3;

fn twist(linear: [f64; 3], angular: [f64; 3]) -> Twist {
    Twist {
        linear: Vector3::from(linear),
        angular: Vector3::from(angular),
    }
}

/// A path through the pose of a configuration, whose derivatives are those given.
fn agree<const N: usize>(
    robot: &impl Robot<N>,
    q: &Joints<N>,
    derivatives: &[[f64; 6]; 3],
) -> Result<(), TestCaseError> {
    let tool =
        Pose::from_rotation_vector(Vector3::new(0.02, -0.03, 0.2), Vector3::new(0.3, 0.2, -0.1));
    let [first, second, third] = derivatives.map(|[a, b, c, d, e, f]| twist([a, b, c], [d, e, f]));
    let point = PathPoint {
        pose: robot.forward(q) * tool,
        first,
        second,
        third,
    };
    let to_flange = tool.inverse();
    let along = PoseAlong::of_flange(&point, &to_flange);
    let Ok(here) = robot.inverse_along(&along, q) else {
        return Err(TestCaseError::reject("a singular wrist"));
    };
    let Some(rates) = here.rates else {
        return Err(TestCaseError::reject("near a singular wrist"));
    };
    let at = |steps: f64| {
        let flange = point.continued(steps * STEP) * to_flange;
        robot.inverse_near(&flange, &here.position)
    };
    let (Ok(b2), Ok(b1), Ok(a1), Ok(a2)) = (at(-2.0), at(-1.0), at(1.0), at(2.0)) else {
        return Err(TestCaseError::reject("outside the limits"));
    };
    // how close the configuration is to one of the column's axis, a wrist in line, a stretched elbow
    let sine = libm::sin(q.0[if N == 5 { 4 } else { N - 2 }]).abs();
    let p = along.pose.position;
    let track = if N == 7 { here.position.0[0] } else { 0.0 };
    let level = libm::sqrt(p.x * p.x + (p.y - track) * (p.y - track));
    prop_assume!(sine > 0.2 && level > 0.15);
    for k in 0..N {
        let (b2, b1, q, a1, a2) = (b2.0[k], b1.0[k], here.position.0[k], a1.0[k], a2.0[k]);
        let wanted = [
            (8.0 * (a1 - b1) - (a2 - b2)) / (12.0 * STEP),
            (16.0 * (a1 + b1) - (a2 + b2) - 30.0 * q) / (12.0 * STEP * STEP),
            ((a2 - b2) - 2.0 * (a1 - b1)) / (2.0 * STEP * STEP * STEP),
        ];
        // natural sizes: 1/0.15 m for each order, 1/0.2 for the wrist; the third is of second order in the step, so a part
        // in (step / natural size)² of itself, some 1e-3 where it is large
        let third = 0.8 + 2e-3 * wanted[2].abs();
        let most = [3e-5, 2e-3, third];
        for (rates, (wanted, most)) in rates.iter().zip(wanted.into_iter().zip(most)) {
            let off = (f64::from(rates[k]) - wanted).abs();
            prop_assert!(off < most, "axis {k}: {} {wanted}", rates[k]);
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(patient())]

    #[test]
    fn derivatives_of_the_joints_are_their_differences(
        unit in prop::array::uniform7(0.05..0.95f64),
        derivatives in prop::array::uniform3(prop::array::uniform6(-0.6..0.6f64)),
    ) {
        agree(&Irp6Postument, &within_limits(&Irp6Postument, &unit), &derivatives)?;
    }

    #[test]
    fn so_are_those_on_the_track_and_with_five_axes(
        unit in prop::array::uniform7(0.05..0.95f64),
        derivatives in prop::array::uniform3(prop::array::uniform6(-0.6..0.6f64)),
    ) {
        agree(&Irp6Track::KEEP, &within_limits(&Irp6Track::KEEP, &unit), &derivatives)?;
        agree(&Irp6Arm, &within_limits(&Irp6Arm, &unit), &derivatives)?;
        // in front of the flange, where the track can be
        let mut q = within_limits(&Irp6Track::IN_FRONT, &unit);
        q.0[1] = 0.0;
        agree(&Irp6Track::IN_FRONT, &q, &derivatives)?;
    }
}

#[test]
fn near_a_wrist_in_line_there_are_none() {
    let mut q = Joints([0.0, -1.57, 0.0, 1.2, 0.005, -1.57]);
    let point = |q: &Joints<6>| PathPoint {
        pose: Irp6Postument.forward(q),
        first: twist([0.0; 3], [1.0, 0.0, 0.0]),
        second: Twist::zero(),
        third: Twist::zero(),
    };
    let rates = |q: &Joints<6>| {
        let along = PoseAlong::of_flange(&point(q), &Pose::identity());
        Irp6Postument.inverse_along(&along, q).unwrap().rates
    };
    assert!(rates(&q).is_none());
    q.0[4] = 0.02;
    assert!(rates(&q).is_some());
}
