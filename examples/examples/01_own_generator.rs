//! A generator and a condition of one's own, linked into the node of an arm.
//!
//! The IRp-6 nods its wrist when nothing presses against it. Both functions run on the node, once
//! per macrostep of 20 ms; the Master Process only says: begin.

use agent::args::{E, F, V};
use agent::{Class, Condition, Generator, Move, Then, Wait, X};
use anyhow::Result;
use firmware::ecp::{Demand, EcpOf, OneProgram};
use host::mp::behaviour::{sequence, start_programs};
use host::mp::condition::AllDone;
use mrroc_examples::{Arm, DURATION_S, STEP_S, WRIST, World, nod, summary};
use protocol::fault::Refusal;
use robots::{JointMotion, Joints};

/// `f_I^1(c_j, v_j)`: no motor needs half its current limit, so nothing presses.
#[derive(Debug)]
pub(crate) struct Untouched;

impl Condition<EcpOf<6>> for Untouched {
    type Args = F<(), (), V>;

    fn holds(&self, x: X<'_, EcpOf<6>, Self::Args>) -> bool {
        x.v().effort.iter().all(|effort| *effort < 0.5)
    }
}

/// `f^2(c_j, e_j)`: nod from wherever the arm stands.
#[derive(Debug)]
pub(crate) struct Nod;

/// `c_j`: where it began, and how many macrosteps it has demanded.
pub(crate) type Own = (Option<Joints<6>>, u32);

impl Generator<EcpOf<6>> for Nod {
    type Own = Own;
    type Args = F<(), E, ()>;

    fn first(&self, x: X<'_, EcpOf<6>, Self::Args>) -> (Own, Demand<6>) {
        let mut c = (x.e().demanded_joints, 0);
        let y = self.next(&mut c, x);
        (c, y)
    }

    fn next(&self, (from, i): &mut Own, _: X<'_, EcpOf<6>, Self::Args>) -> Demand<6> {
        let Some(Joints(mut position)) = *from else {
            return Demand::Refuse(Refusal::NotSynchronised);
        };
        *i += 1;
        let (mut velocity, mut acceleration) = ([0.0; 6], [0.0; 6]);
        let [p, v, a] = nod(f64::from(*i) * STEP_S);
        position[WRIST] += p;
        velocity[WRIST] = v;
        acceleration[WRIST] = a;
        Demand::Joints(JointMotion {
            position: Joints(position),
            velocity,
            acceleration,
        })
    }

    fn terminal(&self, (_, i): &Own, _: X<'_, EcpOf<6>, Self::Args>) -> bool {
        f64::from(*i) * STEP_S >= DURATION_S
    }
}

/// The node's only program, number 1: Wait, then Move.
pub(crate) type Linked = OneProgram<Then<Wait<Untouched>, Move<Nod, Own>>>;

pub(crate) const fn linked() -> Linked {
    OneProgram(Then::new(Wait::new(Untouched), Move::new(Nod)))
}

/// Runs it; gives where the wrist really was, at every servo step.
pub(crate) fn run(world: &mut World) -> Result<Vec<f64>> {
    let program = start_programs(&[0], 1, 0.0);
    let done = Box::new(Wait::new(AllDone { robots: vec![0] }));
    let mut wrist = Vec::new();
    world.watch(sequence(vec![program, done]), |world| {
        wrist.extend(world.joints(0).map(|joints| joints[WRIST]));
    })?;
    Ok(wrist)
}

/// The example, as the text it prints.
pub(crate) fn example() -> Result<String> {
    let mut world = World::new(vec![Arm::postument(linked())?])?;
    world.get_ready()?;
    let wrist = run(&mut world)?;
    Ok(format!(
        "Wait until {}, then Move by {}\n{}\n{} faults\n",
        Class::of_condition(&Untouched),
        Class::of_generator(&Nod),
        summary("wrist on the node", &wrist),
        world.faults(),
    ))
}

fn main() -> Result<()> {
    print!("{}", example()?);
    Ok(())
}
