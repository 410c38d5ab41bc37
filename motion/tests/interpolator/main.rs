//! The interpolator against an observer that knows nothing of it but its set-points.
#![expect(
    clippy::cast_precision_loss,
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    clippy::float_cmp,
    reason = "test times are small, and exact equality is what is promised"
)]
mod behaviour;
mod fixed;
mod observer;
mod path;

use motion::interpolator::{EVALUATION_QUANTA, PushError};
use motion::profile::{AxisLimits, PhaseSynchronised};
use motion::{Angle, Knot, Status};
use observer::{Observer, STEP_US, envelope};
use path::Path;
use proptest::prelude::*;

const KNOT_US: u64 = 20_000;
/// What a position in fixed point may be off, in units of the axis: 2⁻⁴⁰ a quantum.
const QUANTA: f64 = EVALUATION_QUANTA as f64 / 1_099_511_627_776.0;

/// A knot that the plan limits admit, drawn near where the path is; halves its ambition until accepted.
fn push_some<const N: usize, const Q: usize>(
    edp: &mut Path<N, Q>,
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
            Ok(steps) => {
                assert!(steps.iter().all(|s| *s < 1e-6));
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
        let mut edp = Path::<3, 6>::new(axes, [0.1, -0.1, 0.0].map(Angle::bound)).unwrap();
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
                    last = Knot { at_us: now + 4000, position: edp.setpoint().position.map(Angle::to_f64), velocity: [0.0; 3], acceleration: Some([0.0; 3]) };
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
            prop_assert_eq!(edp.setpoint().position, tail.position);
        }
    }

    /// Planned within `for_planning`, no knot is refused; the motion is reproduced, its end exact.
    #[test]
    fn a_profile_in_knots_is_never_refused_and_arrives_exactly(
        end in prop::array::uniform2(-3.0..3.0f64), knot_us in 2_000..60_000u64,
        v in 0.5..5.0f64, a in 2.0..50.0f64, j in 20.0..5000.0f64,
    ) {
        let hard = AxisLimits { v, a, j };
        let axes = [envelope(9.0, hard); 2];
        let planned = axes[0].for_planning(knot_us);
        let plan = PhaseSynchronised::new([0.0; 2], end, &[planned; 2]).unwrap();
        let mut edp = Path::<2, 4>::new(axes, [Angle::ZERO; 2]).unwrap();
        let mut observer = Observer::new(&axes);
        edp.start(0).unwrap();
        let (mut now, mut next) = (0, knot_us);
        let last_us = (plan.duration() * 1e6) as u64 + knot_us;
        while now <= last_us {
            while edp.room() > 0 && next <= last_us {
                let s = plan.at(next as f64 * 1e-6);
                let knot = Knot { at_us: next, position: s.map(|s| s.p), velocity: s.map(|s| s.v), acceleration: Some(s.map(|s| s.a)) };
                if let Err(refused) = edp.push(knot, now) {
                    return Err(TestCaseError::fail(format!("{refused} {knot:?}")));
                }
                next += knot_us;
            }
            let output = edp.step(now);
            observer.see(&output);
            let expected = plan.at(now as f64 * 1e-6);
            let h = knot_us as f64 * 1e-6;
            for (p, e) in output.setpoint.position.iter().zip(&expected) {
                // a velocity that strays by 0.0221·j·h² for at most h
                prop_assert!((p.to_f64() - e.p).abs() < 0.0221 * planned.j * h * h * h + QUANTA);
            }
            now += STEP_US;
        }
        prop_assert_eq!(edp.step(now).status, Status::Idle);
        prop_assert_eq!(edp.setpoint().position, end.map(Angle::bound));
    }

    /// Feed hold stays on the path: the same positions are passed, later.
    #[test]
    fn hold_and_resume_stay_on_the_path(at in 10..120u64, long in 0..300u64, override_rate in 0.05..1.0f64) {
        let hard = AxisLimits { v: 4.0, a: 20.0, j: 800.0 };
        let axes = [envelope(9.0, hard); 2];
        let mut edp = Path::<2, 4>::new(axes, [Angle::ZERO; 2]).unwrap();
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
            let [x, y] = output.setpoint.position.map(Angle::to_f64);
            prop_assert!((x + 2.0 * y).abs() < 3.0 * QUANTA, "off the path");
        }
        let mut i = 6000;
        while edp.step(i * STEP_US).status != Status::Idle {
            i += 1;
            prop_assert!(i < 30_000);
        }
        prop_assert_eq!(edp.setpoint().position, end.map(Angle::bound));
    }
}
