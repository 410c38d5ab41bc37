//! A view narrows; it does not widen.
use agent::args::{self, E, F, V};
use agent::{Subsystem, X};

enum Arm {}
impl Subsystem for Arm {
    type Level = args::Executor;
    type Coordination = f64;
    type Effector = [f64; 6];
    type Sensors = f64;
    type Transmissions = f64;
    type Command = f64;
}

fn widened(x: X<'_, Arm, F<(), E, ()>>) -> f64 {
    *x.narrow::<F<(), E, V>>().v()
}

fn main() {}
