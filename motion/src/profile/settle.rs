//! What rounding left of the end of a motion, made good.
//!
//! A motion of an hour multiplies the last digit of a velocity by its length, and one with a jerk of 1e6 turns
//! the last digit of an instant into acceleration. So where the phases miss the end by more than [`MISSED`],
//! their lengths are changed by as little as it takes. With R what is left of the motion after a phase, and j, a, v
//! at its end, a phase that lasts δ longer moves the end by
//!
//! ```text
//!   δ in time      j·δ in acceleration      (a + j·R)·δ in velocity      (v + a·R + j·R²/2)·δ in position
//! ```
//!
//! and of all changes that leave the time as it is and make the rest good, the one with the least Σδ² is taken:
//! δ = Aᵀ·(A·Aᵀ)⁻¹·missed.

use super::blend::Phases;
use super::{Boundary, Phase};
use crate::scalar::larger;
use nalgebra::{Matrix4, Vector4};

/// What an end may be off, in the axis' unit, per s and per s².
const MISSED: f64 = 2e-11;

impl Phases {
    /// Makes good what the end is off by.
    pub(super) fn settle(&mut self) {
        let Some(missed) = self.missed() else { return };
        let off = greatest(&missed);
        if off <= MISSED {
            return;
        }
        let mut settled = self.clone();
        if settled.shift(&missed).is_some()
            && settled.missed().is_some_and(|left| greatest(&left) < off)
        {
            *self = settled;
        }
    }

    /// The end asked for minus the end of the phases.
    fn missed(&self) -> Option<Boundary> {
        let last = self.as_slice().last()?;
        let (is, end) = (last.at(last.t), self.end());
        Some(Boundary {
            p: end.p - is.p,
            v: end.v - is.v,
            a: end.a - is.a,
        })
    }

    /// Moves the end by so much; nothing where the phases cannot.
    fn shift(&mut self, by: &Boundary) -> Option<()> {
        // every row in seconds: time, and acceleration, velocity and position over j, j·T and j·T²
        let jerk = self
            .as_slice()
            .iter()
            .fold(0.0, |most, phase| larger(most, phase.j.abs()));
        let time: f64 = self.as_slice().iter().map(|phase| phase.t).sum();
        let row = |phase: &Phase, left: f64| {
            let end = phase.at(phase.t);
            let v = end.a + phase.j * left;
            let p = end.v + (end.a + 0.5 * phase.j * left) * left;
            Vector4::new(
                1.0,
                phase.j / jerk,
                v / (jerk * time),
                p / (jerk * time * time),
            )
        };
        let mut gram = Matrix4::zeros();
        let mut left = time;
        for phase in self.as_slice() {
            left -= phase.t;
            let row = row(phase, left);
            gram += row * row.transpose();
        }
        let scaled = Vector4::new(
            0.0,
            by.a / jerk,
            by.v / (jerk * time),
            by.p / (jerk * time * time),
        );
        let share = gram.try_inverse()? * scaled;
        let mut left = time;
        let (mut at, mut more) = (Boundary::default(), 0.0);
        for (number, phase) in self.as_mut_slice().iter_mut().enumerate() {
            left -= phase.t;
            let longer = row(phase, left).dot(&share);
            if number > 0 {
                (phase.p0, phase.v0, phase.a0) = (at.p, at.v, phase.a0 + more);
            }
            let t = phase.t + longer;
            if t.is_nan() || t < 0.0 {
                return None;
            }
            more += phase.j * (t - phase.t);
            phase.t = t;
            let end = phase.at(phase.t);
            at = Boundary {
                p: end.p,
                v: end.v,
                a: end.a,
            };
        }
        Some(())
    }
}

fn greatest(off: &Boundary) -> f64 {
    larger(off.p.abs(), larger(off.v.abs(), off.a.abs()))
}
