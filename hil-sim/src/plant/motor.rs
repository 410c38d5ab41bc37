//! The motor's winding: how its current follows what is demanded, and how warm that makes it.
//!
//! # Electrics
//!
//! The current loop lets the current approach its demand with a time constant. Where the winding is known, that
//! takes the voltage of R·i + L·di/dt + k·ω, with the torque constant k as the constant of the back-EMF (the same
//! number in SI units), and the supply gives no more than it has. With the voltage constant over a substep the
//! current is exactly
//!
//! ```text
//!   i⁺ = i·d + (V − k·ω)/R·(1 − d),   d = exp(−R·dt/L)
//! ```
//!
//! # Heat
//!
//! Two masses: R·i² heats the winding, which heats the housing, which heats the air. R grows with the winding's
//! temperature.

/// The temperatures are taken anew every so many substeps: every 0.1 s with the default substep, a hundredth of the
/// fastest time constant there is.
const HEAT_SUBSTEPS: u32 = 400;

/// Temperature coefficient of copper's resistance at 20 °C, 1/K (IEC 60028).
const COPPER_K: f64 = 0.003_93;

/// What is known of a winding and its housing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Winding {
    /// Resistance at 20 °C, Ω.
    pub resistance_ohm: f64,
    /// Inductance, H; 0 for none.
    pub inductance_h: f64,
    /// Greatest voltage of the power stage, V.
    pub supply_v: f64,
    /// Heat capacity of the winding, J/K.
    pub winding_j_k: f64,
    /// Heat capacity of the housing, J/K.
    pub housing_j_k: f64,
    /// Thermal resistance from winding to housing, K/W.
    pub winding_housing_k_w: f64,
    /// Thermal resistance from housing to air, K/W.
    pub housing_air_k_w: f64,
    /// Temperature of the air, °C.
    pub air_c: f64,
    /// The thermal switch in the winding opens above this, °C.
    pub trip_c: f64,
}

/// A winding in operation.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Warm {
    p: Winding,
    winding_c: f64,
    housing_c: f64,
    /// ∫i² since the temperatures were last taken, A²·s.
    squared_a2s: f64,
    substeps: u32,
    /// R, Ω, and exp(−R·dt/L), at the present temperature.
    resistance_ohm: f64,
    kept: f64,
}

/// A motor with its current loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Motor {
    current_a: f64,
    torque_constant_nm_a: f64,
    limit_a: f64,
    /// Part of the distance to its demand the current covers in a substep.
    part: f64,
    dt_s: f64,
    warm: Option<Warm>,
}

impl Warm {
    fn new(p: Winding, dt_s: f64) -> Self {
        let mut warm = Self {
            p,
            winding_c: p.air_c,
            housing_c: p.air_c,
            squared_a2s: 0.0,
            substeps: 0,
            resistance_ohm: p.resistance_ohm,
            kept: 0.0,
        };
        warm.take_resistance(dt_s);
        warm
    }

    fn take_resistance(&mut self, dt_s: f64) {
        let p = &self.p;
        self.resistance_ohm = p.resistance_ohm * (1.0 + COPPER_K * (self.winding_c - 20.0));
        self.kept = if p.inductance_h > 0.0 {
            libm::exp(-self.resistance_ohm * dt_s / p.inductance_h)
        } else {
            0.0
        };
    }

    /// The current nearest to `wanted_a` that the supply can drive, A, while the back-EMF is `back_v`.
    fn driven(&self, current_a: f64, wanted_a: f64, back_v: f64) -> f64 {
        let gone = 1.0 - self.kept;
        let needed_v = (wanted_a - current_a * self.kept) / gone * self.resistance_ohm + back_v;
        let supply_v = self.p.supply_v;
        if needed_v.abs() <= supply_v {
            return wanted_a;
        }
        let volt = needed_v.clamp(-supply_v, supply_v);
        current_a * self.kept + (volt - back_v) / self.resistance_ohm * gone
    }

    fn heat(&mut self, current_a: f64, dt_s: f64) {
        self.squared_a2s += current_a * current_a * dt_s;
        self.substeps += 1;
        if self.substeps < HEAT_SUBSTEPS {
            return;
        }
        let p = &self.p;
        let span_s = dt_s * f64::from(HEAT_SUBSTEPS);
        let flow_j = span_s * (self.winding_c - self.housing_c) / p.winding_housing_k_w;
        let lost_j = span_s * (self.housing_c - p.air_c) / p.housing_air_k_w;
        self.winding_c += (self.resistance_ohm * self.squared_a2s - flow_j) / p.winding_j_k;
        self.housing_c += (flow_j - lost_j) / p.housing_j_k;
        (self.squared_a2s, self.substeps) = (0.0, 0);
        self.take_resistance(dt_s);
    }
}

impl Motor {
    /// Without current and as warm as the air. `current_time_s`: time constant of the current loop.
    pub(super) fn new(
        torque_constant_nm_a: f64,
        limit_a: f64,
        current_time_s: f64,
        winding: Option<Winding>,
        dt_s: f64,
    ) -> Self {
        Self {
            current_a: 0.0,
            torque_constant_nm_a,
            limit_a,
            part: if current_time_s > 0.0 {
                1.0 - libm::exp(-dt_s / current_time_s)
            } else {
                1.0
            },
            dt_s,
            warm: winding.map(|winding| Warm::new(winding, dt_s)),
        }
    }

    /// One substep at a shaft velocity, rad/s: the torque, N·m. A demand that is no number is no torque.
    #[inline]
    pub(super) fn step(&mut self, torque_nm: f64, velocity_rad_s: f64) -> f64 {
        let wanted = torque_nm / self.torque_constant_nm_a;
        let wanted = if wanted.is_nan() {
            0.0
        } else {
            wanted.clamp(-self.limit_a, self.limit_a)
        };
        let next = self.current_a + self.part * (wanted - self.current_a);
        self.current_a = match &mut self.warm {
            Some(warm) => {
                let back_v = self.torque_constant_nm_a * velocity_rad_s;
                let driven = warm.driven(self.current_a, next, back_v);
                warm.heat(driven, self.dt_s);
                driven
            }
            None => next,
        };
        self.current_a * self.torque_constant_nm_a
    }

    /// A.
    pub(super) const fn current_a(&self) -> f64 {
        self.current_a
    }

    /// Temperature of the winding, °C, where it is known.
    pub(super) fn winding_c(&self) -> Option<f64> {
        self.warm.as_ref().map(|warm| warm.winding_c)
    }

    /// Is the thermal switch open?
    pub(super) fn is_hot(&self) -> bool {
        self.warm
            .as_ref()
            .is_some_and(|warm| warm.winding_c > warm.p.trip_c)
    }
}

#[cfg(test)]
mod tests;
