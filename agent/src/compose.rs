//! Composition: one demand out of the partial results of several behaviours.

use crate::behaviour::Behaviour;
use crate::bundle::{Bundle, Fixed};
use crate::instruction::Step;
use crate::subsystem::{Command, Input, Subsystem};

/// A composition operator of \[Z2\] (18): one result of `n` partial ones.
///
/// `None` is a behaviour that made no demand in this step.
pub trait Composition<Y, const N: usize> {
    /// The composed result; `None` where there is nothing to compose.
    fn compose(&self, partial: [Option<Y>; N]) -> Option<Y>;
}

/// The endless loop \[Z2\] (18): all behaviours make their step, then the results are composed.
///
/// `if p then` is written by a [`Reaction`](crate::Reaction) as a behaviour. A behaviour that has
/// ended takes no further part. Ends when all have ended; holds where no one demands.
#[derive(Clone, Copy, Debug)]
pub struct Compose<B, K, const N: usize> {
    bundle: B,
    by: K,
}

/// Competitive composition \[Z2\] (16): one of the results is selected.
///
/// The selection function is [`Greatest`], [`First`], or [`Inhibit`] and [`Suppress`] around one.
///
/// ```
/// # use agent::{args::{self, F, V}, function, Behaviour, Compete, Greatest, Input, Step, Subsystem};
/// # struct Cart;
/// # impl Subsystem for Cart {
/// #     type Level = args::Executor;
/// #     type Coordination = ();
/// #     type Effector = ();
/// #     type Sensors = f64;
/// #     type Transmissions = ();
/// #     type Command = f64;
/// # }
/// let mut flee = Compete::new(
///     (
///         function::<Cart, F<(), (), V>, _>(|x| 2.0 - x.v()),
///         function::<Cart, F<(), (), ()>, _>(|_| 0.5),
///     ),
///     Greatest(|y: &f64| *y),
/// );
/// let x = Input::<Cart> { i: 0, c0: (), e: (), v: 1.0, t: () };
/// assert_eq!(flee.step(&x), Step::Demand(1.0));
/// ```
pub type Compete<B, K, const N: usize> = Compose<B, K, N>;

/// Cooperative composition \[Z2\] (17): the weighted sum of the results.
///
/// Only where demands form a vector space: velocities, wrenches, offsets; see [`Vector`].
pub type Superpose<B, const N: usize> = Compose<B, Sum<N>, N>;

impl<B: Fixed<N>, K, const N: usize> Compose<B, K, N> {
    /// The behaviours of `bundle`, composed by `by`.
    pub const fn new(bundle: B, by: K) -> Self {
        Self { bundle, by }
    }
}

impl<B: Fixed<N>, const N: usize> Superpose<B, N> {
    /// `Σ w_m · ^m f` over the behaviours of `bundle`.
    pub const fn weighted(bundle: B, weights: [f64; N]) -> Self {
        Self::new(bundle, Sum(weights))
    }
}

impl<S, B, K, const N: usize> Behaviour<S> for Compose<B, K, N>
where
    S: Subsystem,
    B: Bundle<S>,
    K: Composition<S::Command, N>,
{
    fn begin(&mut self) {
        (0..N).for_each(|m| self.bundle.begin(m));
    }

    fn step(&mut self, x: &Input<S>) -> Step<S::Command> {
        let mut partial = [const { None }; N];
        let mut ended = true;
        for (m, y) in partial.iter_mut().enumerate() {
            match self.bundle.step(m, x) {
                Step::Demand(demand) => (*y, ended) = (Some(demand), false),
                Step::Hold => ended = false,
                Step::Done => {}
            }
        }
        if ended {
            return Step::Done;
        }
        self.by.compose(partial).map_or(Step::Hold, Step::Demand)
    }
}

/// `max` of \[Z2\] (16): the result of the greatest worth, the first of equals.
///
/// The paper needs real numbers for its maximum; here a function gives each demand its real
/// number. A worth that is NaN loses against any number.
#[derive(Clone, Copy, Debug)]
pub struct Greatest<W>(pub W);

impl<Y, W: Fn(&Y) -> f64, const N: usize> Composition<Y, N> for Greatest<W> {
    fn compose(&self, partial: [Option<Y>; N]) -> Option<Y> {
        let mut best: Option<(f64, Y)> = None;
        for y in partial.into_iter().flatten() {
            let worth = (self.0)(&y);
            let wins = best
                .as_ref()
                .is_none_or(|(b, _)| worth > *b || b.is_nan() && !worth.is_nan());
            if wins {
                best = Some((worth, y));
            }
        }
        best.map(|(_, y)| y)
    }
}

/// The first result in the order of the bundle: layers of fixed priority, the highest first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct First;

impl<Y, const N: usize> Composition<Y, N> for First {
    fn compose(&self, partial: [Option<Y>; N]) -> Option<Y> {
        partial.into_iter().flatten().next()
    }
}

/// A connection from one behaviour of a bundle to the output of another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Wire {
    /// The index of the behaviour that acts on the other.
    pub by: usize,
    /// The index of the behaviour whose output is acted on.
    pub of: usize,
}

/// Brooks' inhibition as a selection function: while `by` demands, the result of `of` is
/// eliminated. What is left is composed by `K`.
///
/// All wires act at once, on the results as computed: two behaviours may eliminate each other.
#[derive(Clone, Copy, Debug)]
pub struct Inhibit<'w, K> {
    /// Who eliminates whom.
    pub wires: &'w [Wire],
    /// The composition of the rest.
    pub then: K,
}

impl<Y, K: Composition<Y, N>, const N: usize> Composition<Y, N> for Inhibit<'_, K> {
    fn compose(&self, mut partial: [Option<Y>; N]) -> Option<Y> {
        let active = partial.each_ref().map(Option::is_some);
        for wire in self.wires {
            if active.get(wire.by) == Some(&true)
                && let Some(y) = partial.get_mut(wire.of)
            {
                *y = None;
            }
        }
        self.then.compose(partial)
    }
}

/// Brooks' suppression as a selection function: while `by` demands, its result takes the place of
/// the result of `of`. What then stands in the places is composed by `K`.
///
/// A substituted place counts as a result even if `of` made no demand. Of several wires to one
/// place, the last that is active wins. All act at once, on the results as computed.
#[derive(Clone, Copy, Debug)]
pub struct Suppress<'w, K> {
    /// Who takes whose place.
    pub wires: &'w [Wire],
    /// The composition of the places.
    pub then: K,
}

impl<Y: Clone, K: Composition<Y, N>, const N: usize> Composition<Y, N> for Suppress<'_, K> {
    fn compose(&self, partial: [Option<Y>; N]) -> Option<Y> {
        let mut places = partial.clone();
        for wire in self.wires {
            if let Some(Some(y)) = partial.get(wire.by)
                && let Some(place) = places.get_mut(wire.of)
            {
                *place = Some(y.clone());
            }
        }
        self.then.compose(places)
    }
}

/// The linear combination of \[Z2\] (17), with one weight for each behaviour.
///
/// `yc^{i+1} = Σ w_m · ^m f_c(xc^i)` over the behaviours that made a demand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sum<const N: usize>(pub [f64; N]);

impl<Y: Vector, const N: usize> Composition<Y, N> for Sum<N> {
    fn compose(&self, partial: [Option<Y>; N]) -> Option<Y> {
        partial
            .into_iter()
            .zip(self.0)
            .filter_map(|(y, w)| Some(y?.scaled(w)))
            .reduce(Vector::plus)
    }
}

/// A quantity with a linear structure: velocities, wrenches, offsets, but never poses.
///
/// Implemented by hand for a quantity, because having `+` and `·` is not enough: the sum of two
/// positions is no position.
#[diagnostic::on_unimplemented(
    message = "`{Self}` cannot be superposed: it is not a vector",
    label = "(17) adds demands, and demands of this type cannot be added",
    note = "poses compete (`Compete`); velocities, wrenches and offsets superpose: implement `agent::Vector` for those"
)]
pub trait Vector {
    /// `w · self`
    #[must_use]
    fn scaled(self, w: f64) -> Self;
    /// `self + other`
    #[must_use]
    fn plus(self, other: Self) -> Self;
}

impl Vector for f64 {
    fn scaled(self, w: f64) -> Self {
        w * self
    }

    fn plus(self, other: Self) -> Self {
        self + other
    }
}

impl Vector for () {
    fn scaled(self, _: f64) {}

    fn plus(self, (): ()) {}
}

impl<Y: Vector + Copy, const N: usize> Vector for [Y; N] {
    fn scaled(self, w: f64) -> Self {
        self.map(|y| y.scaled(w))
    }

    fn plus(mut self, other: Self) -> Self {
        for (a, b) in self.iter_mut().zip(other) {
            *a = a.plus(b);
        }
        self
    }
}

impl<E: Vector, V: Vector, T: Vector> Vector for Command<E, V, T> {
    fn scaled(self, w: f64) -> Self {
        Self {
            e: self.e.scaled(w),
            v: self.v.scaled(w),
            t: self.t.scaled(w),
        }
    }

    fn plus(self, other: Self) -> Self {
        Self {
            e: self.e.plus(other.e),
            v: self.v.plus(other.v),
            t: self.t.plus(other.t),
        }
    }
}
