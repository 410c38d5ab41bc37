//! The servo laws of the node beside each other: the same moves over the buses in lock step, what the
//! axes lag behind, and what happens where one law takes over from another.
//!
//! `cargo test --release -p mrroc-tests --test laws -- --nocapture` prints the table.

use host::mp::arm::{arm, unit_rad};
use mrroc_tests::coordinator::{Coordinator, speeds};
use protocol::fault::Refusal;
use protocol::message::{Instruction, Progress, Reply, Request, ServoLaw};
use robots::RobotKind;
use robots::dynamics::{Body, Shape};

const LAWS: [ServoLaw; 3] = [
    ServoLaw::Original,
    ServoLaw::FeedForward,
    ServoLaw::ComputedTorque,
];

/// Where a robot of the comparison goes to and fro, at which part of its greatest velocity.
struct Course {
    kind: RobotKind,
    factor: f64,
    /// Part of the planning acceleration.
    acceleration: f32,
    from: &'static [f64],
    to: &'static [f64],
}

const POLYCRANK: Course = Course {
    kind: RobotKind::Polycrank,
    factor: 0.4,
    acceleration: 0.06,
    from: &[0.3, -0.8, 0.5, 0.2, -0.4, 0.3, 0.0],
    to: &[1.5, 0.6, -0.5, 0.9, 0.5, -0.6, 1.0],
};

const POSTUMENT: Course = Course {
    kind: RobotKind::Irp6Postument,
    factor: 0.5,
    acceleration: 0.9,
    from: &[0.3, -1.3, 0.0, 1.2, 0.4, 0.0],
    to: &[-0.3, -1.7, 0.2, 1.5, -0.4, 0.6],
};

const TRACK: Course = Course {
    kind: RobotKind::Irp6Track,
    factor: 0.5,
    acceleration: 0.9,
    from: &[0.2, 0.3, -1.3, 0.0, 1.2, 0.4, 0.0],
    to: &[0.3, -0.3, -1.7, 0.2, 1.5, -0.4, 0.6],
};

impl Course {
    /// Homed with csp, at its beginning.
    fn begun(&self) -> Coordinator {
        let mut c = Coordinator::as_fast_as(self.kind, ServoLaw::DrivePosition, 3, self.factor);
        c.enable();
        c.home();
        // from wherever the encoders found it
        c.execute(Instruction::MoveJoints {
            target: self.from.iter().copied().collect(),
            relative: false,
            speeds: speeds(self.kind.axes(), 0.3, 0.1),
        });
        c
    }

    /// A move; the greatest following error of any axis, rad of its motor.
    fn go(&self, c: &mut Coordinator, target: &[f64]) -> f64 {
        let reply = c.begin(Instruction::MoveJoints {
            target: target.iter().copied().collect(),
            relative: false,
            speeds: speeds(self.kind.axes(), 0.9, self.acceleration),
        });
        assert_eq!(reply, Reply::Accepted, "{}", self.kind);
        let mut worst = 0.0;
        let mut ended = false;
        while !ended {
            c.macrostep();
            let larger = self.error(c);
            if larger > worst {
                worst = larger;
            }
            ended = !matches!(c.feedback().progress, Progress::Pending | Progress::Running);
        }
        c.finish("move");
        worst
    }

    /// The greatest following error of the last macrostep, of the first five axes: the last ones carry next to
    /// nothing, and N of the IRp-6 counts increments of 3 mrad.
    fn error(&self, c: &Coordinator) -> f64 {
        let axes = arm(self.kind).axes();
        let errors = axes.iter().zip(&c.feedback().following_error).take(5);
        errors
            .map(|(axis, units)| f64::from(*units) * unit_rad(axis))
            .fold(0.0, |a, b| if b > a { b } else { a })
    }

    /// Another law; how far any motor turns in the second after it, rad.
    fn select(c: &mut Coordinator, law: ServoLaw) -> f64 {
        let motors = |c: &Coordinator| c.cell.robots().next().unwrap().1.motor_rad().to_vec();
        let before = motors(c);
        c.accepted(|epoch| Request::SelectServo { epoch, law });
        let mut jump = 0.0;
        for _ in 0..50 {
            c.macrostep();
            for (now, before) in motors(c).iter().zip(&before) {
                let moved = (now - before).abs();
                jump = if moved > jump { moved } else { jump };
            }
        }
        jump
    }

    /// Following errors and jumps of the three laws in cst, printed.
    fn compared(&self) -> [[f64; 2]; 3] {
        let mut c = self.begun();
        let rows = LAWS.map(|law| {
            let jump = Self::select(&mut c, law);
            let there = self.go(&mut c, self.to);
            let back = self.go(&mut c, self.from);
            let worst = if there > back { there } else { back };
            println!(
                "{:15} {law:?}: following error {worst:.6} rad, jump {jump:.6} rad",
                self.kind.name()
            );
            [worst, jump]
        });
        // the drives' own loops take over again
        let jump = Self::select(&mut c, ServoLaw::DrivePosition);
        println!("{:15} DrivePosition: jump {jump:.6} rad", self.kind.name());
        self.go(&mut c, self.to);
        assert_eq!(c.feedback().fault, None, "{}", self.kind);
        assert_eq!(c.feedback().limit_violations, 0, "{}", self.kind);
        rows
    }
}

#[test]
fn computed_torque_lags_behind_least() {
    // found: Polycrank 20, 26 and 0.8 mrad; postument 205, 27 and 25 mrad; track 312, 17 and 13 mrad
    for (course, of_original, of_feed_forward) in [
        (POLYCRANK, 0.08, 0.06),
        (POSTUMENT, 0.22, 1.0),
        (TRACK, 0.08, 0.9),
    ] {
        let [[original, _], [forward, _], [computed, jump]] = course.compared();
        assert!(computed < of_original * original && computed > 0.1 * of_original * original);
        assert!(computed < of_feed_forward * forward && computed > 0.2 * of_feed_forward * forward);
        // taking over moves motors by less than four increments of N, the coarsest
        assert!(jump < 0.0125, "{jump}");
    }
}

#[test]
fn computed_torque_bears_a_load_nobody_told_it_of() {
    for (course, kg) in [(POLYCRANK, 0.5), (POSTUMENT, 2.0), (TRACK, 2.0)] {
        let mut c = course.begun();
        Course::select(&mut c, ServoLaw::ComputedTorque);
        let empty = course.go(&mut c, course.to);
        let shape = Shape::Box {
            centre: [0.0, 0.0, 0.05],
            size: [0.1; 3],
        };
        let body = Body::homogeneous(kg, &shape);
        assert!(c.cell.robot_mut(0).unwrap().carry(Some(&body)));
        for _ in 0..100 {
            c.macrostep();
        }
        let loaded = course.go(&mut c, course.from);
        for _ in 0..50 {
            c.macrostep();
        }
        println!(
            "{:15} empty {empty:.6}, loaded {loaded:.6}, at rest {:.6}",
            course.kind.name(),
            course.error(&c)
        );
        assert_eq!(c.feedback().fault, None);
        // twice what was found, 1.1 to 20 mrad in motion and an increment at rest
        assert!(loaded < 0.04 && course.error(&c) < 0.0032, "{loaded}");
        assert!(loaded > 1e-4, "{loaded}");
    }
}

#[test]
fn drives_without_gears_follow_with_the_model_as_an_offset() {
    let mut c = POLYCRANK.begun();
    // homed under torque: the model has taken over from the drives' integrals
    let there = POLYCRANK.go(&mut c, POLYCRANK.to);
    let back = POLYCRANK.go(&mut c, POLYCRANK.from);
    println!("csp: following error {there:.6} and {back:.6} rad");
    // one or two increments of 0.1 mrad
    assert!((0.5e-4..4e-4).contains(&there) && (0.5e-4..4e-4).contains(&back));
    // to cst and back: no part of the torque is lost, or comes twice
    for law in [ServoLaw::ComputedTorque, ServoLaw::DrivePosition] {
        let jump = Course::select(&mut c, law);
        println!("{law:?}: jump {jump:.6} rad");
        assert!(jump < 0.006, "{law:?}: {jump}"); // twice what was found
    }
    // greatest payload, let go and taken up at rest
    let mut sag = [0.0; 2];
    for (sag, kg) in sag.iter_mut().zip([2.0, 1e-6]) {
        let shape = Shape::Box {
            centre: [0.0, 0.0, 0.098],
            size: [0.1; 3],
        };
        let body = Body::homogeneous(kg, &shape);
        assert!(c.cell.robot_mut(0).unwrap().carry(Some(&body)));
        for _ in 0..100 {
            c.macrostep();
            let error = POLYCRANK.error(&c);
            *sag = if error > *sag { error } else { *sag };
        }
    }
    println!("2 kg: {sag:?} rad");
    // 9.9 N·m on crank 5, whose drive bears 0.05·150·35 N·m/rad while it gives way
    assert!(
        sag.iter().all(|sag| (0.006..0.025).contains(sag)),
        "{sag:?}"
    );
    assert_eq!(c.feedback().fault, None);
}

#[test]
fn a_robot_without_a_chain_refuses_computed_torque() {
    let mut c = Coordinator::new(RobotKind::Conveyor, ServoLaw::DrivePosition, 3);
    c.wait_for(protocol::message::NodeState::Disabled);
    c.acquire();
    let law = ServoLaw::ComputedTorque;
    let reply = c.request(&Request::SelectServo {
        epoch: c.epoch(),
        law,
    });
    assert_eq!(reply, Reply::Refused(Refusal::UnknownServoLaw));
}
