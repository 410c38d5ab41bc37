//! Tests of processes in real time, on machines that others use too.
//!
//! A process that the machine does not let run for 7 ms misses SYNCs that its drives waited for, and they stop
//! as they should: that says nothing about the process. So a watch sleeps beside the test, a millisecond at a
//! time, and knows how long the machine let it wait. What fails though nothing stalled is wrong.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

/// What a sleep of the watch may take beyond its time: less than half of what the drives bear, since the
/// watch sees only the stalls of its own thread.
const STALL: Duration = Duration::from_millis(3);
const NAP: Duration = Duration::from_millis(1);
/// A test that stalls spoil so often has failed.
const ATTEMPTS: u32 = 3;

/// The longest that the machine kept a thread waiting while `work` ran.
fn watched<T>(work: impl FnOnce() -> T) -> (T, Duration) {
    let ended = AtomicBool::new(false);
    thread::scope(|scope| {
        let watch = scope.spawn(|| {
            let mut longest = Duration::ZERO;
            while !ended.load(Ordering::Relaxed) {
                let begun = Instant::now();
                thread::sleep(NAP);
                longest = longest.max(begun.elapsed().saturating_sub(NAP));
            }
            longest
        });
        let done = work();
        ended.store(true, Ordering::Relaxed);
        (done, watch.join().unwrap_or_default())
    })
}

/// Runs a scenario; one that fails while the machine stalls is run again, from its beginning.
pub fn in_real_time(scenario: impl Fn()) {
    attempts(|| watched(|| catch_unwind(AssertUnwindSafe(&scenario))));
}

/// What a panic carries.
type Panic = Box<dyn Any + Send>;

fn attempts(run: impl Fn() -> (Result<(), Panic>, Duration)) {
    for attempt in 1..=ATTEMPTS {
        let (Err(panic), stall) = run() else {
            return;
        };
        if stall < STALL || attempt == ATTEMPTS {
            resume_unwind(panic);
        }
        eprintln!("attempt {attempt}: the machine stalled for {stall:?}; again");
    }
}

#[cfg(test)]
mod test {
    use super::*;
    use std::cell::Cell;

    /// How often a scenario runs that succeeds the `success`-th time, and whether that counts as success.
    fn runs(success: u32, stall: Duration) -> (u32, bool) {
        let runs = Cell::new(0);
        let attempted = catch_unwind(AssertUnwindSafe(|| {
            attempts(|| {
                runs.set(runs.get() + 1);
                let succeeds = runs.get() == success;
                let done = if succeeds {
                    Ok(())
                } else {
                    Err(Box::new(()) as Panic)
                };
                (done, stall)
            });
        }));
        (runs.get(), attempted.is_ok())
    }

    #[test]
    fn only_what_a_stall_spoils_is_run_again() {
        assert_eq!(runs(1, Duration::ZERO), (1, true));
        assert_eq!(runs(1, STALL), (1, true));
        assert_eq!(runs(2, STALL / 2), (1, false));
        assert_eq!(runs(2, STALL), (2, true));
        assert_eq!(runs(9, STALL), (ATTEMPTS, false));
    }

    #[test]
    fn the_watch_knows_how_long_it_was_kept_waiting() {
        let (done, longest) = watched(|| {
            thread::sleep(10 * NAP);
            7
        });
        // nothing can be said of an upper bound: the machine may stall
        assert_eq!(done, 7);
        assert!(longest > Duration::ZERO);
    }
}
