//! The sum of two poses is no pose: poses compete.
use agent::args::{self, F};
use agent::{Behaviour, Subsystem, Superpose, function};

#[derive(Clone, Copy)]
struct Pose([f64; 16]);

enum Arm {}
impl Subsystem for Arm {
    type Level = args::Executor;
    type Coordination = f64;
    type Effector = [f64; 6];
    type Sensors = f64;
    type Transmissions = f64;
    type Command = Pose;
}

fn is_behaviour(_: impl Behaviour<Arm>) {}

fn main() {
    let stay = || function::<Arm, F<(), (), ()>, _>(|_| Pose([0.0; 16]));
    is_behaviour(Superpose::weighted((stay(), stay()), [0.5, 0.5]));
}
