use super::*;
use proptest::prelude::*;
use protocol::budget;
use protocol::frame::Id;

fn frame(id: u16, data: &[u8]) -> Frame {
    Frame::classic(Id::Standard(id), data).unwrap()
}

fn length(frame: &Frame) -> u64 {
    Rates::CLASSIC_1M.duration_ns(budget::exact(frame))
}

/// (time, sender, identifier) of everything delivered until `until_ns`.
fn run(wire: &mut Wire, until_ns: u64) -> Vec<(u64, Tap, Id)> {
    let mut log = Vec::new();
    wire.advance(until_ns, &mut |d: Delivery<'_>, _: &mut Outbox<'_>| {
        log.push((d.at_ns, d.from, d.frame.id()));
    });
    log
}

#[test]
fn the_lowest_identifier_wins_between_taps_and_within_one() {
    let mut wire = Wire::new(Kind::Classic, 3);
    for (tap, id) in [(0, 0x300), (1, 0x200), (0, 0x100), (2, 0x180)] {
        wire.post(tap, 0, frame(id, &[1, 2])).unwrap();
    }
    let order: Vec<Id> = run(&mut wire, 1_000_000)
        .into_iter()
        .map(|(_, _, id)| id)
        .collect();
    assert_eq!(order, [0x100, 0x180, 0x200, 0x300].map(Id::Standard));
}

#[test]
fn equal_identifiers_of_one_tap_keep_their_order() {
    let mut wire = Wire::new(Kind::Classic, 2);
    for k in 0..5 {
        wire.post(0, 0, frame(0x10, &[k])).unwrap();
    }
    let mut data = Vec::new();
    wire.advance(1_000_000, &mut |d: Delivery<'_>, _: &mut Outbox<'_>| {
        data.push(d.frame.data()[0]);
    });
    assert_eq!(data, [0, 1, 2, 3, 4]);
}

#[test]
fn a_frame_on_the_bus_is_not_interrupted() {
    let mut wire = Wire::new(Kind::Classic, 2);
    let low = frame(0x700, &[0x55; 8]);
    let high = frame(0x001, &[0x55; 8]);
    wire.post(0, 0, low).unwrap();
    wire.post(1, 1, high).unwrap();
    let first = length(&low);
    assert_eq!(wire.next_event_ns(), Some(first));
    assert_eq!(
        run(&mut wire, 1_000_000),
        [(first, 0, low.id()), (first + length(&high), 1, high.id())]
    );
    assert_eq!(
        wire.statistics().worst_latency_ns,
        first + length(&high) - 1
    );
}

#[test]
fn time_may_stop_within_a_frame() {
    let mut wire = Wire::new(Kind::Classic, 2);
    let sent = frame(0x123, &[1, 2, 3]);
    wire.post(0, 5_000, sent).unwrap();
    let end = 5_000 + length(&sent);
    assert!(run(&mut wire, 4_999).is_empty());
    assert!(run(&mut wire, end - 1).is_empty());
    assert_eq!(wire.next_event_ns(), Some(end));
    assert_eq!(run(&mut wire, end).len(), 1);
    assert_eq!(wire.next_event_ns(), None);
}

#[test]
fn posts_of_the_moment_at_which_time_stopped_arbitrate_together() {
    let mut wire = Wire::new(Kind::Classic, 2);
    wire.post(0, 1_000, frame(0x200, &[])).unwrap();
    run(&mut wire, 1_000);
    wire.post(1, 1_000, frame(0x100, &[])).unwrap();
    let senders: Vec<Tap> = run(&mut wire, 1_000_000).iter().map(|d| d.1).collect();
    assert_eq!(senders, [1, 0]);
}

#[test]
fn a_post_in_the_past_counts_from_now() {
    let mut wire = Wire::new(Kind::Classic, 2);
    run(&mut wire, 10_000);
    let sent = frame(0x123, &[]);
    wire.post(0, 0, sent).unwrap();
    assert_eq!(run(&mut wire, 1_000_000)[0].0, 10_000 + length(&sent));
}

#[test]
fn drives_answer_a_sync_one_after_the_other() {
    let mut wire = Wire::new(Kind::Classic, 4);
    let sync = frame(0x80, &[]);
    wire.post(0, 0, sync).unwrap();
    let mut log = Vec::new();
    wire.advance(10_000_000, &mut |d: Delivery<'_>, out: &mut Outbox<'_>| {
        log.push((d.at_ns, d.from));
        if d.frame.id() == Id::Standard(0x80) {
            for tap in [3, 1, 2] {
                let id = 0x180 + u16::try_from(tap).unwrap();
                out.post(tap, frame(id, &[0x55; 8])).unwrap();
            }
        }
    });
    let senders: Vec<Tap> = log.iter().map(|(_, from)| *from).collect();
    assert_eq!(senders, [0, 1, 2, 3]);
    let mut at = length(&sync);
    assert_eq!(log[0].0, at);
    for tap in 1..=3u16 {
        at += length(&frame(0x180 + tap, &[0x55; 8]));
        assert_eq!(log[usize::from(tap)].0, at);
    }
    assert_eq!(wire.statistics().frames, 4);
    assert_eq!(wire.statistics().busy_ns, at);
}

#[test]
fn what_cannot_be_sent_is_refused_and_counted() {
    let mut wire = Wire::new(Kind::Classic, 2).with_capacity(1);
    let fd = Frame::fd(Id::Extended(1), &[0; 64]).unwrap();
    assert_eq!(wire.post(0, 0, fd), Err(PostError::FdOnClassic));
    assert_eq!(
        wire.post(2, 0, frame(1, &[])),
        Err(PostError::NoTap { tap: 2, taps: 2 })
    );
    assert_eq!(wire.post(0, 0, frame(1, &[])), Ok(()));
    assert_eq!(
        wire.post(0, 0, frame(1, &[])),
        Err(PostError::Full {
            tap: 0,
            capacity: 1
        })
    );
    assert_eq!(wire.statistics().refused, 3);
    let mut fast = Wire::new(Kind::Fd, 2);
    fast.post(0, 0, fd).unwrap();
    let end = Rates::FD_1M_5M.duration_ns(budget::exact(&fd));
    assert_eq!(run(&mut fast, 1_000_000), [(end, 0, fd.id())]);
}

#[test]
fn at_half_the_rates_a_frame_takes_twice_as_long() {
    let long = Frame::fd(Id::Standard(0x10), &[0x3C; 64]).unwrap();
    for (kind, frame) in [(Kind::Classic, frame(0x10, &[0x3C; 8])), (Kind::Fd, long)] {
        let mut wire = Wire::new(kind, 2);
        let Rates { nominal, data } = wire.rates();
        wire.post(0, 0, frame).unwrap();
        let once = run(&mut wire, 1_000_000)[0].0;
        assert_eq!(wire.statistics().busy_ns, once);
        wire.set_rates(Rates {
            nominal: nominal / 2,
            data: data / 2,
        });
        wire.post(0, 0, frame).unwrap();
        // from where the first advance ended; whole nanoseconds a bit at all of these rates
        assert_eq!(run(&mut wire, 3_000_000)[0].0, 1_000_000 + 2 * once);
        assert_eq!(wire.statistics().busy_ns, 3 * once);
    }
}

#[test]
fn a_saturated_bus_has_load_one() {
    let mut wire = Wire::new(Kind::Classic, 2).with_capacity(10_000);
    for _ in 0..2_000 {
        wire.post(0, 0, frame(0x2AA, &[0x55; 8])).unwrap();
    }
    run(&mut wire, 1_000_000_000);
    assert_eq!(wire.statistics().busiest_window_ns, LOAD_WINDOW_NS);
    assert_eq!(wire.statistics().frames, 2_000);
}

#[test]
fn the_window_forgets() {
    let mut wire = Wire::new(Kind::Classic, 2);
    let sent = frame(0x2AA, &[0x55; 8]);
    for k in 0..10 {
        wire.post(0, k * LOAD_WINDOW_NS, sent).unwrap();
    }
    run(&mut wire, u64::MAX / 2);
    let busiest = wire.statistics().busiest_window_ns;
    assert_eq!(busiest, length(&sent));
}

#[test]
fn a_cleared_queue_sends_nothing() {
    let mut wire = Wire::new(Kind::Classic, 2);
    wire.post(0, 0, frame(1, &[])).unwrap();
    assert_eq!(wire.pending(0), 1);
    wire.clear(0);
    assert!(run(&mut wire, 1_000_000).is_empty());
}

proptest! {
    /// However time is cut into steps, the deliveries are the same; every frame is delivered once;
    /// deliveries never overlap; whoever waits while a less urgent frame begins, came later.
    #[test]
    fn laws(
        posts in proptest::collection::vec((0usize..4, 0u64..3_000_000, 0u16..0x800, 0usize..=8), 0..60),
        cuts in proptest::collection::vec(0u64..20_000_000, 0..40),
    ) {
        let fresh = || {
            let mut wire = Wire::new(Kind::Classic, 4);
            for (tap, at, id, len) in &posts {
                // no two taps have an identifier in common
                let id = id & !3 | u16::try_from(*tap).unwrap();
                wire.post(*tap, *at, frame(id, &vec![0xA5; *len])).unwrap();
            }
            wire
        };
        let mut whole = fresh();
        let mut all = Vec::new();
        let mut begun = Vec::new();
        whole.advance(20_000_000, &mut |d: Delivery<'_>, _: &mut Outbox<'_>| {
            all.push((d.at_ns, d.from, d.frame.id()));
            begun.push((d.at_ns - length(d.frame), d.posted_ns, d.frame.id().arbitration()));
        });
        prop_assert_eq!(all.len(), posts.len());

        let mut stepped = fresh();
        let mut cuts = cuts.clone();
        cuts.sort_unstable();
        let mut pieces = Vec::new();
        for cut in cuts.into_iter().chain([20_000_000]) {
            let event = stepped.next_event_ns();
            let piece = run(&mut stepped, cut);
            prop_assert_eq!(piece.first().map(|d| d.0), event.filter(|at| *at <= cut));
            pieces.extend(piece);
        }
        prop_assert_eq!(&pieces, &all);
        prop_assert_eq!(stepped.statistics(), whole.statistics());

        let ends: Vec<u64> = all.iter().map(|d| d.0).collect();
        prop_assert!(ends.windows(2).all(|pair| pair[1] >= pair[0] + 44_000));
        for (k, (start, _, urgency)) in begun.iter().enumerate() {
            for (_, posted, other) in &begun[k + 1..] {
                prop_assert!(other >= urgency || posted > start);
            }
        }
    }
}
