//! The interpolator against an observer that knows nothing of it but its set-points.
mod observer;

use motion::interpolator::{PushError, QuickStop, StopCause};
use motion::knot::Quantity;
use motion::profile::{AxisLimits, PhaseSynchronised};
use motion::{AxisEnvelope, Interpolator, Knot, Status};
use observer::{Observer, STEP_US, envelope};
use proptest::prelude::*;

const KNOT_US: u64 = 20_000;

/// A knot that the plan limits admit, drawn near where the path is; halves its ambition until accepted.
fn push_some<const N: usize, const Q: usize>(
    edp: &mut Interpolator<N, Q>,
    last: &mut Knot<N>,
    wish: &[f64; 3],
    limits: &AxisLimits,
    now_us: u64,
) -> bool {
    for k in 0..8u32 {
        let share = libm::pow(0.5, f64::from(k));
        let mut knot = *last;
        knot.at_us = last.at_us + KNOT_US;
        let dt = 1e-6 * KNOT_US as f64;
        let mut acceleration = last.acceleration.unwrap();
        for i in 0..N {
            let spread = 1.0 - 0.3 * i as f64 / N as f64;
            // jerk towards a wish, integrated: what a generator with state does
            let jerk = share * spread * 0.4 * limits.j * wish[i % 3];
            let damped = if k > 3 {
                -2.0 * acceleration[i] - 6.0 * last.velocity[i]
            } else {
                0.0
            };
            let change = jerk + damped;
            knot.position[i] +=
                dt * (last.velocity[i] + dt * (0.5 * acceleration[i] + dt * change / 6.0));
            knot.velocity[i] += dt * (acceleration[i] + 0.5 * dt * change);
            acceleration[i] += dt * change;
        }
        knot.acceleration = Some(acceleration);
        match edp.push(knot, now_us) {
            Ok(accepted) => {
                assert!(accepted.acceleration_step.iter().all(|s| *s < 1e-6));
                *last = knot;
                return true;
            }
            Err(PushError::Limit { .. } | PushError::NoRoomToStop { .. }) => {}
            Err(PushError::Full | PushError::Late { .. } | PushError::Stopped { .. }) => {
                return false;
            }
            Err(other) => panic!("{other:?}"),
        }
    }
    false
}

#[derive(Clone, Copy, Debug)]
enum Act {
    Wish([f64; 3]),
    Hold,
    Resume,
    Override(f64),
    Silence,
    Speak,
    QuickStop,
}

fn act() -> impl Strategy<Value = Act> {
    prop_oneof![
        12 => prop::array::uniform3(-1.0..1.0f64).prop_map(Act::Wish),
        2 => Just(Act::Hold),
        3 => Just(Act::Resume),
        2 => (0.0..=1.0f64).prop_map(Act::Override),
        1 => Just(Act::Silence),
        2 => Just(Act::Speak),
        1 => Just(Act::QuickStop),
    ]
}

proptest! {
    /// P1a, P5: whatever comes, every set-point keeps the hard limits, and everything can rest.
    #[test]
    fn no_sequence_of_commands_breaks_a_hard_limit(
        acts in prop::collection::vec((act(), 1..40u32), 1..40),
        v in 1.0..4.0f64, a in 2.0..40.0f64, j in 20.0..2000.0f64, upper in 0.3..20.0f64,
    ) {
        let limits = AxisLimits { v, a, j };
        let axes = [envelope(upper, limits), envelope(upper, limits.scaled(1.7)), envelope(2.0 * upper, limits)];
        let mut edp = Interpolator::<3, 6>::new(axes, [0.1, -0.1, 0.0]).unwrap();
        let mut observer = Observer::new(&axes);
        let (mut now, mut wish, mut speaks) = (0, [0.5, -0.3, 0.2], true);
        let mut last = Knot { at_us: 0, position: [0.0; 3], velocity: [0.0; 3], acceleration: Some([0.0; 3]) };
        for (act, steps) in acts {
            match act {
                Act::Wish(w) => wish = w,
                Act::Hold => edp.feed_hold(),
                Act::Resume => edp.resume(),
                Act::Override(r) => edp.set_override(r),
                Act::Silence => speaks = false,
                Act::Speak => speaks = true,
                Act::QuickStop => { edp.quick_stop(); }
            }
            for _ in 0..steps {
                if matches!(edp.step(now).status, Status::Stopped { .. }) {
                    edp.flush().unwrap();
                }
                if matches!(edp.step(now).status, Status::Idle) {
                    edp.start(now + 4000).unwrap();
                    last = Knot { at_us: now + 4000, position: edp.setpoint().position, velocity: [0.0; 3], acceleration: Some([0.0; 3]) };
                }
                if speaks {
                    push_some(&mut edp, &mut last, &wish, &limits, now);
                }
                observer.see(&edp.step(now));
                now += STEP_US;
            }
        }
        // silence: it comes to rest by itself, inside the limits, where it said
        edp.resume();
        edp.set_override(1.0);
        let promised = edp.stop_tail();
        for _ in 0..20_000 {
            let output = edp.step(now);
            observer.see(&output);
            now += STEP_US;
            if matches!(output.status, Status::Idle | Status::Stopped { .. }) {
                break;
            }
        }
        prop_assert!(edp.is_at_rest());
        if let Some(tail) = promised {
            for (p, q) in edp.setpoint().position.iter().zip(&tail.position) {
                prop_assert!((p - q).abs() < 1e-12);
            }
        }
    }

    /// A planned motion sampled into knots is reproduced, and its end is exact.
    #[test]
    fn a_profile_in_knots_arrives_exactly(end in prop::array::uniform2(-3.0..3.0f64)) {
        let hard = AxisLimits { v: 4.0, a: 20.0, j: 800.0 };
        let axes = [envelope(9.0, hard); 2];
        let planned = axes[0].plan;
        let share = AxisLimits { v: planned.v * 0.98, a: planned.a * 0.9, j: planned.j * 0.5 };
        let plan = PhaseSynchronised::new([0.0; 2], end, &[share; 2]).unwrap();
        let mut edp = Interpolator::<2, 4>::new(axes, [0.0; 2]).unwrap();
        let mut observer = Observer::new(&axes);
        edp.start(0).unwrap();
        let (mut now, mut next) = (0, KNOT_US);
        let last_us = (plan.duration() * 1e6) as u64 + KNOT_US;
        while now < last_us + KNOT_US {
            while edp.room() > 0 && next <= last_us {
                let s = plan.at(next as f64 * 1e-6);
                let knot = Knot { at_us: next, position: s.map(|s| s.p), velocity: s.map(|s| s.v), acceleration: Some(s.map(|s| s.a)) };
                if let Err(refused) = edp.push(knot, now) {
                    return Err(TestCaseError::fail(format!("{refused} {knot:?}")));
                }
                next += KNOT_US;
            }
            let output = edp.step(now);
            observer.see(&output);
            let expected = plan.at(now as f64 * 1e-6);
            for (p, e) in output.setpoint.position.iter().zip(&expected) {
                // a quintic over h misses a step of jerk by less than j·h³/100
                prop_assert!((p - e.p).abs() < 800.0 * 8e-6 / 100.0);
            }
            now += STEP_US;
        }
        prop_assert_eq!(edp.step(now).status, Status::Idle);
        for (p, e) in edp.setpoint().position.iter().zip(&end) {
            prop_assert_eq!(p.to_bits(), e.to_bits());
        }
    }

    /// Feed hold stays on the path: the same positions are passed, later.
    #[test]
    fn hold_and_resume_stay_on_the_path(at in 10..120u64, long in 0..300u64, override_rate in 0.05..1.0f64) {
        let hard = AxisLimits { v: 4.0, a: 20.0, j: 800.0 };
        let axes = [envelope(9.0, hard); 2];
        let mut edp = Interpolator::<2, 4>::new(axes, [0.0; 2]).unwrap();
        let mut observer = Observer::new(&axes);
        edp.start(0).unwrap();
        let end = [2.0, -1.0];
        edp.push(Knot { at_us: 2_000_000, position: end, velocity: [0.0; 2], acceleration: Some([0.0; 2]) }, 0).unwrap();
        for i in 0..6000u64 {
            if i == at { edp.feed_hold(); }
            if i == at + long { edp.set_override(override_rate); }
            if i == at + long + 3 { edp.resume(); }
            if i == 5500 { edp.set_override(1.0); }
            let output = edp.step(i * STEP_US);
            observer.see(&output);
            let [x, y] = output.setpoint.position;
            prop_assert!((x + 2.0 * y).abs() < 1e-12, "off the path");
        }
        let mut i = 6000;
        while edp.step(i * STEP_US).status != Status::Idle {
            i += 1;
            prop_assert!(i < 30_000);
        }
        prop_assert_eq!(edp.setpoint().position.map(f64::to_bits), end.map(f64::to_bits));
    }
}

const HARD: AxisLimits = AxisLimits {
    v: 2.0,
    a: 10.0,
    j: 200.0,
};

fn one() -> Interpolator<1, 4> {
    let mut edp = Interpolator::new([envelope(5.0, HARD)], [0.0]).unwrap();
    edp.start(0).unwrap();
    edp
}

fn knot(at_us: u64, p: f64, v: f64) -> Knot<1> {
    Knot {
        at_us,
        position: [p],
        velocity: [v],
        acceleration: Some([0.0]),
    }
}

#[test]
fn golden_samples_of_a_quintic() {
    let mut edp = one();
    edp.push(knot(1_000_000, 0.5, 0.0), 0).unwrap();
    // minimum-jerk motion: p = 10u³ − 15u⁴ + 6u⁵ halves
    for (now, p, v, a) in [
        (250_000, 0.051_757_812_5, 0.527_343_75, 2.8125),
        (500_000, 0.25, 0.9375, 0.0),
        (750_000, 0.448_242_187_5, 0.527_343_75, -2.8125),
    ] {
        let s = edp.step(now).setpoint;
        assert!((s.position[0] - p).abs() < 1e-15);
        assert!((s.velocity[0] - v).abs() < 1e-14);
        assert!((s.acceleration[0] - a).abs() < 1e-13);
    }
}

#[test]
fn refusals_come_before_motion_and_change_nothing() {
    let mut edp = one();
    let same = |edp: &Interpolator<1, 4>| (edp.room(), edp.horizon_us(0));
    let before = same(&edp);
    let refused = |edp: &mut Interpolator<1, 4>, k| edp.push(k, 0).unwrap_err();
    assert_eq!(
        refused(&mut edp, knot(0, 0.0, 0.0)),
        PushError::NotMonotone { previous_us: 0 }
    );
    assert_eq!(
        refused(&mut edp, knot(9, f64::NAN, 0.0)),
        PushError::NotFinite { axis: 0 }
    );
    assert_eq!(
        edp.push(knot(20_000, 0.0, 0.0), 20_000),
        Err(PushError::Late { path_us: 20_000 })
    );
    let limited = |k, quantity| matches!(one().push(k, 0), Err(PushError::Limit { axis: 0, quantity: q, .. }) if q == quantity);
    assert!(limited(knot(9_000_000, 5.1, 0.0), Quantity::Position));
    assert!(limited(knot(1_500_000, 2.0, 0.0), Quantity::Velocity));
    assert!(limited(knot(600_000, 0.4, 0.0), Quantity::Acceleration));
    assert!(limited(knot(20_000, 0.000_1, 0.0), Quantity::Jerk));
    assert_eq!(before, same(&edp));
    // in reach, but moving towards a limit too near
    edp.push(knot(6_000_000, 4.8, 0.0), 0).unwrap();
    assert!(matches!(
        refused(&mut edp, knot(7_000_000, 4.99, 0.5)),
        PushError::Limit { .. } | PushError::NoRoomToStop { .. }
    ));
    for i in 0..3 {
        edp.push(knot(7_000_000 + i, 4.8, 0.0), 0).unwrap();
    }
    assert_eq!(
        refused(&mut edp, knot(8_000_000, 4.8, 0.0)),
        PushError::Full
    );
}

#[test]
fn an_underrun_stops_where_promised_and_must_be_flushed() {
    let mut edp = one();
    edp.push(knot(1_000_000, 0.5, 1.0), 0).unwrap();
    let promise = edp.stop_tail().unwrap();
    let mut observer = Observer::new(&[envelope(5.0, HARD)]);
    let mut now = 0;
    let end = loop {
        let output = edp.step(now);
        observer.see(&output);
        match output.status {
            Status::Stopped { cause } => break cause,
            Status::Stopping { cause } => assert!(cause == StopCause::Underrun && now > 1_000_000),
            _ => assert!(now <= 1_000_000),
        }
        now += STEP_US;
    };
    assert_eq!(end, StopCause::Underrun);
    assert!(now >= promise.at_us && now < promise.at_us + STEP_US);
    assert_eq!(
        edp.setpoint().position.map(f64::to_bits),
        promise.position.map(f64::to_bits)
    );
    let stopped = Err(PushError::Stopped {
        cause: StopCause::Underrun,
    });
    assert_eq!(edp.push(knot(now + 1_000_000, 1.0, 0.0), now), stopped);
    assert!(edp.start(now).is_err());
    edp.flush().unwrap();
    assert_eq!(
        edp.push(knot(now + 1_000_000, 1.0, 0.0), now),
        Err(PushError::NotStarted)
    );
    edp.start(now).unwrap();
    edp.push(knot(now + 2_000_000, 1.0, 0.0), now).unwrap();
}

#[test]
fn at_rate_one_path_time_is_time_less_a_constant() {
    let mut edp = one();
    edp.set_override(1.0);
    edp.push(knot(100_000_000, 4.0, 0.0), 0).unwrap();
    for i in 0..500 {
        edp.step(i * STEP_US);
    }
    edp.feed_hold();
    let mut now = 1_000_000;
    while edp.step(now).status != Status::Held {
        now += STEP_US;
    }
    edp.resume();
    while !matches!(edp.step(now).status, Status::Following { .. }) {
        now += STEP_US;
    }
    let lag = now - edp.path_time_us(now);
    assert!(lag > 100_000);
    for i in 0..20_000 {
        edp.step(now + i * STEP_US);
        assert_eq!(now + i * STEP_US - edp.path_time_us(now + i * STEP_US), lag);
    }
}

#[test]
fn a_hold_lasts_as_long_as_announced() {
    let mut edp = one();
    edp.push(knot(20_000_000, 4.0, 0.0), 0).unwrap();
    edp.step(5_000_000);
    edp.feed_hold();
    let announced = 5_000_000 + (edp.hold_duration_s() * 1e6) as u64;
    assert!(
        matches!(edp.step(announced - 10).status, Status::Changing { target, .. } if target == 0.0)
    );
    assert_eq!(edp.step(announced + 10).status, Status::Held);
    assert!(edp.is_at_rest() && edp.setpoint().velocity[0] == 0.0);
    assert!(edp.flush().is_ok());
}

#[test]
fn a_quick_stop_is_the_fastest_and_leaves_the_path() {
    let mut edp = one();
    edp.push(knot(5_000_000, 4.0, 0.0), 0).unwrap();
    let moving = edp.step(2_500_000).setpoint;
    assert!(edp.flush().is_err());
    assert_eq!(edp.quick_stop(), QuickStop::OffPath);
    // v = 1.5, a = 0: v/a + a/j
    let t = moving.velocity[0] / HARD.a + HARD.a / HARD.j;
    let end = 2_500_000 + (t * 1e6) as u64;
    assert!(matches!(
        edp.step(end - 5).status,
        Status::Stopping {
            cause: StopCause::QuickStop
        }
    ));
    assert!(matches!(
        edp.step(end + 5).status,
        Status::Stopped {
            cause: StopCause::QuickStop
        }
    ));
    let way = edp.setpoint().position[0] - moving.position[0];
    assert!((way - 0.5 * t * moving.velocity[0]).abs() < 1e-9);
    edp.resume();
    assert!(matches!(
        edp.step(end + 5_000).status,
        Status::Stopped { .. }
    ));
}

#[test]
fn a_cubic_steps_in_acceleration_as_reported_and_no_more() {
    let mut edp = one();
    let mut cubic = knot(1_000_000, 0.5, 0.0);
    cubic.acceleration = None;
    let accepted = edp.push(cubic, 0).unwrap();
    assert!((accepted.acceleration_step[0] - 3.0).abs() < 1e-12); // 6·d/t²
    assert!((edp.step(1).setpoint.acceleration[0] - 3.0).abs() < 1e-4);
    edp.step(1_000_001);
    assert!(edp.setpoint().acceleration[0] == 0.0 && edp.setpoint().position[0] == 0.5);
    let mut axis = envelope(5.0, HARD);
    axis.acceleration_step = 2.9;
    let mut strict = Interpolator::<1, 4>::new([axis], [0.0]).unwrap();
    strict.start(0).unwrap();
    let refused = strict.push(cubic, 0);
    assert!(
        matches!(refused, Err(PushError::AccelerationStep { axis: 0, limit, .. }) if limit == 2.9)
    );
}

#[test]
fn from_outside_the_limits_only_the_way_back_is_open() {
    let mut edp = Interpolator::<1, 4>::new([envelope(1.0, HARD)], [1.5]).unwrap();
    edp.start(0).unwrap();
    assert!(edp.push(knot(2_000_000, 1.6, 0.0), 0).is_err());
    edp.push(knot(2_000_000, 0.9, 0.0), 0).unwrap();
    assert!(edp.push(knot(4_000_000, 1.1, 0.0), 0).is_err());
}

#[test]
fn knots_can_be_taken_back() {
    let mut edp = one();
    for i in 1..=3 {
        edp.push(knot(i * 1_000_000, 0.2 * i as f64, 0.0), 0)
            .unwrap();
    }
    edp.step(1_500_000);
    assert_eq!(edp.clear_after(0), 1);
    assert_eq!(edp.horizon_us(1_500_000), 500_000);
    edp.push(knot(3_000_000, 0.3, 0.0), 1_500_000).unwrap();
}

#[test]
fn limits_without_room_to_stop_are_refused() {
    let mut axis = AxisEnvelope::new(-1.0, 1.0, HARD);
    assert!(Interpolator::<1, 2>::new([axis], [0.0]).is_ok());
    axis.plan = HARD;
    assert!(Interpolator::<1, 2>::new([axis], [0.0]).is_err());
    axis.plan = HARD.scaled(f64::NAN);
    assert!(Interpolator::<1, 2>::new([axis], [0.0]).is_err());
    assert!(Interpolator::<1, 2>::new([envelope(1.0, HARD)], [f64::INFINITY]).is_err());
}
