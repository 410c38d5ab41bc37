use super::*;
use crate::frame::Id;
use crate::id::{NodeId, Port, Priority, Subject};
use crate::time::Micros;
use proptest::prelude::*;
use std::vec::Vec;

fn id() -> CanId {
    CanId {
        priority: Priority::Nominal,
        source: NodeId::new(42).unwrap(),
        port: Port::Message(Subject::new(1234).unwrap()),
    }
}

fn frames(mtu: Mtu, transfer_id: u8, payload: &[u8]) -> Vec<Frame> {
    Transmitter::new(id(), TransferId::new(transfer_id), mtu, payload).collect()
}

fn accept<const N: usize>(receiver: &mut Receiver<N>, frame: &Frame, at: u64) -> Option<Vec<u8>> {
    let id = CanId::parse(frame.id()).unwrap();
    receiver
        .accept(id, frame.data(), Micros(at))
        .map(|t| t.payload.to_vec())
}

#[test]
fn the_standards_examples() {
    // Cyphal Specification v1.0, 4.2.3: the string of 18 bytes "Hello world!" style transfers are
    // checked by their rules: single-frame heartbeat, transfer-id 0 -> tail 0xE0.
    let heartbeat = frames(Mtu::Classic, 0, &[0, 0, 0, 0, 4, 1, 0]);
    assert_eq!(heartbeat.len(), 1);
    assert_eq!(heartbeat[0].data(), [0, 0, 0, 0, 4, 1, 0, 0xE0]);
    // An empty request is its tail byte alone.
    assert_eq!(frames(Mtu::Classic, 1, &[])[0].data(), [0xE1]);
    assert_eq!(frames(Mtu::Fd, 1, &[])[0].data(), [0xE1]);
    // FD: 15 bytes and tail need no padding, 16 bytes and tail are padded to 20.
    assert_eq!(frames(Mtu::Fd, 0, &[9; 15])[0].data().len(), 16);
    let padded = frames(Mtu::Fd, 0, &[9; 16]);
    assert_eq!(padded[0].data(), [&[9; 16][..], &[0, 0, 0, 0xE0]].concat());
}

#[test]
fn the_crc_may_be_split_between_two_frames() {
    // 13 + 2 = 15 = 7 + 7 + 1: the CRC's second byte travels alone.
    let payload: Vec<u8> = (0..13).collect();
    let frames = frames(Mtu::Classic, 7, &payload);
    let crc = CRC.checksum(&payload).to_be_bytes();
    assert_eq!(frames.len(), 3);
    assert_eq!(frames[0].data()[7], 0xA7); // start, toggle 1
    assert_eq!(frames[1].data()[6..], [crc[0], 0x07]); // toggle 0
    assert_eq!(frames[2].data(), [crc[1], 0x67]); // end, toggle 1
}

#[test]
fn check_value_of_the_crc() {
    assert_eq!(CRC.checksum(b"123456789"), 0x29B1);
}

#[test]
fn a_repeated_frame_and_a_repeated_transfer_are_dropped() {
    let mut receiver = Receiver::<2>::new();
    let transfer = frames(Mtu::Classic, 0, &[5; 20]);
    for (k, frame) in transfer.iter().enumerate() {
        let last = k == transfer.len() - 1;
        assert_eq!(accept(&mut receiver, frame, k as u64).is_some(), last);
        assert_eq!(accept(&mut receiver, frame, k as u64), None);
    }
    for frame in &transfer {
        assert_eq!(accept(&mut receiver, frame, 10), None);
    }
    assert_eq!(receiver.counters().transfers, 1);
    assert_eq!(
        receiver.counters().unexpected,
        2 * u32::try_from(transfer.len()).unwrap()
    );
}

#[test]
fn any_one_missing_frame_loses_the_transfer_but_not_the_next() {
    let transfer = frames(Mtu::Classic, 3, &[5; 40]);
    for missing in 0..transfer.len() {
        let mut receiver = Receiver::<2>::new();
        for (_, frame) in transfer.iter().enumerate().filter(|(k, _)| *k != missing) {
            assert_eq!(accept(&mut receiver, frame, 0), None);
        }
        let next = frames(Mtu::Classic, 4, &[6; 40]);
        let received = next
            .iter()
            .find_map(|frame| accept(&mut receiver, frame, 1));
        assert_eq!(received, Some([6; 40].to_vec()), "missing {missing}");
    }
}

#[test]
fn the_same_transfer_id_is_new_again_after_two_seconds() {
    let mut receiver = Receiver::<2>::new();
    let transfer = &frames(Mtu::Classic, 3, &[5])[0];
    assert!(accept(&mut receiver, transfer, 0).is_some());
    assert!(accept(&mut receiver, transfer, 2_000_000).is_none());
    assert!(accept(&mut receiver, transfer, 2_000_001).is_some());
}

#[test]
fn lost_transfers_are_counted() {
    let mut receiver = Receiver::<2>::new();
    for tid in [0, 1, 4, 5] {
        assert!(accept(&mut receiver, &frames(Mtu::Fd, tid, &[5])[0], 0).is_some());
    }
    assert_eq!(receiver.counters().lost, 2);
}

#[test]
fn a_transfer_that_is_too_long_is_given_up() {
    let mut receiver = Receiver::<1>::new();
    for frame in &frames(Mtu::Fd, 0, &[1; 400]) {
        assert_eq!(accept(&mut receiver, frame, 0), None);
    }
    assert_eq!(receiver.counters().aborted, 1);
}

#[test]
fn the_longest_silent_session_makes_room() {
    let mut receiver = Receiver::<2>::new();
    let data = [1, 0xE0];
    for (at, source) in [(0, 1), (1, 2), (2, 3)] {
        let id = CanId {
            source: NodeId::new(source).unwrap(),
            ..id()
        };
        assert!(receiver.accept(id, &data, Micros(at)).is_some());
    }
    assert_eq!(receiver.counters().evicted, 1);
    // Source 2 is still known: its duplicate is recognised.
    let two = CanId {
        source: NodeId::new(2).unwrap(),
        ..id()
    };
    assert!(receiver.accept(two, &data, Micros(3)).is_none());
}

proptest! {
    #[test]
    fn what_is_sent_is_received_and_padded_with_zeros(
        payload in proptest::collection::vec(any::<u8>(), 0..=MAX_TRANSFER - MAX_PADDING),
        fd in any::<bool>(),
        tid in 0u8..32,
    ) {
        let mtu = if fd { Mtu::Fd } else { Mtu::Classic };
        let mut receiver = Receiver::<4>::new();
        let mut received = None;
        for frame in frames(mtu, tid, &payload) {
            prop_assert!(received.is_none());
            prop_assert!(frame.data().len() <= mtu.bytes());
            received = accept(&mut receiver, &frame, 5);
        }
        let received = received.unwrap();
        prop_assert_eq!(received.len(), padded_length(payload.len(), mtu));
        let (head, padding) = received.split_at(payload.len());
        prop_assert_eq!(head, &payload[..]);
        prop_assert!(padding.len() <= MAX_PADDING && padding.iter().all(|b| *b == 0));
        prop_assert!(fd || padding.is_empty());
    }

    #[test]
    fn padding_is_idempotent(len in 0usize..400, fd in any::<bool>()) {
        let mtu = if fd { Mtu::Fd } else { Mtu::Classic };
        let once = padded_length(len, mtu);
        prop_assert!(once >= len && once <= len + MAX_PADDING);
        prop_assert_eq!(padded_length(once, mtu), once);
    }

    #[test]
    fn no_sequence_of_frames_upsets_the_receiver(
        input in proptest::collection::vec(
            (0u32..=0x1FFF_FFFF, proptest::collection::vec(any::<u8>(), 0..=64), 0u64..3_000_000),
            0..80,
        ),
    ) {
        let mut receiver = Receiver::<3>::new();
        let mut now = 0;
        for (bits, data, after) in input {
            now += after;
            // Few sources and ports, so that sessions are really hit.
            let Some(id) = CanId::parse(Id::Extended(bits & 0x0200_0303)) else { continue };
            if let Some(transfer) = receiver.accept(id, &data, Micros(now)) {
                prop_assert!(transfer.payload.len() <= MAX_TRANSFER + 2);
            }
        }
    }

    /// Of the payload; the tail byte itself is guarded by CAN's CRC and by [`crate::e2e`] only.
    #[test]
    fn one_flipped_bit_never_passes_in_a_long_transfer(
        payload in proptest::collection::vec(any::<u8>(), 62..=200),
        bit in any::<prop::sample::Index>(),
    ) {
        let mut receiver = Receiver::<1>::new();
        let sent = frames(Mtu::Classic, 0, &payload);
        let bits: usize = sent.iter().map(|f| (f.data().len() - 1) * 8).sum();
        let mut at = bit.index(bits);
        for frame in &sent {
            let mut data = frame.data().to_vec();
            let bits = (data.len() - 1) * 8;
            if at < bits {
                data[at / 8] ^= 1 << (at % 8);
                at = usize::MAX;
            } else if at != usize::MAX {
                at -= bits;
            }
            prop_assert!(receiver.accept(id(), &data, Micros(0)).is_none());
        }
    }
}
