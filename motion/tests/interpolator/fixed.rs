//! Fixed point against the same polynomials in f64: evaluated here once more, by another scheme.
use crate::observer::envelope;
use crate::path::Path;
use motion::interpolator::{EVALUATION_QUANTA, PushError};
use motion::profile::AxisLimits;
use motion::{Angle, Knot};
use proptest::prelude::*;

/// So wide that no polynomial of these tests is refused.
const WIDE: AxisLimits = AxisLimits {
    v: 1e9,
    a: 1e12,
    j: 1e18,
};

/// The quintic of Hermite's basis: position, velocity, acceleration at both ends, over t seconds.
fn hermite(u: f64, t: f64, from: [f64; 3], to: [f64; 3]) -> [f64; 3] {
    let b = |u: f64| {
        let (u2, u3) = (u * u, u * u * u);
        let rise = u3 * (10.0 - 15.0 * u + 6.0 * u2);
        let begin = u - u3 * (6.0 - 8.0 * u + 3.0 * u2);
        let end = -u3 * (4.0 - 7.0 * u + 3.0 * u2);
        let bend = 0.5 * (u2 - u3 * (3.0 - 3.0 * u + u2));
        let last = 0.5 * u3 * (1.0 - 2.0 * u + u2);
        [rise, begin, end, bend, last]
    };
    let slope = |u: f64| {
        let (u2, u3, u4) = (u * u, u * u * u, u * u * u * u);
        [
            30.0 * u2 - 60.0 * u3 + 30.0 * u4,
            1.0 - 18.0 * u2 + 32.0 * u3 - 15.0 * u4,
            -12.0 * u2 + 28.0 * u3 - 15.0 * u4,
            u - 4.5 * u2 + 6.0 * u3 - 2.5 * u4,
            1.5 * u2 - 4.0 * u3 + 2.5 * u4,
        ]
    };
    let bend = |u: f64| {
        let (u2, u3) = (u * u, u * u * u);
        [
            60.0 * u - 180.0 * u2 + 120.0 * u3,
            -36.0 * u + 96.0 * u2 - 60.0 * u3,
            -24.0 * u + 84.0 * u2 - 60.0 * u3,
            1.0 - 9.0 * u + 18.0 * u2 - 10.0 * u3,
            3.0 * u - 12.0 * u2 + 10.0 * u3,
        ]
    };
    let terms = [
        to[0] - from[0],
        from[1] * t,
        to[1] * t,
        from[2] * t * t,
        to[2] * t * t,
    ];
    let sum = |b: [f64; 5]| b.iter().zip(terms).map(|(b, x)| b * x).sum::<f64>();
    [
        from[0] + sum(b(u)),
        sum(slope(u)) / t,
        sum(bend(u)) / (t * t),
    ]
}

fn knot(at_us: u64, [p, v, a]: [f64; 3]) -> Knot<1> {
    Knot {
        at_us,
        position: [p],
        velocity: [v],
        acceleration: Some([a]),
    }
}

proptest! {
    /// Two pieces, the second from any state to any other, from 1 µs to 71 minutes long.
    #[test]
    fn a_set_point_is_the_polynomial_within_the_bound(
        from in (-4000.0..4000.0f64, -1.0..1.0f64, -1.0..1.0f64), to in (-100.0..100.0f64, -1.0..1.0f64, -1.0..1.0f64),
        logarithm in 0.0..22.1f64, at in prop::collection::vec(0.0..1.0f64, 16),
    ) {
        let duration_us = libm::exp(logarithm) as u64 + 1;
        let t = 1e-6 * duration_us as f64;
        // so that each term is of the size of the way
        let start = [from.0, 100.0 * from.1 / t, 100.0 * from.2 / (t * t)];
        let end = [from.0 + to.0, 100.0 * to.1 / t, 100.0 * to.2 / (t * t)];
        let wide = AxisLimits { v: WIDE.v * (1.0 + 1.0 / t), a: WIDE.a * (1.0 + 1.0 / (t * t)), j: WIDE.j * (1.0 + 1.0 / (t * t * t)) };
        let mut edp = Path::<1, 4>::new([envelope(1e6, wide)], [Angle::bound(from.0)]).unwrap();
        edp.start(0).unwrap();
        edp.push(knot(duration_us, start), 0).unwrap();
        edp.push(knot(2 * duration_us, end), 0).unwrap();
        let mut times: Vec<u64> = at.iter().map(|x| (x * duration_us as f64) as u64).collect();
        times.sort_unstable();
        for since in times {
            let got = edp.step(duration_us + since).setpoint;
            let [p, v, a] = hermite(since as f64 / duration_us as f64, t, start, end);
            let off = (got.position[0].to_f64() - p) * 1_099_511_627_776.0;
            // and f64 here: 30 roundings of terms up to 15 times 100, and of the start
            let rounding = (30.0 * 1500.0 + from.0.abs()) * 2.3e-16 * 1_099_511_627_776.0;
            prop_assert!(off.abs() <= EVALUATION_QUANTA as f64 + rounding, "{off} quanta");
            // 24 bits of terms up to 60 and 180 times the way, ten roundings of each
            prop_assert!((f64::from(got.velocity[0]) - v).abs() * t <= 100.0 * 240.0 * 6e-7, "{v}");
            prop_assert!((f64::from(got.acceleration[0]) - a).abs() * t * t <= 100.0 * 1000.0 * 6e-7, "{a}");
        }
        let last = edp.step(2 * duration_us).setpoint.position[0];
        prop_assert_eq!(last, Angle::bound(end[0]));
    }

    /// Around a knot: positions, first and second differences are those of one smooth curve.
    #[test]
    fn pieces_meet_without_a_jump(
        before in (-1.0..1.0f64, -1.0..1.0f64, -1.0..1.0f64), at in (-1.0..1.0f64, -1.0..1.0f64, -1.0..1.0f64), duration_us in 2_000..200_000u64,
    ) {
        let t = 1e-6 * duration_us as f64;
        let state = |(p, v, a): (f64, f64, f64)| [p, v / t, a / (t * t)];
        let (begin, middle) = (state(before), state(at));
        let wide = AxisLimits { v: WIDE.v, a: WIDE.a, j: WIDE.j };
        let mut edp = Path::<1, 4>::new([envelope(1e3, wide)], [Angle::bound(begin[0])]).unwrap();
        edp.start(0).unwrap();
        edp.push(knot(duration_us, begin), 0).unwrap();
        edp.push(knot(2 * duration_us, middle), 0).unwrap();
        edp.push(knot(3 * duration_us, begin), 0).unwrap();
        let knot_us = 2 * duration_us;
        let [p, q, r] = [knot_us - 1, knot_us, knot_us + 1].map(|us| edp.step(us).setpoint);
        prop_assert_eq!(q.position[0], Angle::bound(middle[0]));
        // four and six roundings
        prop_assert!((f64::from(q.velocity[0]) - middle[1]).abs() <= 2.4e-7 * middle[1].abs());
        prop_assert!((f64::from(q.acceleration[0]) - middle[2]).abs() <= 3.6e-7 * middle[2].abs());
        // a microsecond before and behind: the state of the knot carries there, but for its jerk: the third
        // derivative of a quintic whose terms are at most 600 times the way
        let h = 1e-6;
        let jerk = 3000.0 / (t * t * t);
        for (s, h) in [(p, -h), (r, h)] {
            let expected = middle[0] + h * (middle[1] + 0.5 * h * middle[2]);
            let off = (s.position[0].to_f64() - expected) * 1_099_511_627_776.0;
            let bound = EVALUATION_QUANTA as f64 + 1.0 + jerk * h.abs() * h * h / 6.0 * 1_099_511_627_776.0;
            prop_assert!(off.abs() <= bound, "{off} quanta, {bound}");
            let v = f64::from(s.velocity[0]) - middle[1] - h * middle[2];
            // f32: ten roundings of terms up to 240 times the way
            prop_assert!(v.abs() <= 0.5 * jerk * h * h + 240.0 * 6e-7 / t, "{v}");
            let a = f64::from(s.acceleration[0]) - middle[2];
            prop_assert!(a.abs() <= jerk * h.abs() + 1000.0 * 6e-7 / (t * t), "{a}");
        }
    }

    /// Every position comes from a time, at any rate: on a rising piece none is less than the one before.
    #[test]
    fn path_time_rises_while_the_rate_changes(rates in prop::collection::vec((0.0..=1.0f64, 1..200u32), 1..20)) {
        let hard = AxisLimits { v: 4.0, a: 20.0, j: 800.0 };
        let mut edp = Path::<1, 4>::new([envelope(1e4, hard)], [Angle::ZERO]).unwrap();
        edp.start(0).unwrap();
        edp.push(knot(100_000_000, [100.0, 0.0, 0.0]), 0).unwrap();
        let (mut now, mut last) = (0, edp.step(0).setpoint.position[0]);
        for (rate, steps) in rates {
            edp.set_override(rate);
            for _ in 0..steps {
                now += 2_000;
                let position = edp.step(now).setpoint.position[0];
                // rounding may go back by the bound where nothing moves, not by more
                prop_assert!(position.since(last) >= -EVALUATION_QUANTA, "{}", position.since(last));
                last = position;
            }
        }
    }
}

#[test]
fn what_fixed_point_does_not_reach_is_refused() {
    let edp = |hold: f64| {
        let mut edp = Path::<1, 4>::new([envelope(8e6, WIDE)], [Angle::bound(hold)]).unwrap();
        edp.start(0).unwrap();
        edp
    };
    let rest = |at_us, p| knot(at_us, [p, 0.0, 0.0]);
    let hour = 3_600_000_000;
    assert!(edp(0.0).push(rest(hour, 8000.0), 0).is_ok());
    // 31 ways are more than 2^18
    assert!(matches!(
        edp(0.0).push(rest(hour, 9000.0), 0),
        Err(PushError::Far { axis: 0, value, limit: 262_144.0 }) if value > 278_999.0 && value < 279_001.0
    ));
    assert!(matches!(
        edp(5e6).push(rest(hour, 5e6), 0),
        Err(PushError::Far { axis: 0, .. })
    ));
    assert!(edp(0.0).push(rest(u64::from(u32::MAX), 1.0), 0).is_ok());
    assert_eq!(
        edp(0.0).push(rest(u64::from(u32::MAX) + 1, 1.0), 0),
        Err(PushError::Long)
    );
}
