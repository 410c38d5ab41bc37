//! Several nodes that send the same identifier at once.

use bus::wire::confinement::{Counters, State};
use bus::wire::{BusFault, Delivery, Disturbance, Fault, Kind, Outbox, Tap, Wire};
use proptest::prelude::*;
use protocol::budget::{self, Rates};
use protocol::frame::{Frame, Id};

/// A bit at 1 Mbit/s, ns.
const BIT: u64 = 1000;
/// Two flags one behind the other, delimiter, interframe space.
const ERROR_BITS: u64 = 12 + 8 + 3;

fn frame(id: u16, data: &[u8]) -> Frame {
    Frame::classic(Id::Standard(id), data).unwrap()
}

fn length(frame: &Frame) -> u64 {
    Rates::FD_1M_5M.duration_ns(budget::exact(frame))
}

/// (time, sender, taps reached) of all deliveries until `until_ns`.
fn run(wire: &mut Wire, taps: Tap, until_ns: u64) -> Vec<(u64, Tap, Vec<Tap>)> {
    let mut log = Vec::new();
    wire.advance(until_ns, &mut |d: Delivery<'_>, _: &mut Outbox<'_>| {
        let reached = (0..taps).filter(|tap| d.reaches(*tap)).collect();
        log.push((d.at_ns, d.from, reached));
    });
    log
}

fn counters(transmit: u16, receive: u16) -> Counters {
    Counters { transmit, receive }
}

/// What tap 0 and tap 1 send: they differ in the first bit of their data, which tap 1 sends recessive.
fn pair() -> [Frame; 2] {
    [frame(0x100, &[0x00]), frame(0x100, &[0x80])]
}

/// Of [`pair`]: 19 bits in front of the data, and two put in behind five equal ones (00100000 000, then 000 and 0001).
const DIFFERENT_BIT: u64 = 21;

#[test]
fn two_that_differ_destroy_each_other_until_both_are_passive_and_then_go_one_by_one() {
    let [dominant, recessive] = pair();
    let mut wire = Wire::new(Kind::Classic, 3);
    wire.post(1, 0, recessive).unwrap();
    wire.post(0, 0, dominant).unwrap();
    let attempt = (DIFFERENT_BIT + 1 + ERROR_BITS) * BIT;
    assert_eq!(wire.next_event_ns(), Some(attempt));
    assert!(run(&mut wire, 3, attempt).is_empty());
    assert_eq!(
        [0, 1, 2].map(|tap| wire.counters(tap)),
        [counters(8, 0), counters(8, 0), counters(0, 1)]
    );
    assert!(run(&mut wire, 3, 16 * attempt).is_empty());
    assert_eq!(
        [0, 1, 2].map(|tap| wire.counters(tap)),
        [counters(128, 0), counters(128, 0), counters(0, 16)]
    );
    // both suspend their transmission for 8 bits; nobody sees the flag of the one whose bit is not on the wire
    let first = 16 * attempt + 8 * BIT + length(&dominant);
    assert_eq!(run(&mut wire, 3, first), [(first, 0, vec![2])]);
    assert_eq!(
        [0, 1, 2].map(|tap| wire.counters(tap)),
        [counters(127, 0), counters(136, 0), counters(0, 15)]
    );
    // its flag ends in the end of frame: six bits later than for the others it may begin to be silent for 8
    let second = first + 14 * BIT + length(&recessive);
    assert_eq!(run(&mut wire, 3, second), [(second, 1, vec![0, 2])]);
    assert_eq!([0, 1].map(|tap| wire.pending(tap)), [0, 0]);
    let statistics = wire.statistics();
    assert_eq!(
        (statistics.collisions, statistics.errors, statistics.frames),
        (17, 16, 2)
    );
    assert_eq!(statistics.bus_off, 0);
}

#[test]
fn an_error_passive_sender_lets_the_active_one_go_first_when_its_own_bit_won() {
    let [dominant, recessive] = pair();
    let mut wire = Wire::new(Kind::Classic, 3);
    // 16 destroyed tries of its own make tap 0 passive, and its 17th meets that of tap 1
    wire.disturb(Fault {
        from_ns: 0,
        id: None,
        sender: Some(0),
        count: 16,
        disturbance: Disturbance::Bit(0),
    });
    let passive = 16 * (1 + 17) * BIT;
    wire.post(0, 0, dominant).unwrap();
    assert!(run(&mut wire, 3, passive).is_empty());
    assert_eq!(wire.state(0), State::Passive);
    wire.post(1, passive + 8 * BIT, recessive).unwrap();
    let destroyed = passive + (8 + DIFFERENT_BIT + 1 + ERROR_BITS) * BIT;
    let first = destroyed + length(&recessive);
    let second = first + length(&dominant);
    assert_eq!(
        run(&mut wire, 3, second),
        [(first, 1, vec![0, 2]), (second, 0, vec![1, 2])]
    );
    assert_eq!(wire.statistics().collisions, 1);
    assert_eq!(wire.counters(0).transmit, 128 + 8 - 1);
}

#[test]
fn frames_alike_are_one_frame_which_somebody_else_must_acknowledge() {
    let sent = frame(0x100, &[1, 2, 3]);
    let mut wire = Wire::new(Kind::Classic, 3);
    for tap in [1, 0] {
        wire.post(tap, 0, sent).unwrap();
    }
    let end = length(&sent);
    assert_eq!(wire.next_event_ns(), Some(end));
    assert_eq!(run(&mut wire, 3, 10_000_000), [(end, 0, vec![2])]);
    assert_eq!([0, 1].map(|tap| wire.pending(tap)), [0, 0]);
    let statistics = wire.statistics();
    assert_eq!(
        (statistics.collisions, statistics.errors, statistics.frames),
        (1, 0, 1)
    );
    assert!(wire.is_plain());

    let mut alone = Wire::new(Kind::Classic, 2);
    for tap in [0, 1] {
        alone.post(tap, 0, sent).unwrap();
    }
    assert!(run(&mut alone, 2, 10_000_000).is_empty());
    // 16 unacknowledged tries make passive, and no more is counted; they go on trying
    assert_eq!([0, 1].map(|tap| alone.counters(tap)), [counters(128, 0); 2]);
    assert!(alone.statistics().errors > 32);
    assert_eq!(alone.statistics().frames, 0);
}

#[test]
fn who_collides_with_ever_new_frames_goes_off_the_bus() {
    let [dominant, recessive] = pair();
    let mut wire = Wire::new(Kind::Classic, 3);
    wire.post(0, 0, dominant).unwrap();
    wire.post(1, 0, recessive).unwrap();
    let mut through = 0;
    wire.advance(100_000_000, &mut |d: Delivery<'_>, out: &mut Outbox<'_>| {
        assert_eq!(d.from, 0);
        through += 1;
        // just when the other is through with its flag and its silence
        out.post_at(0, d.at_ns + 14 * BIT, dominant).unwrap();
    });
    // 8 · 16 by error frames, 8 · 16 by frames of the other: 256 is off, and tap 0 goes on by itself
    assert_eq!(wire.statistics().errors, 16);
    assert_eq!(wire.statistics().collisions, 32);
    assert_eq!(
        [0, 1].map(|tap| wire.state(tap)),
        [State::Active, State::BusOff]
    );
    assert!(through > 100, "{through}");
    assert_eq!((wire.pending(1), wire.statistics().bus_off), (1, 1));
}

#[test]
fn an_fd_frame_loses_against_a_classical_one_where_it_says_that_it_is_one() {
    let fd = Frame::fd(Id::Standard(0x100), &[0x00]).unwrap();
    let classic = frame(0x100, &[0xFF]);
    let mut wire = Wire::new(Kind::Fd, 3);
    wire.post(0, 0, fd).unwrap();
    wire.post(1, 0, classic).unwrap();
    // start, identifier, remote request, format: 14 bits and one behind the five zeros of the identifier, one in front of FDF
    let attempt = (16 + 1 + ERROR_BITS) * BIT;
    assert!(run(&mut wire, 3, attempt - 1).is_empty());
    assert_eq!(wire.counters(0), counters(0, 0));
    run(&mut wire, 3, attempt);
    assert_eq!(wire.counters(0), counters(8, 0));
    let log = run(&mut wire, 3, 10_000_000);
    let senders: Vec<Tap> = log.iter().map(|(_, from, _)| *from).collect();
    assert_eq!(senders, [1, 0]);
}

/// Equal FD frames of an error-active and an error-passive node differ in the bit that tells it.
#[test]
fn equal_fd_frames_of_an_active_and_a_passive_node_are_two() {
    let sent = Frame::fd(Id::Standard(0x2AA), &[0x55; 8]).unwrap();
    let mut wire = Wire::new(Kind::Fd, 3);
    wire.disturb(Fault {
        from_ns: 0,
        id: None,
        sender: Some(1),
        count: 16,
        disturbance: Disturbance::Bit(0),
    });
    wire.post(1, 0, sent).unwrap();
    let passive = 16 * (1 + 17) * BIT;
    run(&mut wire, 3, passive);
    wire.post(0, passive + 8 * BIT, sent).unwrap();
    let first = passive + 8 * BIT + length(&sent);
    let second = first + 14 * BIT + length(&sent);
    assert_eq!(
        run(&mut wire, 3, 10_000_000),
        [(first, 0, vec![2]), (second, 1, vec![0, 2])]
    );
    assert_eq!(wire.counters(1).transmit, 128 + 8 - 1);
}

#[test]
fn a_wrecked_sender_wrecks_what_it_sends_together_with_another() {
    let sent = frame(0x100, &[0x55; 8]);
    let mut wire = Wire::new(Kind::Classic, 3);
    wire.set_bus_fault(Some(BusFault::Wrecked(1)));
    wire.post(0, 0, sent).unwrap();
    wire.post(1, 0, sent).unwrap();
    run(&mut wire, 3, 10_000_000);
    // together until both are passive and on to the end: 32 tries
    assert_eq!([0, 1].map(|tap| wire.state(tap)), [State::BusOff; 2]);
    assert_eq!(wire.statistics().errors, 32);
}

proptest! {
    /// Three that begin at once: if they are not all alike, 16 tries are destroyed and then no more; each frame gets to the
    /// listener, those alike once. In whatever pieces time passes.
    #[test]
    fn every_collision_ends(
        data in proptest::collection::vec((any::<bool>(), proptest::collection::vec(prop_oneof![Just(0x55), any::<u8>()], 0..=2)), 3),
        extended in any::<bool>(),
        cuts in proptest::collection::vec(0u64..3_000_000, 0..20),
    ) {
        let id = if extended { Id::Extended(0x1555_5555) } else { Id::Standard(0x555) };
        let frames: Vec<Frame> = data
            .iter()
            .map(|(fd, data)| if *fd { Frame::fd(id, data) } else { Frame::classic(id, data) }.unwrap())
            .collect();
        let fresh = || {
            let mut wire = Wire::new(Kind::Fd, 4);
            for (tap, frame) in frames.iter().enumerate() {
                wire.post(tap, 0, *frame).unwrap();
            }
            wire
        };
        let mut whole = fresh();
        let mut heard = Vec::new();
        whole.advance(10_000_000, &mut |d: Delivery<'_>, _: &mut Outbox<'_>| {
            assert!(d.reaches(3));
            heard.push(*d.frame);
        });
        let alike = frames.iter().all(|frame| *frame == frames[0]);
        let statistics = whole.statistics();
        prop_assert_eq!(statistics.errors, if alike { 0 } else { 16 });
        prop_assert_eq!(statistics.bus_off, 0);
        for frame in &frames {
            prop_assert!(heard.contains(frame));
        }
        prop_assert!(heard.len() <= 3 && (0..3).all(|tap| whole.pending(tap) == 0));

        let mut pieces = fresh();
        let mut log = Vec::new();
        let mut cuts = cuts.clone();
        cuts.sort_unstable();
        for cut in cuts.into_iter().chain([10_000_000]) {
            let event = pieces.next_event_ns();
            let piece = run(&mut pieces, 4, cut);
            if let (Some((at, ..)), Some(event)) = (piece.first(), event) {
                prop_assert!(*at >= event);
            }
            log.extend(piece);
        }
        prop_assert_eq!(log, run(&mut fresh(), 4, 10_000_000));
        prop_assert_eq!(pieces.statistics(), statistics);
    }
}
