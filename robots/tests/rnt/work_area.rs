//! The work area: a vertical spindle everywhere over it, far from limits and singularities.

use motion::Pose;
use motion::pose::exp;
use nalgebra::{Matrix3, Vector3};
use robots::report::{posture, singular_values};
use robots::rnt::{HOME, WORK_AREA_CENTRE_M, WORK_AREA_CLEARANCE_M, WORK_AREA_SIZE_M};
use robots::{Joints, Rnt, Robot};

/// Flange with the spindle's tip at `tip`, pointing straight down, its x turned by `yaw` from the base's −x: at 0, as
/// at home.
fn vertical(tip: Vector3<f64>, yaw: f64) -> Pose {
    Pose {
        position: tip + Vector3::new(0.0, 0.0, 0.15),
        rotation: exp(Vector3::z() * yaw) * Matrix3::from_diagonal(&Vector3::new(-1.0, 1.0, -1.0)),
    }
}

/// Least and greatest.
#[derive(Clone, Copy, Debug)]
struct Span(f64, f64);

impl Span {
    fn add(&mut self, value: f64) {
        if value < self.0 {
            self.0 = value;
        }
        if value > self.1 {
            self.1 = value;
        }
    }
}

const NOTHING: Span = Span(f64::INFINITY, f64::NEG_INFINITY);

/// Every point of a grid over the area, `height` above it, with the joints there.
fn over(height: f64, yaw: f64, mut visit: impl FnMut(Joints<6>)) {
    for i in -20..=20 {
        for j in -20..=20 {
            let [x, y, z] = WORK_AREA_CENTRE_M;
            let [along_x, along_y] = WORK_AREA_SIZE_M;
            let tip = Vector3::new(
                x + along_x * f64::from(i) / 40.0,
                y + along_y * f64::from(j) / 40.0,
                z + height,
            );
            let q = Rnt.inverse_near(&vertical(tip, yaw), &HOME).unwrap();
            let reached = Rnt.forward(&q) * Rnt.description().default_tool();
            assert!((reached.position - tip).norm() < 1e-12);
            assert!((reached.rotation.column(2) + Vector3::z()).norm() < 1e-12);
            visit(q);
        }
    }
}

#[test]
fn the_board_is_reached_far_from_the_wrist_singularity_and_every_limit() {
    let mut w2 = NOTHING;
    let mut legs = NOTHING;
    let (mut tilt, mut reach, mut w1, mut w3) = (NOTHING, NOTHING, NOTHING, NOTHING);
    let (mut joints, mut motors) = (NOTHING, NOTHING);
    over(0.0, 0.0, |q| {
        w2.add(q.0[4].to_degrees());
        tilt.add(q.0[0].to_degrees());
        tilt.add(q.0[1].to_degrees());
        reach.add(q.0[2]);
        w1.add(q.0[3].to_degrees());
        w3.add(q.0[5].to_degrees());
        Rnt.legs(&q).unwrap().into_iter().for_each(|l| legs.add(l));
        let posture = posture(&Rnt, &q, 0.15).unwrap();
        joints.add(posture.joints.unwrap().share);
        motors.add(posture.motors.unwrap().share);
    });
    // what the crate's documentation says of the area
    assert!(40.8 < w2.0 && w2.1 < 80.0, "{w2:?}");
    assert!(
        tilt.1 < 19.2 && w1.1 < 19.8 && w3.1 < 19.8,
        "{tilt:?} {w1:?} {w3:?}"
    );
    assert!(1.0299 < reach.0 && reach.1 < 1.1341, "{reach:?}");
    assert!(0.992 < legs.0 && legs.1 < 1.311, "{legs:?}");
    // at least a quarter of every half range is left
    assert!(joints.0 > 0.25 && motors.0 > 0.25, "{joints:?} {motors:?}");
}

#[test]
fn the_spindle_can_be_led_above_the_board_and_into_it() {
    for height in [-0.02, WORK_AREA_CLEARANCE_M] {
        let mut sine = NOTHING;
        let (mut joints, mut motors) = (NOTHING, NOTHING);
        over(height, 0.0, |q| {
            sine.add(libm::sin(q.0[4]).abs());
            let posture = posture(&Rnt, &q, 0.15).unwrap();
            joints.add(posture.joints.unwrap().share);
            motors.add(posture.motors.unwrap().share);
        });
        assert!(sine.0 >= 0.6, "{sine:?}");
        assert!(joints.0 > 0.25 && motors.0 > 0.25, "{joints:?} {motors:?}");
    }
}

#[test]
fn the_tripod_is_well_conditioned_over_the_board() {
    let mut condition = NOTHING;
    over(0.0, 0.0, |q| {
        // tilts weighted by the reach: both sides are metres of the platform
        let rows = Rnt.leg_jacobian(&q).unwrap();
        let scaled = rows.map(|[y, x, r]| [y / q.0[2], x / q.0[2], r]);
        let [greatest, _, least] = singular_values(scaled);
        condition.add(greatest / least);
    });
    assert!((1.0..5.0).contains(&condition.1), "{condition:?}");
}

#[test]
fn the_spindle_may_be_turned_about_its_axis_as_one_likes() {
    for step in -6..=6 {
        let mut least = NOTHING;
        over(0.0, (30.0 * f64::from(step)).to_radians(), |q| {
            least.add(libm::sin(q.0[4]).abs());
            let posture = posture(&Rnt, &q, 0.15).unwrap();
            least.add(posture.joints.unwrap().share);
        });
        assert!(least.0 > 0.25, "{step}: {least:?}");
    }
}
