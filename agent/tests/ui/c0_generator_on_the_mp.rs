//! On the MP level `c_0` is the own state; nobody sends it.
use agent::args::{self, C0, F};
use agent::{Generator, Subsystem, X};

enum Mp {}
impl Subsystem for Mp {
    type Level = args::Coordinator;
    type Coordination = ();
    type Effector = [f64; 2];
    type Sensors = ();
    type Transmissions = ();
    type Command = f64;
}

struct G;
impl Generator<Mp> for G {
    type Own = ();
    type Args = F<C0, (), ()>;
    fn first(&self, _: X<'_, Mp, Self::Args>) -> ((), f64) {
        ((), 0.0)
    }
    fn next(&self, _: &mut (), _: X<'_, Mp, Self::Args>) -> f64 {
        0.0
    }
    fn terminal(&self, _: &(), _: X<'_, Mp, Self::Args>) -> bool {
        true
    }
}

fn main() {}
