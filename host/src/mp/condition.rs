//! Conditions of the MP level, in all four classes of \[Z1\] §VII.

use super::robot::Image;
use super::subsystem::MpSubsystem;
use agent::args::{E, F, V};
use agent::{Condition, X};
use protocol::message::{NodeState, Progress};

/// `f_P^0(c_0)`: the instant has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Until {
    /// The instant.
    pub i: u32,
}

impl Condition<MpSubsystem> for Until {
    type Args = F<(), (), ()>;

    fn holds(&self, x: X<'_, MpSubsystem, Self::Args>) -> bool {
        x.i() >= self.i
    }
}

/// `f_P^1(c_0, v_0)`: two tools are nearer to each other than this. A stale reading is no reading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearer {
    /// One robot.
    pub a: usize,
    /// The other.
    pub b: usize,
    /// m
    pub distance_m: f64,
}

impl Condition<MpSubsystem> for Nearer {
    type Args = F<(), (), V>;

    fn holds(&self, x: X<'_, MpSubsystem, Self::Args>) -> bool {
        x.v()
            .distance(self.a, self.b)
            .fresh()
            .is_some_and(|d| d < self.distance_m)
    }
}

/// `f_P^2(c_0, e_c)`: the latest instruction of every robot of a list is done.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AllDone {
    /// The robots.
    pub robots: Vec<usize>,
}

impl Condition<MpSubsystem> for AllDone {
    type Args = F<(), E, ()>;

    fn holds(&self, x: X<'_, MpSubsystem, Self::Args>) -> bool {
        each(x.e(), &self.robots, |image| {
            image.progress() == Some(Progress::Done)
        })
    }
}

/// `f_P^2(c_0, e_c)`: every robot of a list is at rest.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AllAtRest {
    /// The robots.
    pub robots: Vec<usize>,
}

impl Condition<MpSubsystem> for AllAtRest {
    type Args = F<(), E, ()>;

    fn holds(&self, x: X<'_, MpSubsystem, Self::Args>) -> bool {
        each(x.e(), &self.robots, |image| {
            image.is_at_rest() && !image.is_asked()
        })
    }
}

/// `f_P^3(c_0, e_c, v_0)`: two robots hold still with their tools within a distance, ready to hand
/// over.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MetAtRest {
    /// One robot.
    pub a: usize,
    /// The other.
    pub b: usize,
    /// m
    pub distance_m: f64,
}

impl Condition<MpSubsystem> for MetAtRest {
    type Args = F<(), E, V>;

    fn holds(&self, x: X<'_, MpSubsystem, Self::Args>) -> bool {
        let holding = each(x.e(), &[self.a, self.b], |image| {
            image.state() == Some(NodeState::Holding)
        });
        holding
            && x.v()
                .distance(self.a, self.b)
                .fresh()
                .is_some_and(|d| d <= self.distance_m)
    }
}

fn each(images: &[Image], robots: &[usize], holds: impl Fn(&Image) -> bool) -> bool {
    robots
        .iter()
        .all(|robot| images.get(*robot).is_some_and(&holds))
}
