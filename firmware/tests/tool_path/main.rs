//! Paths on the node: exactly on the curve, within the limits, and always able to stop.

mod feeds;
mod scalar;

use agent::{Input, MoveIn, Step};
use firmware::capacity::PATH_SAMPLES;
use firmware::ecp::generator::PathMove;
use firmware::ecp::tool_motion::{PathSpeeds, ToolMotion};
use firmware::ecp::tool_path::ToolPath;
use firmware::ecp::{Coordinator, Demand, EcpOf, EffectorImage, Limits, Sensors};
use firmware::edp::EdpSetup;
use motion::interpolator::{Braking, PathLimits};
use motion::path::{Arc, Curve, MovingSegment, Straight};
use motion::{Angle, AxisEnvelope, AxisLimits, Interpolator, Knot, Pose, Status};
use nalgebra::Vector3;
use protocol::fault::{PathProblem, Refusal};
use protocol::message::{Coordination, Corner, PathElement, PoseMessage};
use robots::{Irp6Postument, JointMotion, Joints, Robot};
use scalar::{larger, smaller};

const H: f64 = 0.02;
const N: usize = 6;
const W: usize = PATH_SAMPLES;
const FROM: Joints<N> = Joints([0.0, -1.57, 0.0, 1.2, 1.57, -1.57]);

fn limits() -> Limits<N> {
    EdpSetup::<N>::generator_limits(&Irp6Postument, 1.0)
}

fn arm(velocity_m_s: f64) -> ToolMotion<Irp6Postument, N> {
    ToolMotion {
        robot: Irp6Postument,
        t_flange_tool: Irp6Postument.description().default_tool(),
        joint_limits: limits().joints_anywhere,
        speeds: PathSpeeds {
            velocity_m_s,
            angular_velocity_rad_s: 1.0,
            acceleration_m_s2: 1.0,
            angular_acceleration_rad_s2: 4.0,
        },
        macrostep_s: H,
    }
}

fn start() -> Pose {
    Irp6Postument.forward(&FROM) * Irp6Postument.description().default_tool()
}

fn message(pose: &Pose) -> PoseMessage {
    PoseMessage {
        position_m: pose.position.into(),
        rotation_rad: pose.rotation_vector().into(),
    }
}

/// A coordinator that streams elements as the node has room, and overrides the feed.
struct Run {
    arm: ToolMotion<Irp6Postument, N>,
    elements: Vec<PathElement>,
    sent: usize,
    running: MoveIn<PathMove<Irp6Postument, N, W>>,
    path: ToolPath<N, W>,
    /// One each half of a macrostep.
    knots: Vec<JointMotion<N>>,
}

#[derive(Debug, PartialEq)]
enum End {
    Done,
    Refused(Refusal),
    StillRunning,
}

impl Run {
    fn new(arm: &ToolMotion<Irp6Postument, N>, elements: Vec<PathElement>) -> Self {
        let arm = *arm;
        Self {
            arm,
            elements,
            sent: 0,
            running: MoveIn::new(PathMove(arm)),
            path: ToolPath::new(),
            knots: vec![JointMotion {
                position: FROM,
                velocity: [0.0; N],
                acceleration: [0.0; N],
            }],
        }
    }

    /// At most so many macrosteps; `late` says in which of them nothing arrives.
    fn steps(
        &mut self,
        most: usize,
        share: impl Fn(usize) -> f64,
        late: impl Fn(usize) -> bool,
    ) -> End {
        let motors = self.arm.robot.motors(&FROM).unwrap();
        for i in 0..most {
            let room = if self.running.runs() {
                self.path.room()
            } else {
                4
            };
            let count = if late(i) {
                0
            } else {
                room.min(4).min(self.elements.len() - self.sent)
            };
            let path = (self.sent..self.sent + count)
                .map(|k| (u32::try_from(k).unwrap(), self.elements[k]))
                .collect();
            self.sent += count;
            let x = Input::<EcpOf<N>> {
                i: 0,
                c0: Coordinator {
                    says: Coordination::None,
                    end_motion: false,
                    path,
                    feed_override: share(i),
                },
                e: EffectorImage {
                    motors,
                    joints: Some(FROM),
                    demanded_motors: motors,
                    demanded_joints: Some(FROM),
                    following_error: [0.0; N],
                },
                v: Sensors::NONE,
                t: (),
            };
            match self.running.step(&mut self.path, &x) {
                Step::Demand(Demand::JointsTwice(halves)) => self.knots.extend(halves),
                // at rest
                Step::Demand(Demand::Joints(motion)) => self.knots.extend([motion; 2]),
                Step::Demand(Demand::Refuse(refusal)) => return End::Refused(refusal),
                Step::Demand(_) | Step::Hold => {}
                Step::Done => return End::Done,
            }
        }
        End::StillRunning
    }

    /// What the node's interpolator makes of the knots, at 8 kHz: joints, velocities, accelerations.
    fn set_points(&self) -> Vec<[JointMotion<N>; 1]> {
        let wide = AxisEnvelope::new(
            -1e6,
            1e6,
            AxisLimits {
                v: 1e4,
                a: 1e7,
                j: 1e10,
            },
        );
        let motors = |motion: &JointMotion<N>| self.arm.robot.motor_motion(motion).unwrap();
        let first = motors(&self.knots[0]).position.0.map(Angle::bound);
        let limits = PathLimits::new([wide; N]).unwrap();
        let mut edp = Interpolator::<N, 8>::new(Braking::new(&[wide; N]));
        edp.hold_anew(&limits.ranges(), first);
        edp.start(0).unwrap();
        let mut knots = self.knots[1..].iter();
        let (mut at_us, mut out) = (0, Vec::new());
        for now_us in (0..).step_by(125) {
            while edp.room() > 0
                && let Some(knot) = knots.next()
            {
                let motion = motors(knot);
                at_us += 10_000;
                let knot = Knot {
                    at_us,
                    position: motion.position.0,
                    velocity: motion.velocity,
                    acceleration: Some(motion.acceleration),
                };
                let made = limits.piece(&edp.tip(), &knot).unwrap();
                edp.push(&made.piece, now_us).unwrap();
            }
            let output = edp.step(now_us);
            let motion = robots::MotorMotion {
                position: robots::Motors(output.setpoint.position.map(Angle::to_f64)),
                velocity: output.setpoint.velocity.map(f64::from),
                acceleration: output.setpoint.acceleration.map(f64::from),
            };
            out.push([self.arm.robot.joint_motion(&motion).unwrap()]);
            if output.status == Status::Idle {
                break;
            }
        }
        out
    }

    fn tool(&self, joints: &Joints<N>) -> Pose {
        self.arm.robot.forward(joints) * self.arm.t_flange_tool
    }

    /// Largest velocity, acceleration and jerk of the set-points' joints, as shares of the limits.
    fn load(&self, points: &[[JointMotion<N>; 1]]) -> [f64; 3] {
        let mut load = [0.0f64; 3];
        for [m] in points {
            for k in 0..N {
                let l = self.arm.joint_limits[k];
                load[0] = larger(load[0], m.velocity[k].abs() / l.v);
                load[1] = larger(load[1], m.acceleration[k].abs() / l.a);
            }
        }
        for pair in points.windows(2) {
            for k in 0..N {
                let jerk = (pair[1][0].acceleration[k] - pair[0][0].acceleration[k]) / 125e-6;
                load[2] = larger(load[2], jerk.abs() / self.arm.joint_limits[k].j);
            }
        }
        load
    }
}

/// Distance of a point from a curve, m: golden sections around the nearest of many samples.
fn distance(curve: &impl Curve, p: &Vector3<f64>) -> f64 {
    let away = |s: f64| (curve.at(s).pose.position - p).norm();
    let n = 200;
    let at = |i: i32| curve.length() * f64::from(i) / f64::from(n);
    let nearest = (0..=n)
        .min_by(|a, b| away(at(*a)).total_cmp(&away(at(*b))))
        .unwrap();
    let (mut from, mut to) = (at(nearest - 1), at(nearest + 1));
    for _ in 0..60 {
        let (left, right) = (to - 0.618 * (to - from), from + 0.618 * (to - from));
        if away(left) < away(right) {
            to = right;
        } else {
            from = left;
        }
    }
    away(0.5 * (from + to))
}

fn exact() -> Corner {
    Corner {
        metres: 0.0,
        radians: 0.0,
    }
}

#[test]
fn set_points_of_arcs_and_lines_are_on_them_to_a_nanometre() {
    let a = start();
    let at = |x: f64, y: f64, z: f64| Pose {
        position: a.position + Vector3::new(x, y, z),
        ..a
    };
    let (b, c) = (at(0.0, -0.08, 0.0), at(0.04, -0.12, 0.02));
    let via = a.position + Vector3::new(0.04, -0.04, 0.0);
    let elements = vec![
        PathElement::Arc {
            via_m: via.into(),
            to: message(&b),
            corner: exact(),
        },
        PathElement::Line {
            to: message(&c),
            corner: exact(),
        },
        PathElement::End,
    ];
    for feed in [0.02, 0.1, 0.25] {
        let mut run = Run::new(&arm(feed), elements.clone());
        assert_eq!(run.steps(2000, |_| 1.0, |_| false), End::Done);
        let points = run.set_points();
        let arc = Arc::through(a, via, b).unwrap();
        let line = Straight::new(b, c).unwrap();
        let worst = points.iter().step_by(7).fold(0.0f64, |worst, [m]| {
            let p = run.tool(&m.position).position;
            larger(worst, smaller(distance(&arc, &p), distance(&line, &p)))
        });
        let load = run.load(&points);
        println!(
            "{feed} m/s: {} knots, off by {worst:.2e} m, load {load:.3?}",
            run.knots.len()
        );
        assert!(worst < 1e-9, "{feed}: {worst:e}");
        // quintics between the knots may exceed what was planned by 5/24·j·h and the like: less than the room left
        assert!(
            load[0] <= 1.001 && load[1] <= 1.01 && load[2] <= 1.2,
            "{load:?}"
        );
        let end = run.tool(&run.knots.last().unwrap().position);
        assert!((end.position - c.position).norm() < 1e-9);
    }
}

/// A flower around the start: closed, with curvature that changes all the time.
fn flower(points: u32) -> Vec<Pose> {
    let a = start();
    (1..=points)
        .map(|i| {
            let t = f64::from(i) / f64::from(points) * std::f64::consts::TAU;
            let r = 0.03 * libm::sin(3.0 * t);
            let way = Vector3::new(0.2 * r * libm::sin(t), r * libm::sin(t), r * libm::cos(t));
            let turn = motion::pose::exp(Vector3::new(0.0, 0.1 * libm::sin(t), 0.0));
            Pose {
                position: a.position + way,
                rotation: turn * a.rotation,
            }
        })
        .collect()
}

fn through(points: &[Pose]) -> Vec<PathElement> {
    let points = points
        .iter()
        .map(|pose| PathElement::Through(message(pose)));
    points.chain([PathElement::End]).collect()
}

/// The spans of the curve that the node makes of the same points.
fn spans(points: &[Pose]) -> Vec<motion::path::Quintic> {
    let mut curve = MovingSegment::new();
    let mut spans: Vec<_> = std::iter::once(start())
        .chain(points.iter().map(|pose| {
            // as they arrive: rotation vectors there and back
            Pose::from_rotation_vector(pose.position, pose.rotation_vector())
        }))
        .filter_map(|pose| curve.push(pose).unwrap())
        .collect();
    spans.extend(std::iter::from_fn(|| curve.finish()));
    spans
}

/// A stream of numbers that look random.
struct Dice(u64);

impl Dice {
    fn roll(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        f64::from(u32::try_from(self.0 >> 32).unwrap()) / f64::from(u32::MAX)
    }
}

#[test]
fn a_streamed_curve_is_kept_whatever_the_feed_rate_does() {
    let points = flower(240);
    let curve = spans(&points);
    for seed in 0..3 {
        // a new share of the feed every 0.6 s, and gaps in the stream
        let mut dice = Dice(seed);
        let shares: Vec<f64> = (0..400)
            .map(|_| match dice.roll() {
                x if x < 0.2 => 0.0,
                x if x < 0.35 => -dice.roll(),
                _ => dice.roll(),
            })
            .collect();
        let gaps: Vec<bool> = (0..400).map(|_| dice.roll() < 0.2).collect();
        let mut run = Run::new(&arm(0.08), through(&points));
        let first = run.steps(4000, |i| shares[i / 30 % 400], |i| gaps[i / 25 % 400]);
        if first == End::StillRunning {
            assert_eq!(run.steps(4000, |_| 1.0, |_| false), End::Done);
        }
        let set_points = run.set_points();
        let worst = set_points.iter().step_by(97).fold(0.0f64, |worst, [m]| {
            let p = run.tool(&m.position).position;
            // the spans are about a millimetre long
            let off = curve
                .iter()
                .filter(|span| (span.at(0.0).pose.position - p).norm() < 3e-3)
                .map(|span| distance(span, &p))
                .fold(f64::MAX, smaller);
            larger(worst, off)
        });
        let load = run.load(&set_points);
        println!(
            "seed {seed}: {} knots, off by {worst:.2e} m, load {load:.3?}",
            run.knots.len()
        );
        // where spans meet, between two knots, the third derivative jumps: a quintic cannot
        assert!(worst < 1e-9, "{worst:e}");
        assert!(
            load[0] <= 1.001 && load[1] <= 1.01 && load[2] <= 1.2,
            "{load:?}"
        );
        let end = run.tool(&run.knots.last().unwrap().position);
        assert!((end.position - points.last().unwrap().position).norm() < 1e-9);
    }
}

#[test]
fn corners_are_rounded_within_their_tolerance_and_not_stopped_at() {
    let a = start();
    let at = |x: f64, y: f64| Pose {
        position: a.position + Vector3::new(x, y, 0.0),
        ..a
    };
    let rounded = Corner {
        metres: 5e-3,
        radians: 0.05,
    };
    let corners = [at(0.06, 0.0), at(0.06, 0.06), at(0.0, 0.06), a];
    let square = |corner: Corner| -> Vec<PathElement> {
        let lines = corners.iter().map(|to| PathElement::Line {
            to: message(to),
            corner,
        });
        lines.chain([PathElement::End]).collect()
    };
    let mut sharp = Run::new(&arm(0.1), square(exact()));
    assert_eq!(sharp.steps(2000, |_| 1.0, |_| false), End::Done);
    let mut round = Run::new(&arm(0.1), square(rounded));
    assert_eq!(round.steps(2000, |_| 1.0, |_| false), End::Done);
    let stops = |run: &Run| {
        let inner = &run.knots[2..run.knots.len() - 2];
        let at_rest = |k: &&JointMotion<N>| k.velocity.iter().all(|v| v.abs() < 1e-6);
        inner.iter().filter(at_rest).count()
    };
    assert!(
        stops(&sharp) >= 3 && stops(&round) == 0,
        "{} {}",
        stops(&sharp),
        stops(&round)
    );
    let sides: Vec<_> = std::iter::once(&a)
        .chain(&corners)
        .zip(&corners)
        .map(|(from, to)| Straight::new(*from, *to).unwrap())
        .collect();
    let off = |run: &Run| {
        run.knots.iter().fold(0.0f64, |worst, k| {
            let p = run.tool(&k.position).position;
            larger(
                worst,
                sides
                    .iter()
                    .map(|side| distance(side, &p))
                    .fold(f64::MAX, smaller),
            )
        })
    };
    assert!(off(&sharp) < 1e-9);
    for run in [&sharp, &round] {
        let load = run.load(&run.set_points());
        assert!(
            load[0] <= 1.001 && load[1] <= 1.01 && load[2] <= 1.2,
            "{load:?}"
        );
    }
    // somewhere near the corners it uses the tolerance, nowhere more
    assert!(
        off(&round) < 5e-3 + 1e-9 && off(&round) > 1e-3,
        "{}",
        off(&round)
    );
}

#[test]
fn what_cannot_be_done_is_refused_at_rest_before_it() {
    let a = start();
    let at = |x: f64, y: f64| Pose {
        position: a.position + Vector3::new(x, y, 0.0),
        ..a
    };
    let line = |to: Pose| PathElement::Line {
        to: message(&to),
        corner: exact(),
    };
    let nan = PathElement::Line {
        to: PoseMessage {
            position_m: [f64::NAN, 0.0, 0.0],
            rotation_rad: [0.0; 3],
        },
        corner: exact(),
    };
    let refused = |elements: Vec<PathElement>| {
        let mut run = Run::new(&arm(0.1), elements);
        let end = run.steps(3000, |_| 1.0, |_| false);
        let last = run.knots.last().unwrap();
        let at_rest = last
            .velocity
            .iter()
            .chain(&last.acceleration)
            .all(|x| *x == 0.0);
        assert!(at_rest, "{last:?}");
        let tool = run.tool(&last.position).position;
        (end, tool)
    };
    let problem = |element, problem| End::Refused(Refusal::Path { element, problem });
    let straight = PathElement::Arc {
        via_m: at(0.01, 0.0).position.into(),
        to: message(&at(0.02, 0.0)),
        corner: exact(),
    };
    let negative = PathElement::Line {
        to: message(&at(0.02, 0.02)),
        corner: Corner {
            metres: -1.0,
            radians: 1.0,
        },
    };
    let b = at(0.02, 0.0);
    assert_eq!(
        refused(vec![line(b), nan]).0,
        problem(1, PathProblem::NotFinite)
    );
    assert_eq!(refused(vec![straight]).0, problem(0, PathProblem::NotAnArc));
    assert_eq!(
        refused(vec![line(b), negative]).0,
        problem(1, PathProblem::Corner)
    );
    // out of reach: the tool stops short of it, on the line
    let far = at(3.0, 0.0);
    let (end, tool) = refused(vec![line(far), PathElement::End]);
    assert!(
        matches!(
            end,
            End::Refused(Refusal::Unreachable | Refusal::Limit { .. })
        ),
        "{end:?}"
    );
    assert!(distance(&Straight::new(a, far).unwrap(), &tool) < 1e-9);
    // a line that goes nowhere is none, and a path of nothing is done
    assert_eq!(refused(vec![line(a), PathElement::End]).0, End::Done);
}

/// `LinuxCNC` 2.10 accelerated with 8.1 times the limit when it rounded G3 arcs of 4 mm (`LinuxCNC#3773`).
#[test]
fn small_arcs_are_rounded_within_the_acceleration_asked_for() {
    const RADIUS: f64 = 4e-3;
    let a = start();
    let at = |x: f64, y: f64| a.position + Vector3::new(-y, x, 0.0);
    for rounding in [1e-5_f32, 1e-4, 1e-3] {
        // half circles side by side, so that they meet in a cusp, and quarters that meet in right angles
        let arc = |from: f64, sweep: f64| {
            let (middle, end) = (0.5 * sweep, sweep);
            let (dx, dy) = (RADIUS * libm::cos(middle), RADIUS * libm::sin(middle));
            let (ex, ey) = (RADIUS * libm::cos(end), RADIUS * libm::sin(end));
            PathElement::Arc {
                via_m: at(from + RADIUS - dx, dy).into(),
                to: message(&Pose {
                    position: at(from + RADIUS - ex, ey),
                    ..a
                }),
                corner: Corner {
                    metres: rounding,
                    radians: 0.05,
                },
            }
        };
        let back = |x: f64| PathElement::Line {
            to: message(&Pose {
                position: at(x, 0.0),
                ..a
            }),
            corner: Corner {
                metres: rounding,
                radians: 0.05,
            },
        };
        let mut elements = Vec::new();
        for k in 0..4 {
            let from = f64::from(k) * 3.0 * RADIUS;
            elements.push(arc(from, std::f64::consts::PI));
            elements.push(arc(from + 2.0 * RADIUS, std::f64::consts::FRAC_PI_2));
            elements.push(back(from + 3.0 * RADIUS));
        }
        elements.push(PathElement::End);
        let mut asked = arm(0.12);
        asked.speeds.acceleration_m_s2 = 1.75;
        // joints that bear whatever the tool may do
        asked.joint_limits = asked.joint_limits.map(|l| AxisLimits {
            v: l.v * 100.0,
            a: l.a * 1e3,
            j: l.j * 1e5,
        });
        let mut run = Run::new(&asked, elements);
        assert_eq!(
            run.steps(4000, |_| 1.0, |_| false),
            End::Done,
            "{:?}",
            run.knots.len()
        );
        let points = run.set_points();
        let tool: Vec<_> = points
            .iter()
            .map(|[m]| run.tool(&m.position).position)
            .collect();
        let worst = tool.windows(3).fold(0.0f64, |worst, w| {
            let bent = (w[2] - w[1]) - (w[1] - w[0]);
            larger(worst, bent.norm() / (125e-6 * 125e-6))
        });
        let fastest = tool.windows(2).fold(0.0f64, |most, w| {
            larger(most, (w[1] - w[0]).norm() / 125e-6)
        });
        println!("{rounding} m: {worst:.3} m/s², {fastest:.3} m/s");
        // what lies between samples may exceed them a little
        assert!(worst < 1.75 * 1.01 && worst > 1.0, "{rounding}: {worst}");
        // √(a·r) = 0.084 m/s on the arcs, more where they are straight
        assert!(fastest > 0.04, "{rounding}: {fastest}");
    }
}
