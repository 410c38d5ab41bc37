//! `f_τ` reads a sensor, but is of class 2: it has the arguments of its `f'` and `f''`.
use agent::args::{self, E, F};
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
    type Args = F<(), E, ()>;
    fn first(&self, x: X<'_, Arm, Self::Args>) -> ((), f64) {
        ((), x.e()[0])
    }
    fn next(&self, _: &mut (), x: X<'_, Arm, Self::Args>) -> f64 {
        x.e()[0]
    }
    fn terminal(&self, _: &(), x: X<'_, Arm, Self::Args>) -> bool {
        *x.v() > 1.0
    }
}

fn main() {}
