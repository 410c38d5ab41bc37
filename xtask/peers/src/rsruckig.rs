//! rsruckig: the port of Ruckig to Rust.

use crate::case::{Axis, Case};
use crate::clock;
use crate::plan::{Batch, Outcome, Phase, Plan};
use rsruckig::error::RuckigError;
use rsruckig::prelude::{
    DataArrayOrVec, InputParameter, Ruckig, RuckigResult, ThrowErrorHandler, Trajectory,
};
use rsruckig::profile::Profile;
use std::fmt;
use std::hint::black_box;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Cases in rsruckig's own types.
pub struct Rsruckig<const N: usize> {
    planner: Ruckig<N, ThrowErrorHandler>,
    trajectory: Trajectory<N>,
    inputs: Vec<InputParameter<N>>,
    kept: Vec<Trajectory<N>>,
}

impl<const N: usize> fmt::Debug for Rsruckig<N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Rsruckig with {} cases", self.inputs.len())
    }
}

impl<const N: usize> Rsruckig<N> {
    /// Copies the cases.
    #[must_use]
    pub fn new(cases: &[Case<N>]) -> Self {
        Self {
            // the period matters to its stepping only, which is not used
            planner: Ruckig::new(None, 0.001),
            trajectory: Trajectory::new(None),
            inputs: cases.iter().map(input).collect(),
            kept: Vec::new(),
        }
    }

    /// The name is what callgrind looks for.
    #[inline(never)]
    fn measured_work(&mut self) -> f64 {
        let mut sum = 0.0;
        for input in &self.inputs {
            let result = self.planner.calculate(input, &mut self.trajectory);
            let _ = black_box(result.is_ok());
            sum += self.trajectory.get_duration();
        }
        sum
    }
}

fn input<const N: usize>(case: &Case<N>) -> InputParameter<N> {
    let each = |of: fn(&Axis) -> f64| DataArrayOrVec::Stack(case.each_ref().map(of));
    let symmetric = case.iter().all(Axis::is_symmetric);
    let mut input = InputParameter::new(None);
    input.current_position = each(|x| x.p0);
    input.current_velocity = each(|x| x.v0);
    input.current_acceleration = each(|x| x.a0);
    input.target_position = each(|x| x.p1);
    input.target_velocity = each(|x| x.v1);
    input.target_acceleration = each(|x| x.a1);
    input.max_velocity = each(|x| x.v_max);
    input.max_acceleration = each(|x| x.a_max);
    input.max_jerk = each(|x| x.j_max);
    if !symmetric {
        input.min_velocity = Some(each(|x| x.v_min));
        input.min_acceleration = Some(each(|x| x.a_min));
    }
    input
}

fn phases(profile: &Profile) -> Vec<Phase> {
    let brake = &profile.brake;
    let parts = match brake.duration {
        d if d > 0.0 && brake.t[1] > 0.0 => 2,
        d if d > 0.0 => 1,
        _ => 0,
    };
    let braking = (0..parts).map(|i| Phase {
        t: brake.t[i],
        j: brake.j[i],
        a0: brake.a[i],
        v0: brake.v[i],
        p0: brake.p[i],
    });
    let moving = (0..profile.t.len()).map(|i| Phase {
        t: profile.t[i],
        j: profile.j[i],
        a0: profile.a[i],
        v0: profile.v[i],
        p0: profile.p[i],
    });
    braking.chain(moving).collect()
}

impl<const N: usize> Batch for Rsruckig<N> {
    fn plan(&mut self, index: usize) -> Outcome {
        let input = &self.inputs[index];
        let (planner, trajectory) = (&mut self.planner, &mut self.trajectory);
        // whatever it left half done is overwritten by the next call
        let result = catch_unwind(AssertUnwindSafe(|| planner.calculate(input, trajectory)));
        match result {
            Ok(Ok(RuckigResult::Working | RuckigResult::Finished)) => Outcome::Planned(Plan {
                duration: trajectory.get_duration(),
                axes: (0..N).map(|i| phases(&trajectory.profiles[0][i])).collect(),
            }),
            Ok(Ok(code)) => Outcome::Failed(format!("{code:?}")),
            Ok(Err(RuckigError::ValidationError(_))) => Outcome::Refused("invalid input".into()),
            Ok(Err(RuckigError::CalculatorError(why))) => {
                let kind = why.split([',', ':']).next().unwrap_or_default();
                Outcome::Failed(kind.trim().to_owned())
            }
            Err(_) => Outcome::Failed("panic".into()),
        }
    }

    fn run(&mut self) -> f64 {
        self.measured_work()
    }

    fn calls(&mut self, least_ns: &mut [f64]) {
        let (planner, trajectory) = (&mut self.planner, &mut self.trajectory);
        clock::calls(least_ns, &self.inputs, |input| {
            let _ = black_box(planner.calculate(input, trajectory).is_ok());
        });
    }

    fn keep(&mut self) {
        self.kept.clear();
        for input in &self.inputs {
            // cases that fail are not asked for here
            if self.planner.calculate(input, &mut self.trajectory).is_ok() {
                self.kept.push(self.trajectory.clone());
            }
        }
    }

    fn sample(&self, samples: usize) -> f64 {
        let new = || DataArrayOrVec::<f64, N>::new(None, 0.0);
        let (mut p, mut v, mut a, mut j) = (new(), new(), new(), new());
        let mut sum = 0.0;
        for plan in &self.kept {
            clock::ascending(plan.get_duration(), samples, |t| {
                plan.at_time(
                    t,
                    &mut Some(&mut p),
                    &mut Some(&mut v),
                    &mut Some(&mut a),
                    &mut Some(&mut j),
                    &mut None,
                );
                for axis in 0..N {
                    sum += p[axis] + v[axis] + a[axis] + j[axis];
                }
            });
        }
        sum
    }
}
