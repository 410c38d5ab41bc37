extern crate std;

use std::vec::Vec;

use super::master::{Master, Outcome, Progress, STORE_WINDOW, Task};
use super::*;
use crate::time::Micros;

const A: Identity = Identity {
    vendor: 1,
    product: 402,
    revision: 0x0001_0000,
    serial: 17,
};
const B: Identity = Identity { serial: 18, ..A };

fn node(id: u8) -> NodeId {
    NodeId::new(id).unwrap()
}

/// Slaves on a wire that needs no time, each with what it takes to answer.
struct Bus {
    slaves: Vec<(Slave, Micros)>,
    /// Refuses to store.
    forgetful: bool,
    due: Vec<(Micros, [u8; 8])>,
    now: Micros,
    sent: Vec<Frame>,
}

impl Bus {
    fn new(slaves: &[(Slave, u64)]) -> Self {
        Self {
            slaves: slaves
                .iter()
                .map(|(s, ms)| (*s, Micros::from_millis(*ms)))
                .collect(),
            forgetful: false,
            due: Vec::new(),
            now: Micros(0),
            sent: Vec::new(),
        }
    }

    /// One dialogue, looked at every millisecond, and when it ended.
    fn run(&mut self, master: &mut Master, task: Task) -> (Outcome, Micros) {
        assert!(master.begin(task));
        let began = self.now;
        for _ in 0..10_000 {
            match master.poll(self.now) {
                Progress::Send(frame) => self.hear(&frame),
                Progress::Wait => {}
                Progress::Done(outcome) => return (outcome, self.now.since(began)),
                Progress::Idle => panic!("forgot its task"),
            }
            self.now = self.now + Micros::from_millis(1);
            let now = self.now;
            let (ripe, later) = self.due.drain(..).partition(|(at, _)| *at <= now);
            self.due = later;
            let ripe: Vec<(Micros, [u8; 8])> = ripe;
            for (_, bytes) in ripe {
                master.on_answer(&bytes);
            }
        }
        panic!("no end");
    }

    fn hear(&mut self, frame: &Frame) {
        self.sent.push(*frame);
        for (slave, delay) in &mut self.slaves {
            let (answer, effect) = slave.on_request(frame.data());
            let refused = self.forgetful && effect == Some(Effect::Store);
            let answer = if refused {
                Some([cs::STORE, 1, 0, 0, 0, 0, 0, 0])
            } else {
                answer
            };
            self.due
                .extend(answer.map(|bytes| (self.now + *delay, bytes)));
        }
    }

    fn give(&mut self, identity: Identity, id: u8) -> Outcome {
        let node = node(id);
        self.run(&mut Master::new(), Task::Give { identity, node })
            .0
    }

    fn pending(&self) -> Vec<Option<u8>> {
        self.slaves
            .iter()
            .map(|(s, _)| s.pending().map(NodeId::get))
            .collect()
    }

    /// All are in waiting.
    fn rests(&self) -> bool {
        self.slaves.iter().all(|(s, _)| !s.is_configuration())
    }
}

#[test]
fn two_blank_devices_get_the_ids_of_their_names() {
    let mut bus = Bus::new(&[(Slave::new(B, None), 0), (Slave::new(A, None), 0)]);
    let (asked, took) = bus.run(&mut Master::new(), Task::Ask);
    assert_eq!(asked, Outcome::Somebody);
    // one window, and the millisecond in which it is looked at
    assert!((20..=22).contains(&(took.0 / 1000)), "{took:?}");
    assert_eq!(bus.give(A, 3), Outcome::Given { stored: true });
    assert_eq!(bus.pending(), [None, Some(3)]);
    assert_eq!(bus.run(&mut Master::new(), Task::Ask).0, Outcome::Somebody);
    assert_eq!(bus.give(B, 4), Outcome::Given { stored: true });
    assert_eq!(bus.pending(), [Some(4), Some(3)]);
    assert_eq!(bus.run(&mut Master::new(), Task::Ask).0, Outcome::Nobody);
    assert!(bus.rests());
}

#[test]
fn a_device_with_an_id_keeps_it() {
    let mut bus = Bus::new(&[(Slave::new(A, Some(node(9))), 0)]);
    assert_eq!(bus.give(A, 3), Outcome::Configured(node(9)));
    assert_eq!(bus.pending(), [Some(9)]);
    let changes = |frame: &&Frame| [0x11, 0x17].contains(&frame.data()[0]);
    assert_eq!(bus.sent.iter().find(changes), None);
    assert!(bus.rests());
}

#[test]
fn another_device_is_left_alone_and_found_by_a_scan() {
    let mut bus = Bus::new(&[(Slave::new(B, None), 0)]);
    assert_eq!(bus.give(A, 3), Outcome::Nobody);
    let (found, took) = bus.run(&mut Master::new(), Task::Scan);
    assert_eq!(found, Outcome::Found(B));
    // 133 questions of 20 ms, looked at once a millisecond
    assert!((2660..2960).contains(&(took.0 / 1000)), "{took:?}");
    assert_eq!(bus.pending(), [None]);
    assert!(bus.rests());
}

#[test]
fn on_an_empty_bus_every_task_ends() {
    let mut bus = Bus::new(&[]);
    assert_eq!(bus.give(A, 3), Outcome::Nobody);
    for task in [Task::Ask, Task::Scan] {
        let (outcome, took) = bus.run(&mut Master::new(), task);
        assert_eq!(outcome, Outcome::Nobody);
        assert!(took <= Micros::from_millis(30), "{task:?}: {took:?}");
    }
}

#[test]
fn two_devices_of_one_identity_get_nothing() {
    // the second answers later, in the same window
    let mut bus = Bus::new(&[(Slave::new(A, None), 0), (Slave::new(A, None), 7)]);
    assert_eq!(bus.give(A, 3), Outcome::Collision);
    assert_eq!(bus.pending(), [None, None]);
    assert!(bus.rests());
}

#[test]
fn an_answer_after_its_window_gives_nobody_an_id() {
    for late_ms in [25, 30, 45] {
        let mut bus = Bus::new(&[(Slave::new(A, None), late_ms)]);
        assert_eq!(bus.run(&mut Master::new(), Task::Ask).0, Outcome::Nobody);
        // "switched" comes while another is asked for
        let mut master = Master::new();
        let task = |identity, id| Task::Give {
            identity,
            node: node(id),
        };
        assert_eq!(bus.run(&mut master, task(A, 3)).0, Outcome::Nobody);
        assert_eq!(bus.run(&mut master, task(B, 4)).0, Outcome::Nobody);
        assert_eq!((bus.pending(), bus.rests()), ([None].to_vec(), true));
    }
}

#[test]
fn a_device_that_does_not_store_is_told_of() {
    let mut bus = Bus::new(&[(Slave::new(A, None), 0)]);
    bus.forgetful = true;
    assert_eq!(bus.give(A, 3), Outcome::Given { stored: false });
    assert_eq!(bus.pending(), [Some(3)]);
}

#[test]
fn storing_may_take_longer_than_other_answers() {
    let mut bus = Bus::new(&[(Slave::new(A, None), 0)]);
    let mut master = Master::new();
    assert!(master.begin(Task::Give {
        identity: A,
        node: node(3)
    }));
    let mut stored_at = None;
    for ms in 0..2000 {
        let now = Micros::from_millis(ms);
        bus.now = now;
        match master.poll(now) {
            Progress::Send(frame) => {
                if frame.data()[0] == cs::STORE {
                    stored_at = Some(ms);
                } else {
                    bus.hear(&frame);
                }
            }
            Progress::Wait | Progress::Idle => {}
            Progress::Done(outcome) => {
                assert_eq!(outcome, Outcome::Given { stored: true });
                let took = ms - stored_at.unwrap();
                // the answer after 300 ms, then the end of the dialogue
                assert!((300..=304).contains(&took), "{took}");
                assert!(took < STORE_WINDOW.0 / 1000);
                return;
            }
        }
        for (_, bytes) in bus.due.drain(..) {
            master.on_answer(&bytes);
        }
        if stored_at == ms.checked_sub(300) {
            master.on_answer(&[cs::STORE, 0, 0, 0, 0, 0, 0, 0]);
        }
    }
    panic!("no end");
}

#[test]
fn a_refused_id_is_told_with_its_error() {
    let mut master = Master::new();
    assert!(master.begin(Task::Give {
        identity: A,
        node: node(3)
    }));
    assert!(!master.begin(Task::Ask), "one dialogue at a time");
    let mut slave = Slave::new(A, None);
    for ms in 0..1000 {
        match master.poll(Micros::from_millis(ms)) {
            Progress::Send(frame) if frame.data()[0] == cs::NODE_ID => {
                master.on_answer(&[cs::NODE_ID, 1, 0, 0, 0, 0, 0, 0]);
            }
            Progress::Send(frame) => {
                if let (Some(bytes), _) = slave.on_request(frame.data()) {
                    master.on_answer(&bytes);
                }
            }
            Progress::Wait | Progress::Idle => {}
            Progress::Done(outcome) => return assert_eq!(outcome, Outcome::Refused(1)),
        }
    }
    panic!("no end");
}

#[test]
fn what_answers_nothing_is_ignored() {
    let mut master = Master::new();
    for specifier in 0..=255 {
        master.on_answer(&[specifier, 0, 0, 0, 0, 0, 0, 0]);
        master.on_answer(&[specifier]);
    }
    assert_eq!(master, Master::new());
    assert_eq!(master.poll(Micros(0)), Progress::Idle);
}
