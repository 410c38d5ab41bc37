//! How long `motion::feed` takes along paths read from standard input: see `oracles/toppra/README.md`.
//!
//! A line is a path of six joints: its length, then for each joint a slope and four sines, each as
//! amplitude, angular frequency by s, phase. Printed: the time in s for each of the settings in SETTINGS.

use motion::AxisLimits;
use motion::feed::{Feed, FeedLimits, NormLimits, Sample, Status, ToolSample};
use std::io::BufRead;

const JOINTS: usize = 6;
const SINES: usize = 4;
const VELOCITY: f64 = 1.0;
const ACCELERATION: f64 = 5.0;
const GRID: f64 = 0.002;
/// Jerk limit and macrostep.
const SETTINGS: [(f64, f64); 5] = [
    (f64::INFINITY, 0.0005),
    (f64::INFINITY, 0.001),
    (f64::INFINITY, 0.02),
    (100.0, 0.001),
    (100.0, 0.02),
];

type Wave = (f64, [[f64; 3]; SINES]);

fn sample(path: &[Wave; JOINTS], s: f64) -> Sample<JOINTS> {
    let mut out = Sample {
        first: [0.0; JOINTS],
        second: [0.0; JOINTS],
        third: [0.0; JOINTS],
        tool: ToolSample::default(),
        feed: f64::INFINITY,
    };
    for (joint, (slope, sines)) in path.iter().enumerate() {
        out.first[joint] = *slope;
        for [amplitude, w, phase] in sines {
            let angle = w * s + phase;
            out.first[joint] += amplitude * w * libm::cos(angle);
            out.second[joint] -= amplitude * w * w * libm::sin(angle);
            out.third[joint] -= amplitude * w * w * w * libm::cos(angle);
        }
    }
    out
}

fn time(
    path: &[Wave; JOINTS],
    length: f64,
    jerk: f64,
    macrostep_s: f64,
) -> Result<f64, Box<dyn std::error::Error>> {
    let limits = FeedLimits {
        joints: [AxisLimits {
            v: VELOCITY,
            a: ACCELERATION,
            j: jerk,
        }; JOINTS],
        linear: NormLimits::default(),
        angular: NormLimits::default(),
    };
    let mut feed = Feed::<JOINTS, 1024, 256>::new(&limits, GRID, macrostep_s)?;
    let (mut next, mut steps) = (0u32, 0u32);
    let mut finished = false;
    loop {
        while !finished && feed.room() >= 2 {
            let s = f64::from(next) * GRID;
            if s < length - 1e-9 {
                feed.push(&sample(path, s))?;
                next += 1;
            } else {
                feed.end_piece(&sample(path, length), (length - s) / GRID + 1.0)?;
                feed.finish()?;
                finished = true;
            }
        }
        steps += 1;
        if feed.step(1.0).status == Status::Done {
            return Ok(f64::from(steps) * macrostep_s);
        }
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    for line in std::io::stdin().lock().lines() {
        let line = line?;
        let numbers: Result<Vec<f64>, _> = line.split_whitespace().map(str::parse).collect();
        let mut numbers = numbers?.into_iter();
        let mut number = || numbers.next().ok_or("a line is too short");
        let length = number()?;
        let mut path: [Wave; JOINTS] = [(0.0, [[0.0; 3]; SINES]); JOINTS];
        for (slope, sines) in &mut path {
            *slope = number()?;
            for x in sines.iter_mut().flatten() {
                *x = number()?;
            }
        }
        let times: Result<Vec<_>, _> = SETTINGS
            .iter()
            .map(|(jerk, h)| time(&path, length, *jerk, *h).map(|t| t.to_string()))
            .collect();
        println!("{}", times?.join(" "));
    }
    Ok(())
}
