//! Tight coordination: several robots move one rigid object, `lead` macrosteps ahead of time.

use crate::mp::arm::AxisMotion;
use crate::mp::command::{Commands, RobotCommand};
use crate::mp::config::{Grid, Timing};
use crate::mp::failure::Failure;
use crate::mp::generator::course::Course;
use crate::mp::generator::pace::Pace;
use crate::mp::subsystem::MpSubsystem;
use agent::{Generator, X};
use protocol::message::{KnotMessage, Space};
use protocol::time::Micros;
use protocol::units::PerAxis;

/// `f^0`, `f^1` or `f^3`, by its [`Pace`]: the knots of every robot that carries, each macrostep.
///
/// Knots lie on the grid of instants, `lead` macrosteps ahead of the present one. Each gives
/// position, velocity and acceleration of one smooth function of time, so that the node's quintics
/// between them join with continuous acceleration. The first knot is the robots' rest, the last one
/// is rest at the goal. Where the process was late, the knots it owes are sent together.
#[derive(Clone, Debug)]
pub struct Carry<P> {
    course: Course,
    pace: P,
    grid: Grid,
    lead: u32,
    /// How many macrosteps after the last knot it goes on, so that the last knot is repeated.
    tail: u32,
}

/// The most knots sent in one step: what a node has room for.
const BURST: u32 = 7;

/// What a carry remembers between macrosteps.
#[derive(Clone, Debug, PartialEq)]
pub struct Carrying {
    /// The instant of the next knot.
    next: u32,
    /// Path time of the next knot, s.
    tau: f64,
    /// Rate of path time and its change per second.
    rate: f64,
    change: f64,
    /// The last joint positions, a list per robot.
    near: Vec<PerAxis<f64>>,
    /// Macrosteps since the last knot.
    after: u32,
    arrived: bool,
}

impl Carrying {
    /// Rate of path time: 1 = as planned.
    #[must_use]
    pub const fn rate(&self) -> f64 {
        self.rate
    }

    /// Path time passes for `h` seconds towards the wanted rate.
    ///
    /// The exact solution of r̈ = ω²(w − r) − 2ωṙ: with d = r − w and b = ṙ + ωd,
    /// r(t) = w + (d + bt)·e^(−ωt), and its integral.
    fn pass(&mut self, wanted: f64, omega: f64, h: f64) {
        if omega <= 0.0 {
            self.tau += h;
            return;
        }
        let d = self.rate - wanted;
        let b = self.change + omega * d;
        let e = libm::exp(-omega * h);
        self.tau += wanted * h
            + d / omega * (1.0 - e)
            + b * (1.0 / (omega * omega) - e * (h / omega + 1.0 / (omega * omega)));
        self.rate = wanted + (d + b * h) * e;
        self.change = (self.change - omega * b * h) * e;
    }
}

impl<P: Pace> Carry<P> {
    /// A carry along a course.
    ///
    /// # Errors
    /// Somewhere on the way a robot cannot follow: see [`Course::check`].
    pub fn new(course: Course, pace: P, grid: Grid, timing: &Timing) -> Result<Self, Failure> {
        course.check(grid, pace.omega() / core::f64::consts::E)?;
        Ok(Self::checked(course, pace, grid, timing))
    }

    /// The same along a course that has been checked, when the task was planned.
    #[must_use]
    pub fn checked(course: Course, pace: P, grid: Grid, timing: &Timing) -> Self {
        Self {
            course,
            pace,
            grid,
            lead: timing.knot_lead_steps,
            tail: timing.knot_repeats.saturating_add(1),
        }
    }

    /// The course.
    #[must_use]
    pub const fn course(&self) -> &Course {
        &self.course
    }

    /// The knots up to `lead` macrosteps ahead.
    fn stream(&self, c: &mut Carrying, x: X<'_, MpSubsystem, P::Args>) -> Commands {
        let wanted = match self.pace.wanted(x, &self.course) {
            Ok(wanted) => wanted,
            Err(failure) => return Commands::give_up(failure),
        };
        let horizon = x.i().saturating_add(self.lead);
        let mut knots: Vec<Vec<KnotMessage>> = vec![Vec::new(); c.near.len()];
        for _ in 0..BURST {
            if c.next > horizon || c.arrived {
                break;
            }
            let advance = self.course.advance(c.tau, c.rate, c.change);
            c.arrived = c.tau >= self.course.duration_s();
            let each = self.course.robots().iter().zip(&mut c.near).zip(&mut knots);
            for ((carried, near), knots) in each {
                match self.course.joint_motion(carried, advance, near) {
                    Ok(motion) => {
                        near.clone_from(&motion.position);
                        knots.push(knot(self.grid.at(c.next), &motion));
                    }
                    Err(error) => {
                        return Commands::give_up(Failure::Kinematics {
                            who: carried.who.clone(),
                            at: format!("{:.0} % of the way", 100.0 * advance.s),
                            error,
                        });
                    }
                }
            }
            c.next = c.next.saturating_add(1);
            c.pass(wanted, self.pace.omega(), self.grid.macrostep_s());
        }
        let robots = self
            .course
            .robots()
            .iter()
            .zip(knots)
            .filter(|(_, knots)| !knots.is_empty())
            .map(|(carried, knots)| (carried.robot, RobotCommand::Tight(knots)))
            .collect();
        Commands {
            robots,
            give_up: None,
        }
    }
}

/// A motion of the joints at an instant (bus time), as a knot on the wire: velocity and acceleration
/// are rounded to `f32`.
#[must_use]
pub fn knot(at: Micros, motion: &AxisMotion) -> KnotMessage {
    KnotMessage {
        at,
        space: Space::Joints,
        position: motion.position.clone(),
        velocity: narrow(&motion.velocity),
        acceleration: narrow(&motion.acceleration),
    }
}

#[expect(
    clippy::cast_possible_truncation,
    reason = "rates travel as f32: 6·10⁻⁸ of their value"
)]
fn narrow(values: &[f64]) -> PerAxis<f32> {
    values.iter().map(|v| *v as f32).collect()
}

impl<P: Pace> Generator<MpSubsystem> for Carry<P> {
    type Own = Carrying;
    type Args = P::Args;

    fn first(&self, x: X<'_, MpSubsystem, Self::Args>) -> (Carrying, Commands) {
        let mut c = Carrying {
            next: x.i().saturating_add(self.lead),
            tau: 0.0,
            rate: 1.0,
            change: 0.0,
            near: self
                .course
                .robots()
                .iter()
                .map(|carried| carried.joints().iter().copied().collect())
                .collect(),
            after: 0,
            arrived: false,
        };
        let commands = self.stream(&mut c, x);
        (c, commands)
    }

    fn next(&self, c: &mut Carrying, x: X<'_, MpSubsystem, Self::Args>) -> Commands {
        if c.arrived {
            c.after = c.after.saturating_add(1);
            return Commands::none();
        }
        self.stream(c, x)
    }

    fn terminal(&self, c: &Carrying, _: X<'_, MpSubsystem, Self::Args>) -> bool {
        c.arrived && c.after >= self.tail
    }
}

#[cfg(test)]
mod test {
    use super::*;
    use proptest::prelude::*;

    fn carrying() -> Carrying {
        Carrying {
            next: 0,
            tau: 0.0,
            rate: 1.0,
            change: 0.0,
            near: Vec::new(),
            after: 0,
            arrived: false,
        }
    }

    proptest! {
        #[test]
        fn the_rate_stays_between_standstill_and_plan(wishes in prop::collection::vec(0.0..=1.0f64, 1..80)) {
            let (mut c, omega, h) = (carrying(), 10.0, 0.02);
            for wanted in wishes {
                let before = c.clone();
                c.pass(wanted, omega, h);
                // rounding only
                prop_assert!(c.rate > -1e-12 && c.rate < 1.0 + 1e-12, "{c:?}");
                prop_assert!(c.change.abs() <= omega + 1e-12);
                prop_assert!(c.tau >= before.tau - 1e-12 && c.tau <= before.tau + h + 1e-12);
                // the integral against Simpson's rule over the step: error of order (ωh)⁵/2880
                let mut half = before.clone();
                half.pass(wanted, omega, 0.5 * h);
                let simpson = h / 6.0 * (before.rate + 4.0 * half.rate + c.rate);
                prop_assert!((c.tau - before.tau - simpson).abs() < 1e-7);
            }
        }
    }

    #[test]
    fn a_wish_is_granted_in_the_end() {
        let mut c = carrying();
        for _ in 0..100 {
            c.pass(0.0, 10.0, 0.02);
        }
        assert!(c.rate < 1e-6 && c.change.abs() < 1e-5, "{c:?}");
        // path time passed while slowing down: the integral of (1 + ωt)·e^(−ωt) is 2/ω
        assert!((c.tau - 0.2).abs() < 1e-6, "{}", c.tau);
    }
}
