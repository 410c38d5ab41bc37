use super::*;
use proptest::prelude::*;

const PERIOD: u64 = 20_000;

/// A true local clock: off by `offset` and fast by `ppm` against bus time.
#[derive(Clone, Copy)]
struct Truth {
    offset: u64,
    ppm: i64,
}

impl Truth {
    fn local(self, bus: u64) -> u64 {
        let drift = i64::try_from(bus).unwrap() * self.ppm / 1_000_000;
        (self.offset + bus).checked_add_signed(drift).unwrap()
    }
}

/// Sends `n` messages; `disturb(k)` gives the error of the k-th arrival time, or `None` for a loss.
/// Checks that bus time never runs backwards. Returns the worst error, µs, after `settle` messages.
fn run(truth: Truth, n: u64, settle: u64, disturb: impl Fn(u64) -> Option<i64>) -> (Clock, i64) {
    let (mut master, mut clock) = (Master::default(), Clock::default());
    let (mut worst, mut before) = (0, Micros(0));
    for k in 0..n {
        let bus = 1_000_000 + k * PERIOD;
        let sync = master.message();
        master.sent(Micros(bus));
        if let Some(error) = disturb(k) {
            let arrived = truth.local(bus).checked_add_signed(error).unwrap();
            let known = clock.quality(Micros(arrived)) != Quality::Unsynchronised;
            let just_before = clock.to_bus(Micros(arrived));
            clock.receive(Micros(arrived), &sync);
            if known {
                assert_eq!(clock.to_bus(Micros(arrived)), just_before, "stepped at {k}");
            }
        }
        if clock.quality(Micros(truth.local(bus))) == Quality::Unsynchronised {
            continue;
        }
        for at in [400, 5_000, 12_000, 19_000] {
            let local = truth.local(bus + at);
            let now = clock.to_bus(Micros(local));
            assert!(now >= before, "{before:?} then {now:?}");
            before = now;
            if k >= settle {
                let error = i64::try_from(now.0).unwrap() - i64::try_from(bus + at).unwrap();
                worst = worst.max(error.abs());
            }
            let back = clock.to_local(now).0;
            assert!(back <= local && local - back <= 1, "{back} {local}");
        }
    }
    (clock, worst)
}

/// A deterministic spread of −amplitude … amplitude.
fn jitter(k: u64, amplitude: i64) -> i64 {
    let mixed = (k + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 33;
    i64::try_from(mixed).unwrap() % (2 * amplitude + 1) - amplitude
}

#[test]
fn drift_of_either_sign_is_followed_to_a_microsecond() {
    for ppm in [-100, -37, 0, 12, 100] {
        let (clock, worst) = run(
            Truth {
                offset: 7_654_321,
                ppm,
            },
            200,
            60,
            |_| Some(0),
        );
        // Integer time-stamps on both sides: rounding alone can make 1 to 2 µs.
        assert!(worst <= 2, "{ppm} ppm: {worst} µs");
        let error_ppm = clock.drift() * 1e6 + float(ppm);
        assert!(error_ppm.abs() < 2.0, "{ppm} ppm: off by {error_ppm}");
    }
}

#[test]
fn jitter_is_averaged() {
    // 20 µs of jitter, 32 pairs: the fit's end point has σ = 2/√32 · 11.5 µs = 4 µs; 5 σ.
    let (clock, worst) = run(
        Truth {
            offset: 99,
            ppm: 80,
        },
        400,
        60,
        |k| Some(jitter(k, 20)),
    );
    assert!((1..=20).contains(&worst), "{worst} µs");
    let quality = clock.quality(Micros(
        Truth {
            offset: 99,
            ppm: 80,
        }
        .local(9_000_000),
    ));
    assert!(
        matches!(
            quality,
            Quality::Synchronised {
                residual_us: 5..=16
            }
        ),
        "{quality:?}"
    );
}

#[test]
fn lost_messages_do_no_harm() {
    let (_, worst) = run(
        Truth {
            offset: 5,
            ppm: -100,
        },
        300,
        100,
        |k| (k % 5 != 2).then_some(0),
    );
    assert!(worst <= 2, "{worst} µs");
}

#[test]
fn one_outlier_changes_nothing() {
    let truth = Truth {
        offset: 5,
        ppm: 100,
    };
    for size in [-5_000, 300, 5_000, 19_000] {
        let (clock, worst) = run(truth, 200, 60, |k| Some(if k == 120 { size } else { 0 }));
        assert_eq!(clock.refused(), 1, "{size}");
        assert!(worst <= 2, "{size}: {worst} µs");
    }
}

#[test]
fn a_master_that_changed_its_time_is_noticed_and_followed_only_after_reset() {
    let (mut master, mut clock) = (Master::default(), Clock::default());
    let send = |clock: &mut Clock, master: &mut Master, local: u64, bus: u64| {
        clock.receive(Micros(local), &master.message());
        master.sent(Micros(bus));
    };
    for k in 0..20 {
        send(&mut clock, &mut master, k * PERIOD, k * PERIOD);
    }
    for k in 20..40 {
        send(&mut clock, &mut master, k * PERIOD, k * PERIOD + 1_000_000);
    }
    let now = Micros(39 * PERIOD);
    assert_eq!(clock.quality(now), Quality::Disagrees);
    assert_eq!(clock.to_bus(now), now);
    clock.reset();
    for k in 40..43 {
        send(&mut clock, &mut master, k * PERIOD, k * PERIOD + 1_000_000);
    }
    assert_eq!(
        clock.to_bus(Micros(42 * PERIOD)),
        Micros(42 * PERIOD + 1_000_000)
    );
}

#[test]
fn silence_is_holdover() {
    let (clock, _) = run(Truth { offset: 0, ppm: 0 }, 20, 20, |_| Some(0));
    let last = 1_000_000 + 18 * PERIOD;
    assert_eq!(
        clock.quality(Micros(last)),
        Quality::Synchronised { residual_us: 0 }
    );
    assert_eq!(clock.quality(Micros(last + 600_000)), Quality::Holdover);
    assert_eq!(Clock::default().quality(Micros(0)), Quality::Unsynchronised);
    assert_eq!(Clock::default().to_bus(Micros(77)), Micros(77));
}

#[test]
fn a_master_that_was_not_told_skips_a_number() {
    let mut master = Master::default();
    let first = master.message();
    master.sent(Micros(5));
    let second = master.message();
    assert_eq!(
        second,
        TimeSync {
            sequence: first.sequence + 1,
            previous_sent_at: Micros(5)
        }
    );
    assert_eq!(master.message().sequence, second.sequence + 2);
}

proptest! {
    /// Whatever arrives, time does not run backwards or fast, and nothing panics.
    #[test]
    fn any_messages_leave_time_monotone(
        messages in proptest::collection::vec((1u64..100_000, any::<u8>(), any::<u64>(), 0u8..4), 1..100),
    ) {
        let mut clock = Clock::default();
        let mut local = 0u64;
        let (mut sequence, mut known, mut before) = (0u8, false, Micros(0));
        for (after, other, bus, kind) in messages {
            let from = clock.to_bus(Micros(local));
            local += after;
            let to = clock.to_bus(Micros(local));
            prop_assert!(to >= from);
            // Mostly consecutive and plausible, sometimes anything.
            sequence = if kind == 0 { other } else { sequence.wrapping_add(1) };
            let sent = if kind == 1 { bus } else { local - after };
            clock.receive(Micros(local), &TimeSync { sequence, previous_sent_at: Micros(sent) });
            let now = clock.to_bus(Micros(local));
            prop_assert!(!known || now >= before);
            known = clock.quality(Micros(local)) != Quality::Unsynchronised;
            before = now;
            let _ = clock.to_local(Micros(bus));
        }
    }

    #[test]
    fn jitter_and_loss_together(
        ppm in -100i64..=100,
        offset in 0u64..10_000_000_000,
        losses in proptest::collection::vec(any::<bool>(), 200),
    ) {
        let disturb = |k: u64| {
            let index = usize::try_from(k).unwrap();
            // At most one in three is lost.
            let lost = k.is_multiple_of(3) && losses[index];
            (!lost).then(|| jitter(k, 10))
        };
        let (_, worst) = run(Truth { offset, ppm }, 200, 100, disturb);
        prop_assert!(worst <= 20, "{} µs", worst);
    }
}
