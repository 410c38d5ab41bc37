//! Judges set-points by their finite differences: the mean of a derivative over an interval is a value
//! between its extremes there, so a difference quotient above a limit proves that the limit was broken.
use motion::interpolator::{EVALUATION_QUANTA, Output};
use motion::profile::AxisLimits;
use motion::{Angle, AxisEnvelope, Status};

pub(crate) const STEP_US: u64 = 2_000;
const TS: f64 = 2e-3;
/// f32 has 24 bits, and the terms of a motion from rest to rest are up to 64 times their sum: ten roundings of that.
const NARROW: f64 = 64.0 * 10.0 / 16_777_216.0;

pub(crate) fn envelope(upper: f64, hard: AxisLimits) -> AxisEnvelope {
    AxisEnvelope::new(-upper, upper, hard)
}

pub(crate) struct Observer<const N: usize> {
    axes: [AxisEnvelope; N],
    seen: Vec<Output<N>>,
}

impl<const N: usize> Observer<N> {
    pub(crate) fn new(axes: &[AxisEnvelope; N]) -> Self {
        Self {
            axes: *axes,
            seen: Vec::new(),
        }
    }

    pub(crate) fn see(&mut self, output: &Output<N>) {
        self.seen.push(*output);
        for (i, axis) in self.axes.iter().enumerate() {
            let s = &output.setpoint;
            let hard = axis.hard;
            assert!(
                s.position[i] >= Angle::bound(axis.lower)
                    && s.position[i] <= Angle::bound(axis.upper),
                "position {output:?}"
            );
            let (v, a) = (f64::from(s.velocity[i]), f64::from(s.acceleration[i]));
            assert!(v.abs() <= hard.v * (1.0 + NARROW), "velocity {output:?}");
            assert!(
                a.abs() <= hard.a * (1.0 + NARROW),
                "acceleration {output:?}"
            );
            if matches!(
                output.status,
                Status::Idle | Status::Held | Status::Stopped { .. }
            ) {
                assert!(s.velocity[i] == 0.0 && s.acceleration[i] == 0.0);
            }
            self.differences(i, &hard);
        }
    }

    fn differences(&self, i: usize, hard: &AxisLimits) {
        let n = self.seen.len();
        let state = |back: usize| {
            n.checked_sub(back + 1).map(|k| {
                let s = &self.seen[k].setpoint;
                (
                    s.position[i].to_f64(),
                    f64::from(s.velocity[i]),
                    f64::from(s.acceleration[i]),
                )
            })
        };
        let (Some((p0, v0, a0)), Some((p1, v1, a1))) = (state(0), state(1)) else {
            return;
        };
        // what a position in fixed point is off at most, and f64 in this test
        let noise = EVALUATION_QUANTA as f64 * Angle::of_quanta(1).to_f64() + 1e-14 * p0.abs();
        let (narrow_v, narrow_a) = (NARROW * hard.v, NARROW * hard.a);
        let context = || format!("axis {i} {:?}", &self.seen[n.saturating_sub(3)..]);
        assert!(
            (p0 - p1).abs() <= hard.v * TS + 2.0 * noise,
            "velocity, {}",
            context()
        );
        assert!(
            (v0 - v1).abs() <= hard.a * TS + 2.0 * narrow_v,
            "acceleration, {}",
            context()
        );
        assert!(
            (a0 - a1).abs() <= hard.j * TS * (1.0 + 1e-9) + 2.0 * narrow_a,
            "jerk, {}",
            context()
        );
        // reported derivatives are the derivatives: trapezoid rules, error |f''|·h³/12
        assert!(
            (v0 - v1 - 0.5 * TS * (a0 + a1)).abs()
                <= 0.26 * hard.j * TS * TS + 2.0 * narrow_v + TS * narrow_a,
            "v' = a, {}",
            context()
        );
        let slack = hard.j * TS * TS * TS / 4.0 + 2.0 * noise + TS * narrow_v + TS * TS * narrow_a;
        assert!(
            (p0 - p1 - 0.5 * TS * (v0 + v1) + TS * TS * (a0 - a1) / 12.0).abs() <= slack,
            "p' = v, {}",
            context()
        );
        let (Some((p2, ..)), Some((p3, ..))) = (state(2), state(3)) else {
            return;
        };
        assert!(
            (p0 - 2.0 * p1 + p2).abs() <= hard.a * TS * TS + 4.0 * noise,
            "second difference, {}",
            context()
        );
        assert!(
            (p0 - 3.0 * p1 + 3.0 * p2 - p3).abs() <= hard.j * TS * TS * TS + 8.0 * noise,
            "third difference, {}",
            context()
        );
    }
}
