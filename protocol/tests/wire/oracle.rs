//! Our frames against those of pycyphal 1.27.1, the Cyphal project's own implementation (MIT).
//!
//! `golden/pycyphal.hex` was written once by its `serialize_transfer` for the payloads below; it is
//! not blessed by us. Each line: wire/payload length/frame number, identifier, data.

use super::golden::{frame_bytes, hex};
use protocol::frame::{Frame, Id};
use protocol::id::{CanId, NodeId, Port, Priority, Service, Subject};
use protocol::time::Micros;
use protocol::transfer::{Mtu, Receiver, TransferId, Transmitter};
use std::collections::BTreeMap;

const LINES: &str = include_str!("../golden/pycyphal.hex");

fn payload(len: usize) -> Vec<u8> {
    (0..len)
        .map(|k| u8::try_from((k * 7 + len) % 256).unwrap())
        .collect()
}

fn identifier(len: usize) -> CanId {
    let node = |id| NodeId::new(id).unwrap();
    let (priority, source, port) = match len % 3 {
        0 => (Priority::High, 11, Port::Message(Subject::FEEDBACK)),
        1 => (
            Priority::Nominal,
            1,
            Port::Request(Service::REQUEST, node(11)),
        ),
        _ => (
            Priority::Optional,
            127,
            Port::Response(Service::GET_INFO, node(1)),
        ),
    };
    CanId {
        priority,
        source: node(source),
        port,
    }
}

fn mtu(name: &str) -> Mtu {
    match name {
        "classic" => Mtu::Classic,
        _ => Mtu::Fd,
    }
}

/// The frames of each transfer, by wire and length.
fn transfers() -> BTreeMap<(&'static str, usize), Vec<&'static str>> {
    let mut transfers: BTreeMap<_, Vec<_>> = BTreeMap::new();
    for line in LINES.lines() {
        let (name, hex) = line.split_once(' ').unwrap();
        let mut parts = name.split('/');
        let key = (
            parts.next().unwrap(),
            parts.next().unwrap().parse().unwrap(),
        );
        transfers.entry(key).or_default().push(hex);
    }
    transfers
}

#[test]
fn we_send_the_same_frames() {
    let transfers = transfers();
    assert_eq!(transfers.len(), 60);
    for ((name, len), expected) in transfers {
        let payload = payload(len);
        let id = TransferId::new(u8::try_from(len % 32).unwrap());
        let ours: Vec<String> = Transmitter::new(identifier(len), id, mtu(name), &payload)
            .map(|frame| hex(&frame_bytes(&frame)))
            .collect();
        assert_eq!(ours, expected, "{name}, {len} bytes");
    }
}

#[test]
fn we_understand_its_frames() {
    for ((name, len), frames) in transfers() {
        let mut receiver = Receiver::<1>::new();
        let mut payload = payload(len);
        let mut received = None;
        for text in frames {
            assert!(received.is_none());
            let bytes: Vec<u8> = (0..text.len() / 2)
                .map(|k| u8::from_str_radix(&text[2 * k..2 * k + 2], 16).unwrap())
                .collect();
            let (id, data) = bytes.split_at(4);
            let id = Id::Extended(u32::from_be_bytes(id.try_into().unwrap()));
            let frame = match mtu(name) {
                Mtu::Classic => Frame::classic(id, data),
                Mtu::Fd => Frame::fd(id, data),
            };
            let frame = frame.unwrap();
            let id = CanId::parse(frame.id()).unwrap();
            assert_eq!(id, identifier(len));
            received = receiver
                .accept(id, frame.data(), Micros(0))
                .map(|t| t.payload.to_vec());
        }
        let received = received.unwrap();
        payload.resize(received.len(), 0); // its padding
        assert_eq!(received, payload, "{name}, {len} bytes");
    }
}
