//! A master that lets the robot move.

use super::bench::{Bench, node_id};
use protocol::id::NodeId;
use protocol::link::{Endpoint, Message, Role};
use protocol::message::{
    AxisSpeeds, Command, Coordination, Instruction, NodeState, Reply, Request, StopAll, StopKind,
};
use protocol::time::Micros;
use protocol::transfer::Mtu;

/// A master that lets the robot move, by raw requests.
pub(super) struct Master {
    pub(super) link: Endpoint<8>,
    pub(super) epoch: u32,
    pub(super) sequence: u16,
}

impl Master {
    pub(super) fn join(bench: &mut Bench) -> Self {
        let mut master = Self {
            link: Endpoint::new(NodeId::MP, Role::Coordinator, Mtu::Classic),
            epoch: 0,
            sequence: 0,
        };
        let acquire = Request::Acquire {
            nonce: 1,
            lease_ms: 2000,
            takeover: false,
        };
        match master.request(bench, &acquire) {
            Reply::Lease { epoch } => master.epoch = epoch,
            other => panic!("{other:?}"),
        }
        master
    }

    pub(super) fn request(&mut self, bench: &mut Bench, request: &Request) -> Reply {
        let mut frames = Vec::new();
        let out = &mut |frame| frames.push(frame);
        let id = self.link.send_request(node_id(), request, out).unwrap();
        for frame in frames {
            bench.cell.send(frame);
        }
        for _ in 0..100 {
            let until = bench.cell.now() + Micros::from_millis(2);
            bench.cell.advance(until, &mut ());
            let arrived: Vec<_> = bench.cell.receive().collect();
            for (at, frame) in arrived {
                if let Some(incoming) = self.link.receive(&frame, at)
                    && let Message::Reply { transfer_id, reply } = incoming.message
                    && transfer_id == id
                {
                    return reply;
                }
            }
        }
        panic!("no answer to {request:?}");
    }

    pub(super) fn demand(&mut self, bench: &mut Bench, request: &Request) {
        assert_eq!(self.request(bench, request), Reply::Accepted, "{request:?}");
    }

    /// Keeps the lease for a while.
    pub(super) fn hold(&mut self, bench: &mut Bench, ms: u64) {
        for _ in 0..ms / 50 {
            self.sequence += 1;
            let command = Command {
                epoch: self.epoch,
                sequence: self.sequence,
                valid_until: Micros(u64::MAX),
                coordination: Coordination::None,
            };
            let mut frames = Vec::new();
            let out = &mut |frame| frames.push(frame);
            self.link.send_command(node_id(), &command, out).unwrap();
            for frame in frames {
                bench.cell.send(frame);
            }
            bench.run(50);
        }
    }

    pub(super) fn enable(&mut self, bench: &mut Bench) {
        let epoch = self.epoch;
        self.demand(bench, &Request::Enable { epoch });
        self.hold(bench, 500);
        assert_eq!(bench.state(), NodeState::Unsynchronised);
    }

    pub(super) fn start(&mut self, bench: &mut Bench) {
        let one = |value| std::iter::once(value).collect();
        let instruction = Instruction::MoveMotors {
            target: std::iter::once(500.0).collect(),
            relative: true,
            speeds: AxisSpeeds {
                velocity: one(0.5),
                acceleration: one(0.5),
            },
        };
        let execute = Request::Execute {
            epoch: self.epoch,
            id: 9,
            start_at: Micros(0),
            instruction,
        };
        self.demand(bench, &execute);
    }

    pub(super) fn stop_all(&mut self, bench: &mut Bench) {
        let kind = StopKind::Quick;
        let mut frames = Vec::new();
        let out = &mut |frame| frames.push(frame);
        self.link.send_stop_all(&StopAll { kind }, out).unwrap();
        for frame in frames {
            bench.cell.send(frame);
        }
    }
}
