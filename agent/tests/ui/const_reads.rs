//! `f** = const` has no arguments to read.
use agent::args::{self, Const};
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
    type Args = Const;
    fn first(&self, x: X<'_, Mp, Self::Args>) -> ((), f64) {
        ((), x.e()[0])
    }
    fn next(&self, _: &mut (), _: X<'_, Mp, Self::Args>) -> f64 {
        0.0
    }
    fn terminal(&self, _: &(), _: X<'_, Mp, Self::Args>) -> bool {
        true
    }
}

fn main() {}
