//! Rigid-body dynamics of the chains, without another program: `oracles/` compares with Pinocchio and
//! `MuJoCo`.

mod chains;
mod energy;
mod equations;
mod every_robot;
mod model;
mod motors;
mod shapes;
mod urdf;

use proptest::prelude::*;
use robots::Joints;
use robots::dynamics::{Chain, rnt_chain};

/// The RNT with a wrist inclined by some angle.
fn rnt() -> Chain<6> {
    rnt_chain(0.7)
}

/// N numbers in [−scale, scale].
fn numbers<const N: usize>(scale: f64) -> impl Strategy<Value = [f64; N]> {
    prop::collection::vec(-scale..=scale, N).prop_map(|all| all.try_into().unwrap())
}

/// Seven positions, velocities and accelerations; a chain takes as many as it has joints.
#[derive(Clone, Debug)]
struct State {
    q: [f64; 7],
    dq: [f64; 7],
    ddq: [f64; 7],
}

impl State {
    fn joints<const N: usize>(&self) -> Joints<N> {
        Joints(first(&self.q))
    }
    fn velocity<const N: usize>(&self) -> [f64; N] {
        first(&self.dq)
    }
    fn acceleration<const N: usize>(&self) -> [f64; N] {
        first(&self.ddq)
    }
}

fn first<const N: usize>(all: &[f64; 7]) -> [f64; N] {
    *all.first_chunk().unwrap()
}

fn state() -> impl Strategy<Value = State> {
    (numbers(3.0), numbers(2.0), numbers(5.0)).prop_map(|(q, dq, ddq)| State { q, dq, ddq })
}

/// One check with a state, on every chain.
macro_rules! on_every_chain {
    ($check:ident, $state:expr) => {{
        let state = &$state;
        $check(&robots::dynamics::IRP6_TRACK, state)?;
        $check(&robots::dynamics::IRP6_POSTUMENT, state)?;
        $check(&robots::dynamics::IRP6_ARM, state)?;
        $check(&robots::dynamics::POLYCRANK, state)?;
        $check(&crate::rnt(), state)?;
    }};
}
use on_every_chain;

/// The greatest |a − b|; NaN if there is one.
fn apart(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).fold(0.0, |most: f64, (a, b)| {
        let d = (a - b).abs();
        if d <= most { most } else { d }
    })
}
