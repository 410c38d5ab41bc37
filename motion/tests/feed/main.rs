//! explore
mod support;
use motion::AxisLimits;
use motion::feed::*;
use support::*;

fn lcg(seed: &mut u64) -> f64 {
    *seed = seed
        .wrapping_mul(6364136223846793005)
        .wrapping_add(1442695040888963407);
    (*seed >> 11) as f64 / (1u64 << 53) as f64
}
fn wave(seed: &mut u64, slope: f64, sharp: f64) -> Wave {
    Wave {
        slope: slope * (2.0 * lcg(seed) - 1.0),
        sines: (1..=4)
            .map(|k| {
                let w = k as f64 * sharp * lcg(seed);
                [
                    (2.0 * lcg(seed) - 1.0) / k as f64 / (1.0 + w * 0.3),
                    w,
                    6.3 * lcg(seed),
                ]
            })
            .collect(),
    }
}

#[test]
fn explore() {
    let n: u64 = std::env::var("CASES").map_or(200, |x| x.parse().unwrap());
    let mut bad = 0;
    let only: Option<u64> = std::env::var("ONLY").ok().map(|x| x.parse().unwrap());
    for case in 0..n {
        if only.is_some_and(|o| o != case) {
            continue;
        }
        let mut seed = case * 7919 + 13;
        for _ in 0..5 {
            lcg(&mut seed);
        }
        let sharp = 1.0 + 6.0 * lcg(&mut seed);
        let tool = lcg(&mut seed) < 0.6;
        let path = Path::<3> {
            joints: [0; 3].map(|_| wave(&mut seed, 1.0, sharp)),
            linear: [0; 3].map(|_| wave(&mut seed, 0.5, sharp)),
            angular: [0; 3].map(|_| wave(&mut seed, 0.5, sharp)),
            feed: if lcg(&mut seed) < 0.5 {
                f64::INFINITY
            } else {
                0.1 + lcg(&mut seed)
            },
        };
        let jerk = lcg(&mut seed) < 0.7;
        let mut ax = || AxisLimits {
            v: 0.3 + 2.0 * lcg(&mut seed),
            a: 1.0 + 8.0 * lcg(&mut seed),
            j: if jerk {
                20.0 + 200.0 * lcg(&mut seed)
            } else {
                f64::INFINITY
            },
        };
        let joints = [ax(), ax(), ax()];
        let mut opt = |k: f64, on: bool| {
            (on && lcg(&mut seed) < 0.7)
                .then(|| 0.0)
                .map(|_: f64| k * (0.3 + lcg(&mut seed)))
        };
        let limits = FeedLimits {
            joints,
            linear: NormLimits {
                v: opt(1.0, tool),
                a: opt(5.0, tool),
                j: opt(100.0, tool && jerk),
            },
            angular: NormLimits {
                v: opt(1.0, tool),
                a: opt(5.0, tool),
                j: opt(100.0, tool && jerk),
            },
        };
        let step_s = [0.001, 0.004, 0.01, 0.02][(lcg(&mut seed) * 4.0) as usize];
        let grid = [0.002, 0.005, 0.01][(lcg(&mut seed) * 3.0) as usize];
        let course = Course {
            length: 0.3 + 1.7 * lcg(&mut seed),
            grid,
            step_s,
        };
        let mode = (lcg(&mut seed) * 5.0) as usize;
        let most = if lcg(&mut seed) < 0.3 { 1 } else { 1000 };
        let mut ov = 1.0;
        let mut left = 0;
        let f = |k: usize| {
            if k > 3_000 {
                return 1.0;
            }
            match mode {
                0 | 1 => 1.0,
                2 => 2.0 * lcg(&mut seed) - 0.7,
                3 => {
                    if left == 0 {
                        ov = [1.0, 0.0, -1.0, 0.5, 1.0, 1.0, -0.3, 0.0]
                            [(lcg(&mut seed) * 8.0) as usize];
                        left = (lcg(&mut seed) * 0.4 / step_s) as usize + 1;
                    }
                    left -= 1;
                    ov
                }
                _ => {
                    if lcg(&mut seed) < 0.02 {
                        ov = lcg(&mut seed)
                    }
                    ov
                }
            }
        };
        let r = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
            run::<3, 128, 64>(&path, &limits, &course, most, f)
        }));
        match r {
            Ok(r) => {
                if r.worst.0.iter().any(|x| *x > 1.0 + 1e-9) {
                    bad += 1;
                    println!(
                        "BAD case {case} sharp {sharp:.1} grid {grid} h {step_s} mode {mode} most {most} jerk {jerk} tool {tool}: {:?}",
                        r.worst
                    )
                }
            }
            Err(e) => {
                bad += 1;
                println!(
                    "FAIL case {case} sharp {sharp:.1} grid {grid} h {step_s} mode {mode} most {most} jerk {jerk}: {:?}",
                    e.downcast_ref::<String>()
                )
            }
        }
    }
    println!("bad {bad} of {n}");
}
