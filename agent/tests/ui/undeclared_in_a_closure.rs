//! A closure is held to the list it declares.
use agent::args::{self, E, F};
use agent::{Subsystem, condition};

enum Arm {}
impl Subsystem for Arm {
    type Level = args::Executor;
    type Coordination = f64;
    type Effector = [f64; 6];
    type Sensors = f64;
    type Transmissions = f64;
    type Command = f64;
}

fn main() {
    let _ = condition::<Arm, F<(), E, ()>, _>(|x| *x.v() > 1.0);
}
