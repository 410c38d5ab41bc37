//! The speed along a path keeps every limit at every time, and is nearly the fastest.

mod support;

use support::*;

fn lcg(seed: &mut u64) -> f64 {
    *seed = seed
        .wrapping_mul(6364136223846793005)
        .wrapping_add(1442695040888963407);
    (*seed >> 11) as f64 / (1u64 << 53) as f64
}

fn random_path(seed: &mut u64) -> Path<6> {
    let joints = [0; 6].map(|_| Wave {
        slope: 2.0 * lcg(seed) - 1.0,
        sines: (1..=5)
            .map(|k| {
                [
                    (2.0 * lcg(seed) - 1.0) / k as f64,
                    k as f64 * 3.0 * lcg(seed),
                    6.3 * lcg(seed),
                ]
            })
            .collect(),
    });
    Path::of_joints(joints)
}

#[test]
fn explore() {
    let mut seed = 1;
    for i in 0..12 {
        let path = random_path(&mut seed);
        let mut times = Vec::new();
        for (j, h) in [
            (f64::INFINITY, 0.001),
            (f64::INFINITY, 0.02),
            (100.0, 0.001),
            (100.0, 0.02),
        ] {
            let limits = joint_limits::<6>(1.0, 5.0, j);
            let course = Course {
                length: 4.0,
                grid: 0.005,
                step_s: h,
            };
            let run = run::<6, 512, 512>(&path, &limits, &course, 1000, |_| 1.0);
            times.push(run.duration);
            println!(
                "{i} j {j} h {h}: {:.3} s  worst {:?}",
                run.duration, run.worst
            );
        }
    }
}
