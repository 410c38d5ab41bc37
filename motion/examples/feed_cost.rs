//! What a macrostep of `motion::feed` costs, with six joints and limits of the tool: run it under an
//! instruction counter with two numbers of runs and divide the difference.
//!
//! `feed_cost RUNS` prints the macrosteps of a run, and the slowest and mean step in ns.

use motion::AxisLimits;
use motion::feed::{Feed, FeedLimits, NormLimits, Sample, Status, ToolSample};
use std::time::Instant;

const GRID: f64 = 0.005;
const MACROSTEP_S: f64 = 0.02;
const SAMPLES: u32 = 400;

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
    let samples: Vec<_> = (0..SAMPLES).map(|i| sample(f64::from(i) * GRID)).collect();
    let (mut steps, mut slowest, mut sum) = (0u32, 0, 0);
    for _ in 0..runs {
        let mut feed = Feed::<6, 128, 16>::new(&limits, GRID, MACROSTEP_S)?;
        let mut next = samples.iter();
        let mut finished = false;
        (steps, sum) = (0, 0);
        loop {
            let since = Instant::now();
            while !finished && feed.room() >= 2 {
                if let Some(sample) = next.next() {
                    feed.push(sample)?;
                } else {
                    feed.end_piece(&sample(f64::from(SAMPLES) * GRID), 1.0)?;
                    feed.finish()?;
                    finished = true;
                }
            }
            let step = feed.step(1.0);
            let took = since.elapsed().as_nanos();
            slowest = if took > slowest && steps > 0 {
                took
            } else {
                slowest
            };
            (steps, sum) = (steps + 1, sum + took);
            if step.status == Status::Done {
                break;
            }
        }
    }
    let bytes = size_of::<Feed<6, 128, 16>>();
    println!(
        "{steps} macrosteps, slowest {slowest} ns, mean {} ns, {bytes} bytes",
        sum / u128::from(steps)
    );
    Ok(())
}
