//! A generator is no behaviour: Move runs it.
use agent::args::{self, F};
use agent::{Always, Behaviour, Generator, Subsystem, Then, Wait, X};

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
    type Args = F<(), (), ()>;
    fn first(&self, _: X<'_, Arm, Self::Args>) -> ((), f64) {
        ((), 0.0)
    }
    fn next(&self, _: &mut (), _: X<'_, Arm, Self::Args>) -> f64 {
        0.0
    }
    fn terminal(&self, _: &(), _: X<'_, Arm, Self::Args>) -> bool {
        true
    }
}

fn is_behaviour(_: impl Behaviour<Arm>) {}

fn main() {
    is_behaviour(Then::new(Wait::new(Always), G));
}
