//! The image of `i` is gone at `i + 1`: the own state cannot keep a reference into it.
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

struct Keep<'i>(&'i ());
impl<'i> Generator<Arm> for Keep<'i> {
    type Own = &'i [f64; 6];
    type Args = F<(), E, ()>;
    fn first(&self, x: X<'_, Arm, Self::Args>) -> (&'i [f64; 6], f64) {
        (x.e(), 0.0)
    }
    fn next(&self, c: &mut &'i [f64; 6], _: X<'_, Arm, Self::Args>) -> f64 {
        c[0]
    }
    fn terminal(&self, _: &&'i [f64; 6], _: X<'_, Arm, Self::Args>) -> bool {
        true
    }
}

fn main() {}
