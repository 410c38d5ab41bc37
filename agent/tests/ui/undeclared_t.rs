//! A class of the first paper does not hear other agents.
use agent::args::{self, C0, E, F, V};
use agent::{Generator, Subsystem, X};

enum Arm {}
impl Subsystem for Arm {
    type Level = args::Executor;
    type Coordination = f64;
    type Effector = [f64; 6];
    type Sensors = f64;
    type Transmissions = f64;
    type Command = f64;
}

struct G;
impl Generator<Arm> for G {
    type Own = ();
    type Args = F<C0, E, V>;
    fn first(&self, x: X<'_, Arm, Self::Args>) -> ((), f64) {
        ((), *x.v())
    }
    fn next(&self, _: &mut (), x: X<'_, Arm, Self::Args>) -> f64 {
        *x.t()
    }
    fn terminal(&self, _: &(), _: X<'_, Arm, Self::Args>) -> bool {
        true
    }
}

fn main() {}
