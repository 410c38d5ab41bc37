//! The subsystems the tests speak about: one arm with everything, and the MP of two arms.

use agent::{Behaviour, Input, Step, Subsystem, args};

/// `C_j`: an axis at `e` rad, a force `v` in N, and what its neighbour says.
#[derive(Debug)]
pub(crate) enum Arm {}
impl Subsystem for Arm {
    type Level = args::Executor;
    type Coordination = f64;
    type Effector = f64;
    type Sensors = f64;
    type Transmissions = f64;
    type Command = f64;
}

/// `C_0` of two arms.
#[derive(Debug)]
pub(crate) enum Mp {}
impl Subsystem for Mp {
    type Level = args::Coordinator;
    type Coordination = ();
    type Effector = [f64; 2];
    type Sensors = f64;
    type Transmissions = ();
    type Command = [f64; 2];
}

/// What the arm perceives at `i`: `e = 1`, `c_0 = 10`, `T = 1000`, and the force `v`.
pub(crate) fn arm(i: u32, v: f64) -> Input<Arm> {
    Input {
        i,
        c0: 10.0,
        e: 1.0,
        v,
        t: 1000.0,
    }
}

/// All steps until the end, at most one for each force.
pub(crate) fn run(b: &mut (impl Behaviour<Arm> + ?Sized), forces: &[f64]) -> Vec<Step<f64>> {
    let mut steps = Vec::new();
    for (i, &v) in (0..).zip(forces) {
        let step = b.step(&arm(i, v));
        steps.push(step);
        if step == Step::Done {
            break;
        }
    }
    steps
}

/// A behaviour that plays the given steps, then ends.
#[derive(Clone, Debug)]
pub(crate) struct Script {
    steps: Vec<Step<f64>>,
    at: usize,
    /// How often it was begun.
    pub(crate) begun: u32,
}

impl Script {
    pub(crate) fn new(steps: &[Step<f64>]) -> Self {
        Self {
            steps: steps.to_vec(),
            at: 0,
            begun: 0,
        }
    }
}

impl Behaviour<Arm> for Script {
    fn begin(&mut self) {
        self.at = 0;
        self.begun += 1;
    }

    fn step(&mut self, _: &Input<Arm>) -> Step<f64> {
        let step = self.steps.get(self.at).copied().unwrap_or(Step::Done);
        self.at = (self.at + 1).min(self.steps.len());
        step
    }
}
