//! There is no fifth class of conditions.
use agent::args::{self, Const};
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
    type Args = Const;
    fn holds(&self, _: X<'_, Mp, Self::Args>) -> bool {
        true
    }
}

fn main() {}
