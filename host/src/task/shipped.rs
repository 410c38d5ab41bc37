//! The tasks we ship, walked through by kinematics: every pose within reach, every axis and motor
//! within its limits all the way, and about as long as a task for a first run should be.

use super::*;
use crate::trj::{Reference, Space};
use robots::{Inverse, Irp6Postument, Irp6Track, Joints, Motors, Robot};

const SAMPLES: i32 = 100;

/// The motors' greatest velocity at the cell's factor of 0.2, rad/s (MRROC++: 0.5 rad in 2 ms).
const MOTOR_RAD_S: f64 = 50.0;

struct Arm<'r, const N: usize, R> {
    robot: &'r R,
    /// Its place in the cell.
    index: usize,
    joints: Joints<N>,
}

impl<const N: usize, R: Robot<N>> Arm<'_, N, R> {
    fn tool(&self) -> Pose {
        self.robot.forward(&self.joints) * self.robot.description().default_tool()
    }

    /// Goes to joints and says how far the motor that turned most did.
    fn go(&mut self, to: Joints<N>, what: &str) -> f64 {
        let motors = |q: &Joints<N>| {
            self.robot
                .motors(q)
                .unwrap_or_else(|e| panic!("{what}: {e}"))
        };
        self.robot
            .check_joints(&to)
            .unwrap_or_else(|e| panic!("{what}: {e}"));
        self.robot
            .check_motors(&motors(&to))
            .unwrap_or_else(|e| panic!("{what}: {e}"));
        let turned = motors(&to)
            .0
            .iter()
            .zip(motors(&self.joints).0)
            .map(|(a, b)| (a - b).abs())
            .fold(0.0, larger);
        self.joints = to;
        turned
    }

    /// Straight in joint space; the time it takes at least, s.
    fn joint_move(&mut self, to: Joints<N>, fractions: &[f64], what: &str) -> f64 {
        let from = self.joints;
        let mut motors = 0.0;
        for k in 1..=SAMPLES {
            let s = f64::from(k) / f64::from(SAMPLES);
            let mut q = from;
            for (q, to) in q.0.iter_mut().zip(to.0) {
                *q += s * (to - *q);
            }
            motors += self.go(q, what);
        }
        let axes = to.0.iter().zip(from.0).zip(fractions);
        let time = axes.map(|((a, b), f)| (a - b).abs() / (f * Space::Joint.velocity_ceiling()));
        larger(time.fold(0.0, larger), motors / MOTOR_RAD_S)
    }

    fn motor_move(&mut self, to: Motors<N>, fractions: &[f64], what: &str) -> f64 {
        let from = self.robot.motors(&self.joints).unwrap();
        for k in 1..=SAMPLES {
            let s = f64::from(k) / f64::from(SAMPLES);
            let mut m = from;
            for (m, to) in m.0.iter_mut().zip(to.0) {
                *m += s * (to - *m);
            }
            let q = self
                .robot
                .joints(&m)
                .unwrap_or_else(|e| panic!("{what}: {e}"));
            self.go(q, what);
        }
        let axes = to.0.iter().zip(from.0).zip(fractions);
        let ceiling = |f: f64| {
            let v = f * Space::Motor.velocity_ceiling();
            if v > MOTOR_RAD_S { MOTOR_RAD_S } else { v }
        };
        axes.map(|((a, b), f)| (a - b).abs() / ceiling(*f))
            .fold(0.0, larger)
    }

    /// Along poses of the tool; the time the motors need at least, s.
    fn follow(&mut self, pose: impl Fn(f64) -> Pose, what: &str) -> f64 {
        let mut turned = 0.0;
        for k in 1..=SAMPLES {
            let at = pose(f64::from(k) / f64::from(SAMPLES));
            turned += self.beside(at, &format!("{what}, sample {k}"));
        }
        turned / MOTOR_RAD_S
    }

    /// To a pose of the tool nearby; how far the motor that turned most did.
    fn beside(&mut self, tool: Pose, what: &str) -> f64 {
        let flange = tool * self.robot.description().default_tool().inverse();
        let found: Inverse<N> = self
            .robot
            .inverse(&flange, &self.joints)
            .unwrap_or_else(|e| panic!("{what}: {e}"));
        let q = found.nearest();
        let jump =
            q.0.iter()
                .zip(self.joints.0)
                .map(|(a, b)| (a - b).abs())
                .fold(0.0, larger);
        assert!(jump < 0.05, "{what}: a jump of {jump}");
        self.go(q, what)
    }

    fn line(&mut self, to: Pose, velocity: f64, angular: f64, what: &str) -> f64 {
        let from = self.tool();
        let turn = (from.inverse() * to).rotation_vector();
        let way = to.position - from.position;
        let time = self.follow(
            |s| {
                let step = Pose::from_rotation_vector(Vector3::zeros(), turn * s);
                Pose {
                    position: from.position + way * s,
                    rotation: from.rotation * step.rotation,
                }
            },
            what,
        );
        larger(time, larger(way.norm() / velocity, turn.norm() / angular))
    }

    fn replay(&mut self, trajectory: &Trajectory, what: &str) -> f64 {
        let relative = trajectory.reference == Reference::Relative;
        let mut time = 0.0;
        for node in &trajectory.nodes {
            let what = format!("{what}, line {}", node.line);
            time += match trajectory.space {
                Space::Joint => {
                    let to = target(&node.coordinates, self.joints.0, relative);
                    self.joint_move(Joints(to), &node.velocity, &what)
                }
                Space::Motor => {
                    let from = self.robot.motors(&self.joints).unwrap();
                    let to = target(&node.coordinates, from.0, relative);
                    self.motor_move(Motors(to), &node.velocity, &what)
                }
                Space::XyzAngleAxis | Space::XyzEulerZyz => {
                    let pose = trajectory.pose(node).unwrap();
                    let to = if relative { self.tool() * pose } else { pose };
                    let ceiling = trajectory.space.velocity_ceiling();
                    let (v, w) = (node.velocity[0] * ceiling, node.velocity[3] * ceiling);
                    self.line(to, v, w, &what)
                }
            };
            self.say(&what, time);
        }
        time
    }

    fn say(&self, what: &str, time: f64) {
        let tool = self.tool();
        println!(
            "{what}: {time:.2} s, joints {:.4?}, tool {:.4?} {:.4?}",
            self.joints.0,
            tool.position.as_slice(),
            tool.rotation_vector().as_slice()
        );
    }

    /// The time a step takes this arm at least, s, without acceleration.
    fn step(&mut self, cell: &Cell, step: &Step) -> f64 {
        let me = self.index;
        let what = format!("{} {}", cell.robots[me].name, step.name);
        match &step.action {
            Action::Home { robots } => {
                assert!(robots.contains(&self.index));
                self.joints = self.robot.joints(&Motors([0.0; N])).unwrap();
                0.0
            }
            Action::Replay { replays, .. } => replays
                .iter()
                .filter(|replay| replay.robot == me)
                .map(|replay| self.replay(&replay.trajectory, &what))
                .sum(),
            Action::Move { moves } => moves
                .iter()
                .filter(|one| one.robot == me)
                .map(|one| self.one_move(one, &what))
                .sum(),
            Action::Wait { seconds } => *seconds,
            Action::Tight(tight) => {
                let base = cell.robots[self.index].t_world_base;
                let begin = base * self.tool();
                let time = self.follow(|s| base.inverse() * tight.displacement(s) * begin, &what);
                // a smooth motion is at its fastest 15/8 as fast as the mean
                assert!(time * 1.875 < tight.duration_s, "{what}: {time} s at least");
                self.say(&what, tight.duration_s);
                tight.duration_s
            }
            Action::Path(path) => {
                if path.robot != me {
                    return 0.0;
                }
                let streamed = path.path.from(&self.tool(), path.reference).unwrap();
                let course = &streamed.course;
                let time = course.length_m() / f64::from(path.speeds.velocity_m_s);
                for s in course.samples(2e-3) {
                    self.beside(course.at(s).unwrap().pose, &format!("{what}, s = {s:.3}"));
                }
                self.say(&what, time);
                time
            }
            Action::Engrave(_) | Action::Regulator { .. } => 0.0,
        }
    }

    fn one_move(&mut self, one: &Move, what: &str) -> f64 {
        let fractions = [one.velocity; N];
        let time = match &one.target {
            Target::Joints { values, relative } => {
                let to = target(values, self.joints.0, *relative);
                self.joint_move(Joints(to), &fractions, what)
            }
            Target::Motors { values, relative } => {
                let from = self.robot.motors(&self.joints).unwrap();
                let to = target(values, from.0, *relative);
                self.motor_move(Motors(to), &fractions, what)
            }
            Target::Pose {
                pose, reference, ..
            } => {
                let to = match reference {
                    PoseReference::Tool => self.tool() * *pose,
                    PoseReference::Base => *pose,
                };
                let v = one.velocity * Space::XyzAngleAxis.velocity_ceiling();
                self.line(to, v, v, what)
            }
        };
        self.say(what, time);
        time
    }
}

/// Values, or increments from where the axes are.
fn target<const N: usize>(values: &[f64], from: [f64; N], relative: bool) -> [f64; N] {
    let mut to = if relative { from } else { [0.0; N] };
    for (to, value) in to.iter_mut().zip(values) {
        *to += value;
    }
    to
}

fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

fn shipped(name: &str) -> Task {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tasks");
    Task::load(&folder.join(name), &Files::on_disk()).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn the_main_job_stays_within_reach_and_limits() {
    let task = shipped("two-arms.toml");
    let mut track = Arm {
        robot: &Irp6Track::KEEP,
        index: task.cell.robot("irp6-track").unwrap(),
        joints: Joints([0.0; 7]),
    };
    let mut postument = Arm {
        robot: &Irp6Postument,
        index: task.cell.robot("irp6-postument").unwrap(),
        joints: Joints([0.0; 6]),
    };
    let mut total = 0.0;
    for step in &task.steps {
        let (a, b) = (
            track.step(&task.cell, step),
            postument.step(&task.cell, step),
        );
        total += larger(a, b);
        println!("{}: {a:.1} s, {b:.1} s", step.name);
    }
    println!("{total:.1} s without homing and acceleration");
    assert!((30.0..80.0).contains(&total), "{total}");
}

#[test]
fn the_main_job_shows_every_way_of_moving() {
    let task = shipped("two-arms.toml");
    assert_eq!(task.warnings(), [] as [String; 0]);
    for robot in 0..task.cell.robots.len() {
        let replays: Vec<_> = task
            .steps
            .iter()
            .filter_map(|step| match &step.action {
                Action::Replay { replays, .. } => Some(replays),
                _ => None,
            })
            .flatten()
            .filter(|replay| replay.robot == robot)
            .map(|replay| (replay.trajectory.space, replay.trajectory.reference))
            .collect();
        for space in [Space::Joint, Space::Motor, Space::XyzAngleAxis] {
            for reference in [Reference::Absolute, Reference::Relative] {
                assert!(
                    replays.contains(&(space, reference)),
                    "{robot} {space:?} {reference:?}"
                );
            }
        }
    }
    let has = |wanted: fn(&Action) -> bool| task.steps.iter().any(|step| wanted(&step.action));
    assert!(has(|a| matches!(a, Action::Tight(_))));
    assert!(has(|a| matches!(a, Action::Move { .. })));
    assert!(has(|a| matches!(a, Action::Home { .. })));
}

#[test]
fn the_rose_is_within_reach_and_as_its_formula_says() {
    let task = shipped("rose.toml");
    let mut postument = Arm {
        robot: &Irp6Postument,
        index: 0,
        joints: Joints([0.0; 6]),
    };
    let mut total = 0.0;
    for step in &task.steps {
        total += postument.step(&task.cell, step);
    }
    // at the feed asked for, without homing
    assert!((60.0..150.0).contains(&total), "{total}");
    let mut paths = task.steps.iter().filter_map(|step| match &step.action {
        Action::Path(path) => Some(path),
        _ => None,
    });
    let rose = &paths.next().unwrap().path.marks;
    assert_eq!(rose.len(), 1501);
    for (mark, k) in rose.iter().zip(0..) {
        let u = 8.0 * std::f64::consts::PI * f64::from(k) / 1500.0;
        let r = 0.11 * libm::cos(1.75 * u);
        let expected = [
            r * libm::cos(u) - 0.11,
            r * libm::sin(u),
            0.015 * (1.0 - libm::cos(u / 4.0)),
            0.0,
            0.0,
            0.2 * libm::sin(u / 4.0),
        ];
        let turn = mark.to.rotation_rad.unwrap();
        let read = mark.to.position_m.iter().chain(&turn);
        for (read, expected) in read.zip(expected) {
            // seven digits after the point
            assert!((read - expected).abs() < 5.1e-8, "line {}", mark.line);
        }
    }
    let frame = &paths.next().unwrap().path.marks;
    let has = |wanted: fn(&crate::path::Way) -> bool| frame.iter().any(|m| wanted(&m.way));
    assert!(has(|way| matches!(way, crate::path::Way::Line { .. })));
    assert!(has(|way| matches!(way, crate::path::Way::Arc { .. })));
}
