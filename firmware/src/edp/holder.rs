//! The interpolator in its place: it is too large to be made anew by value whenever the axes begin to hold.

use crate::capacity::KNOT_QUEUE;
use motion::interpolator::{Braking, Range};
use motion::{Angle, Interpolator};

/// An interpolator that is in force, or not.
#[derive(Debug)]
pub(super) struct Holder<const N: usize> {
    interpolator: Interpolator<N, KNOT_QUEUE>,
    in_force: bool,
}

impl<const N: usize> Holder<N> {
    /// Not in force.
    pub(super) fn new(braking: Braking<N>) -> Self {
        Self {
            interpolator: Interpolator::new(braking),
            in_force: false,
        }
    }

    /// In force from now on, holding these positions.
    pub(super) fn hold(&mut self, ranges: &[Range; N], positions: [Angle; N]) {
        self.interpolator.hold_anew(ranges, positions);
        self.in_force = true;
    }

    /// Not in force any more.
    pub(super) const fn leave(&mut self) {
        self.in_force = false;
    }

    /// The interpolator, if it is in force.
    pub(super) fn get(&self) -> Option<&Interpolator<N, KNOT_QUEUE>> {
        self.in_force.then_some(&self.interpolator)
    }

    /// The same, to command it.
    pub(super) fn get_mut(&mut self) -> Option<&mut Interpolator<N, KNOT_QUEUE>> {
        self.in_force.then_some(&mut self.interpolator)
    }
}
