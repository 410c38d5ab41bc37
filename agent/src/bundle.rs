//! Several behaviours as one argument: tuples, arrays and lists.

use core::ops::DerefMut;

use crate::behaviour::Behaviour;
use crate::instruction::Step;
use crate::subsystem::{Input, Subsystem};

/// Behaviours addressed by an index `m`, counted from 0.
///
/// Tuples of up to eight behaviours of different types, arrays and [`List`]s of one type.
/// An index beyond the last one addresses a behaviour that has ended.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a bundle of behaviours of the subsystem `{S}`",
    label = "write a tuple of up to 8 behaviours, an array, or a `List`"
)]
pub trait Bundle<S: Subsystem> {
    /// How many there are.
    fn count(&self) -> usize;
    /// Begin the `m`-th.
    fn begin(&mut self, m: usize);
    /// Step the `m`-th.
    fn step(&mut self, m: usize, x: &Input<S>) -> Step<S::Command>;
}

/// The number of elements is known from the type: `N`.
pub trait Fixed<const N: usize> {}

/// What dereferences to a slice, as a bundle or as choices: `Vec<B>`, `Box<[B]>`, `&mut [B]`.
///
/// The robot and sensor lists of \[Z1\] §V are not these: they are the images in the
/// [`Subsystem`](crate::Subsystem).
#[derive(Clone, Copy, Debug, Default)]
pub struct List<L>(pub L);

impl<S, L, B> Bundle<S> for List<L>
where
    S: Subsystem,
    L: DerefMut<Target = [B]>,
    B: Behaviour<S>,
{
    fn count(&self) -> usize {
        self.0.len()
    }

    fn begin(&mut self, m: usize) {
        if let Some(b) = self.0.get_mut(m) {
            b.begin();
        }
    }

    fn step(&mut self, m: usize, x: &Input<S>) -> Step<S::Command> {
        self.0.get_mut(m).map_or(Step::Done, |b| b.step(x))
    }
}

impl<S: Subsystem, B: Behaviour<S>, const N: usize> Bundle<S> for [B; N] {
    fn count(&self) -> usize {
        N
    }

    fn begin(&mut self, m: usize) {
        if let Some(b) = self.get_mut(m) {
            b.begin();
        }
    }

    fn step(&mut self, m: usize, x: &Input<S>) -> Step<S::Command> {
        self.get_mut(m).map_or(Step::Done, |b| b.step(x))
    }
}

impl<B, const N: usize> Fixed<N> for [B; N] {}

macro_rules! tuple {
    ($n:literal: $($m:tt $B:ident),+) => {
        impl<S: Subsystem, $($B: Behaviour<S>),+> Bundle<S> for ($($B,)+) {
            fn count(&self) -> usize {
                $n
            }

            fn begin(&mut self, m: usize) {
                match m {
                    $( $m => self.$m.begin(), )+
                    _ => {}
                }
            }

            fn step(&mut self, m: usize, x: &Input<S>) -> Step<S::Command> {
                match m {
                    $( $m => self.$m.step(x), )+
                    _ => Step::Done,
                }
            }
        }
        impl<$($B),+> Fixed<$n> for ($($B,)+) {}
    };
}
tuple!(1: 0 B0);
tuple!(2: 0 B0, 1 B1);
tuple!(3: 0 B0, 1 B1, 2 B2);
tuple!(4: 0 B0, 1 B1, 2 B2, 3 B3);
tuple!(5: 0 B0, 1 B1, 2 B2, 3 B3, 4 B4);
tuple!(6: 0 B0, 1 B1, 2 B2, 3 B3, 4 B4, 5 B5);
tuple!(7: 0 B0, 1 B1, 2 B2, 3 B3, 4 B4, 5 B5, 6 B6);
tuple!(8: 0 B0, 1 B1, 2 B2, 3 B3, 4 B4, 5 B5, 6 B6, 7 B7);
