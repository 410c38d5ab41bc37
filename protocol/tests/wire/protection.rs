//! No damage of one or two bits to a protected message passes unnoticed.

use super::{bytes::bytes, samples};
use protocol::codec::Payload;
use protocol::e2e::{HEADER, data_id, protect, verify};
use protocol::id::{CanId, NodeId, Port, Priority, Subject};
use protocol::transfer::{Mtu, padded_length};
use std::fmt::Debug;

const EPOCH: u32 = 9;

fn id(subject: Subject) -> CanId {
    CanId {
        priority: Priority::Fast,
        source: NodeId::MP,
        port: Port::Message(subject),
    }
}

/// As the endpoint sends it on CAN FD: header, message, padding.
fn protected<M: Payload + PartialEq + Debug>(id: CanId, message: &M) -> Vec<u8> {
    let mut all = vec![0; HEADER];
    all.extend(bytes(message));
    all.resize(padded_length(all.len(), Mtu::Fd), 0);
    protect(data_id(id, EPOCH), 200, &mut all);
    assert_eq!(verify(data_id(id, EPOCH), &all).map(|v| v.0), Some(200));
    all
}

fn every_double_error_is_found(id: CanId, mut all: Vec<u8>) {
    let id = data_id(id, EPOCH);
    let bits = all.len() * 8;
    let flip = |all: &mut [u8], bit: usize| all[bit / 8] ^= 1 << (bit % 8);
    for first in 0..bits {
        flip(&mut all, first);
        assert!(verify(id, &all).is_none(), "bit {first}");
        for second in 0..first {
            flip(&mut all, second);
            assert!(verify(id, &all).is_none(), "bits {first} and {second}");
            flip(&mut all, second);
        }
        flip(&mut all, first);
    }
}

#[test]
fn commands() {
    let id = id(Subject::command(NodeId::effector(1).unwrap()));
    for (_, command) in samples::commands() {
        every_double_error_is_found(id, protected(id, &command));
    }
}

#[test]
fn feedbacks() {
    for (_, feedback) in samples::feedbacks() {
        let id = id(Subject::FEEDBACK);
        every_double_error_is_found(id, protected(id, &feedback));
    }
}

#[test]
fn stops_and_time() {
    for (_, stop) in samples::stops() {
        let id = id(Subject::STOP_ALL);
        every_double_error_is_found(id, protected(id, &stop));
    }
    for (_, sync) in samples::syncs() {
        let id = id(Subject::TIME_SYNC);
        every_double_error_is_found(id, protected(id, &sync));
    }
}

#[test]
fn requests() {
    for (_, request) in samples::requests() {
        let id = id(Subject::EVENT);
        every_double_error_is_found(id, protected(id, &request));
    }
}

/// A message that is whole but from another node, of another subject, or of another lease.
#[test]
fn what_belongs_elsewhere_is_found() {
    let ours = id(Subject::FEEDBACK);
    let all = protected(ours, &samples::feedbacks()[3].1);
    let elsewhere = [
        CanId {
            source: NodeId::new(12).unwrap(),
            ..ours
        },
        id(Subject::EVENT),
        id(Subject::STOP_ALL),
    ];
    for other in elsewhere {
        assert!(verify(data_id(other, EPOCH), &all).is_none(), "{other:?}");
    }
    for epoch in (0..1000).filter(|epoch| *epoch != EPOCH) {
        let same = data_id(ours, epoch) == data_id(ours, EPOCH);
        assert_eq!(verify(data_id(ours, epoch), &all).is_some(), same);
    }
}
