//! A servo step of a node with six axes: the wake-up that sends SYNC and the one that answers it.

use crate::capture::{Capture, Wake, capture, config, digest, task};
use crate::timing::{Cost, Mode, Pieces};
use firmware::Node;
use host::program::Segment;
use protocol::message::{NodeState, ServoLaw};
use protocol::time::Micros;
use robots::{Irp6Postument, RobotKind};

const KINDS: [RobotKind; 1] = [RobotKind::Irp6Postument];
/// More frames than a wake-up sends.
const MOST_FRAMES: usize = 64;

/// Which steps of a run count.
#[derive(Clone, Copy)]
enum Kept {
    Holding,
    Joints,
    Line,
}

impl Kept {
    fn is(self, capture: &Capture, wake: &Wake) -> bool {
        let moving = wake.state == NodeState::Moving;
        match (self, capture.segment(wake.now)) {
            (Self::Holding, _) => wake.state == NodeState::Holding,
            (Self::Joints, Segment::Joints { .. }) | (Self::Line, Segment::Line { .. }) => moving,
            _ => false,
        }
    }
}

pub(crate) fn cost(name: &str, mode: Mode) -> Cost {
    let (law, kept) = match name {
        "node-csp-hold" => (ServoLaw::DrivePosition, Kept::Holding),
        "node-csp-joints" => (ServoLaw::DrivePosition, Kept::Joints),
        "node-csp-line" => (ServoLaw::DrivePosition, Kept::Line),
        "node-cst-original-line" => (ServoLaw::Original, Kept::Line),
        "node-cst-feed-forward-line" => (ServoLaw::FeedForward, Kept::Line),
        other => unreachable!("no workload {other}"),
    };
    let capture = capture(&KINDS, law);
    let config = config(&Irp6Postument, &task(&KINDS, law).cell, 0);
    let mut pieces = Pieces::default();
    for _ in 0..mode.repeats() {
        pieces.again();
        let mut node = Node::new(Micros(0), Irp6Postument, config).expect("a node");
        let (pairs, rest) = capture.wakes.as_chunks::<2>();
        assert!(rest.len() < 2, "SYNC and servo step take turns");
        for [sync, servo] in pairs {
            let mut at_sync = Vec::with_capacity(MOST_FRAMES);
            let mut at_servo = Vec::with_capacity(MOST_FRAMES);
            let mut step = || {
                node.step(sync.now, &sync.rx, &mut |_, frame| at_sync.push(frame));
                node.step(servo.now, &servo.rx, &mut |_, frame| at_servo.push(frame));
            };
            if kept.is(&capture, servo) {
                pieces.time(step);
            } else {
                step();
            }
            let as_recorded = digest(&at_sync) == sync.sent && digest(&at_servo) == servo.sent;
            assert!(
                as_recorded,
                "{name}: other frames than in the run at {:?}",
                sync.now
            );
        }
    }
    pieces.cost(1)
}
