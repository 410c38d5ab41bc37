//! The regulators' constants against their design, and in a simulated loop.

use core::f64::consts::TAU;

use robots::{AxisDescription, Rnt, Robot};

const STEP_S: f64 = 1e-3;
const SUBSTEPS: u32 = 50;

/// The design of the crate's documentation, with functions where constants have numbers.
#[test]
fn gains_place_the_poles() {
    for axis in &Rnt.description().axes {
        let (r, m) = (axis.pwm_regulator, axis.motor);
        let omega = 150.0;
        let (slow, fast) = (
            (5.0 - libm::sqrt(8.0)) / 17.0 * omega,
            (5.0 + libm::sqrt(8.0)) / 17.0 * omega,
        );
        // by z1·T/2 for its tangent
        assert!((r.epsilon - libm::tanh(0.5 * slow * STEP_S)).abs() < 1e-6);
        assert!((r.b1 / r.b0 - libm::exp(-fast * STEP_S)).abs() < 1e-12);
        // at low frequencies i/E is K·z1·z2/s: per step, (2ε)(b0 − b1)/(1 − a) of a unit an increment
        let inertia = m.rotor_kg_m2 + m.load_kg_m2;
        let k = 17.0 / 8.0 * omega * inertia / m.torque_constant_nm_a;
        let integral = k * slow * fast;
        let amperes = axis.current_regulator.gain_ma * 1e-3;
        let per_rad = f64::from(axis.increments_per_turn) / TAU;
        let ours = 2.0 * r.epsilon * (r.b0 - r.b1) / (1.0 - r.a) / STEP_S * amperes * per_rad;
        // zeros at e^(−zT) ≈ 1 − zT: second order in zT, 0.07
        assert!((ours / integral - 1.0).abs() < 0.06, "{ours} {integral}");
        // all of the current, no more
        let most = r.limit * axis.current_regulator.gain_ma;
        assert!((most - axis.current_regulator.limit_ma).abs() < 1e-9);
    }
}

/// The motor with `load` times its inertia, current loop 0.3 ms, encoder in whole increments, and the
/// regulator's output one step late, as on the bus.
struct Loop<'a> {
    axis: &'a AxisDescription,
    inertia: f64,
    weight_nm: f64,
    angle: f64,
    velocity: f64,
    current: f64,
    pending: f64,
    demanded: f64,
    counted: f64,
    // the regulator's memory
    e: f64,
    delta: f64,
    u: [f64; 2],
}

impl<'a> Loop<'a> {
    fn new(axis: &'a AxisDescription, load: f64, weight_nm: f64) -> Self {
        let m = axis.motor;
        Self {
            axis,
            inertia: load * (m.rotor_kg_m2 + m.load_kg_m2),
            weight_nm,
            angle: 0.0,
            velocity: 0.0,
            current: 0.0,
            pending: 0.0,
            demanded: 0.0,
            counted: 0.0,
            e: 0.0,
            delta: 0.0,
            u: [0.0; 2],
        }
    }

    /// One servo step towards `demand`, rad; the position error, increments.
    fn step(&mut self, demand: f64) -> f64 {
        let per_rad = f64::from(self.axis.increments_per_turn) / TAU;
        let counted = libm::floor(self.angle * per_rad);
        let e = (demand - self.demanded) * per_rad - (counted - self.counted);
        (self.demanded, self.counted) = (demand, counted);
        let applied = self.pending;
        let r = self.axis.pwm_regulator;
        let delta = self.delta + (1.0 + r.epsilon) * e - (1.0 - r.epsilon) * self.e;
        let u = (1.0 + r.a) * self.u[0] - r.a * self.u[1] + r.b0 * delta - r.b1 * self.delta;
        let u = u.clamp(-r.limit, r.limit);
        (self.e, self.delta, self.u) = (e, delta, [u, self.u[0]]);
        self.pending = u * self.axis.current_regulator.gain_ma * 1e-3;
        let (m, dt) = (self.axis.motor, STEP_S / f64::from(SUBSTEPS));
        for _ in 0..SUBSTEPS {
            self.current += (applied - self.current) * dt / 0.3e-3;
            let drive = m.torque_constant_nm_a * self.current - self.weight_nm;
            let friction =
                m.viscous_nms_rad * self.velocity + m.coulomb_nm * libm::tanh(self.velocity / 0.05);
            self.velocity += (drive - friction) / self.inertia * dt;
            self.angle += self.velocity * dt;
        }
        demand * per_rad - counted
    }
}

/// Up to 250 rad/s with the planning acceleration (rounded by a sine), on for a while, and down.
fn demand(t: f64) -> f64 {
    let ramp = 0.3;
    // ∫ of v·(1 − cos πt/T)/2, 250 rad/s: at most 1309 rad/s²
    let rising = |t: f64| {
        let t = t.clamp(0.0, ramp);
        250.0
            * 0.5
            * (t - libm::sin(core::f64::consts::PI * t / ramp) * ramp / core::f64::consts::PI)
    };
    let after = |t: f64| if t > ramp { 250.0 * (t - ramp) } else { 0.0 };
    let upward = |t: f64| rising(t) + after(t);
    upward(t) - upward(t - 0.6)
}

#[test]
fn the_loop_follows_and_comes_to_rest_with_half_and_with_double_the_inertia() {
    for axis in &Rnt.description().axes {
        for load in [0.5, 1.0, 2.0] {
            // 30 kg on one screw
            let mut simulated = Loop::new(axis, load, 30.0 * 9.81 * 0.010 / TAU);
            let (mut most, mut at_rest) = (0.0_f64, 0.0_f64);
            for k in 0..2500 {
                let t = f64::from(k) * STEP_S;
                let error = simulated.step(demand(t - 0.5)).abs();
                if t > 0.5 {
                    most = if error > most { error } else { most };
                }
                if t > 2.0 {
                    at_rest = if error > at_rest { error } else { at_rest };
                }
            }
            // far from the trip, and 2.5 µm of a leg at rest
            assert!(
                most < 0.4 * f64::from(axis.following_error_increments),
                "{} x{load}: {most} increments",
                axis.name
            );
            assert!(
                at_rest <= 2.0,
                "{} x{load}: {at_rest} increments",
                axis.name
            );
        }
    }
}

#[test]
fn a_loop_of_four_times_the_gain_does_not() {
    // the simulation can tell a bad design: a quarter of the inertia is four times the gain
    let axis = &Rnt.description().axes[0];
    let mut simulated = Loop::new(axis, 0.25, 0.0);
    let mut most = 0.0_f64;
    for k in 0..1000 {
        let error = simulated.step(if k < 5 { 0.0 } else { 0.05 }).abs();
        if k > 500 {
            most = if error > most { error } else { most };
        }
    }
    assert!(most > 20.0, "{most}");
}
