//! The planner of `motion`: the one that is measured.

use crate::case::Case;
use crate::clock;
use crate::plan::{Batch, Outcome, Phase, Plan};
use motion::profile::{
    AxisBounds, Boundary, ProfileError, Request, Synchronisation, Trajectory, TrajectoryError,
};
use std::hint::black_box;

/// Cases in `motion`'s own types.
#[derive(Debug)]
pub struct Ours<const N: usize> {
    trajectory: Trajectory<N>,
    requests: Vec<Request<N>>,
    kept: Vec<Trajectory<N>>,
}

impl<const N: usize> Ours<N> {
    /// Copies the cases.
    #[must_use]
    pub fn new(cases: &[Case<N>]) -> Self {
        Self {
            trajectory: Trajectory::empty(),
            requests: cases.iter().map(request).collect(),
            kept: Vec::new(),
        }
    }

    /// The name is what callgrind looks for.
    #[inline(never)]
    fn measured_work(&mut self) -> f64 {
        let mut sum = 0.0;
        for request in &self.requests {
            let _ = black_box(self.trajectory.plan(request));
            sum += self.trajectory.duration();
        }
        sum
    }
}

fn request<const N: usize>(case: &Case<N>) -> Request<N> {
    Request {
        start: case.map(|x| Boundary {
            p: x.p0,
            v: x.v0,
            a: x.a0,
        }),
        end: case.map(|x| Boundary {
            p: x.p1,
            v: x.v1,
            a: x.a1,
        }),
        bounds: case.map(|x| AxisBounds {
            v_min: x.v_min,
            v_max: x.v_max,
            a_min: x.a_min,
            a_max: x.a_max,
            j_max: x.j_max,
            p_min: f64::NEG_INFINITY,
            p_max: f64::INFINITY,
        }),
        synchronisation: Synchronisation::Time,
        minimum_duration: 0.0,
    }
}

/// A refusal of the question, or a failure to answer it?
fn no_plan(error: TrajectoryError) -> Outcome {
    let TrajectoryError { reason, .. } = error;
    match reason {
        ProfileError::NotRepresentable => Outcome::Failed(reason.to_string()),
        _ => Outcome::Refused(reason.to_string()),
    }
}

fn phases<const N: usize>(trajectory: &Trajectory<N>, axis: usize) -> Vec<Phase> {
    let mut phases = Vec::new();
    for own in trajectory.phases(axis) {
        phases.push(Phase {
            t: own.t,
            j: own.j,
            a0: own.a0,
            v0: own.v0,
            p0: own.p0,
        });
    }
    phases
}

impl<const N: usize> Batch for Ours<N> {
    fn plan(&mut self, index: usize) -> Outcome {
        match self.trajectory.plan(&self.requests[index]) {
            Ok(()) => Outcome::Planned(Plan {
                duration: self.trajectory.duration(),
                axes: (0..N).map(|axis| phases(&self.trajectory, axis)).collect(),
            }),
            Err(error) => no_plan(error),
        }
    }

    fn run(&mut self) -> f64 {
        self.measured_work()
    }

    fn calls(&mut self, least_ns: &mut [f64]) {
        clock::calls(least_ns, &self.requests, |request| {
            let _ = black_box(self.trajectory.plan(request));
        });
    }

    fn keep(&mut self) {
        let plans = self.requests.iter().map(Trajectory::new);
        self.kept = plans.filter_map(Result::ok).collect();
    }

    fn sample(&self, samples: usize) -> f64 {
        let mut sum = 0.0;
        for trajectory in &self.kept {
            let mut sampler = trajectory.sampler();
            clock::ascending(trajectory.duration(), samples, |t| {
                for axis in sampler.at(t) {
                    sum += axis.p + axis.v + axis.a + axis.j;
                }
            });
        }
        sum
    }
}
