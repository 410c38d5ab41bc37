//! Total states, and where they go.

use core::fmt;

use crate::process::Outcome;
use crate::subsystem::{Input, Subsystem};

/// The total state of a control subsystem, valid when step `i` has been computed. \[Z2\] (9).
///
/// The inputs as of `i`, the own state as changed by the step (`c_c^{i+1}`, written `i′` in the
/// paper), and the outputs for `i + 1`. Borrowed: a recorder copies what it wants to keep. The
/// inputs alone suffice to repeat a run to the byte, because every function is pure.
pub struct TotalState<'s, S: Subsystem, B: ?Sized, Fault> {
    /// `i`
    pub i: u32,
    /// `c_c`: the behaviour itself, which is all the state there is between steps.
    pub c: &'s B,
    /// `xc`: what was perceived.
    pub x: &'s Input<S>,
    /// `yc`: what was demanded, or how the program ended.
    pub y: &'s Outcome<S::Command, Fault>,
}

impl<S: Subsystem, B: ?Sized, Fault> Clone for TotalState<'_, S, B, Fault> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<S: Subsystem, B: ?Sized, Fault> Copy for TotalState<'_, S, B, Fault> {}

impl<S, B, Fault> fmt::Debug for TotalState<'_, S, B, Fault>
where
    S: Subsystem,
    Input<S>: fmt::Debug,
    B: fmt::Debug + ?Sized,
    S::Command: fmt::Debug,
    Fault: fmt::Debug,
{
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("TotalState")
            .field("i", &self.i)
            .field("c", &self.c)
            .field("x", &self.x)
            .field("y", &self.y)
            .finish()
    }
}

/// Receives the total state of every step.
///
/// `()` records nothing; a closure `|state: TotalState<'_, S, B, Fault>|` is a recorder.
pub trait Recorder<S: Subsystem, B: ?Sized, Fault> {
    /// One step was computed.
    fn record(&mut self, state: TotalState<'_, S, B, Fault>);
}

impl<S: Subsystem, B: ?Sized, Fault> Recorder<S, B, Fault> for () {
    fn record(&mut self, _: TotalState<'_, S, B, Fault>) {}
}

impl<S, B, Fault, F> Recorder<S, B, Fault> for F
where
    S: Subsystem,
    B: ?Sized,
    F: FnMut(TotalState<'_, S, B, Fault>),
{
    fn record(&mut self, state: TotalState<'_, S, B, Fault>) {
        self(state);
    }
}
