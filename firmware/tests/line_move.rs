//! The straight line on the node: its knots are consistent, on the line, and within what the EDP takes.

use agent::{Input, MoveIn, Step};
use firmware::capacity::{PATH_SAMPLES, PATH_SAMPLES_SMALL};
use firmware::ecp::generator::line_move::{LineMove, Reference};
use firmware::ecp::tool_motion::{PathSpeeds, ToolMotion};
use firmware::ecp::tool_path::ToolPath;
use firmware::ecp::{Coordinator, Demand, EcpOf, EffectorImage, Sensors};
use firmware::edp::EdpSetup;
use motion::Pose;
use nalgebra::Vector3;
use protocol::message::Coordination;
use robots::{Irp6Postument, Joints, Robot};

const H: f64 = 0.02;

#[test]
fn knots_of_a_line_are_consistent() {
    line::<PATH_SAMPLES>();
}

#[test]
fn they_are_with_the_window_of_a_microcontroller_too() {
    line::<PATH_SAMPLES_SMALL>();
}

/// One after the other in the same place, of which the second sees nothing of the first.
fn line<const W: usize>() {
    let mut path = ToolPath::<6, W>::new();
    let first = knots(&mut path);
    assert_eq!(first, knots(&mut path));
}

type Knot = ([f64; 6], [f64; 6], [f64; 6]);

fn knots<const W: usize>(path: &mut ToolPath<6, W>) -> Vec<Knot> {
    let robot = Irp6Postument;
    let limits = EdpSetup::<6>::generator_limits(&robot, 0.2);
    let from = Joints([0.0, -1.57, 0.0, 1.2, 1.57, -1.57]);
    let line = LineMove::<_, 6, W> {
        motion: ToolMotion {
            robot,
            t_flange_tool: robot.description().default_tool(),
            joint_limits: limits.joints_anywhere,
            speeds: PathSpeeds {
                velocity_m_s: 0.5,
                angular_velocity_rad_s: 0.5,
                acceleration_m_s2: 0.45,
                angular_acceleration_rad_s2: 0.45,
            },
            macrostep_s: H,
        },
        target: Pose::from_rotation_vector(Vector3::new(-0.06, -0.06, 0.0), Vector3::zeros()),
        reference: Reference::Tool,
    };
    let motors = robot.motors(&from).unwrap();
    let x = Input::<EcpOf<6>> {
        i: 0,
        c0: Coordinator {
            says: Coordination::None,
            end_motion: false,
            path: heapless::Vec::new(),
            feed_override: 1.0,
        },
        e: EffectorImage {
            motors,
            joints: Some(from),
            demanded_motors: motors,
            demanded_joints: Some(from),
            following_error: [0.0; 6],
        },
        v: Sensors::NONE,
        t: (),
    };
    let mut b = MoveIn::new(line);
    let mut knots = vec![(from.0, [0.0; 6], [0.0; 6])];
    loop {
        match b.step(path, &x) {
            Step::Demand(Demand::Stay) => {}
            Step::Demand(Demand::JointsTwice(halves)) => {
                knots.extend(halves.map(|m| (m.position.0, m.velocity, m.acceleration)));
            }
            Step::Done => break,
            other => panic!("{other:?}"),
        }
    }
    assert!(knots.len() > 20);
    let h = 0.5 * H;
    for w in knots.windows(2) {
        let ((p0, v0, a0), (p1, v1, a1)) = (w[0], w[1]);
        for k in 0..6 {
            let dp = p1[k] - p0[k];
            let quad = 0.5 * h * (v0[k] + v1[k]) + h * h / 12.0 * (a0[k] - a1[k]);
            // what is left is h³/24 of a change of jerk inside the interval, at most the whole jerk
            let jerk = limits.joints_anywhere[k].j;
            assert!(
                (dp - quad).abs() < h * h * h / 24.0 * 2.0 * jerk + 1e-12,
                "{k}: {dp} {quad}"
            );
        }
    }
    knots
}
