//! `f**` activates ECPs; an ECP has no one below to activate.
use agent::args;
use agent::{Behaviour, Constant, Move, Subsystem};

enum Arm {}
impl Subsystem for Arm {
    type Level = args::Executor;
    type Coordination = f64;
    type Effector = [f64; 6];
    type Sensors = f64;
    type Transmissions = f64;
    type Command = f64;
}

fn is_behaviour(_: impl Behaviour<Arm>) {}

fn main() {
    is_behaviour(Move::new(Constant(1.0)));
}
