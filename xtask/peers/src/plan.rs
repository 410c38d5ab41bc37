//! The answer of a planner, whoever gave it.

/// A stretch of time with constant jerk: `p(τ) = p0 + v0·τ + a0·τ²/2 + j·τ³/6`, τ in \[0, t\].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub struct Phase {
    /// Length, s.
    pub t: f64,
    /// Jerk.
    pub j: f64,
    /// Acceleration at its beginning.
    pub a0: f64,
    /// Velocity at its beginning.
    pub v0: f64,
    /// Position at its beginning.
    pub p0: f64,
}

/// A motion of all axes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Plan {
    /// Its length, s.
    pub duration: f64,
    /// The phases of each axis, in order.
    pub axes: Vec<Vec<Phase>>,
}

/// What a planner says to a case.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    /// It has a motion.
    Planned(Plan),
    /// It does not take the question: its own check of the input failed.
    Refused(String),
    /// It took the question and found no motion.
    Failed(String),
}

/// Cases in a planner's own types, and what can be asked of it about them.
pub trait Batch {
    /// Plans one of the cases and hands out its phases.
    fn plan(&mut self, index: usize) -> Outcome;

    /// The work that is timed: plans every case once; the sum of the durations, s.
    fn run(&mut self) -> f64;

    /// Times every call alone on the monotonic clock, ns, and keeps the time if it is the least.
    fn calls(&mut self, least_ns: &mut [f64]);

    /// Plans every case once and keeps the motions, to be sampled.
    fn keep(&mut self);

    /// Samples every motion kept at so many ascending times; the sum of all numbers got.
    fn sample(&self, samples: usize) -> f64;
}
