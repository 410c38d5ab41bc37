//! Servo laws for cst: from the demand and the encoder to a motor current.
//!
//! Sign convention: positive error (demand ahead of actual) gives positive current gives positive
//! motor acceleration.

/// The constants of MRROC++'s regulator, one set per axis.
///
/// The law is one second-order difference equation on *increments* per servo step, in encoder
/// impulses, with e = Δr − Δy:
/// ```text
/// δ[k] = δ[k−1] + (1+ε)·e[k] − (1−ε)·e[k−1]
/// u[k] = (1+a)·u[k−1] − a·u[k−2] + b0·δ[k] − b1·δ[k−1],   |u| ≤ u_max
/// ```
/// On the position error E = Σe this is a PID with a filter pole at a. `u` is in the original's
/// PWM counts; `ma_per_count` turns it into a current (as the successor of MRROC++ on the same
/// robots does).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OriginalGains {
    /// ε: weight of the integral of the position error.
    pub epsilon: f32,
    /// a: pole of the filter.
    pub a: f32,
    /// b0
    pub b0: f32,
    /// b1
    pub b1: f32,
    /// Saturation of u, PWM counts (190 of 255 in the original).
    pub u_max: f32,
    /// Motor current per PWM count, mA.
    pub ma_per_count: f32,
}

/// The state of [`OriginalGains`]' difference equation.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OriginalState {
    e: f32,
    delta: f32,
    u1: f32,
    u2: f32,
    last_actual: Option<i64>,
}

impl OriginalState {
    /// The state in which the law goes on giving this current, mA, as long as nothing moves.
    #[must_use]
    pub fn holding(gains: &OriginalGains, current_ma: f32) -> Self {
        let u = clamp(current_ma / gains.ma_per_count, gains.u_max);
        // Standing still, u settles where (1−a)·(u1−u2) = (b0−b1)·δ; with u1 = u2 that is δ = 0.
        Self {
            u1: u,
            u2: u,
            ..Self::default()
        }
    }

    /// How far the axis has moved since the last step, drive units.
    pub fn moved(&mut self, actual: i64) -> i64 {
        moved(&mut self.last_actual, actual)
    }
}

fn moved(last: &mut Option<i64>, actual: i64) -> i64 {
    actual.wrapping_sub(last.replace(actual).unwrap_or(actual))
}

impl OriginalGains {
    /// One servo step: increments of demand and of encoder, impulses → current, mA.
    ///
    /// The saturated u is what is fed back, so the output does not wind up.
    pub fn step(&self, s: &mut OriginalState, demanded_inc: f32, measured_inc: f32) -> f32 {
        let e = demanded_inc - measured_inc;
        let delta = s.delta + (1.0 + self.epsilon) * e - (1.0 - self.epsilon) * s.e;
        // (1+a)·u1 − a·u2 so that what does not change is kept to the bit
        let held = s.u1 + self.a * (s.u1 - s.u2);
        let u = held + self.b0 * delta - self.b1 * s.delta;
        let u = clamp(u, self.u_max);
        *s = OriginalState {
            e,
            delta,
            u1: u,
            u2: s.u1,
            last_actual: s.last_actual,
        };
        u * self.ma_per_count
    }
}

/// PID on motor position with velocity and acceleration feed-forward.
///
/// ```text
/// i = kp·E + ki·∫E dt + kd·(v_d − v) + kv·v_d + kc·sign(v_d) + ka·a_d,   |i| ≤ i_max
/// ```
/// The integral stops while the output is saturated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FeedForwardGains {
    /// mA per rad.
    pub kp: f32,
    /// mA per rad·s.
    pub ki: f32,
    /// mA per rad/s.
    pub kd: f32,
    /// Viscous friction compensation, mA per rad/s.
    pub kv: f32,
    /// Coulomb friction compensation, mA.
    pub kc: f32,
    /// Inertia compensation, mA per rad/s².
    pub ka: f32,
    /// Saturation, mA.
    pub i_max: f32,
}

/// The state of [`FeedForwardGains`]' law.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FeedForwardState {
    integral: f32,
    last_actual: Option<i64>,
}

impl FeedForwardState {
    /// The state in which the law goes on giving this current, mA, at standstill without error.
    #[must_use]
    pub fn holding(gains: &FeedForwardGains, current_ma: f32) -> Self {
        let integral = if gains.ki > 0.0 {
            clamp(current_ma, gains.i_max) / gains.ki
        } else {
            0.0
        };
        Self {
            integral,
            last_actual: None,
        }
    }

    /// How far the axis has moved since the last step, drive units.
    pub fn moved(&mut self, actual: i64) -> i64 {
        moved(&mut self.last_actual, actual)
    }
}

/// What the law follows in one step, and how far it is from it; rad of the motor shaft.
///
/// Positions are compared in drive units, so that only their differences have the 24 bits of f32.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Demand {
    /// Demand less actual position, rad.
    pub error: f32,
    /// What is measured, rad/s.
    pub measured_velocity: f32,
    /// rad/s
    pub velocity: f32,
    /// rad/s²
    pub acceleration: f32,
}

/// Bandwidth of the modern regulator's position loop, rad/s.
///
/// The loop's delay is one and a half servo steps (sample to latch, and half of the hold): 3 ms at
/// 2 ms. At 90 rad/s that costs 15° of phase, which critical damping has to spare.
const BANDWIDTH_RAD_S: f64 = 90.0;
/// The same for direct drives: what a motor feels of the links changes with the posture and the other axes. All
/// loops of Polycrank together act as one on an axis 5.4 times as easy to turn as they are designed for: at
/// 40 rad/s its damping crosses at 2·40·5.4 = 430 rad/s, where the delay costs 75° of phase.
const DIRECT_BANDWIDTH_RAD_S: f64 = 40.0;
/// Damping ratio of its two fast poles.
const DAMPING: f64 = 1.0;
/// The integral's pole is so much slower than the bandwidth.
const INTEGRAL_RATIO: f64 = 8.0;
/// The same for direct drives: stable up to 2·10 times the inertia they are designed for, which is about what Polycrank
/// has without a payload.
const DIRECT_INTEGRAL_RATIO: f64 = 10.0;

impl FeedForwardGains {
    /// Gains for a motor and its load: J·ω², 2ζJ·ω and so on over the torque constant, mA.
    #[must_use]
    pub fn design(axis: &robots::AxisDescription) -> Self {
        let (motor, i_max) = (&axis.motor, axis.current_regulator.limit_ma);
        let (w, integral_ratio) = if axis.is_direct() {
            (DIRECT_BANDWIDTH_RAD_S, DIRECT_INTEGRAL_RATIO)
        } else {
            (BANDWIDTH_RAD_S, INTEGRAL_RATIO)
        };
        let per_torque = 1000.0 / motor.torque_constant_nm_a;
        let inertia = (motor.rotor_kg_m2 + motor.load_kg_m2) * per_torque;
        Self {
            kp: narrow(inertia * w * w),
            ki: narrow(inertia * w * w * w / integral_ratio),
            kd: narrow(2.0 * DAMPING * inertia * w),
            kv: narrow(motor.viscous_nms_rad * per_torque),
            kc: narrow(motor.coulomb_nm * per_torque),
            ka: narrow(inertia),
            i_max: narrow(i_max),
        }
    }

    /// One servo step of `ts` seconds → current, mA.
    pub fn step(&self, s: &mut FeedForwardState, demand: &Demand, ts: f32) -> f32 {
        let Demand {
            error,
            measured_velocity,
            velocity,
            acceleration,
        } = *demand;
        let direction = velocity / (libm::fabsf(velocity) + COULOMB_BLEND_RAD_S);
        let raw = self.kp * error
            + self.ki * s.integral
            + self.kd * (velocity - measured_velocity)
            + self.kv * velocity
            + self.kc * direction
            + self.ka * acceleration;
        let i = clamp(raw, self.i_max);
        if libm::fabsf(raw) < self.i_max {
            s.integral += error * ts;
        }
        i
    }
}

/// Below this speed the Coulomb compensation fades out instead of switching sign, rad/s.
const COULOMB_BLEND_RAD_S: f32 = 0.5;

fn clamp(x: f32, bound: f32) -> f32 {
    if x > bound {
        bound
    } else if x < -bound {
        -bound
    } else {
        x
    }
}

/// The nearest float of 32 bits: what constants of a description are in a servo step.
#[expect(clippy::cast_possible_truncation, reason = "24 bits are enough")]
pub(crate) const fn narrow(x: f64) -> f32 {
    x as f32
}

#[cfg(test)]
mod test {
    use super::*;

    /// Axis "column": MRROC++ `NL_2`.
    const NL_2: OriginalGains = OriginalGains {
        epsilon: 0.010,
        a: 0.412_429_4,
        b0: 1.556_959_2,
        b1: 1.502_861_4,
        u_max: 190.0,
        ma_per_count: 200.0,
    };

    /// U/E = [(1+ε) − (1−ε)z⁻¹](b0 − b1 z⁻¹) / [(1 − z⁻¹)(1 − a z⁻¹)] on the position error,
    /// written as a direct-form filter: an independent realisation of the same law.
    fn transfer_function(position_errors: &[f64], out: &mut [f64]) {
        let OriginalGains {
            epsilon, a, b0, b1, ..
        } = NL_2;
        let [epsilon, a, b0, b1] = [epsilon, a, b0, b1].map(f64::from);
        let n = [
            (1.0 + epsilon) * b0,
            -(1.0 + epsilon) * b1 - (1.0 - epsilon) * b0,
            (1.0 - epsilon) * b1,
        ];
        for k in 0..position_errors.len() {
            let at = |d: usize| if k >= d { position_errors[k - d] } else { 0.0 };
            let y = |d: usize, out: &[f64]| if k >= d { out[k - d] } else { 0.0 };
            out[k] =
                (1.0 + a) * y(1, out) - a * y(2, out) + n[0] * at(0) + n[1] * at(1) + n[2] * at(2);
        }
    }

    #[test]
    fn the_original_is_a_filtered_pid_on_position() {
        let increments = [3.0, 1.0, -2.0, 0.0, 5.0, 0.5, -4.0, 0.0, 0.0, 1.0];
        let mut sum = 0.0;
        let errors = increments.map(|e| {
            sum += e;
            sum
        });
        let mut expected = [0.0; 10];
        transfer_function(&errors, &mut expected);
        let mut s = OriginalState::default();
        for (e, want) in increments.iter().zip(expected) {
            #[expect(clippy::cast_possible_truncation, reason = "halves")]
            let e = *e as f32;
            let got = f64::from(NL_2.step(&mut s, e, 0.0) / NL_2.ma_per_count);
            // ten steps, each a few roundings of numbers below 20
            assert!(
                (got - want).abs() < 20.0 * 10.0 * 4.0 * 6e-8,
                "{got} {want}"
            );
        }
    }

    #[test]
    fn saturation_is_fed_back() {
        let mut s = OriginalState::default();
        for _ in 0..100 {
            assert!(NL_2.step(&mut s, 50.0, 0.0) <= 190.0 * 200.0);
        }
        // the error reverses: the output must leave saturation at once, not after unwinding
        assert!(NL_2.step(&mut s, -5000.0, 0.0) < 190.0 * 200.0);
    }

    #[test]
    fn feed_forward_alone_carries_a_perfectly_modelled_axis() {
        let gains = FeedForwardGains {
            kp: 100.0,
            ki: 10.0,
            kd: 5.0,
            kv: 2.0,
            kc: 0.0,
            ka: 3.0,
            i_max: 1e4,
        };
        let mut s = FeedForwardState::default();
        let ts = 0.002;
        for _ in 0..100 {
            let d = Demand {
                error: 0.0,
                measured_velocity: 7.0,
                velocity: 7.0,
                acceleration: 0.0,
            };
            let i = gains.step(&mut s, &d, ts);
            assert!((i - 14.0).abs() < 1e-5, "{i}");
        }
        // each error is answered by its gain: 100·0.1, 5·2, 3·4, and what 0.1 leaves in the integral
        let d = Demand {
            error: 0.1,
            measured_velocity: 5.0,
            velocity: 7.0,
            acceleration: 4.0,
        };
        for expected in [46.0, 46.002] {
            let i = gains.step(&mut s, &d, ts);
            assert!((i - expected).abs() < 2e-5, "{i}");
        }
    }

    #[test]
    fn what_holds_an_axis_is_held_to_the_bit() {
        let mut s = OriginalState::holding(&NL_2, 1234.5);
        let first = NL_2.step(&mut s, 0.0, 0.0);
        for _ in 0..100_000 {
            assert_eq!(NL_2.step(&mut s, 0.0, 0.0).to_bits(), first.to_bits());
        }
        assert!((first - 1234.5).abs() < 1e-3);
    }

    #[test]
    fn the_first_movement_is_none() {
        let mut s = FeedForwardState::default();
        assert_eq!((s.moved(1 << 60), s.moved((1 << 60) + 3)), (0, 3));
        assert_eq!(s.moved(-(1 << 60)), -(1 << 61) - 3);
    }
}
