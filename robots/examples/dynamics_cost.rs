//! What the dynamics of a seven-axis arm cost: ns a call, sine and cosine included.
//!
//! `dynamics_cost [CALLS] [QUESTION]` asks every question, or one: `fk`, `rnea`, `crba`, `forward`,
//! `motors`. With `valgrind --tool=callgrind` and one question, the difference between two numbers of
//! calls is its instructions.

use nalgebra::Vector3;
use robots::dynamics::{Chain, IRP6_TRACK, POLYCRANK, STANDARD_GRAVITY, Wrench};
use robots::{Irp6Track, Joints, Robot};
use std::hint::black_box;
use std::time::Instant;

const STATES: u32 = 256;

/// A state: positions, velocities, accelerations or torques.
type State = (Joints<7>, [f64; 7], [f64; 7]);

/// Numbers in [−1, 1): a multiplicative congruential generator, so that runs are alike.
fn states() -> Vec<State> {
    let mut seed = 1_u64;
    let mut next = || {
        seed = seed
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        f64::from(u32::try_from(seed >> 32).unwrap_or(0)) / f64::from(1_u32 << 31) - 1.0
    };
    let mut seven = |scale: f64| [0.0; 7].map(|_: f64| scale * next());
    (0..STATES)
        .map(|_| (Joints(seven(3.0)), seven(2.0), seven(5.0)))
        .collect()
}

#[inline(never)]
fn fk(chain: &Chain<7>, (q, ..): &State) -> f64 {
    chain.at(q).flange().position.x
}

#[inline(never)]
fn rnea(chain: &Chain<7>, (q, dq, ddq): &State) -> f64 {
    let gravity: Vector3<f64> = STANDARD_GRAVITY;
    let torques = chain
        .at(q)
        .inverse_dynamics(dq, ddq, &gravity, &Wrench::NONE);
    torques.iter().sum()
}

#[inline(never)]
fn crba(chain: &Chain<7>, (q, ..): &State) -> f64 {
    chain.at(q).mass_matrix().sum()
}

#[inline(never)]
fn forward(chain: &Chain<7>, (q, dq, tau): &State) -> f64 {
    let gravity: Vector3<f64> = STANDARD_GRAVITY;
    let accelerations = chain
        .at(q)
        .forward_dynamics(dq, tau, &gravity, &Wrench::NONE);
    accelerations.iter().sum()
}

/// The IRp-6 on its track, from joints near its working posture and motor velocities.
#[inline(never)]
fn motors(_: &Chain<7>, (q, dm, tau): &State) -> f64 {
    let near = [0.0, 0.0, -1.5, 0.0, 1.5, 0.0, 0.0];
    let mut q = *q;
    for (q, near) in q.0.iter_mut().zip(near) {
        *q = 0.1 * *q + near;
    }
    let gravity: Vector3<f64> = STANDARD_GRAVITY;
    Irp6Track::KEEP
        .transmission(&q)
        .map_or(f64::NAN, |transmission| {
            let posture = IRP6_TRACK.at(&q);
            let accelerations =
                posture.motor_forward_dynamics(&transmission, dm, tau, &gravity, &Wrench::NONE);
            accelerations.iter().sum()
        })
}

type Question = (&'static str, fn(&Chain<7>, &State) -> f64);

const QUESTIONS: [Question; 5] = [
    ("fk", fk),
    ("rnea", rnea),
    ("crba", crba),
    ("forward", forward),
    ("motors", motors),
];

/// Batches of which the fastest counts.
const BATCHES: u32 = 20;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let calls: u32 = arguments.next().map_or(Ok(100_000), |x| x.parse())?;
    let only = arguments.next();
    let states = states();
    let chain = black_box(&POLYCRANK);
    for (name, question) in QUESTIONS {
        if only.as_deref().is_some_and(|only| only != name) {
            continue;
        }
        let batch = calls.div_ceil(BATCHES).max(1);
        let mut best = f64::INFINITY;
        let mut done = 0;
        while done < calls {
            let since = Instant::now();
            for state in states.iter().cycle().take(batch.min(calls - done) as usize) {
                black_box(question(chain, black_box(state)));
            }
            let ns = since.elapsed().as_secs_f64() * 1e9 / f64::from(batch.min(calls - done));
            done += batch.min(calls - done);
            if ns < best {
                best = ns;
            }
        }
        println!("{name} {best:.1}");
    }
    Ok(())
}
