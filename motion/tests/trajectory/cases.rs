//! What is asked in these tests: limits of any shape, states inside and outside them.
use motion::profile::{AxisBounds, Boundary, Request, Synchronisation, Trajectory};
use proptest::prelude::*;

pub(crate) const ENDLESS: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);

pub(crate) fn smaller(a: f64, b: f64) -> f64 {
    if b < a { b } else { a }
}

pub(crate) fn larger(a: f64, b: f64) -> f64 {
    if b > a { b } else { a }
}

/// Limits equal in both directions, without a range of positions.
pub(crate) fn symmetric(v: f64, a: f64, j: f64) -> AxisBounds {
    AxisBounds {
        v_min: -v,
        v_max: v,
        a_min: -a,
        a_max: a,
        j_max: j,
        p_min: ENDLESS.0,
        p_max: ENDLESS.1,
    }
}

pub(crate) fn at(p: f64, v: f64, a: f64) -> Boundary {
    Boundary { p, v, a }
}

/// One axis alone.
pub(crate) fn alone(start: Boundary, end: Boundary, bounds: AxisBounds) -> Request<1> {
    Request {
        start: [start],
        end: [end],
        bounds: [bounds],
        synchronisation: Synchronisation::Time,
        minimum_duration: 0.0,
    }
}

/// One axis of a request.
pub(crate) fn axis<const N: usize>(request: &Request<N>, i: usize) -> Request<1> {
    alone(request.start[i], request.end[i], request.bounds[i])
}

/// How long one axis takes; it must be possible.
pub(crate) fn duration<const N: usize>(request: &Request<N>) -> f64 {
    Trajectory::new(request).unwrap().duration()
}

/// A value of any magnitude between 10^lo and 10^hi.
fn magnitude(lo: f64, hi: f64) -> impl Strategy<Value = f64> {
    (lo..hi).prop_map(libm::exp10)
}

/// Limits between 10^lo and 10^hi, every other one different by direction.
pub(crate) fn bounds(lo: f64, hi: f64) -> impl Strategy<Value = AxisBounds> {
    let m = move || magnitude(lo, hi);
    (m(), m(), m(), m(), m(), any::<bool>()).prop_map(|(v, a, j, v_down, a_down, alike)| {
        let mut bounds = symmetric(v, a, j);
        if !alike {
            (bounds.v_min, bounds.a_min) = (-v_down, -a_down);
        }
        bounds
    })
}

/// A state that can be left (`sign` 1) or reached (`sign` -1) within the limits: while its acceleration is
/// brought to zero, or was before, the velocity stays inside.
fn inside(bounds: &AxisBounds, u: (f64, f64, f64), sign: f64) -> Boundary {
    let AxisBounds {
        v_min,
        v_max,
        a_min,
        a_max,
        j_max,
        ..
    } = *bounds;
    // half of the span of velocities is the most that acceleration may need
    let most = libm::sqrt(j_max * (v_max - v_min));
    let a = if u.2 > 0.0 {
        u.2 * smaller(a_max, most)
    } else {
        u.2 * smaller(-a_min, most)
    };
    let needed = 0.5 * a * a / j_max;
    let (low, high) = if a * sign > 0.0 {
        (v_min, v_max - needed)
    } else {
        (v_min + needed, v_max)
    };
    let v = low + (high - low) * (0.5 + 0.5 * u.1);
    at(4.0 * u.0, smaller(larger(v, low), high), a)
}

fn unit() -> impl Strategy<Value = (f64, f64, f64)> {
    // exact zeros and limits are as likely as the rest: there the cases meet
    let u = || prop_oneof![4 => -1.0..1.0f64, 1 => Just(0.0), 1 => Just(1.0), 1 => Just(-1.0)];
    (-1.0..1.0f64, u(), u())
}

/// One axis between two states inside its limits.
pub(crate) fn within(lo: f64, hi: f64) -> impl Strategy<Value = Request<1>> {
    (bounds(lo, hi), unit(), unit()).prop_map(|(bounds, from, to)| {
        alone(
            inside(&bounds, from, 1.0),
            inside(&bounds, to, -1.0),
            bounds,
        )
    })
}

/// The same from a start up to twice the limits.
pub(crate) fn from_anywhere(lo: f64, hi: f64) -> impl Strategy<Value = Request<1>> {
    (bounds(lo, hi), unit(), unit()).prop_map(|(bounds, from, to)| {
        let reach = |u: f64, low: f64, high: f64| 2.0 * if u > 0.0 { u * high } else { -u * low };
        // not so much acceleration that hundreds of limits of velocity cannot be avoided
        let most = 0.5 * libm::sqrt(bounds.j_max * (bounds.v_max - bounds.v_min));
        let start = at(
            4.0 * from.0,
            reach(from.1, bounds.v_min, bounds.v_max),
            reach(
                from.2,
                larger(bounds.a_min, -most),
                smaller(bounds.a_max, most),
            ),
        );
        alone(start, inside(&bounds, to, -1.0), bounds)
    })
}

/// Several axes between states inside their limits.
pub(crate) fn several<const N: usize>(
    one: impl Strategy<Value = Request<1>>,
) -> impl Strategy<Value = Request<N>> {
    proptest::collection::vec(one, N).prop_map(|axes| Request {
        start: core::array::from_fn(|i| axes[i].start[0]),
        end: core::array::from_fn(|i| axes[i].end[0]),
        bounds: core::array::from_fn(|i| axes[i].bounds[0]),
        synchronisation: Synchronisation::Time,
        minimum_duration: 0.0,
    })
}

/// The lowest and the highest position of an axis, sampled finely and at every end of a phase.
pub(crate) fn reach<const N: usize>(trajectory: &Trajectory<N>, i: usize) -> (f64, f64) {
    let mut reach = (f64::INFINITY, f64::NEG_INFINITY);
    for phase in trajectory.phases(i) {
        for k in 0..=200 {
            let p = phase.at(phase.t * f64::from(k) / 200.0).p;
            reach = (smaller(reach.0, p), larger(reach.1, p));
        }
    }
    reach
}

/// How far the end of the last phase is from the asked state: position, velocity, acceleration.
pub(crate) fn missed<const N: usize>(
    trajectory: &Trajectory<N>,
    request: &Request<N>,
    i: usize,
) -> [f64; 3] {
    let (asked, from) = (request.end[i], request.start[i]);
    let last = trajectory.phases(i).last().map_or(from, |phase| {
        let state = phase.at(phase.t);
        at(state.p, state.v, state.a)
    });
    [last.p - asked.p, last.v - asked.v, last.a - asked.a].map(f64::abs)
}
