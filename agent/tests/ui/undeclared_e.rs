//! `f'` reads the effector, but is of class 1.
use agent::args::{self, F, V};
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
    type Args = F<(), (), V>;
    fn first(&self, x: X<'_, Arm, Self::Args>) -> ((), f64) {
        ((), x.e()[0])
    }
    fn next(&self, _: &mut (), x: X<'_, Arm, Self::Args>) -> f64 {
        *x.v()
    }
    fn terminal(&self, _: &(), _: X<'_, Arm, Self::Args>) -> bool {
        true
    }
}

fn main() {}
