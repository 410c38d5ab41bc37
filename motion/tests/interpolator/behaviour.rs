//! Single behaviours of the interpolator, each as one story.
use crate::observer::{Observer, STEP_US, envelope};
use crate::path::Path;
use motion::interpolator::{Braking, EVALUATION_QUANTA, PushError, QuickStop, StopCause};
use motion::knot::Quantity;
use motion::profile::AxisLimits;
use motion::{Angle, AxisEnvelope, Knot, Status};
use std::ops::DerefMut as _;

const HARD: AxisLimits = AxisLimits {
    v: 2.0,
    a: 10.0,
    j: 200.0,
};

fn one() -> Path<1, 4> {
    let mut edp = Path::new([envelope(5.0, HARD)], [Angle::ZERO]).unwrap();
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
        let off = Angle::bound(p).since(s.position[0]);
        assert!(off.abs() <= EVALUATION_QUANTA, "{off}");
        // ten roundings of f32, of terms up to 30 and 60
        assert!((f64::from(s.velocity[0]) - v).abs() < 30.0 * 6e-7);
        assert!((f64::from(s.acceleration[0]) - a).abs() < 60.0 * 6e-7);
    }
}

#[test]
fn refusals_come_before_motion_and_change_nothing() {
    let mut edp = one();
    let same = |edp: &Path<1, 4>| (edp.room(), edp.horizon_us(0));
    let before = same(&edp);
    let refused = |edp: &mut Path<1, 4>, k| edp.push(k, 0).unwrap_err();
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
    assert_eq!(edp.setpoint().position, promise.position);
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
        edp.set_override(1.0);
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
    let v = f64::from(moving.velocity[0]);
    let t = v / HARD.a + HARD.a / HARD.j;
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
    let way = edp.setpoint().position[0].to_f64() - moving.position[0].to_f64();
    // what is kept below the limits for rounding is 16 millionths
    assert!((way - 0.5 * t * v).abs() < 20e-6 * way);
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
    let steps = edp.push(cubic, 0).unwrap();
    assert!((steps[0] - 3.0).abs() < 1e-12); // 6·d/t²
    assert!((edp.step(1).setpoint.acceleration[0] - 3.0).abs() < 1e-4);
    edp.step(1_000_001);
    assert!(
        edp.setpoint().acceleration[0] == 0.0
            && Some(edp.setpoint().position[0]) == Angle::nearest(0.5)
    );
    let mut axis = envelope(5.0, HARD);
    axis.acceleration_step = 2.9;
    let mut strict = Path::<1, 4>::new([axis], [Angle::ZERO]).unwrap();
    strict.start(0).unwrap();
    let refused = strict.push(cubic, 0);
    assert!(
        matches!(refused, Err(PushError::AccelerationStep { axis: 0, limit, .. }) if limit == 2.9)
    );
}

#[test]
fn from_outside_the_limits_only_the_way_back_is_open() {
    let mut edp = Path::<1, 4>::new([envelope(1.0, HARD)], [Angle::bound(1.5)]).unwrap();
    edp.start(0).unwrap();
    assert!(edp.push(knot(2_000_000, 1.6, 0.0), 0).is_err());
    edp.push(knot(2_000_000, 0.9, 0.0), 0).unwrap();
    assert!(edp.push(knot(4_000_000, 1.1, 0.0), 0).is_err());
}

#[test]
fn limits_without_room_to_stop_are_refused() {
    let mut axis = AxisEnvelope::new(-1.0, 1.0, HARD);
    assert!(Path::<1, 2>::new([axis], [Angle::ZERO]).is_ok());
    axis.plan = HARD;
    assert!(Path::<1, 2>::new([axis], [Angle::ZERO]).is_err());
    axis.plan = HARD.scaled(f64::NAN);
    assert!(Path::<1, 2>::new([axis], [Angle::ZERO]).is_err());
}

/// Turning round at a position limit needs less room than stopping there without turning.
#[test]
fn a_quick_stop_that_would_leave_the_position_limits_stays_on_the_path() {
    let axis = envelope(0.5, HARD);
    let turn = |a| Knot {
        acceleration: Some([a]),
        ..knot(1_000_000, 0.5, 0.0)
    };
    let (mut on, mut off) = (0, 0);
    for stop_at in 300..520u64 {
        let mut edp = Path::<1, 4>::new([axis], [Angle::ZERO]).unwrap();
        let mut observer = Observer::new(&[axis]);
        edp.start(0).unwrap();
        edp.push(turn(-0.98 * axis.plan.a), 0).unwrap();
        edp.push(knot(2_500_000, 0.0, 0.0), 0).unwrap();
        for i in 0..1500 {
            if i == stop_at {
                match edp.quick_stop() {
                    QuickStop::OnPath => on += 1,
                    QuickStop::OffPath => off += 1,
                    QuickStop::AtRest => panic!("moving"),
                }
            }
            observer.see(&edp.step(i * STEP_US));
        }
        assert!(edp.is_at_rest());
    }
    assert!(on > 0 && off > 0, "{on} {off}");
}

#[test]
fn braking_is_the_same_for_every_envelope_that_differs_in_position_only() {
    let braking = Braking::new(&[envelope(5.0, HARD)]);
    assert_eq!(Braking::new(&[envelope(7.0, HARD)]), braking);
    // and of no other
    let faster = AxisLimits { j: 300.0, ..HARD };
    assert_ne!(Braking::new(&[envelope(5.0, faster)]), braking);
}

#[test]
fn a_piece_is_refused_by_a_path_that_has_got_another_end_meanwhile() {
    let stale = |change: fn(&mut Path<1, 4>)| {
        let mut edp = one();
        edp.push(knot(1_000_000, 0.5, 0.0), 0).unwrap();
        let made = edp.limits.piece(&edp.tip(), &knot(2_000_000, 0.7, 0.0));
        let piece = made.unwrap().piece;
        let mut other = edp.clone();
        change(&mut other);
        (
            edp.deref_mut().push(&piece, 0),
            other.push_whenever(&piece, 0),
        )
    };
    let refused = |change| {
        let (same, other) = stale(change);
        assert_eq!(same, Ok(()));
        other.unwrap_err()
    };
    // another knot
    let more = |edp: &mut Path<1, 4>| {
        edp.push(knot(1_500_000, 0.5, 0.0), 0).unwrap();
    };
    assert_eq!(refused(more), PushError::Stale);
    // held anew, where it stood
    let anew = |edp: &mut Path<1, 4>| {
        let ranges = edp.limits.ranges();
        edp.hold_anew(&ranges, [Angle::ZERO]);
        edp.start(0).unwrap();
    };
    assert_eq!(refused(anew), PushError::Stale);
    // flushed, and begun again
    let flushed = |edp: &mut Path<1, 4>| {
        edp.flush().unwrap();
        edp.start(1_000_000).unwrap();
    };
    assert_eq!(refused(flushed), PushError::Stale);
    let stopped = |edp: &mut Path<1, 4>| {
        edp.quick_stop();
    };
    let cause = StopCause::QuickStop;
    assert_eq!(refused(stopped), PushError::Stopped { cause });
    // where the path ends in time counts for a knot that has one
    let mut edp = one();
    let made = edp
        .limits
        .piece(&edp.tip().starting_at(5), &knot(1_000_000, 0.5, 0.0));
    let piece = made.unwrap().piece;
    assert_eq!(
        edp.clone().deref_mut().push(&piece, 0),
        Err(PushError::Stale)
    );
    edp.push_whenever(&piece, 0).unwrap();
    assert_eq!(edp.tip().at_us(), 999_995);
}

#[test]
fn the_next_piece_can_be_made_before_the_first_is_in_the_queue() {
    let mut edp = one();
    let mut ahead = one();
    let first = ahead.limits.piece(&ahead.tip(), &knot(1_000_000, 0.5, 0.3));
    let first = first.unwrap().piece;
    let second = knot(2_000_000, 0.7, 0.0);
    let second = ahead.limits.piece(&first.tip(), &second).unwrap().piece;
    ahead.deref_mut().push(&first, 0).unwrap();
    ahead.deref_mut().push(&second, 0).unwrap();
    edp.push(knot(1_000_000, 0.5, 0.3), 0).unwrap();
    edp.push(knot(2_000_000, 0.7, 0.0), 0).unwrap();
    for i in 0..1100 {
        assert_eq!(edp.step(i * STEP_US), ahead.step(i * STEP_US));
    }
    assert_eq!(edp.step(2_300_000).status, Status::Idle);
}
