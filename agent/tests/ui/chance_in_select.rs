//! Select is deterministic: an urge needs a source of deviates.
use agent::args::{self, F, V};
use agent::{Always, Behaviour, Response, Rest, Select, Subsystem, Urge, stimulus};

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
    let zeta = stimulus::<Arm, F<(), (), V>, _>(|x| *x.v());
    is_behaviour(Select::new((Urge::new(
        Always,
        zeta,
        Response::threshold(1.0),
        Rest,
    ),)));
}
