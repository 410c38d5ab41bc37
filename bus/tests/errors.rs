//! Errors on a virtual wire, their confinement, and finite mailboxes.

use bus::wire::confinement::{Counters, State};
use bus::wire::{Delivery, Disturbance, Fault, Kind, Outbox, Tap, Taps, Wire};
use proptest::prelude::*;
use protocol::budget::{self, Rates};
use protocol::frame::{Frame, Id};

const MICROSECOND: u64 = 1000;
/// Error flag, delimiter and interframe space at 1 Mbit/s; flags that follow each other are twice as long.
const ERROR_NS: u64 = (6 + 8 + 3) * MICROSECOND;
const LONG_ERROR_NS: u64 = (12 + 8 + 3) * MICROSECOND;
/// What an error-passive sender lets pass after its frame.
const SUSPEND_NS: u64 = 8 * MICROSECOND;

fn frame(id: u16, data: &[u8]) -> Frame {
    Frame::classic(Id::Standard(id), data).unwrap()
}

fn length(frame: &Frame) -> u64 {
    Rates::CLASSIC_1M.duration_ns(budget::exact(frame))
}

/// To the end of the acknowledge slot: without its delimiter, end of frame and interframe space.
fn to_acknowledge(frame: &Frame) -> u64 {
    length(frame) - 11 * MICROSECOND
}

fn always(count: u32, disturbance: Disturbance) -> Fault {
    Fault {
        from_ns: 0,
        id: None,
        sender: None,
        count,
        disturbance,
    }
}

/// (time, identifier, taps reached) of all deliveries until `until_ns`.
fn run(wire: &mut Wire, taps: Tap, until_ns: u64) -> Vec<(u64, Id, Vec<Tap>)> {
    let mut log = Vec::new();
    wire.advance(until_ns, &mut |d: Delivery<'_>, _: &mut Outbox<'_>| {
        let reached = (0..taps).filter(|tap| d.reaches(*tap)).collect();
        log.push((d.at_ns, d.frame.id(), reached));
    });
    log
}

fn counters(transmit: u16, receive: u16) -> Counters {
    Counters { transmit, receive }
}

#[test]
fn a_destroyed_frame_is_sent_again_after_an_error_frame() {
    let sent = frame(0x123, &[1, 2, 3]);
    // the last bit that can be destroyed is the sixth of the end of frame: four bits before the last
    for (bit, bits_seen) in [(0, 1), (20, 21), (1000, length(&sent) / MICROSECOND - 4)] {
        let mut wire = Wire::new(Kind::Classic, 3);
        wire.disturb(always(1, Disturbance::Bit(bit)));
        wire.post(0, 0, sent).unwrap();
        let first = bits_seen * MICROSECOND + ERROR_NS;
        assert_eq!(wire.next_event_ns(), Some(first));
        assert!(run(&mut wire, 3, first).is_empty());
        assert_eq!(wire.counters(0), counters(8, 0));
        assert_eq!(
            (wire.counters(1), wire.counters(2)),
            (counters(0, 1), counters(0, 1))
        );
        let end = first + length(&sent);
        let log = run(&mut wire, 3, end);
        assert_eq!(log, [(end, sent.id(), vec![1, 2])], "bit {bit}");
        assert_eq!(
            (wire.counters(0), wire.counters(1)),
            (counters(7, 0), counters(0, 0))
        );
        let statistics = wire.statistics();
        assert_eq!((statistics.frames, statistics.errors), (1, 1));
        assert_eq!(
            (statistics.busy_ns, statistics.worst_latency_ns),
            (end, end)
        );
    }
}

/// At 5 Mbit/s a data bit takes 200 ns: an error in it comes later than in the arbitration, but not by a
/// whole nominal bit.
#[test]
fn an_error_in_fast_data_is_seen_at_the_fast_rate() {
    let sent = Frame::fd(Id::Extended(0x1234_5678), &[0x55; 64]).unwrap();
    let arbitration = u64::from(budget::exact(&sent).nominal) - 13;
    for (bit, at) in [
        (arbitration - 1, arbitration * MICROSECOND),
        (arbitration, arbitration * MICROSECOND + 200),
        (arbitration + 99, arbitration * MICROSECOND + 20_000),
    ] {
        let mut wire = Wire::new(Kind::Fd, 2);
        wire.disturb(always(1, Disturbance::Bit(u32::try_from(bit).unwrap())));
        wire.post(0, 0, sent).unwrap();
        assert_eq!(wire.next_event_ns(), Some(at + ERROR_NS));
    }
}

#[test]
fn a_receiver_that_sees_an_error_alone_destroys_the_frame_for_all_unless_it_is_passive() {
    let sent = frame(0x123, &[1, 2, 3]);
    let mut wire = Wire::new(Kind::Classic, 3);
    wire.disturb(always(20, Disturbance::BitAt { tap: 2, bit: 30 }));
    for _ in 0..20 {
        wire.post(0, 0, sent).unwrap();
    }
    let first = 31 * MICROSECOND + LONG_ERROR_NS;
    assert!(run(&mut wire, 3, first).is_empty());
    assert_eq!(wire.counters(0), counters(8, 0));
    assert_eq!(
        (wire.counters(1), wire.counters(2)),
        (counters(0, 1), counters(0, 9))
    );
    // 9 · 15 = 135 makes it passive: now it misses frames, the others have them
    let log = run(&mut wire, 3, 20_000_000);
    let missed = log.iter().filter(|(.., reached)| *reached == [1]).count();
    assert_eq!((log.len(), missed), (20, 5));
    assert_eq!(wire.statistics().errors, 15);
}

#[test]
fn who_is_alone_tries_for_ever_and_never_goes_bus_off() {
    let sent = frame(0x123, &[]);
    let mut wire = Wire::new(Kind::Classic, 2);
    wire.set_attached(1, false);
    wire.post(0, 0, sent).unwrap();
    let attempt = to_acknowledge(&sent) + ERROR_NS;
    assert!(run(&mut wire, 2, 16 * attempt).is_empty());
    assert_eq!(
        (wire.counters(0), wire.state(0)),
        (counters(128, 0), State::Passive)
    );
    assert_eq!(wire.statistics().errors, 16);
    // passive, it suspends transmission before each further try
    let later = 16 * attempt + 100 * (SUSPEND_NS + attempt);
    assert!(run(&mut wire, 2, later).is_empty());
    assert_eq!(
        (wire.statistics().errors, wire.counters(0)),
        (116, counters(128, 0))
    );
    wire.set_attached(1, true);
    let end = later + SUSPEND_NS + length(&sent);
    assert_eq!(run(&mut wire, 2, end), [(end, sent.id(), vec![1])]);
    assert_eq!(wire.state(0), State::Active);
}

/// A wire of three taps, the first of which has just gone bus-off; 10 ms have passed.
fn one_off(sent: Frame) -> Wire {
    let mut wire = Wire::new(Kind::Classic, 3);
    wire.disturb(Fault {
        id: Some(sent.id()),
        ..always(32, Disturbance::Bit(5))
    });
    wire.post(0, 0, sent).unwrap();
    run(&mut wire, 3, 10_000_000);
    assert_eq!(
        (wire.state(0), wire.counters(0).transmit),
        (State::BusOff, 256)
    );
    wire
}

#[test]
fn bus_off_ends_only_when_told_and_after_128_times_eleven_recessive_bits() {
    let (sent, other) = (frame(0x100, &[1]), frame(0x700, &[2]));
    let mut wire = one_off(sent);
    assert_eq!(
        (wire.statistics().errors, wire.statistics().bus_off),
        (32, 1)
    );
    // the others go on; it hears nothing, and its frame waits
    wire.post(1, 0, other).unwrap();
    let log = run(&mut wire, 3, 20_000_000);
    assert_eq!(log.len(), 1);
    assert_eq!(log[0].2, [2]);
    assert_eq!(wire.pending(0), 1);
    assert_eq!(wire.next_event_ns(), None);
    wire.recover(0);
    let back = 20_000_000 + 128 * 11 * MICROSECOND;
    run(&mut wire, 3, back - 1);
    assert_eq!(wire.state(0), State::BusOff);
    let end = back + length(&sent);
    assert_eq!(wire.next_event_ns(), Some(end));
    assert_eq!(run(&mut wire, 3, end), [(end, sent.id(), vec![1, 2])]);
    assert_eq!(
        (wire.state(0), wire.counters(0)),
        (State::Active, counters(0, 0))
    );
}

/// Each frame of others ends in eleven recessive bits; the idle time between them counts, too.
#[test]
fn recovery_counts_the_ends_of_frames() {
    let other = frame(0x700, &[]);
    let mut wire = one_off(frame(0x100, &[1]));
    wire.recover(0);
    wire.clear(0);
    for _ in 0..127 {
        wire.post(1, 10_000_000, other).unwrap();
    }
    let busy = 10_000_000 + 127 * length(&other);
    run(&mut wire, 3, busy);
    assert_eq!(wire.state(0), State::BusOff);
    run(&mut wire, 3, busy + 11 * MICROSECOND - 1);
    assert_eq!(wire.state(0), State::BusOff);
    run(&mut wire, 3, busy + 11 * MICROSECOND);
    assert_eq!(wire.state(0), State::Active);
}

#[test]
fn an_error_in_the_last_but_one_bit_makes_a_duplicate_or_an_omission() {
    let sent = frame(0x123, &[7]);
    for sender_dies in [false, true] {
        let mut wire = Wire::new(Kind::Classic, 3);
        wire.disturb(always(1, Disturbance::LastButOne(Taps::of(&[2]))));
        wire.post(0, 0, sent).unwrap();
        let mut log = run(&mut wire, 3, length(&sent) / 2);
        if sender_dies {
            wire.clear(0);
        }
        log.extend(run(&mut wire, 3, 10_000_000));
        let reached: Vec<Vec<Tap>> = log.into_iter().map(|(.., reached)| reached).collect();
        if sender_dies {
            assert_eq!(reached, [vec![1]], "tap 2 never has it");
        } else {
            assert_eq!(reached, [vec![1], vec![1, 2]], "tap 1 has it twice");
        }
    }
}

#[test]
fn with_one_mailbox_an_urgent_frame_waits_behind_those_that_were_posted_before() {
    let ids = [0x500, 0x400, 0x300, 0x001];
    for (mailboxes, order) in [
        (1, [0x500, 0x400, 0x300, 0x001]),
        (2, [0x400, 0x300, 0x001, 0x500]),
        (3, [0x300, 0x001, 0x400, 0x500]),
        (4, [0x001, 0x300, 0x400, 0x500]),
    ] {
        let mut wire = Wire::new(Kind::Classic, 2);
        wire.set_mailboxes(0, mailboxes);
        for id in ids {
            wire.post(0, 0, frame(id, &[])).unwrap();
        }
        let log = run(&mut wire, 2, 10_000_000);
        let sent: Vec<Id> = log.into_iter().map(|(_, id, _)| id).collect();
        assert_eq!(sent, order.map(Id::Standard), "{mailboxes} mailboxes");
    }
}

fn any_disturbance() -> impl Strategy<Value = Disturbance> {
    prop_oneof![
        (0..200u32).prop_map(Disturbance::Bit),
        (0..4usize, 0..200u32).prop_map(|(tap, bit)| Disturbance::BitAt { tap, bit }),
        (0..16u8).prop_map(|bits| {
            let taps: Vec<Tap> = (0..4).filter(|tap| bits >> tap & 1 == 1).collect();
            Disturbance::LastButOne(Taps::of(&taps))
        }),
    ]
}

fn any_fault() -> impl Strategy<Value = Fault> {
    let id = proptest::option::of(0..32u16);
    let sender = proptest::option::of(0..4usize);
    (0..3_000_000u64, id, sender, 1..5u32, any_disturbance()).prop_map(
        |(from_ns, id, sender, count, disturbance)| Fault {
            from_ns,
            id: id.map(Id::Standard),
            sender,
            count,
            disturbance,
        },
    )
}

proptest! {
    /// At most 12 tries fail, so that nobody becomes passive (8 · 16) and every error is followed by
    /// another try: every frame posted is sent to its end and reaches everybody, and some twice. Time
    /// cut into pieces changes nothing.
    #[test]
    fn nothing_is_lost_without_a_reason(
        posts in proptest::collection::vec(
            (0usize..4, 0u64..3_000_000, 0u16..8, 0usize..=8), 1..40),
        faults in proptest::collection::vec(any_fault(), 0..4),
        mailboxes in 1usize..5,
        cuts in proptest::collection::vec(0u64..60_000_000, 0..20),
    ) {
        let fresh = || {
            let mut wire = Wire::new(Kind::Classic, 4);
            wire.set_mailboxes(1, mailboxes);
            for fault in &faults {
                wire.disturb(*fault);
            }
            for (tap, at, id, len) in &posts {
                // no two taps have an identifier in common
                let id = id | u16::try_from(*tap).unwrap() << 3;
                wire.post(*tap, *at, frame(id, &vec![0xA5; *len])).unwrap();
            }
            wire
        };
        let mut whole = fresh();
        let all = run(&mut whole, 4, 60_000_000);
        let pending: usize = (0..4).map(|tap| whole.pending(tap)).sum();
        prop_assert_eq!(pending, 0);
        let statistics = whole.statistics();
        prop_assert_eq!(usize::try_from(statistics.frames).unwrap(), posts.len());
        let failed: u32 = faults.iter().map(|fault| fault.count).sum();
        prop_assert!(statistics.errors <= u64::from(failed));
        for tap in 0..4 {
            prop_assert_eq!(whole.state(tap), State::Active);
            let own = posts.iter().filter(|post| post.0 == tap).count();
            let reached = all.iter().filter(|(.., reached)| reached.contains(&tap)).count();
            let twice = usize::try_from(statistics.errors).unwrap();
            prop_assert!((posts.len() - own..=posts.len() - own + twice).contains(&reached));
        }
        let mut stepped = fresh();
        let mut cuts = cuts.clone();
        cuts.sort_unstable();
        let mut pieces = Vec::new();
        for cut in cuts.into_iter().chain([60_000_000]) {
            pieces.extend(run(&mut stepped, 4, cut));
        }
        prop_assert_eq!(&pieces, &all);
        prop_assert_eq!(stepped.statistics(), statistics);
    }
}
