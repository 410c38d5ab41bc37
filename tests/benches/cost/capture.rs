//! A real run of a simulated cell, with everything its nodes and its Master Process were given.

use bus::wire::Kind;
use firmware::{DriveAddress, Node, NodeConfig, NodeProcess, Port, Received, Station};
use hil_sim::cell::Cell as SimCell;
use host::program::{Run, RunStatus, Segment, config_of};
use host::task::{Action, Cell, Move, Target, Task};
use motion::Pose;
use protocol::frame::Frame;
use protocol::message::{Identity, NodeState, PosePath, PoseReference, ServoLaw};
use protocol::time::Micros;
use protocol::transfer::Mtu;
use robots::{Robot, RobotKind, RobotVisitor};
use std::sync::{Arc, Mutex, PoisonError};

/// The seed of the run.
const SEED: u64 = 1;
/// The period of the Master Process, as in `mrroc run`.
const MACROSTEP: Micros = Micros::from_millis(20);
/// Fractions of the speed ceilings, as in the shipped trajectories.
const SPEED: f64 = 0.15;

/// How long the robots hold still between their motions, s.
const HOLD_S: f64 = 2.0;

/// What a node was given at one wake-up, and what it was doing.
#[derive(Debug)]
pub(crate) struct Wake {
    pub(crate) now: Micros,
    pub(crate) rx: Vec<Received>,
    pub(crate) state: NodeState,
    pub(crate) sent: u64,
}

/// What the Master Process was given in one step, and what it sent.
#[derive(Debug)]
pub(crate) struct Step {
    pub(crate) now: Micros,
    pub(crate) rx: Vec<(Micros, Frame)>,
    pub(crate) sent: u64,
    /// What the last robot was executing.
    pub(crate) segment: Segment,
}

/// A finished run.
#[derive(Debug)]
pub(crate) struct Capture {
    /// Of the last robot of the cell.
    pub(crate) wakes: Vec<Wake>,
    pub(crate) steps: Vec<Step>,
}

/// A digest of frames sent, so that a replay can be compared.
pub(crate) fn digest(frames: &[Frame]) -> u64 {
    frames.iter().fold(0, |digest, frame| {
        let id = frame.id().arbitration().to_le_bytes();
        // FNV-1a
        id.iter()
            .chain(frame.data())
            .fold(digest, |digest: u64, byte| {
                (digest ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3)
            })
    })
}

/// The task: homing, a joint move, holding still, a line of 6 cm along the tool's axis.
pub(crate) fn task(kinds: &[RobotKind], law: ServoLaw) -> Task {
    let mut task = Task::homing(kinds);
    task.seed = SEED;
    for robot in &mut task.cell.robots {
        robot.servo = law;
    }
    let each = |target: fn(RobotKind) -> Target| Action::Move {
        moves: (0..)
            .zip(kinds)
            .map(|(robot, kind)| Move {
                robot,
                target: target(*kind),
                velocity: SPEED,
                acceleration: SPEED / 3.0,
                until_force_n: None,
            })
            .collect(),
    };
    let hold = Action::Wait { seconds: HOLD_S };
    for (name, action) in [
        ("joints", each(joints)),
        ("hold", hold),
        ("line", each(line)),
    ] {
        let step = host::task::Step {
            name: name.into(),
            line: 0,
            action,
        };
        task.steps.push(step);
    }
    task
}

/// Where the shipped approaches end.
fn joints(kind: RobotKind) -> Target {
    let mut values = vec![-0.35, -1.5, -0.1, 1.25, 1.39, -1.84];
    if kind == RobotKind::Irp6Track {
        values.insert(0, 0.1);
    }
    Target::Joints {
        values,
        relative: false,
    }
}

fn line(_: RobotKind) -> Target {
    let mut pose = Pose::identity();
    pose.position.z = 0.06;
    Target::Pose {
        pose,
        reference: PoseReference::Tool,
        path: PosePath::Line,
    }
}

/// The place of the `k`-th robot's node.
pub(crate) fn station(cell: &Cell, k: usize) -> Station {
    let robot = &cell.robots[k];
    Station {
        effector: robot.kind.effector(),
        unique_id: SEED * 1000 + k as u64,
        mtu: Mtu::Fd,
        law: robot.servo,
        velocity_factor: robot.velocity_factor,
        one_wire: false,
        track: robot.track,
    }
}

/// The configuration of the `k`-th robot's node.
pub(crate) fn config<R: Robot<N>, const N: usize>(
    robot: &R,
    cell: &Cell,
    k: usize,
) -> NodeConfig<N> {
    station(cell, k)
        .config(robot.description().drive_buses())
        .expect("a configuration that is right")
}

/// Makes the node of the `k`-th robot and says where its drives are.
struct Build<'a>(&'a Cell, usize);

impl RobotVisitor for Build<'_> {
    type Output = (Box<dyn NodeProcess + Send>, Vec<DriveAddress>);

    fn visit<R, const N: usize>(self, robot: R) -> Self::Output
    where
        R: Robot<N> + Copy + std::fmt::Debug + Send + Sync + 'static,
    {
        let config = config(&robot, self.0, self.1);
        let node = Node::new(Micros(0), robot, config).expect("a node");
        (Box::new(node), config.drives.to_vec())
    }
}

/// A fresh Master Process for a task.
pub(crate) fn master(task: Task) -> Run {
    let mut config = config_of(&task.cell).expect("a cell of known robots");
    config.trace_every = 1;
    Run::new(task, None, config, 1).expect("a configuration that is right")
}

/// Runs the task in lock step; ends the process where the run does not end as it should.
pub(crate) fn capture(kinds: &[RobotKind], law: ServoLaw) -> Capture {
    let task = task(kinds, law);
    let mut sim = SimCell::new(Kind::Fd);
    let wakes = Arc::new(Mutex::new(Vec::new()));
    for (k, kind) in kinds.iter().enumerate() {
        let (node, drives) = kind.visit(task.cell.robots[k].track, Build(&task.cell, k));
        let watched = k + 1 == kinds.len();
        let node = if watched {
            Box::new(Watched {
                node,
                wakes: wakes.clone(),
            })
        } else {
            node
        };
        sim.add_node(*kind, node, &drives, SEED).expect("a robot");
    }
    let mut run = master(task);
    let mut steps: Vec<Step> = Vec::new();
    let mut rx = Vec::new();
    loop {
        let now = sim.now();
        let mut sent = Vec::new();
        let status = run.step(now, rx.iter().copied(), &mut |frame| sent.push(frame));
        for frame in &sent {
            sim.send(*frame);
        }
        let segment = run.segment(kinds.len() - 1).clone();
        steps.push(Step {
            now,
            rx: std::mem::take(&mut rx),
            sent: digest(&sent),
            segment,
        });
        match status {
            RunStatus::Running => {}
            RunStatus::Done => break,
            RunStatus::Failed(error) => panic!("the run that is to be measured failed: {error}"),
        }
        sim.advance(now + MACROSTEP, &mut ());
        rx.extend(sim.receive());
    }
    drop(sim);
    let wakes = std::mem::take(&mut *wakes.lock().unwrap_or_else(PoisonError::into_inner));
    Capture { wakes, steps }
}

impl Capture {
    /// What the last robot was executing at a time.
    pub(crate) fn segment(&self, at: Micros) -> &Segment {
        let after = self.steps.partition_point(|step| step.now <= at);
        after
            .checked_sub(1)
            .and_then(|k| self.steps.get(k))
            .map_or(&Segment::None, |s| &s.segment)
    }
}

/// A node that is looked at while it works.
#[derive(Debug)]
struct Watched {
    node: Box<dyn NodeProcess + Send>,
    wakes: Arc<Mutex<Vec<Wake>>>,
}

impl NodeProcess for Watched {
    fn step(&mut self, now: Micros, rx: &[Received], tx: &mut dyn FnMut(Port, Frame)) {
        let mut sent = Vec::new();
        self.node.step(now, rx, &mut |port, frame| {
            sent.push(frame);
            tx(port, frame);
        });
        let wake = Wake {
            now,
            rx: rx.to_vec(),
            state: self.node.state(),
            sent: digest(&sent),
        };
        self.wakes
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .push(wake);
    }
    fn next_wake(&self) -> Micros {
        self.node.next_wake()
    }
    fn state(&self) -> NodeState {
        self.node.state()
    }
    fn identity(&self) -> Identity {
        self.node.identity()
    }
}
