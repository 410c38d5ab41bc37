//! On the MP level `c_0` is the own state, for conditions as well.
use agent::args::{self, C0, E, F};
use agent::{Condition, Subsystem, X};

enum Mp {}
impl Subsystem for Mp {
    type Level = args::Coordinator;
    type Coordination = ();
    type Effector = [f64; 2];
    type Sensors = ();
    type Transmissions = ();
    type Command = f64;
}

struct P;
impl Condition<Mp> for P {
    type Args = F<C0, E, ()>;
    fn holds(&self, _: X<'_, Mp, Self::Args>) -> bool {
        true
    }
}

fn main() {}
