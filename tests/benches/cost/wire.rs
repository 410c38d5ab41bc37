//! Messages to frames and back, as both ends of the MP wire do it; and the length of a frame.

use crate::timing::{Cost, Mode, Pieces};
use protocol::budget::exact;
use protocol::frame::{Frame, Id};
use protocol::id::NodeId;
use protocol::link::{Endpoint, Role};
use protocol::message::{Command, Coordination, Feedback, KnotMessage, NodeState, Progress, Space};
use protocol::time::Micros;
use protocol::transfer::Mtu;
use std::hint::black_box;

/// Too short for the clock: so many make one piece of work.
const UNITS: u32 = 64;
/// Pieces of work.
const PIECES: u64 = 200;

/// Both ends of the wire.
struct Ends {
    mp: Endpoint<16>,
    node: Endpoint<8>,
    robot: NodeId,
    wire: Vec<Frame>,
    now: Micros,
}

/// Which way a message goes.
enum Way<'m> {
    ToNode(&'m Command),
    ToMp(&'m Feedback),
}

impl Ends {
    fn new(mtu: Mtu) -> Self {
        let robot = NodeId::effector(1).expect("a robot");
        let mut node = Endpoint::new(robot, Role::Node, mtu);
        node.set_lease(EPOCH);
        let mp = Endpoint::new(NodeId::MP, Role::Coordinator, mtu);
        Self {
            mp,
            node,
            robot,
            wire: Vec::with_capacity(64),
            now: Micros(0),
        }
    }

    fn send(&mut self, way: &Way<'_>) {
        self.wire.clear();
        let wire = &mut self.wire;
        match way {
            Way::ToNode(command) => self
                .mp
                .send_command(self.robot, command, &mut |f| wire.push(f)),
            Way::ToMp(feedback) => self.node.send_feedback(feedback, &mut |f| wire.push(f)),
        }
        .expect("a message that the types allow");
    }

    fn hear(&mut self, way: &Way<'_>) {
        self.now = self.now + Micros::from_millis(20);
        let (mp, node, now) = (&mut self.mp, &mut self.node, self.now);
        let heard = self.wire.iter().filter(|frame| {
            let incoming = match way {
                Way::ToNode(_) => node.receive(frame, now),
                Way::ToMp(_) => mp.receive(frame, now),
            };
            black_box(incoming).is_some()
        });
        assert_eq!(heard.count(), 1, "one message was sent");
    }
}

const EPOCH: u32 = 7;

/// The image of six axes in motion.
fn feedback() -> Feedback {
    let each = |scale: i32| (0..6).map(move |k| scale * (k - 3));
    Feedback {
        step: 123_456,
        sampled_at: Micros(246_912_000),
        state: NodeState::Moving,
        fault: None,
        synchronised: 0x3F,
        epoch: EPOCH,
        instruction: 12,
        progress: Progress::Running,
        horizon_us: 20_000,
        actual: each(400_000).map(i64::from).collect(),
        demand: each(400_010).map(i64::from).collect(),
        current_ma: each(700).filter_map(|ma| i16::try_from(ma).ok()).collect(),
        following_error: (0..6).map(|k| 100 * k).collect(),
        limit_violations: 0,
        acceleration_step: 0.0,
        lost: 0,
        force_n: None,
    }
}

/// A knot of six axes, as under tight coordination.
fn command() -> Command {
    let knot = KnotMessage {
        at: Micros(12_345_678),
        space: Space::Joints,
        position: (0..6).map(|k| f64::from(k) * 0.25 - 0.5).collect(),
        velocity: (0..6_u8).map(|k| f32::from(k) * 0.125).collect(),
        acceleration: (0..6_u8).map(|k| -f32::from(k)).collect(),
    };
    Command {
        epoch: EPOCH,
        sequence: 515,
        valid_until: Micros(1_000_000_000),
        coordination: Coordination::Tight(knot),
    }
}

pub(crate) fn cost(name: &str, mode: Mode) -> Cost {
    let (feedback, command) = (feedback(), command());
    let mtu = if name.contains("-classic") {
        Mtu::Classic
    } else {
        Mtu::Fd
    };
    let way = if name.starts_with("command") {
        Way::ToNode(&command)
    } else {
        Way::ToMp(&feedback)
    };
    let mut ends = Ends::new(mtu);
    match name {
        _ if name.ends_with("-length") => {
            let data = [0x00, 0x12, 0xFF, 0xFF, 0x34, 0x56, 0x78, 0x00];
            let frame = Frame::classic(Id::Standard(0x203), &data).expect("eight bytes");
            repeat(mode, || {
                black_box(exact(black_box(&frame)));
            })
        }
        _ => repeat(mode, || {
            ends.send(&way);
            ends.hear(&way);
        }),
    }
}

fn repeat(mode: Mode, mut unit: impl FnMut()) -> Cost {
    let mut pieces = Pieces::default();
    for _ in 0..mode.repeats() {
        pieces.again();
        for _ in 0..PIECES {
            pieces.time(|| (0..UNITS).for_each(|_| unit()));
        }
    }
    pieces.cost(UNITS)
}
