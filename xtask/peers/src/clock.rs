//! How time is taken. What is timed is written twice only where a planner is not in Rust.

use std::time::Instant;

/// Time this thread has kept a core busy, ns.
#[must_use]
pub fn thread_ns() -> f64 {
    let now = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    #[expect(clippy::cast_precision_loss, reason = "below 2^53 ns, 104 days")]
    let parts = (now.tv_sec as f64, now.tv_nsec as f64);
    parts.0 * 1e9 + parts.1
}

/// Times a call for each input alone and keeps the time if it is the least so far, ns.
pub fn calls<T>(least_ns: &mut [f64], inputs: &[T], mut call: impl FnMut(&T)) {
    for (least, input) in least_ns.iter_mut().zip(inputs) {
        let began = Instant::now();
        call(input);
        #[expect(clippy::cast_precision_loss, reason = "far below 2^53 ns")]
        let ns = began.elapsed().as_nanos() as f64;
        if ns < *least {
            *least = ns;
        }
    }
}

/// What the clock itself adds to a call, at least, ns.
#[must_use]
pub fn overhead_ns() -> f64 {
    let mut least = [f64::INFINITY];
    for _ in 0..10_000 {
        calls(&mut least, &[()], |()| ());
    }
    least[0]
}

/// Calls for ascending times from 0 on, in equal steps, the last a step before the end.
pub fn ascending(duration: f64, samples: usize, mut call: impl FnMut(f64)) {
    #[expect(clippy::cast_precision_loss, reason = "counts far below 2^53")]
    let step = duration / samples as f64;
    for i in 0..samples {
        #[expect(clippy::cast_precision_loss, reason = "counts far below 2^53")]
        call(i as f64 * step);
    }
}
