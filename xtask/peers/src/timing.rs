//! What a plan costs, and what a sample of it.

use crate::apart::Apart;
use crate::case::Case;
use crate::class::Class;
use crate::clock;
use crate::judge::judge;
use crate::plan::Outcome;
use crate::planner::Planner;
use std::io;
use std::path::Path;

/// Cases in a batch: their inputs and results do not fit the first cache, as in life.
pub const BATCH: usize = 1024;
/// Batches timed in a row; their median counts.
pub const REPEATS: usize = 9;
/// Rounds, in each of which every planner has its turn; the median of their medians counts.
pub const ROUNDS: usize = 3;
/// Times each call is timed alone; the least counts, so interrupts do not.
pub const CALL_REPEATS: usize = 25;
/// Cases looked at to find a batch that every planner plans well.
const MOST_CANDIDATES: u64 = 64 * BATCH as u64;
/// Motions that are sampled, and how often each.
const SAMPLED: usize = 64;
/// Samples of a motion: at 1 kHz a motion of a second.
const SAMPLES: usize = 1000;

/// What a plan costs a planner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cost {
    /// Who.
    pub planner: Planner,
    /// CPU time of a call in a batch, ns.
    pub ns: f64,
    /// Largest minus smallest of the rounds' medians, relative to `ns`.
    pub spread: f64,
    /// The 99th percentile of calls timed alone, ns.
    pub p99_ns: f64,
    /// The worst of them, ns.
    pub worst_ns: f64,
    /// The median of them, ns.
    pub median_ns: f64,
    /// Instructions of a call in a batch; nothing without valgrind.
    pub instructions: Option<f64>,
}

/// Cases that every planner plans without violation, the first of the class. `program` is what Ruckig
/// is run in for that: it calls [`apart::serve`](crate::apart::serve) first of all.
///
/// # Errors
/// Ruckig's own process cannot be started, or there are not enough such cases among very many.
pub fn cases<const N: usize>(program: &Path, class: Class, seed: u64) -> io::Result<Vec<Case<N>>> {
    let mut chosen = Vec::with_capacity(BATCH);
    let mut ruckig = Apart::new(program, class, seed, N, 0..MOST_CANDIDATES);
    for index in 0..MOST_CANDIDATES {
        let case = class.case(seed, index);
        let good = |outcome| match outcome {
            Outcome::Planned(plan) => judge(&case, &plan).pass(),
            Outcome::Refused(_) | Outcome::Failed(_) => false,
        };
        let [ours, rsruckig] =
            [Planner::Ours, Planner::Rsruckig].map(|planner| good(planner.batch(&[case]).plan(0)));
        if good(ruckig.ask_next()?) && ours && rsruckig {
            chosen.push(case);
        }
        if chosen.len() == BATCH {
            return Ok(chosen);
        }
    }
    Err(io::Error::other(format!(
        "{class}: not enough cases all plan"
    )))
}

/// Times every planner on the same cases; instructions are not counted here.
///
/// # Errors
/// As [`cases`].
pub fn plans<const N: usize>(
    program: &Path,
    class: Class,
    seed: u64,
) -> io::Result<[Cost; Planner::ALL.len()]> {
    let cases = cases::<N>(program, class, seed)?;
    let mut batches = Planner::ALL.map(|planner| planner.batch(&cases));
    let count = as_f64(cases.len());
    let medians = rounds(&mut batches, |batch| {
        let began = clock::thread_ns();
        std::hint::black_box(batch.run());
        (clock::thread_ns() - began) / count
    });
    let alone = batches.each_mut().map(|batch| {
        let mut least = vec![f64::INFINITY; cases.len()];
        for _ in 0..CALL_REPEATS {
            batch.calls(&mut least);
        }
        let overhead = clock::overhead_ns();
        for ns in &mut least {
            *ns -= overhead;
        }
        least.sort_by(f64::total_cmp);
        least
    });
    let mut costs = Planner::ALL.map(|planner| {
        let alone = &alone[planner as usize];
        Cost {
            planner,
            ns: f64::NAN,
            spread: f64::NAN,
            p99_ns: alone[alone.len() * 99 / 100],
            worst_ns: alone[alone.len() - 1],
            median_ns: alone[alone.len() / 2],
            instructions: None,
        }
    });
    for (cost, medians) in costs.iter_mut().zip(medians) {
        (cost.ns, cost.spread) = medians;
    }
    Ok(costs)
}

/// What a sample of a motion costs each planner, CPU ns, and the spread of the rounds.
///
/// # Errors
/// As [`cases`].
pub fn samples<const N: usize>(
    program: &Path,
    class: Class,
    seed: u64,
) -> io::Result<[(f64, f64); Planner::ALL.len()]> {
    let mut cases = cases::<N>(program, class, seed)?;
    cases.truncate(SAMPLED);
    let mut batches = Planner::ALL.map(|planner| planner.batch(&cases));
    for batch in &mut batches {
        batch.keep();
    }
    let count = as_f64(SAMPLED * SAMPLES);
    Ok(rounds(&mut batches, |batch| {
        let began = clock::thread_ns();
        std::hint::black_box(batch.sample(SAMPLES));
        (clock::thread_ns() - began) / count
    }))
}

/// For each subject: the median of the rounds' medians, and their spread relative to it.
fn rounds<T, const M: usize>(
    subjects: &mut [T; M],
    mut measure: impl FnMut(&mut T) -> f64,
) -> [(f64, f64); M] {
    let mut medians = [[0.0; ROUNDS]; M];
    for round in 0..ROUNDS {
        for (subject, medians) in subjects.iter_mut().zip(&mut medians) {
            let mut repeats: [f64; REPEATS] = [(); REPEATS].map(|()| measure(subject));
            repeats.sort_by(f64::total_cmp);
            medians[round] = repeats[REPEATS / 2];
        }
    }
    medians.map(|mut rounds| {
        rounds.sort_by(f64::total_cmp);
        let median = rounds[ROUNDS / 2];
        (median, (rounds[ROUNDS - 1] - rounds[0]) / median)
    })
}

#[expect(clippy::cast_precision_loss, reason = "counts far below 2^53")]
fn as_f64(count: usize) -> f64 {
    count as f64
}

#[cfg(test)]
mod test {
    use super::*;

    #[test]
    fn the_median_of_medians_and_its_spread_are_taken_for_each() {
        // the second subject's rounds have medians 10, 30 and 20; the first's never change
        let mut calls = [0, 0];
        let mut subjects = [0_usize, 1];
        let [still, moving] = rounds(&mut subjects, |which| {
            let call = calls[*which];
            calls[*which] += 1;
            let round = [10.0, 30.0, 20.0][call / REPEATS];
            let noise = [0.0, 5.0, -5.0][call % 3];
            if *which == 0 { 7.0 } else { round + noise }
        });
        assert_eq!(still, (7.0, 0.0));
        assert_eq!(moving, (20.0, 1.0));
        assert_eq!(calls, [ROUNDS * REPEATS; 2]);
    }
}
