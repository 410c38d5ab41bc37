//! What a macrostep of `motion::feed` costs, with six joints and limits of the tool.
//!
//! `feed_cost RUNS` prints the macrosteps of a run, ns of the slowest and the mean one, and the bytes of the
//! state. In each macrostep as many samples are pushed as there is room for, at most [`MOST_SAMPLES`]: so
//! the window fills in the first macrosteps, and that is among what the slowest may be.
//!
//! Times are those of the machine, so the slowest of them says little; instructions are exact.
//! `valgrind --tool=callgrind --dump-before='*macrostep*' feed_cost 1` writes a file for what came before
//! the first macrostep, then one for each: the largest of their totals is the worst macrostep.

use motion::AxisLimits;
use motion::feed::{Feed, FeedLimits, NormLimits, PushError, Sample, Status, Step, ToolSample};
use std::time::Instant;

const GRID: f64 = 0.005;
const MACROSTEP_S: f64 = 0.02;
const SAMPLES: u32 = 400;
/// As many as the firmware takes in a macrostep.
const MOST_SAMPLES: usize = 8;

type Measured = Feed<6, 128, 16>;

fn sample(s: f64) -> Sample<6> {
    let wave = |k: f64| {
        let (w, amplitude) = (1.0 + k, 0.4 / (1.0 + k));
        [
            amplitude * w * libm::cos(w * s + k),
            -amplitude * w * w * libm::sin(w * s + k),
            -amplitude * w * w * w * libm::cos(w * s + k),
        ]
    };
    let joints = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0].map(wave);
    let tool = [0, 1, 2].map(|order| [wave(0.5)[order], wave(1.5)[order], wave(2.5)[order]]);
    Sample {
        first: joints.map(|[d, _, _]| d),
        second: joints.map(|[_, d, _]| d),
        third: joints.map(|[_, _, d]| d),
        tool: ToolSample {
            linear: tool,
            angular: tool,
        },
        feed: 0.5,
    }
}

/// Pushes some of these samples, the last of which ends the path, and makes a step.
#[inline(never)]
fn macrostep(feed: &mut Measured, rest: &mut &[Sample<6>]) -> Result<Step, PushError> {
    for _ in 0..MOST_SAMPLES {
        if feed.room() < 2 {
            break;
        }
        match rest {
            [] => break,
            [last] => {
                feed.end_piece(last, 1.0)?;
                feed.finish()?;
                *rest = &[];
            }
            [next, after @ ..] => {
                feed.push(next)?;
                *rest = after;
            }
        }
    }
    Ok(feed.step(1.0))
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let runs: u32 = std::env::args().nth(1).map_or(Ok(1), |x| x.parse())?;
    let axis = AxisLimits {
        v: 1.0,
        a: 5.0,
        j: 100.0,
    };
    let norm = NormLimits {
        v: Some(1.0),
        a: Some(5.0),
        j: Some(100.0),
    };
    let limits = FeedLimits {
        joints: [axis; 6],
        linear: norm,
        angular: norm,
    };
    let samples: Vec<_> = (0..=SAMPLES).map(|i| sample(f64::from(i) * GRID)).collect();
    let (mut steps, mut slowest, mut sum) = (0u32, 0, 0);
    for _ in 0..runs {
        let mut feed = Measured::new(&limits, GRID, MACROSTEP_S)?;
        let mut rest = samples.as_slice();
        (steps, sum) = (0, 0);
        loop {
            let since = Instant::now();
            let step = macrostep(&mut feed, &mut rest)?;
            let took = since.elapsed().as_nanos();
            slowest = slowest.max(took);
            (steps, sum) = (steps + 1, sum + took);
            if step.status == Status::Done {
                break;
            }
        }
    }
    let bytes = size_of::<Measured>();
    println!(
        "{steps} macrosteps, slowest {slowest} ns, mean {} ns, {bytes} bytes",
        sum / u128::from(steps)
    );
    Ok(())
}
