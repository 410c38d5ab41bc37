//! The slots have an order.
use agent::args::{self, E, F};
use agent::{Condition, Subsystem, X};

enum Arm {}
impl Subsystem for Arm {
    type Level = args::Executor;
    type Coordination = f64;
    type Effector = [f64; 6];
    type Sensors = f64;
    type Transmissions = f64;
    type Command = f64;
}

struct P;
impl Condition<Arm> for P {
    type Args = F<E, (), ()>;
    fn holds(&self, _: X<'_, Arm, Self::Args>) -> bool {
        true
    }
}

fn main() {}
