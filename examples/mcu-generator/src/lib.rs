//! A generator and a condition of one's own, linked into the image of a board: two joints draw a Lissajous figure once
//! nothing presses against the robot. `README.md` tells how it gets there.
#![no_std]
#![forbid(unsafe_code)]

use agent::args::{E, F, V};
use agent::{Condition, Generator, Move, Then, Wait, X};
use core::f64::consts::TAU;
use firmware::ecp::{Demand, EcpOf, OneProgram};
use protocol::fault::Refusal;
use robots::{JointMotion, Joints};

/// A macrostep of the robots here, s.
pub const STEP_S: f64 = 0.02;
/// How long the figure takes, s.
pub const DURATION_S: f64 = 8.0;
/// Its amplitude, rad or m.
const AMPLITUDE: f64 = 0.04;
/// Periods within it: of the last joint but one, and of the last.
const PERIODS: [f64; 2] = [2.0, 3.0];

/// `f_I^1(c_j, v_j)`: no motor needs half its current limit, so nothing presses.
#[derive(Clone, Copy, Debug)]
pub struct Untouched;

impl<const N: usize> Condition<EcpOf<N>> for Untouched {
    type Args = F<(), (), V>;

    fn holds(&self, x: X<'_, EcpOf<N>, Self::Args>) -> bool {
        x.v().effort.iter().all(|effort| *effort < 0.5)
    }
}

/// Where a joint with `k` periods is after `t` seconds: position, velocity, acceleration (rad or m, s).
///
/// a·½(1 − cos Ωt)·sin kΩt with Ω = 2π/[`DURATION_S`], as a sum of sines: ½ sin kΩt − ¼ sin (k+1)Ωt − ¼ sin (k−1)Ωt; all
/// three values vanish at both ends, so it joins rest smoothly. Exactly zero outside.
#[must_use]
pub fn figure(k: f64, t: f64) -> [f64; 3] {
    let mut y = [0.0; 3];
    if t > 0.0 && t < DURATION_S {
        for (share, times) in [(0.5, k), (-0.25, k + 1.0), (-0.25, k - 1.0)] {
            let (a, w) = (AMPLITUDE * share, times * TAU / DURATION_S);
            let (sin, cos) = libm::sincos(w * t);
            let [position, velocity, acceleration] = &mut y;
            *position += a * sin;
            *velocity += a * w * cos;
            *acceleration -= a * w * w * sin;
        }
    }
    y
}

/// `f^2(c_j, e_j)`: the figure, about wherever the robot stands.
#[derive(Clone, Copy, Debug)]
pub struct Lissajous;

/// `c_j`: where it began, and how many macrosteps it has demanded.
pub type Own<const N: usize> = (Option<Joints<N>>, u32);

impl<const N: usize> Generator<EcpOf<N>> for Lissajous {
    type Own = Own<N>;
    type Args = F<(), E, ()>;

    fn first(&self, x: X<'_, EcpOf<N>, Self::Args>) -> (Own<N>, Demand<N>) {
        let mut c = (x.e().demanded_joints, 0);
        let y = self.next(&mut c, x);
        (c, y)
    }

    fn next(&self, (from, i): &mut Own<N>, _: X<'_, EcpOf<N>, Self::Args>) -> Demand<N> {
        let Some(Joints(position)) = *from else {
            return Demand::Refuse(Refusal::NotSynchronised);
        };
        *i = i.saturating_add(1);
        let t = f64::from(*i) * STEP_S;
        let mut motion = JointMotion {
            position: Joints(position),
            velocity: [0.0; N],
            acceleration: [0.0; N],
        };
        let axes = motion.position.0.iter_mut().zip(&mut motion.velocity);
        let axes = axes.zip(&mut motion.acceleration).rev();
        // from the last joint on
        for (((q, v), a), k) in axes.zip(PERIODS.into_iter().rev()) {
            let [position, velocity, acceleration] = figure(k, t);
            *q += position;
            (*v, *a) = (velocity, acceleration);
        }
        Demand::Joints(motion)
    }

    fn terminal(&self, (_, i): &Own<N>, _: X<'_, EcpOf<N>, Self::Args>) -> bool {
        f64::from(*i) * STEP_S >= DURATION_S
    }
}

/// What is linked into the node: program 1, whatever the robot.
#[derive(Clone, Copy, Debug)]
pub struct Linked;

impl board::boot::Linked for Linked {
    type Programs<const N: usize> = OneProgram<Then<Wait<Untouched>, Move<Lissajous, Own<N>>>>;

    fn programs<const N: usize>() -> Self::Programs<N> {
        OneProgram(Then::new(Wait::new(Untouched), Move::new(Lissajous)))
    }
}
