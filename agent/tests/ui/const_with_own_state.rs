//! `f** = const` has no `c_0`, so no state to compute with.
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

struct Ramp;
impl Generator<Mp> for Ramp {
    type Own = f64;
    type Args = Const;
    fn first(&self, _: X<'_, Mp, Self::Args>) -> (f64, f64) {
        (0.0, 0.0)
    }
    fn next(&self, c: &mut f64, _: X<'_, Mp, Self::Args>) -> f64 {
        {
            *c += 1.0;
            *c
        }
    }
    fn terminal(&self, c: &f64, _: X<'_, Mp, Self::Args>) -> bool {
        *c > 9.0
    }
}

fn main() {}
