//! What is wrong with a wire as a whole: who goes off the bus, when, and what comes after.

use bus::wire::confinement::State;
use bus::wire::{BusFault, Delivery, Disturbance, Fault, Kind, Outbox, Tap, Wire};
use proptest::prelude::*;
use protocol::budget::{self, Rates};
use protocol::frame::{Frame, Id};

/// A bit at 1 Mbit/s, ns.
const BIT: u64 = 1000;

fn frame(id: u16, data: &[u8]) -> Frame {
    Frame::classic(Id::Standard(id), data).unwrap()
}

fn length(frame: &Frame) -> u64 {
    Rates::CLASSIC_1M.duration_ns(budget::exact(frame))
}

/// (time, sender) of all deliveries until `until_ns`.
fn run(wire: &mut Wire, until_ns: u64) -> Vec<(u64, Tap)> {
    let mut log = Vec::new();
    wire.advance(until_ns, &mut |d: Delivery<'_>, _: &mut Outbox<'_>| {
        log.push((d.at_ns, d.from));
    });
    log
}

fn states(wire: &Wire, taps: Tap) -> Vec<State> {
    (0..taps).map(|tap| wire.state(tap)).collect()
}

#[test]
fn wrecking_one_node_sends_it_off_and_leaves_the_others_active() {
    let mut wire = Wire::new(Kind::Classic, 4);
    wire.set_bus_fault(Some(BusFault::Wrecked(2)));
    for k in 0..40 {
        for tap in [0, 1, 2, 3] {
            let id = 0x180 + u16::try_from(tap).unwrap();
            wire.post(tap, k * 2_000_000, frame(id, &[0x55; 6]))
                .unwrap();
        }
    }
    let log = run(&mut wire, 80_000_000);
    assert_eq!(
        states(&wire, 4),
        [State::Active, State::Active, State::BusOff, State::Active]
    );
    assert_eq!(
        (wire.statistics().errors, wire.statistics().bus_off),
        (32, 1)
    );
    assert!(log.iter().all(|(_, from)| *from != 2));
    assert_eq!(log.len(), 3 * 40);
    // 32 errors seen, and 120 frames received since
    assert!((0..4).all(|tap| wire.counters(tap).receive == 0 || tap == 2));
    // mended and told: it is back after 128 · 11 bits, and sends what waits
    wire.set_bus_fault(None);
    wire.recover(2);
    let back = 80_000_000 + 128 * 11 * BIT;
    assert!(run(&mut wire, back).is_empty());
    let log = run(&mut wire, back + length(&frame(0x182, &[0x55; 6])));
    assert_eq!(log.len(), 1, "{back} {log:?}");
    assert_eq!(states(&wire, 4), [State::Active; 4]);
}

#[test]
fn a_fault_of_one_sender_leaves_the_same_identifier_of_others_alone() {
    let mut wire = Wire::new(Kind::Classic, 3);
    wire.disturb(Fault {
        from_ns: 0,
        id: Some(Id::Standard(0x123)),
        sender: Some(1),
        count: 3,
        disturbance: Disturbance::Bit(30),
    });
    wire.post(0, 0, frame(0x123, &[1])).unwrap();
    wire.post(1, 1_000_000, frame(0x123, &[2])).unwrap();
    assert_eq!(run(&mut wire, 900_000), [(length(&frame(0x123, &[1])), 0)]);
    assert_eq!(wire.statistics().errors, 0);
    assert_eq!(run(&mut wire, 3_000_000).len(), 1);
    assert_eq!(
        (wire.statistics().errors, wire.counters(1).transmit),
        (3, 3 * 8 - 1)
    );
}

#[test]
fn a_stuck_dominant_level_sends_the_sender_off_and_makes_the_others_passive() {
    let sent = frame(0x100, &[0x55; 8]);
    let mut wire = Wire::new(Kind::Classic, 4);
    wire.post(1, 0, sent).unwrap();
    wire.post(0, 0, frame(0x200, &[])).unwrap();
    let cut = 50 * BIT;
    assert!(run(&mut wire, cut).is_empty());
    wire.set_bus_fault(Some(BusFault::StuckDominant));
    // seen after a bit, counted after 14 more and then every 8: TEC is 8·(1 + 31) = 256 after 31 counts
    let off = cut + (1 + 14 + 30 * 8) * BIT;
    assert!(run(&mut wire, off - 1).is_empty());
    assert_eq!(
        (wire.state(1), wire.counters(1).transmit),
        (State::Passive, 248)
    );
    assert!(run(&mut wire, off).is_empty());
    assert_eq!(
        states(&wire, 4),
        [
            State::Passive,
            State::BusOff,
            State::Passive,
            State::Passive
        ]
    );
    // nobody gets anything through, however long it lasts, and nobody else goes off
    assert!(run(&mut wire, 1_000_000_000).is_empty());
    assert_eq!(wire.next_event_ns(), None);
    assert_eq!(wire.statistics().bus_off, 1);
    assert_eq!((wire.pending(0), wire.pending(1)), (1, 1));
    // who waited sends when the wire has been idle; recessive bits for the other count from the end on
    wire.recover(1);
    run(&mut wire, 2_000_000_000);
    assert_eq!(
        wire.state(1),
        State::BusOff,
        "a dominant wire counts for nothing"
    );
    wire.set_bus_fault(None);
    let first = 2_000_000_000 + 11 * BIT + length(&frame(0x200, &[]));
    assert_eq!(run(&mut wire, first), [(first, 0)]);
    assert_eq!(wire.state(1), State::BusOff);
    let last = run(&mut wire, 2_010_000_000);
    assert_eq!(last.len(), 1);
    assert_eq!(last[0].1, 1);
    // an idle gap, a frame of 11 recessive bits at its end, the rest; within a sequence
    let back = last[0].0 - length(&sent);
    let least = 2_000_000_000 + 128 * 11 * BIT;
    assert!(
        (least..least + length(&frame(0x200, &[])) + 11 * BIT).contains(&back),
        "{back}"
    );
}

#[test]
fn a_stuck_dominant_level_on_an_idle_wire_sends_nobody_off() {
    let mut wire = Wire::new(Kind::Classic, 3);
    run(&mut wire, 1_000_000);
    wire.set_bus_fault(Some(BusFault::StuckDominant));
    wire.post(0, 1_000_000, frame(0x80, &[])).unwrap();
    // 6 bits to see it; 1 + 8·16 = 129 is the first above 127: 8 behind the flag, then after 14 and 14 times 8 bits
    let passive = 1_000_000 + (6 + 14 + 14 * 8) * BIT;
    run(&mut wire, 1_000_000 + (6 + 7) * BIT - 1);
    assert_eq!(wire.counters(0).receive, 1);
    run(&mut wire, 1_000_000 + (6 + 7) * BIT);
    assert_eq!(wire.counters(0).receive, 9);
    run(&mut wire, passive - 1);
    assert_eq!(states(&wire, 3), [State::Active; 3]);
    run(&mut wire, passive);
    assert_eq!(states(&wire, 3), [State::Passive; 3]);
    run(&mut wire, 100_000_000);
    assert_eq!(
        (wire.statistics().bus_off, wire.statistics().frames),
        (0, 0)
    );
    wire.set_bus_fault(None);
    assert_eq!(run(&mut wire, 101_000_000).len(), 1);
    // 119 by the frame it received
    assert_eq!(wire.state(1), State::Active);
}

/// A wire of three taps, of which the first sends a frame that began at 0, and which is dominant from this bit on.
fn stuck_in(sent: Frame, bit: u64) -> Wire {
    let mut wire = Wire::new(Kind::Classic, 3);
    wire.post(0, 0, sent).unwrap();
    assert!(run(&mut wire, bit * BIT).is_empty());
    wire.set_bus_fault(Some(BusFault::StuckDominant));
    wire
}

#[test]
fn who_is_in_its_arbitration_when_the_level_begins_has_lost_it_and_stays_on_the_bus() {
    // start 0, identifier 010 1010 1010: bit 3 is dominant, bit 4 recessive
    let sent = frame(0x2AA, &[0x55]);
    let mut wire = stuck_in(sent, 3);
    run(&mut wire, 1_000_000_000);
    assert_eq!(states(&wire, 3), [State::Passive; 3]);
    assert_eq!(
        (wire.counters(0).transmit, wire.statistics().bus_off),
        (0, 0)
    );
    // mended, it sends what it had to say
    wire.set_bus_fault(None);
    let end = 1_000_000_000 + 11 * BIT + length(&sent);
    assert_eq!(run(&mut wire, end), [(end, 0)]);
}

#[test]
fn a_stuff_bit_of_the_arbitration_counts_nothing_by_itself() {
    // start and four zeros of the identifier: the bit behind them is put in, and recessive
    let mut wire = stuck_in(frame(0x050, &[]), 5);
    run(&mut wire, (5 + 1 + 14) * BIT - 1);
    // who listens has had five dominant bits: it sees the error at once, and one dominant bit behind its flag
    assert_eq!(
        (wire.counters(0).transmit, wire.counters(1).receive),
        (0, 1 + 8)
    );
    run(&mut wire, (5 + 1 + 14) * BIT);
    assert_eq!(
        (wire.counters(0).transmit, wire.counters(1).receive),
        (8, 1 + 8 + 8)
    );
    // 32 counts, the last after 14 + 31 · 8 bits
    run(&mut wire, (5 + 1 + 14 + 31 * 8) * BIT - 1);
    assert_eq!(wire.state(0), State::Passive);
    run(&mut wire, (5 + 1 + 14 + 31 * 8) * BIT);
    assert_eq!(wire.state(0), State::BusOff);
}

#[test]
fn a_level_that_begins_between_two_frames_leaves_the_first_whole() {
    let sent = frame(0x123, &[1, 2]);
    let bits = length(&sent) / BIT;
    let mut wire = stuck_in(sent, bits - 3);
    assert_eq!(run(&mut wire, length(&sent)), [(length(&sent), 0)]);
    // an overload flag is no error: it counts when it does not end
    assert_eq!(
        (wire.counters(0).transmit, wire.counters(1).receive),
        (0, 0)
    );
    run(&mut wire, (bits - 3 + 1 + 14) * BIT);
    assert_eq!(
        (wire.counters(0).transmit, wire.counters(1).receive),
        (8, 8)
    );
    run(&mut wire, 10_000_000);
    assert_eq!(
        states(&wire, 3),
        [State::BusOff, State::Passive, State::Passive]
    );
    // a bit earlier it is in the end of frame, and destroyed
    let mut wire = stuck_in(sent, bits - 4);
    assert!(run(&mut wire, length(&sent)).is_empty());
    assert_eq!((wire.counters(0).transmit, wire.pending(0)), (8, 1));
}

#[test]
fn a_level_that_begins_in_fast_data_is_seen_at_the_fast_rate() {
    // all zeros: every sixth bit is recessive, 200 ns each
    let sent = Frame::fd(Id::Extended(0x1555_5555), &[0; 64]).unwrap();
    let mut wire = Wire::new(Kind::Fd, 2);
    wire.post(0, 0, sent).unwrap();
    let begins = (u64::from(budget::exact(&sent).nominal) - 13) * BIT + 50 * 200;
    run(&mut wire, begins);
    wire.set_bus_fault(Some(BusFault::StuckDominant));
    assert_eq!(wire.counters(0).transmit, 8);
    // at most six fast bits until it is seen, and 14 of a flag
    run(&mut wire, begins + 14 * BIT);
    assert_eq!(wire.counters(0).transmit, 8);
    run(&mut wire, begins + 14 * BIT + 6 * 200);
    assert_eq!(wire.counters(0).transmit, 16);
}

#[test]
fn lines_that_touch_send_everybody_off_who_sends_and_nobody_who_listens() {
    let mut wire = Wire::new(Kind::Classic, 4);
    wire.set_bus_fault(Some(BusFault::Short));
    for tap in [0, 1, 2] {
        let id = 0x100 + u16::try_from(tap).unwrap();
        wire.post(tap, 0, frame(id, &[1, 2, 3])).unwrap();
    }
    // a start bit, a flag, a delimiter and the interframe space are 18 bits; the passive half waits 8 more
    let off = (32 * 18 + 16 * 8) * BIT;
    assert!(run(&mut wire, off - 8 * BIT - 1).is_empty());
    assert_eq!(
        states(&wire, 4),
        [
            State::Passive,
            State::Passive,
            State::Passive,
            State::Active
        ]
    );
    assert!(run(&mut wire, off).is_empty());
    assert_eq!(
        states(&wire, 4),
        [State::BusOff, State::BusOff, State::BusOff, State::Active]
    );
    assert_eq!(wire.statistics().bus_off, 3);
    assert_eq!(wire.counters(3).receive, 0);
    // recovery begins a new round, in vain
    wire.recover(1);
    assert!(run(&mut wire, 10_000_000).is_empty());
    assert_eq!(
        (wire.state(1), wire.statistics().bus_off),
        (State::BusOff, 4)
    );
    wire.set_bus_fault(None);
    (0..3).for_each(|tap| wire.recover(tap));
    let log = run(&mut wire, 20_000_000);
    let senders: Vec<Tap> = log.iter().map(|(_, from)| *from).collect();
    assert_eq!(senders, [0, 1, 2]);
}

#[test]
fn behind_a_cut_nobody_hears_and_is_heard() {
    let mut wire = Wire::new(Kind::Classic, 4);
    wire.set_bus_fault(Some(BusFault::Cut(1)));
    for tap in 0..4 {
        let id = 0x300 + u16::try_from(tap).unwrap();
        wire.post(tap, 0, frame(id, &[0])).unwrap();
    }
    let mut reached = Vec::new();
    wire.advance(10_000_000, &mut |d: Delivery<'_>, _: &mut Outbox<'_>| {
        reached.push((
            d.from,
            (0..4).filter(|tap| d.reaches(*tap)).collect::<Vec<_>>(),
        ));
    });
    assert_eq!(reached, [(0, vec![1]), (1, vec![0])]);
    wire.set_bus_fault(None);
    assert_eq!(run(&mut wire, 20_000_000).len(), 2);
}

#[test]
fn names_are_read_as_they_are_written_and_others_are_refused() {
    let all = [
        BusFault::StuckDominant,
        BusFault::Short,
        BusFault::Cut(3),
        BusFault::Wrecked(0),
    ];
    for fault in all {
        assert_eq!(fault.to_string().parse(), Ok(fault));
    }
    for text in [
        "",
        "stuck",
        "cut",
        "cut:",
        "cut:-1",
        "wrecked:x",
        "short:1",
        "Short",
    ] {
        let error = text.parse::<BusFault>().unwrap_err();
        assert!(error.to_string().contains(&format!("{text:?}")), "{error}");
    }
}

fn any_fault() -> impl Strategy<Value = Option<BusFault>> {
    prop_oneof![
        Just(None),
        Just(Some(BusFault::StuckDominant)),
        Just(Some(BusFault::Short)),
        (0..4usize).prop_map(|tap| Some(BusFault::Cut(tap))),
        (0..4usize).prop_map(|tap| Some(BusFault::Wrecked(tap))),
    ]
}

proptest! {
    /// However faults come and go, in whatever pieces time passes: once the wire is whole and everybody is told to
    /// recover, every frame posted is delivered once. 40 frames of at most 135 us are 6 ms, recovery 1.4 ms.
    #[test]
    fn a_mended_wire_delivers_everything(
        posts in proptest::collection::vec((0usize..4, 0u64..20_000_000, 0u16..0x700, 0usize..=8), 0..40),
        faults in proptest::collection::vec((any_fault(), 1u64..4_000_000), 0..8),
        cut in 1u64..500_000,
    ) {
        let (mut whole, mut pieces) = (Wire::new(Kind::Classic, 4), Wire::new(Kind::Classic, 4));
        for (number, (tap, at, id, len)) in posts.iter().enumerate() {
            // no two alike
            let id = id & 0x700 | u16::try_from(number).unwrap();
            for wire in [&mut whole, &mut pieces] {
                wire.post(*tap, *at, frame(id, &vec![0xA5; *len])).unwrap();
            }
        }
        let (mut log, mut other) = (Vec::new(), Vec::new());
        let mut now = 0;
        // the second time after what was begun while the wire was broken
        let whole_again = (None, 1_000_000);
        for (fault, lasts) in faults.iter().chain([&whole_again, &whole_again]) {
            for wire in [&mut whole, &mut pieces] {
                wire.set_bus_fault(*fault);
                (0..4).for_each(|tap| wire.recover(tap));
            }
            log.extend(run(&mut whole, now + lasts));
            let mut at = now;
            while at < now + lasts {
                at = (at + cut).min(now + lasts);
                other.extend(run(&mut pieces, at));
            }
            now += lasts;
        }
        log.extend(run(&mut whole, now + 100_000_000));
        other.extend(run(&mut pieces, now + 100_000_000));
        prop_assert_eq!(&log, &other);
        prop_assert_eq!(log.len(), posts.len());
        prop_assert_eq!(whole.statistics(), pieces.statistics());
    }
}
