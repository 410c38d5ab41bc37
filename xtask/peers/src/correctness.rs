//! Very many cases, every plan judged, on all cores.

use crate::case::Case;
use crate::class::Class;
use crate::judge::judge;
use crate::plan::Outcome;
use crate::planner::Planner;
use crate::tally::{Judged, Tallies};
use std::num::NonZero;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;

/// Cases a thread takes at once.
const CHUNK: u64 = 1024;

/// Asks every planner the first `count` cases of a class.
///
/// Which thread does what changes nothing: counts are sums, the worst is the worst, examples are the
/// lowest; only the last digits of sums of durations may differ between runs.
///
/// # Panics
/// If a thread does, or N is not one of [`AXES`](crate::ruckig::AXES).
#[must_use]
pub fn run<const N: usize>(class: Class, seed: u64, count: u64) -> Tallies {
    let threads = thread::available_parallelism().map_or(1, NonZero::get);
    let next = AtomicU64::new(0);
    let work = || {
        let mut tallies = Tallies::default();
        loop {
            let begin = next.fetch_add(CHUNK, Ordering::Relaxed);
            if begin >= count {
                return tallies;
            }
            let end = count.min(begin + CHUNK);
            chunk::<N>(class, seed, begin..end, &mut tallies);
            if end * 10 / count > begin * 10 / count {
                eprintln!("   {class}: {end} of {count}");
            }
        }
    };
    let mut all = Tallies::default();
    thread::scope(|scope| {
        let workers: Vec<_> = (0..threads).map(|_| scope.spawn(work)).collect();
        for worker in workers {
            all.merge(&worker.join().expect("a worker"));
        }
    });
    all
}

fn chunk<const N: usize>(
    class: Class,
    seed: u64,
    indices: std::ops::Range<u64>,
    tallies: &mut Tallies,
) {
    let cases: Vec<Case<N>> = indices
        .clone()
        .map(|index| class.case(seed, index))
        .collect();
    let mut batches = Planner::ALL.map(|planner| planner.batch(&cases));
    for ((index, case), at) in indices.zip(&cases).zip(0..) {
        let said = batches.each_mut().map(|batch| {
            let outcome = batch.plan(at);
            let amounts = match &outcome {
                Outcome::Planned(plan) => Some(judge(case, plan)),
                Outcome::Refused(_) | Outcome::Failed(_) => None,
            };
            Judged { outcome, amounts }
        });
        tallies.note(index, &said);
    }
}
