//! How fast a carry goes on: as planned, or by what is perceived. The pace gives the carry its
//! class.

use crate::mp::failure::Failure;
use crate::mp::generator::course::Course;
use crate::mp::subsystem::MpSubsystem;
use agent::X;
use agent::args::{Args, Coordinator, E, F, Generates, On, V};
use protocol::units::UNITS_PER_INCREMENT;

/// The wanted rate of path time: 1 = as planned, 0 = stand still on the way.
///
/// The carry follows it smoothly: the rate r obeys r̈ = ω²(wanted − r) − 2ωṙ, which never
/// overshoots and, once within \[0, 1\], stays there whatever is wanted.
pub trait Pace: Send {
    /// What it reads, and so the class of the carry.
    type Args: Args + On<Coordinator> + Generates<Coordinator, super::carry::Carrying>;

    /// The wanted rate; from 0 to 1.
    ///
    /// # Errors
    /// [`Failure::SensorStale`] when what it depends on is not known: the motion then ends.
    fn wanted(&self, x: X<'_, MpSubsystem, Self::Args>, course: &Course) -> Result<f64, Failure>;

    /// ω, 1/s; the rate changes by at most ω/e per second. 0 for a pace that never changes.
    fn omega(&self) -> f64;
}

/// `f^0(c_0)`: as planned, from memory.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct AsPlanned;

impl Pace for AsPlanned {
    type Args = F<(), (), ()>;

    fn wanted(&self, _: X<'_, MpSubsystem, Self::Args>, _: &Course) -> Result<f64, Failure> {
        Ok(1.0)
    }

    fn omega(&self) -> f64 {
        0.0
    }
}

/// ω of the shipped paces, 1/s: a change is done in about half a second.
const OMEGA: f64 = 10.0;

/// `f^1(c_0, v_0)`: slower the nearer two tools are, and still at `stop_m`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ByDistance {
    /// One robot.
    pub a: usize,
    /// The other.
    pub b: usize,
    /// The distance of standstill, m.
    pub stop_m: f64,
    /// The distance from which on the pace is as planned, m.
    pub full_m: f64,
}

/// From 0 at `low` to 1 at `high`, straight in between.
fn ramp(value: f64, low: f64, high: f64) -> f64 {
    if value >= high {
        1.0
    } else if value > low {
        (value - low) / (high - low)
    } else {
        0.0
    }
}

impl Pace for ByDistance {
    type Args = F<(), (), V>;

    fn wanted(&self, x: X<'_, MpSubsystem, Self::Args>, _: &Course) -> Result<f64, Failure> {
        match x.v().distance(self.a, self.b).fresh() {
            Some(distance) => Ok(ramp(distance, self.stop_m, self.full_m)),
            None => Err(stale(self.a, self.b)),
        }
    }

    fn omega(&self) -> f64 {
        OMEGA
    }
}

fn stale(a: usize, b: usize) -> Failure {
    Failure::SensorStale {
        sensor: format!("distance of robots {} and {}", a + 1, b + 1),
    }
}

/// `f^3(c_0, e_c, v_0)`: as planned while the chain is whole: slower as the tools' fed-back distance
/// leaves the one at the beginning, or as an axis lags behind its set-point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Guarded {
    /// One robot.
    pub a: usize,
    /// The other.
    pub b: usize,
    /// The deviation of the distance at which the motion stands, m.
    pub strain_m: f64,
    /// The following error at which the motion stands, encoder increments.
    pub lag_increments: f64,
}

impl Pace for Guarded {
    type Args = F<(), E, V>;

    fn wanted(&self, x: X<'_, MpSubsystem, Self::Args>, course: &Course) -> Result<f64, Failure> {
        let pair = |robot: usize| course.robots().iter().find(|c| c.robot == robot);
        let (Some(a), Some(b)) = (pair(self.a), pair(self.b)) else {
            return Err(stale(self.a, self.b));
        };
        let way = b.start().position - a.start().position;
        let rigid = libm::sqrt(way.dot(&way));
        let Some(distance) = x.v().distance(self.a, self.b).fresh() else {
            return Err(stale(self.a, self.b));
        };
        let strain = 1.0 - ramp((distance - rigid).abs(), 0.5 * self.strain_m, self.strain_m);
        let mut wanted = strain;
        for carried in course.robots() {
            let Some(feedback) = x.e().get(carried.robot).and_then(|e| e.feedback().fresh()) else {
                return Err(Failure::Lost {
                    who: carried.who.clone(),
                    span_ms: 0,
                });
            };
            for units in &feedback.following_error {
                #[expect(clippy::cast_precision_loss, reason = "a thousand")]
                let increments = f64::from(*units) / UNITS_PER_INCREMENT as f64;
                let lag = 1.0 - ramp(increments, 0.5 * self.lag_increments, self.lag_increments);
                if lag < wanted {
                    wanted = lag;
                }
            }
        }
        Ok(wanted)
    }

    fn omega(&self) -> f64 {
        OMEGA
    }
}
