//! The smooth part of a motion: what the axes do of themselves, by weight, centrifugal and Coriolis torques.
//!
//! Their accelerations a = −M⁻¹·h are a smooth function of time, also where friction, brakes, stops and drives
//! make the velocity bend. They are evaluated once in a window of several substeps, and continued over the next
//! window by the polynomial through the last [`ORDER`] evaluations, which every substep integrates exactly:
//! an Adams–Bashforth method (Hairer, Nørsett, Wanner, "Solving Ordinary Differential Equations I", III.1)
//! that costs one evaluation a window whatever its order. What the next evaluation is more than it was foretold is
//! made good by then: the corrector of Adams and Moulton, without an evaluation of its own.
//!
//! Where an evaluation is not what the polynomial foretold (an axis that ran into a stop, a payload that fell
//! off), the past says nothing of the future, and the order begins again at 1.

/// The most evaluations a polynomial goes through.
pub(super) const ORDER: usize = 6;

/// An evaluation that differs from the forecast by more than this part of the greatest acceleration begins a
/// new polynomial. Motions as fast as an arm can bear change by less in a window.
const SURPRISE: f64 = 0.25;

/// What a substep takes of each evaluation, newest first.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Weights {
    /// s: the velocity gained per rad/s².
    velocity: [f64; ORDER],
    /// s²: the angle gained per rad/s², beside that of the velocity before.
    angle: [f64; ORDER],
}

/// The last evaluations, and what to make of them.
#[derive(Clone, Debug)]
pub(super) struct Smooth<const N: usize> {
    dt_s: f64,
    /// By order, then by substep of the window.
    weights: Vec<Weights>,
    substeps: u32,
    /// By order: the forecast at the end of the window.
    forecast: [[f64; ORDER]; ORDER],
    /// rad/s², newest first; all but `order` of them are 0.
    past: [[f64; N]; ORDER],
    order: usize,
    /// What the last evaluation was more than foretold, rad/s².
    surplus: [f64; N],
    /// What that adds at the beginning of the window, s to the velocities and s² to the angles.
    correction: [f64; 2],
    /// The same by order.
    corrections: [[f64; 2]; ORDER],
}

/// The coefficients, lowest power first, of the polynomial that is 1 at −`node` and 0 at the other ones of
/// 0, −1, … −(`order` − 1).
fn lagrange(order: u32, node: u32) -> [f64; ORDER] {
    let mut polynomial = [0.0; ORDER];
    polynomial[0] = 1.0;
    for other in (0..order).filter(|other| *other != node) {
        let (shift, scale) = (f64::from(other), 1.0 / (f64::from(other) - f64::from(node)));
        let mut lower = 0.0;
        for coefficient in &mut polynomial {
            let raised = scale * (lower + shift * *coefficient);
            lower = *coefficient;
            *coefficient = raised;
        }
    }
    polynomial
}

/// ∫ of a polynomial from `from` to `to`, and ∫ (to − s) of it, in units of the window.
fn integrals(polynomial: &[f64; ORDER], from: f64, to: f64) -> [f64; 2] {
    let (mut once, mut moment) = (0.0, 0.0);
    let (mut a, mut b) = (from, to);
    let mut power = 1.0;
    for coefficient in polynomial {
        once += coefficient * (b - a) / power;
        (a, b) = (a * from, b * to);
        moment += coefficient * (b - a) / (power + 1.0);
        power += 1.0;
    }
    [once, to * once - moment]
}

impl<const N: usize> Smooth<N> {
    /// Nothing known yet; windows of `substeps`.
    pub(super) fn new(substeps: u32) -> Self {
        Self {
            dt_s: 0.0,
            weights: Vec::new(),
            substeps,
            forecast: [[0.0; ORDER]; ORDER],
            past: [[0.0; N]; ORDER],
            order: 0,
            surplus: [0.0; N],
            correction: [0.0; 2],
            corrections: [[0.0; 2]; ORDER],
        }
    }

    /// Takes substeps of another length, which forgets the past.
    pub(super) fn pace(&mut self, dt_s: f64) {
        // the same number comes every time
        if self.dt_s.to_bits() == dt_s.to_bits() {
            return;
        }
        self.dt_s = dt_s;
        self.forget();
        self.weights.clear();
        let window_s = dt_s * f64::from(self.substeps);
        for (order, correction) in (1_u32..).zip(&mut self.corrections) {
            let [once, twice] = ahead(order);
            // a velocity corrected at the beginning of a substep moves its axis all through it
            *correction = [window_s * once, window_s * (window_s * twice + dt_s * once)];
        }
        for (order, forecast) in (1_u32..).zip(&mut self.forecast) {
            for (node, weight) in (0..order).zip(forecast) {
                *weight = lagrange(order, node).iter().sum();
            }
            for substep in 0..self.substeps {
                let share = |k: u32| f64::from(k) / f64::from(self.substeps);
                let mut weights = Weights {
                    velocity: [0.0; ORDER],
                    angle: [0.0; ORDER],
                };
                for (node, (velocity, angle)) in
                    (0..order).zip(weights.velocity.iter_mut().zip(&mut weights.angle))
                {
                    let basis = lagrange(order, node);
                    let [once, twice] = integrals(&basis, share(substep), share(substep + 1));
                    (*velocity, *angle) = (window_s * once, window_s * window_s * twice);
                }
                self.weights.push(weights);
            }
        }
    }

    /// The past says nothing of the future any more.
    pub(super) const fn forget(&mut self) {
        self.order = 0;
        self.correction = [0.0; 2];
    }

    /// The accelerations stay as they last were: there is nothing to evaluate.
    pub(super) fn hold(&mut self) {
        self.correction = [0.0; 2];
        self.order = usize::from(self.order > 0);
    }

    /// How many evaluations the polynomial goes through.
    pub(super) const fn order(&self) -> usize {
        self.order
    }

    /// The accelerations at the beginning of the next window, rad/s².
    pub(super) fn evaluated(&mut self, acceleration: &[f64; N]) {
        self.correction = [0.0; 2];
        if let Some(forecast) = self.order.checked_sub(1).and_then(|k| self.forecast.get(k)) {
            let (mut off, mut most) = (0.0, 0.0);
            for (axis, now) in acceleration.iter().enumerate() {
                let expected: f64 = forecast
                    .iter()
                    .zip(&self.past)
                    .map(|(weight, past)| weight * past[axis])
                    .sum();
                self.surplus[axis] = now - expected;
                off = larger(off, libm::fabs(now - expected));
                most = larger(most, libm::fabs(*now));
            }
            if off > SURPRISE * most {
                self.order = 0;
            } else if let Some(correction) = self.corrections.get(self.order - 1) {
                self.correction = *correction;
            }
        }
        if self.order == 0 {
            self.past = [[0.0; N]; ORDER];
        }
        self.past.rotate_right(1);
        self.past[0] = *acceleration;
        if self.order < ORDER {
            self.order += 1;
        }
    }

    /// What a substep of the window, from 0, adds to the velocities, rad/s, and to the angles beside that of
    /// the velocities before, rad.
    #[inline]
    pub(super) fn gains(&self, substep: u32) -> ([f64; N], [f64; N]) {
        let (mut velocity, mut angle) = ([0.0; N], [0.0; N]);
        let row = self.order.saturating_sub(1) * self.substeps as usize + substep as usize;
        if let Some(weights) = self.weights.get(row) {
            for ((past, wv), wa) in self.past.iter().zip(weights.velocity).zip(weights.angle) {
                for k in 0..N {
                    velocity[k] += wv * past[k];
                    angle[k] += wa * past[k];
                }
            }
        }
        if substep == 0 {
            let [of_velocity, of_angle] = self.correction;
            for k in 0..N {
                velocity[k] += of_velocity * self.surplus[k];
                angle[k] += of_angle * self.surplus[k];
            }
        }
        (velocity, angle)
    }
}

/// ∫ and ∫ (1 − s) from 0 to 1 of the polynomial that is 1 at 1 and 0 at 0, −1, … −(`order` − 1), in units of the
/// window.
fn ahead(order: u32) -> [f64; 2] {
    // it has a coefficient more than the others
    let mut polynomial = [0.0; ORDER + 1];
    polynomial[0] = 1.0;
    for node in 0..order {
        let (shift, scale) = (f64::from(node), 1.0 / (1.0 + f64::from(node)));
        let mut lower = 0.0;
        for coefficient in &mut polynomial {
            let raised = scale * (lower + shift * *coefficient);
            lower = *coefficient;
            *coefficient = raised;
        }
    }
    let (mut once, mut moment, mut power) = (0.0, 0.0, 1.0);
    for coefficient in polynomial {
        once += coefficient / power;
        moment += coefficient / (power + 1.0);
        power += 1.0;
    }
    [once, once - moment]
}

fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The classical coefficients of Adams and Bashforth (same book, III.1, table 1.1).
    #[test]
    fn a_window_of_one_substep_is_the_classical_method() {
        let mut smooth = Smooth::<1>::new(1);
        smooth.pace(1.0);
        let rows: [&[f64]; 4] = [
            &[1.0],
            &[1.5, -0.5],
            &[23.0 / 12.0, -16.0 / 12.0, 5.0 / 12.0],
            &[55.0 / 24.0, -59.0 / 24.0, 37.0 / 24.0, -9.0 / 24.0],
        ];
        for (weights, row) in smooth.weights.iter().zip(rows) {
            for (weight, expected) in weights.velocity.iter().zip(row) {
                // sums of some five fractions of order 1
                assert!((weight - expected).abs() < 1e-14, "{weights:?}");
            }
        }
    }

    /// The coefficients of Adams and Moulton's corrector (same book, III.1, table 1.2): 1/2, 5/12, 3/8, 251/720.
    #[test]
    fn the_correction_is_the_classical_one() {
        for (order, expected) in (1..).zip([0.5, 5.0 / 12.0, 3.0 / 8.0, 251.0 / 720.0]) {
            let [once, _] = ahead(order);
            assert!((once - expected).abs() < 1e-14, "{order}: {once}");
        }
    }

    #[test]
    fn polynomials_of_their_order_are_integrated_exactly() {
        let (dt_s, substeps) = (0.01, 3);
        let mut smooth = Smooth::<1>::new(substeps);
        smooth.pace(dt_s);
        // x = t⁷/42 has the acceleration t⁵
        let t_of = |window: u32, substep: u32| dt_s * f64::from(window * substeps + substep) + 2.0;
        for window in 0..8 {
            let t = t_of(window, 0);
            smooth.evaluated(&[t * t * t * t * t]);
        }
        assert_eq!(smooth.order(), ORDER);
        for substep in 0..substeps {
            let (t0, t1) = (t_of(7, substep), t_of(7, substep + 1));
            let power = |t: f64, n: i32| (0..n).fold(1.0, |p, _| p * t);
            let ([v], [x]) = smooth.gains(substep);
            let v_exact = (power(t1, 6) - power(t0, 6)) / 6.0;
            let x_exact = (power(t1, 7) - power(t0, 7)) / 42.0 - power(t0, 6) / 6.0 * (t1 - t0);
            // rounding of numbers up to 2.3⁷/42 = 8
            assert!((v - v_exact).abs() < 1e-13, "{v} {v_exact}");
            assert!((x - x_exact).abs() < 1e-13, "{x} {x_exact}");
        }
    }

    #[test]
    fn a_jump_begins_a_new_polynomial() {
        let mut smooth = Smooth::<2>::new(2);
        smooth.pace(0.001);
        for _ in 0..10 {
            smooth.evaluated(&[1.0, -2.0]);
        }
        assert_eq!(smooth.order(), ORDER);
        smooth.evaluated(&[1.0, 5.0]);
        assert_eq!(smooth.order(), 1);
        let ([a, b], _) = smooth.gains(0);
        assert!((a - 0.001).abs() < 1e-15 && (b - 0.005).abs() < 1e-15);
    }
}
