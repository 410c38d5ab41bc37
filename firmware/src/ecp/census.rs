//! The generators and conditions every node has, with their classes (\[Z1\] VI, VII).

use crate::ecp::EcpOf;
use crate::ecp::condition::{Contact, Decided, ForceAbove, FromWire, Settled};
use crate::ecp::generator::{
    Follow, Guarded, Hold, JointMove, LineMove, MotorMove, PathMove, PoseMove,
};
use agent::{Always, And, Inhabitant};
use robots::Irp6Postument;

type S = EcpOf<6>;
type R = Irp6Postument;

/// Everything shipped on the ECP level; none of the eight classes is neglected (\[Z1\] VIII).
pub const ECP: [Inhabitant; 21] = [
    Inhabitant::generator::<S, Hold>("Hold"),
    Inhabitant::generator::<S, Guarded<Hold, Contact>>("Guarded<Hold, Contact>"),
    Inhabitant::generator::<S, MotorMove<6>>("MotorMove"),
    Inhabitant::generator::<S, JointMove<R, 6>>("JointMove"),
    Inhabitant::generator::<S, PoseMove<R, 6>>("PoseMove"),
    Inhabitant::generator::<S, LineMove<R, 6, 16>>("LineMove"),
    Inhabitant::generator::<S, PathMove<R, 6, 16>>("PathMove"),
    Inhabitant::generator::<S, Guarded<JointMove<R, 6>, Contact>>("Guarded<JointMove, Contact>"),
    Inhabitant::generator::<S, Follow>("Follow"),
    Inhabitant::generator::<S, Guarded<Follow, Contact>>("Guarded<Follow, Contact>"),
    Inhabitant::generator::<S, Guarded<LineMove<R, 6, 16>, Decided>>("Guarded<LineMove, Decided>"),
    Inhabitant::generator::<S, Guarded<LineMove<R, 6, 16>, ForceAbove>>(
        "Guarded<LineMove, ForceAbove>",
    ),
    Inhabitant::generator::<S, Guarded<Follow, And<Settled, Contact>>>(
        "Guarded<Follow, And<Settled, Contact>>",
    ),
    Inhabitant::condition::<S, Always>("Always"),
    Inhabitant::condition::<S, Contact>("Contact"),
    Inhabitant::condition::<S, Settled>("Settled"),
    Inhabitant::condition::<S, And<Settled, Contact>>("And<Settled, Contact>"),
    Inhabitant::condition::<S, Decided>("Decided"),
    Inhabitant::condition::<S, And<Decided, Contact>>("And<Decided, Contact>"),
    Inhabitant::condition::<S, FromWire>("FromWire"),
    Inhabitant::condition::<S, And<FromWire, Contact>>("And<FromWire, Contact>"),
];

#[cfg(test)]
mod test {
    extern crate std;
    use super::*;
    use agent::args::Role;
    use std::string::{String, ToString};
    use std::vec::Vec;

    #[test]
    fn no_class_of_the_ecp_level_is_neglected() {
        let missing: Vec<String> = agent::missing(&ECP)
            .filter(|class| class.role() == Role::Ecp)
            .map(|class| class.to_string())
            .collect();
        assert_eq!(missing, Vec::<String>::new());
    }
}
