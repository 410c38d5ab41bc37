//! One polynomial piece of the path, as it is made of a knot and checked.

use crate::knot::{AxisEnvelope, Knot, Quantity};
use crate::polynomial::{Coefficients, cubic, derivative, evaluate, hulls, quintic, range};
use crate::scalar::{US_PER_S, float_us, larger, smaller};

/// Relative excess over a plan limit that counts as rounding.
const ROUNDING: f64 = 1e-9;

/// The state where a piece ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct End<const N: usize> {
    pub(crate) at_us: u64,
    pub(crate) position: [f64; N],
    pub(crate) velocity: [f64; N],
    pub(crate) acceleration: [f64; N],
}

/// Slower than this counts as rest, per s. Over a step of 2 ms it is 2e-12: nothing in a set-point.
const REST_VELOCITY: f64 = 1e-9;
/// And changing its velocity by less than this, per s².
const REST_ACCELERATION: f64 = 1e-7;

impl<const N: usize> End<N> {
    pub(crate) fn at_rest(at_us: u64, position: [f64; N]) -> Self {
        Self {
            at_us,
            position,
            velocity: [0.0; N],
            acceleration: [0.0; N],
        }
    }

    /// What is left by rounding, as in sin(6π), is rest too.
    pub(crate) fn is_at_rest(&self) -> bool {
        self.velocity.iter().all(|v| v.abs() <= REST_VELOCITY)
            && self
                .acceleration
                .iter()
                .all(|a| a.abs() <= REST_ACCELERATION)
    }

    pub(crate) fn axes(&self) -> impl Iterator<Item = [f64; 3]> + '_ {
        let derivatives = self.velocity.iter().zip(&self.acceleration);
        self.position
            .iter()
            .zip(derivatives)
            .map(|(p, (v, a))| [*p, *v, *a])
    }
}

/// A quantity of one axis beyond its limit.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Excess {
    pub(crate) axis: usize,
    pub(crate) quantity: Quantity,
    pub(crate) value: f64,
    pub(crate) limit: f64,
}

/// One polynomial per axis, in u = time in the piece / its duration.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Segment<const N: usize> {
    start_us: u64,
    per_s: f64,
    coefficients: [Coefficients; N],
    pub(crate) end: End<N>,
}

impl<const N: usize> Segment<N> {
    /// The piece from one state to the next knot; the knot is later.
    pub(crate) fn new(from: &End<N>, knot: &Knot<N>) -> Self {
        let t = float_us(knot.at_us.saturating_sub(from.at_us)) / US_PER_S;
        let mut end = End {
            at_us: knot.at_us,
            position: knot.position,
            velocity: knot.velocity,
            acceleration: knot.acceleration.unwrap_or([0.0; N]),
        };
        let mut coefficients = [[0.0; 6]; N];
        let scaled = |[p, v, a]: [f64; 3]| [p, v * t, a * t * t];
        for ((c, start), end) in coefficients.iter_mut().zip(from.axes()).zip(end.axes()) {
            let ([p0, v0, a0], [p1, v1, a1]) = (scaled(start), scaled(end));
            *c = if knot.acceleration.is_some() {
                quintic([p0, v0, a0], [p1, v1, a1])
            } else {
                cubic([p0, v0], [p1, v1])
            };
        }
        let per_s = 1.0 / t;
        if knot.acceleration.is_none() {
            for (a, c) in end.acceleration.iter_mut().zip(&coefficients) {
                let [_, _, dd] = evaluate(c, 1.0);
                *a = dd * per_s * per_s;
            }
        }
        Self {
            start_us: from.at_us,
            per_s,
            coefficients,
            end,
        }
    }

    pub(crate) const fn start_us(&self) -> u64 {
        self.start_us
    }

    pub(crate) const fn per_s(&self) -> f64 {
        self.per_s
    }

    pub(crate) const fn coefficients(&self) -> &[Coefficients; N] {
        &self.coefficients
    }

    /// Steps of acceleration where the piece begins, by magnitude.
    pub(crate) fn acceleration_step(&self, from: &End<N>) -> [f64; N] {
        let mut steps = from.acceleration;
        for (step, [_, _, c2, ..]) in steps.iter_mut().zip(&self.coefficients) {
            // the second derivative at u = 0
            *step = (2.0 * c2 * self.per_s * self.per_s - *step).abs();
        }
        steps
    }

    /// The first quantity that leaves the plan limits anywhere in the piece.
    ///
    /// `reach` holds the position limits of each axis. Exact: the quick test by the Bernstein hull can
    /// only accept, and what it does not accept is decided by the extrema.
    pub(crate) fn excess(
        &self,
        axes: &[AxisEnvelope; N],
        reach: &[(f64, f64); N],
    ) -> Option<Excess> {
        let each = self.coefficients.iter().zip(axes).zip(reach);
        for (axis, ((c, envelope), (lower, upper))) in (0..N).zip(each) {
            let size = c.iter().fold(0.0, |sum, c| sum + c.abs());
            let rounding = 1e-14 * size;
            let (one, two) = (self.per_s, self.per_s * self.per_s);
            let symmetric = |limit: f64| (-limit, limit, limit * ROUNDING);
            let tests = [
                (Quantity::Position, 1.0, (*lower, *upper, rounding)),
                (Quantity::Velocity, one, symmetric(envelope.plan.v)),
                (Quantity::Acceleration, two, symmetric(envelope.plan.a)),
                (Quantity::Jerk, one * two, symmetric(envelope.plan.j)),
            ];
            let tests = tests.into_iter().zip(hulls(c));
            for (order, ((quantity, scale, (low, high, tolerance)), hull)) in (0..4).zip(tests) {
                let inside = |(l, h): (f64, f64)| {
                    l * scale >= low - tolerance && h * scale <= high + tolerance
                };
                if inside(hull) {
                    continue;
                }
                let polynomial = (0..order).fold(*c, |p, _| derivative(&p));
                let (l, h) = range(&polynomial);
                if !inside((l, h)) {
                    let (value, limit) = if h * scale <= high + tolerance {
                        (l * scale, low)
                    } else {
                        (h * scale, high)
                    };
                    return Some(Excess {
                        axis,
                        quantity,
                        value,
                        limit,
                    });
                }
            }
        }
        None
    }
}

/// The position limits of each axis, widened to hold a position that lies outside already: from
/// there an axis may return, not go further.
pub(crate) fn reach_from<const N: usize>(
    axes: &[AxisEnvelope; N],
    position: &[f64; N],
) -> [(f64, f64); N] {
    let mut reach = [(0.0, 0.0); N];
    for ((bounds, axis), p) in reach.iter_mut().zip(axes).zip(position) {
        *bounds = (smaller(axis.lower, *p), larger(axis.upper, *p));
    }
    reach
}
