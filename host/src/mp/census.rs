//! The generators and conditions of the MP level that are shipped, with their classes.

use super::command::Commands;
use super::condition::{AllAtRest, AllDone, MetAtRest, Nearer, Until};
use super::generator::{
    AsPlanned, Ask, ByDistance, Carry, GetReady, Guarded, Home, Shadow, Stream, Together,
};
use super::subsystem::MpSubsystem;
use agent::{Class, Constant, Inhabitant};

/// Every shipped generator and condition of the Master Process.
pub const CENSUS: [Inhabitant; 15] = [
    Inhabitant::generator::<MpSubsystem, Constant<Commands>>("Start"),
    Inhabitant::generator::<MpSubsystem, Carry<AsPlanned>>("Carry<AsPlanned>"),
    Inhabitant::generator::<MpSubsystem, Carry<ByDistance>>("Carry<ByDistance>"),
    Inhabitant::generator::<MpSubsystem, Shadow>("Shadow"),
    Inhabitant::generator::<MpSubsystem, Ask>("Ask"),
    Inhabitant::generator::<MpSubsystem, Together>("Together"),
    Inhabitant::generator::<MpSubsystem, Home>("Home"),
    Inhabitant::generator::<MpSubsystem, GetReady>("GetReady"),
    Inhabitant::generator::<MpSubsystem, Stream>("Stream"),
    Inhabitant::generator::<MpSubsystem, Carry<Guarded>>("Carry<Guarded>"),
    Inhabitant::condition::<MpSubsystem, Until>("Until"),
    Inhabitant::condition::<MpSubsystem, Nearer>("Nearer"),
    Inhabitant::condition::<MpSubsystem, AllDone>("AllDone"),
    Inhabitant::condition::<MpSubsystem, AllAtRest>("AllAtRest"),
    Inhabitant::condition::<MpSubsystem, MetAtRest>("MetAtRest"),
];

/// The same as pairs of class and name.
#[must_use]
pub fn census() -> Vec<(Class, &'static str)> {
    CENSUS
        .iter()
        .map(|entry| (entry.class, entry.name))
        .collect()
}

#[cfg(test)]
mod test {
    use super::*;
    use agent::args::Role;

    #[test]
    fn no_class_of_the_mp_level_is_neglected() {
        let missing: Vec<String> = agent::missing(&CENSUS)
            .filter(|class| class.role() == Role::Mp)
            .map(|class| class.to_string())
            .collect();
        assert_eq!(missing, Vec::<String>::new());
    }
}
