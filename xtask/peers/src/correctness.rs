//! Very many cases, every plan judged, on all cores.

use crate::apart::Apart;
use crate::case::{Axis, Case};
use crate::class::Class;
use crate::judge::judge;
use crate::plan::Outcome;
use crate::planner::Planner;
use crate::tally::{Judged, Tallies};
use std::io;
use std::num::NonZero;
use std::ops::Range;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;

/// Cases a thread takes at once.
const CHUNK: u64 = 1024;

/// Asks every planner the first `count` cases of a class.
///
/// Which thread does what changes nothing: counts are sums, the worst is the worst, examples are the
/// lowest; only the last digits of sums of durations may differ between runs.
///
/// `program` is what Ruckig is run in: it calls [`apart::serve`](crate::apart::serve) first of all.
///
/// # Errors
/// Ruckig's own process cannot be started.
///
/// # Panics
/// If a thread does, or N is not one of [`AXES`](crate::ruckig::AXES).
pub fn run<const N: usize>(
    program: &Path,
    class: Class,
    seed: u64,
    count: u64,
) -> io::Result<Tallies> {
    let threads = thread::available_parallelism().map_or(1, NonZero::get);
    let next = AtomicU64::new(0);
    let work = || -> io::Result<Tallies> {
        let mut tallies = Tallies::default();
        loop {
            let begin = next.fetch_add(CHUNK, Ordering::Relaxed);
            if begin >= count {
                return Ok(tallies);
            }
            let end = count.min(begin + CHUNK);
            chunk::<N>(program, class, seed, begin..end, &mut tallies)?;
            if end * 10 / count > begin * 10 / count {
                eprintln!("   {class}: {end} of {count}");
            }
        }
    };
    thread::scope(|scope| {
        let mut all = Tallies::default();
        let workers: Vec<_> = (0..threads).map(|_| scope.spawn(work)).collect();
        for worker in workers {
            all.merge(&worker.join().expect("a worker")?);
        }
        Ok(all)
    })
}

fn chunk<const N: usize>(
    program: &Path,
    class: Class,
    seed: u64,
    indices: Range<u64>,
    tallies: &mut Tallies,
) -> io::Result<()> {
    let cases: Vec<Case<N>> = indices
        .clone()
        .map(|index| class.case(seed, index))
        .collect();
    let mut ruckig = Apart::new(program, class, seed, N, indices.clone());
    let [mut ours, mut rsruckig] =
        [Planner::Ours, Planner::Rsruckig].map(|planner| planner.batch(&cases));
    for ((index, case), at) in indices.zip(&cases).zip(0..) {
        let said = Planner::ALL.map(|planner| match planner {
            Planner::Ours => Ok(ours.plan(at)),
            Planner::Ruckig => ruckig.ask_next(),
            Planner::Rsruckig => Ok(rsruckig.plan(at)),
        });
        let [first, second, third] = said.map(|said| said.map(|outcome| judged(case, outcome)));
        tallies.note(index, &[first?, second?, third?]);
    }
    Ok(())
}

fn judged(case: &[Axis], outcome: Outcome) -> Judged {
    let amounts = match &outcome {
        Outcome::Planned(plan) => Some(judge(case, plan)),
        Outcome::Refused(_) | Outcome::Failed(_) => None,
    };
    Judged { outcome, amounts }
}
