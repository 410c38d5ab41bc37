//! The ECP may take its time: what a node sends does not depend on it, up to the step in which its plan is due, and
//! beyond it the node stops by itself.

use board::boot::{BoardNode, Boot};
use firmware::ecp::NoPrograms;
use firmware::process::{NodeProcess, drive_buses};
use firmware::{NodeSetup, Port, Received, Station};
use mrroc_tests::coordinator::{Coordinator, speeds};
use mrroc_tests::emulator::tape::{Recorder, Step};
use protocol::fault::{Cause, Refusal};
use protocol::frame::Frame;
use protocol::message::{
    Identity, Instruction, NodeState, Progress, Reply, Request, ServoLaw, StopKind, WireCondition,
};
use protocol::time::Micros;
use protocol::transfer::Mtu;
use robots::{Conveyor, RobotKind, TrackRule};

const KIND: RobotKind = RobotKind::Conveyor;
/// Servo steps from an order to its plan: a macrostep of 10 less the two knots a plan may have.
const HAND_OVER: u32 = 8;

/// A node whose ECP does its work only when so many servo steps have passed.
#[derive(Debug)]
struct Tardy {
    node: BoardNode<Conveyor, 1>,
    delay: u32,
    ordered: Option<u32>,
}

impl NodeProcess for Tardy {
    fn step(&mut self, now: Micros, rx: &[Received], mut tx: &mut dyn FnMut(Port, Frame)) {
        let (foreground, ecp) = self.node.halves();
        let passed = |since: u32| foreground.servo_step().wrapping_sub(since);
        if self
            .ordered
            .is_some_and(|since| passed(since) >= self.delay)
        {
            self.ordered = None;
            ecp.work();
        }
        let at_hand = self.ordered.is_none().then_some(ecp);
        foreground.step(now, rx, at_hand, &mut tx);
        if foreground.take_order() {
            self.ordered = Some(foreground.servo_step());
        }
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

fn boot() -> Boot {
    Boot {
        now: Micros(0),
        kind: KIND,
        station: Station {
            effector: 1,
            unique_id: 5,
            mtu: Mtu::Fd,
            law: ServoLaw::DrivePosition,
            velocity_factor: 0.2,
            one_wire: false,
            track: TrackRule::Keep,
        },
        buses: drive_buses(KIND),
    }
}

/// A coordinator of such a node, homed; and what the node sends.
fn homed(delay: u32) -> (Coordinator, mrroc_tests::emulator::tape::Recording) {
    let boot = boot();
    let config = boot.station.config([0]).unwrap();
    let setup = NodeSetup::new(Conveyor, config).unwrap();
    let node = Tardy {
        node: BoardNode::of(boot.now, setup, NoPrograms),
        delay,
        ordered: None,
    };
    let (recorder, recording) = Recorder::new(Box::new(node), boot.clone());
    let mut c = Coordinator::with_node(&boot, Box::new(recorder), &config.drives);
    c.enable();
    c.home();
    (c, recording)
}

fn by(rad: f64) -> Instruction {
    Instruction::MoveMotors {
        target: [rad].into_iter().collect(),
        relative: true,
        speeds: speeds(1, 0.5, 0.5),
    }
}

/// A move, one that is stopped on its path, one that is stopped quickly, and one that is waited for.
fn life(delay: u32) -> Vec<Step> {
    let (mut c, recording) = homed(delay);
    c.execute(by(5.0));
    for kind in [StopKind::Path, StopKind::Quick] {
        assert_eq!(c.begin(by(-20.0)), Reply::Accepted);
        for _ in 0..20 {
            c.macrostep();
        }
        assert_eq!(c.state(), Some(NodeState::Moving));
        c.stop(kind);
        c.recover();
    }
    c.execute(by(1.0));
    recording.tape().steps
}

#[test]
fn work_done_at_the_last_moment_comes_to_the_same_as_work_done_at_once() {
    let at_once = life(0);
    let moved = at_once.iter().any(|step| step.state == NodeState::Moving);
    assert!(moved);
    for delay in [1, HAND_OVER] {
        assert!(life(delay) == at_once, "{delay} steps");
    }
}

#[test]
fn work_done_a_step_too_late_is_a_fault_and_moves_nothing() {
    let (mut c, _) = homed(HAND_OVER + 1);
    let before = c.feedback().demand.clone();
    assert_eq!(c.begin(by(5.0)), Reply::Accepted);
    c.wait_for(NodeState::Faulted);
    let fault = c.feedback().fault.unwrap();
    assert_eq!((fault.cause, fault.axis), (Cause::PlanLate, None));
    assert_eq!(c.feedback().demand, before);
    let progress = c.feedback().progress;
    assert_eq!(progress, Progress::Failed(Refusal::Aborted));
    // it can be acknowledged; the plan that came late is nobody's
    c.recover();
    for _ in 0..10 {
        c.macrostep();
    }
    assert_eq!(c.feedback().demand, before);
    assert_eq!(c.state(), Some(NodeState::Holding));
}

#[test]
fn an_ecp_at_work_for_an_instruction_that_was_stopped_takes_another_a_little_later() {
    let (mut c, _) = homed(HAND_OVER);
    let wait = Instruction::Wait {
        until: WireCondition::Decided { label: 1 },
        timeout_ms: 0,
    };
    assert_eq!(c.begin(wait), Reply::Accepted);
    for _ in 0..5 {
        c.macrostep();
    }
    c.accepted(|_| Request::Stop {
        kind: StopKind::Path,
    });
    let mut replies = vec![];
    for _ in 0..5 {
        replies.push(c.begin(by(1.0)));
        if replies.last() == Some(&Reply::Accepted) {
            break;
        }
    }
    let refused = Reply::Refused(Refusal::WrongState {
        state: NodeState::Moving,
    });
    let Some((Reply::Accepted, before)) = replies.split_last() else {
        panic!("{replies:?}")
    };
    // a macrostep is longer than the work
    assert!(
        before.len() <= 1 && before.iter().all(|r| *r == refused),
        "{replies:?}"
    );
    c.finish("a move");
}
