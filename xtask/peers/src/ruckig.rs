//! Ruckig: the C++ original, through the loops of `ruckig.cpp`.
#![expect(unsafe_code, reason = "calls C++")]

use crate::case::{Axis, Case};
use crate::plan::{Batch, Outcome, Phase, Plan};
use std::ffi::{c_int, c_void};
use std::marker::PhantomData;
use std::ptr::NonNull;

/// Numbers of axes for which `ruckig.cpp` has an instance.
pub const AXES: [usize; 5] = [1, 2, 3, 6, 7];

const MAX_PHASES: usize = 9;

#[derive(Clone, Copy)]
#[repr(C)]
struct AxisPhases {
    count: usize,
    phases: [Phase; MAX_PHASES],
}

const _: () = assert!(size_of::<Axis>() == 11 * size_of::<f64>());
const _: () = assert!(size_of::<AxisPhases>() == size_of::<usize>() + MAX_PHASES * 5 * 8);

unsafe extern "C" {
    fn ruckig_batch(axes: usize, cases: *const Axis, count: usize) -> *mut c_void;
    fn ruckig_free(batch: *mut c_void);
    fn ruckig_plan(
        batch: *mut c_void,
        index: usize,
        duration: *mut f64,
        axes: *mut AxisPhases,
    ) -> c_int;
    fn ruckig_run(batch: *mut c_void) -> f64;
    fn ruckig_calls(batch: *mut c_void, least_ns: *mut f64);
    fn ruckig_keep(batch: *mut c_void);
    fn ruckig_sample(batch: *const c_void, samples: usize) -> f64;
}

/// Cases in Ruckig's own types.
#[derive(Debug)]
pub struct Ruckig<const N: usize> {
    batch: NonNull<c_void>,
    count: usize,
    of: PhantomData<[Axis; N]>,
}

impl<const N: usize> Ruckig<N> {
    /// Copies the cases.
    ///
    /// # Panics
    /// If N is not one of [`AXES`].
    #[must_use]
    pub fn new(cases: &[Case<N>]) -> Self {
        // SAFETY: `cases` are so many times N axes in a row, which the other side copies.
        let batch = unsafe { ruckig_batch(N, cases.as_ptr().cast(), cases.len()) };
        Self {
            batch: NonNull::new(batch).expect("an instance for so many axes"),
            count: cases.len(),
            of: PhantomData,
        }
    }
}

impl<const N: usize> Batch for Ruckig<N> {
    fn plan(&mut self, index: usize) -> Outcome {
        assert!(index < self.count);
        let mut duration = f64::NAN;
        let mut axes = [AxisPhases {
            count: 0,
            phases: [Phase::default(); MAX_PHASES],
        }; N];
        // SAFETY: the index is in the batch, which has N axes.
        let code = unsafe {
            ruckig_plan(
                self.batch.as_ptr(),
                index,
                &raw mut duration,
                axes.as_mut_ptr(),
            )
        };
        match code {
            0.. => Outcome::Planned(Plan {
                duration,
                axes: axes
                    .iter()
                    .map(|axis| axis.phases[..axis.count].to_vec())
                    .collect(),
            }),
            -100 => Outcome::Refused("invalid input (-100)".into()),
            -101 => Outcome::Failed("duration out of range (-101)".into()),
            -104 => Outcome::Failed("zero limits (-104)".into()),
            -110 => Outcome::Failed("no extremal time (-110)".into()),
            -111 => Outcome::Failed("no synchronisation (-111)".into()),
            other => Outcome::Failed(format!("code {other}")),
        }
    }

    fn run(&mut self) -> f64 {
        // SAFETY: the batch lives as long as `self`, here and below.
        unsafe { ruckig_run(self.batch.as_ptr()) }
    }

    fn calls(&mut self, least_ns: &mut [f64]) {
        assert_eq!(least_ns.len(), self.count);
        // SAFETY: there is a number for each case.
        unsafe { ruckig_calls(self.batch.as_ptr(), least_ns.as_mut_ptr()) }
    }

    fn keep(&mut self) {
        // SAFETY: as in `run`.
        unsafe { ruckig_keep(self.batch.as_ptr()) }
    }

    fn sample(&self, samples: usize) -> f64 {
        // SAFETY: as in `run`; the other side changes nothing.
        unsafe { ruckig_sample(self.batch.as_ptr(), samples) }
    }
}

impl<const N: usize> Drop for Ruckig<N> {
    fn drop(&mut self) {
        // SAFETY: made by `ruckig_batch`, not freed before.
        unsafe { ruckig_free(self.batch.as_ptr()) }
    }
}
