//! A process: a behaviour under an error condition.

use crate::behaviour::Behaviour;
use crate::error::ErrorCondition;
use crate::instruction::Step;
use crate::record::{Recorder, TotalState};
use crate::subsystem::{Input, Subsystem};

/// What one step of a process came to: the three branches of \[Z1\] (4) and (5).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[must_use = "a demand that is not transmitted is lost"]
pub enum Outcome<Y, Fault> {
    /// The instruction runs: attain this by the next instant.
    Demand(Y),
    /// The instruction runs: stay, `e^{i+1} = e^i`.
    Hold,
    /// The program has ended as it should, `e^{i_m}`.
    Ended {
        /// `i_m`: the instant in which it ended.
        at: u32,
    },
    /// The program was ended by `f_E`, `e^{i_m*}`.
    Error {
        /// `i_m*`: the instant in which the error was found.
        at: u32,
        /// What is wrong.
        fault: Fault,
    },
}

/// How a process ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum End<Fault> {
    Ended { at: u32 },
    Error { at: u32, fault: Fault },
}

/// The executor of one behaviour under an error condition.
///
/// In every step `f_E` is checked first, and wins: where `f_E` and `f_τ` (or `f_I`) are true in
/// the same step, the process ends with the error. Ends are final until [`begin`](Self::begin).
#[derive(Clone, Copy, Debug)]
pub struct Process<B, Q, Fault> {
    behaviour: B,
    error: Q,
    end: Option<End<Fault>>,
}

impl<B, Q, Fault: Clone> Process<B, Q, Fault> {
    /// `behaviour` under the error condition `error`.
    pub const fn new(behaviour: B, error: Q) -> Self {
        Self {
            behaviour,
            error,
            end: None,
        }
    }

    /// The behaviour, which is the own state `c_c` of the program.
    pub const fn behaviour(&self) -> &B {
        &self.behaviour
    }

    /// Has it ended, well or in error?
    pub const fn has_ended(&self) -> bool {
        self.end.is_some()
    }

    /// `i := i_0`: begin the behaviour again, after an error as well.
    pub fn begin<S: Subsystem>(&mut self)
    where
        B: Behaviour<S>,
    {
        self.end = None;
        self.behaviour.begin();
    }

    /// One step: `f_E(c, e, r)`, then the behaviour.
    ///
    /// `recorder` gets the total state, also of the step in which the process ends; once it has
    /// ended nothing is recorded. Pass `&mut ()` to record nothing.
    pub fn step<S, C, R>(
        &mut self,
        x: &Input<S>,
        c: &C,
        r: &R,
        recorder: &mut (impl Recorder<S, B, Fault> + ?Sized),
    ) -> Outcome<S::Command, Fault>
    where
        S: Subsystem,
        C: ?Sized,
        R: ?Sized,
        B: Behaviour<S>,
        Q: ErrorCondition<S, C, R, Fault = Fault>,
    {
        match self.end.clone() {
            Some(End::Ended { at }) => return Outcome::Ended { at },
            Some(End::Error { at, fault }) => return Outcome::Error { at, fault },
            None => {}
        }
        let at = x.i;
        let outcome = match self.error.check(c, &x.e, r) {
            Err(fault) => {
                self.end = Some(End::Error {
                    at,
                    fault: fault.clone(),
                });
                Outcome::Error { at, fault }
            }
            Ok(()) => match self.behaviour.step(x) {
                Step::Demand(y) => Outcome::Demand(y),
                Step::Hold => Outcome::Hold,
                Step::Done => {
                    self.end = Some(End::Ended { at });
                    Outcome::Ended { at }
                }
            },
        };
        recorder.record(TotalState {
            i: at,
            c: &self.behaviour,
            x,
            y: &outcome,
        });
        outcome
    }
}
