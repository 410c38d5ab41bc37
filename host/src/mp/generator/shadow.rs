//! Follow the leader: a robot keeps its pose relative to another's tool, as fed back.

use crate::mp::arm::AxisMotion;
use crate::mp::command::{Commands, RobotCommand};
use crate::mp::config::{Grid, Timing};
use crate::mp::failure::Failure;
use crate::mp::generator::carry::knot;
use crate::mp::robot::Image;
use crate::mp::subsystem::MpSubsystem;
use agent::args::{E, F};
use agent::{Generator, X};
use motion::Pose;
use protocol::message::Progress;
use protocol::units::PerAxis;
use robots::KinematicError;

/// `f^2(c_0, e_c)`: tight coordination from high-level effector feedback.
///
/// Each macrostep the leader's fed-back tool gives the follower a target in its joints. Feedback is
/// quantised and late, so each joint goes through a slew limit and then the filter h(t) = ω³t²/2·e^(−ωt)
/// (three equal poles): position, velocity and acceleration are continuous, and with targets that
/// move at most at v,
///
/// ```text
///   |q̇| ≤ v     |q̈| ≤ v·∫|ḣ| = 0.5414·ωv     |q⃛| ≤ v·∫|ḧ| = 0.6200·ω²v
/// ```
///
/// so v is chosen such that all three are within the planning ceilings. The follower lags by 3/ω and
/// the lead. It ends when the leader's instruction is done and the follower has caught up.
#[derive(Clone, Debug)]
pub struct Shadow {
    leader: usize,
    follower: usize,
    grid: Grid,
    lead: u32,
    tail: u32,
}

/// ω, 1/s: lags 0.25 s.
const OMEGA: f64 = 12.0;
/// ∫|ḣ|/ω = 4·e⁻²
const ACCELERATION_GAIN: f64 = 0.541_341_133;
/// ∫|ḧ|/ω²: the total variation of ḣ, whose extremes are at ωt = 2 ± √2.
const JERK_GAIN: f64 = 0.62;
/// Caught up: within this of the target, rad or m, and rad/s or m/s.
const CAUGHT_UP: f64 = 1e-6;
/// The most knots sent in one step: what a node has room for.
const BURST: u32 = 7;

/// What a shadow remembers between macrosteps.
#[derive(Clone, Debug, PartialEq)]
pub struct Shadowing {
    next: u32,
    t_leader_follower: Pose,
    joints: Vec<Joint>,
    arrived: bool,
    after: u32,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Joint {
    /// The slew-limited target and its bound per second.
    target: f64,
    slew: f64,
    p: f64,
    v: f64,
    a: f64,
}

impl Joint {
    /// `h` seconds with the target moving towards `goal` as fast as it may.
    ///
    /// Within the macrostep the target u(t) = u₀ + ct is a ramp; the deviation of the output from
    /// its steady response u(t) − 3c/ω decays as (k₀ + k₁t + k₂t²)·e^(−ωt).
    fn pass(&mut self, goal: f64, h: f64) {
        let most = self.slew * h;
        let way = goal - self.target;
        let way = if way > most {
            most
        } else if way < -most {
            -most
        } else {
            way
        };
        let (c, w) = (way / h, OMEGA);
        let (d, dv) = (self.p - self.target + 3.0 * c / w, self.v - c);
        let (k0, k1) = (d, dv + w * d);
        let k2 = 0.5 * (self.a + 2.0 * w * dv + w * w * d);
        let (sum, slope) = (k0 + h * (k1 + h * k2), k1 + 2.0 * h * k2);
        let e = libm::exp(-w * h);
        self.target += way;
        self.p = self.target - 3.0 * c / w + sum * e;
        self.v = c + (slope - w * sum) * e;
        self.a = (2.0 * k2 - 2.0 * w * slope + w * w * sum) * e;
    }

    fn has_caught_up(&self, goal: f64) -> bool {
        (self.p - goal).abs() < CAUGHT_UP && self.v.abs() < CAUGHT_UP
    }
}

impl Shadow {
    /// `follower` keeps its pose relative to the tool of `leader`.
    #[must_use]
    pub fn new(leader: usize, follower: usize, grid: Grid, timing: &Timing) -> Self {
        Self {
            leader,
            follower,
            grid,
            lead: timing.knot_lead_steps,
            tail: timing.knot_repeats.saturating_add(1),
        }
    }

    fn images<'x>(&self, x: X<'x, MpSubsystem, F<(), E, ()>>) -> Option<(&'x Image, &'x Image)> {
        Some((x.e().get(self.leader)?, x.e().get(self.follower)?))
    }

    /// Where the follower should be: joints nearest to `near`.
    fn goal(
        c: &Shadowing,
        leader: &Image,
        follower: &Image,
        near: &[f64],
    ) -> Result<PerAxis<f64>, KinematicError> {
        let t_world_tool = tool(leader, false)? * c.t_leader_follower;
        let config = follower.config();
        let flange = config.t_world_base.inverse() * t_world_tool * config.t_flange_tool.inverse();
        let goal = follower.arm().inverse(&flange, near)?;
        follower.arm().check(&goal)?;
        Ok(goal)
    }

    fn stream(&self, c: &mut Shadowing, x: X<'_, MpSubsystem, F<(), E, ()>>) -> Commands {
        let Some((leader, follower)) = self.images(x) else {
            return Commands::none();
        };
        let near: PerAxis<f64> = c.joints.iter().map(|joint| joint.target).collect();
        let goal = match Self::goal(c, leader, follower, &near) {
            Ok(goal) => goal,
            Err(error) => return Commands::give_up(lost_track(follower, error)),
        };
        let ended = leader.progress() == Some(Progress::Done);
        let horizon = x.i().saturating_add(self.lead);
        let mut knots = Vec::new();
        for _ in 0..BURST {
            if c.next > horizon || c.arrived {
                break;
            }
            let mut motion = AxisMotion::default();
            c.arrived = ended
                && c.joints
                    .iter()
                    .zip(&goal)
                    .all(|(j, goal)| j.has_caught_up(*goal));
            for (joint, goal) in c.joints.iter_mut().zip(&goal) {
                let at = if c.arrived {
                    Joint {
                        p: *goal,
                        v: 0.0,
                        a: 0.0,
                        ..*joint
                    }
                } else {
                    *joint
                };
                // as many as there are axes
                let _ = motion.position.push(at.p);
                let _ = motion.velocity.push(at.v);
                let _ = motion.acceleration.push(at.a);
                joint.pass(*goal, self.grid.macrostep_s());
            }
            knots.push(knot(self.grid.at(c.next), &motion));
            c.next = c.next.saturating_add(1);
        }
        if knots.is_empty() {
            Commands::none()
        } else {
            Commands::one(self.follower, RobotCommand::Tight(knots))
        }
    }

    fn begin(&self, x: X<'_, MpSubsystem, F<(), E, ()>>) -> Result<Shadowing, KinematicError> {
        let (leader, follower) = self.images(x).ok_or(KinematicError::NotFinite)?;
        let motors = follower
            .demanded_motors()
            .ok_or(KinematicError::NotFinite)?;
        let joints = follower.arm().joints(&motors)?;
        let ceilings = follower
            .arm()
            .joint_ceilings(follower.config().velocity_factor);
        let joints = joints
            .iter()
            .zip(&ceilings)
            .map(|(p, ceiling)| {
                let bounds = [
                    ceiling.v,
                    ceiling.a / (ACCELERATION_GAIN * OMEGA),
                    ceiling.j / (JERK_GAIN * OMEGA * OMEGA),
                ];
                let slew = bounds
                    .into_iter()
                    .fold(f64::INFINITY, |m, b| if b < m { b } else { m });
                Joint {
                    target: *p,
                    slew,
                    p: *p,
                    v: 0.0,
                    a: 0.0,
                }
            })
            .collect();
        Ok(Shadowing {
            next: x.i().saturating_add(self.lead),
            t_leader_follower: tool(leader, false)?.inverse() * tool(follower, true)?,
            joints,
            arrived: false,
            after: 0,
        })
    }
}

/// `t_world_tool`, measured or demanded.
fn tool(image: &Image, demanded: bool) -> Result<Pose, KinematicError> {
    let motors = if demanded {
        image.demanded_motors()
    } else {
        image.actual_motors()
    };
    let joints = image
        .arm()
        .joints(&motors.ok_or(KinematicError::NotFinite)?)?;
    let config = image.config();
    Ok(config.t_world_base * image.arm().forward(&joints)? * config.t_flange_tool)
}

fn lost_track(image: &Image, error: KinematicError) -> Failure {
    Failure::Kinematics {
        who: image.who(),
        at: "following the leader".to_owned(),
        error,
    }
}

impl Generator<MpSubsystem> for Shadow {
    type Own = Option<Shadowing>;
    type Args = F<(), E, ()>;

    fn first(&self, x: X<'_, MpSubsystem, Self::Args>) -> (Option<Shadowing>, Commands) {
        match self.begin(x) {
            Ok(mut c) => {
                let commands = self.stream(&mut c, x);
                (Some(c), commands)
            }
            Err(error) => {
                let failure = self
                    .images(x)
                    .map(|(_, follower)| lost_track(follower, error));
                (
                    None,
                    Commands {
                        robots: Vec::new(),
                        give_up: failure,
                    },
                )
            }
        }
    }

    fn next(&self, c: &mut Option<Shadowing>, x: X<'_, MpSubsystem, Self::Args>) -> Commands {
        match c {
            Some(c) if c.arrived => {
                c.after = c.after.saturating_add(1);
                Commands::none()
            }
            Some(c) => self.stream(c, x),
            None => Commands::none(),
        }
    }

    fn terminal(&self, c: &Option<Shadowing>, _: X<'_, MpSubsystem, Self::Args>) -> bool {
        c.as_ref().is_none_or(|c| c.arrived && c.after >= self.tail)
    }
}

#[cfg(test)]
mod test {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn whatever_the_goal_does_the_joint_keeps_its_ceilings(goals in prop::collection::vec(-2.0..2.0f64, 1..100)) {
            let (slew, h) = (0.5, 0.02);
            let mut joint = Joint { target: 0.3, slew, p: 0.3, v: 0.0, a: 0.0 };
            for goal in goals {
                let before = joint;
                joint.pass(goal, h);
                let jerk = (joint.a - before.a) / h; // the mean, which is below the greatest
                prop_assert!(joint.v.abs() <= slew + 1e-12);
                prop_assert!(joint.a.abs() <= ACCELERATION_GAIN * OMEGA * slew + 1e-9);
                prop_assert!(jerk.abs() <= 1.001 * JERK_GAIN * OMEGA * OMEGA * slew);
                // position, velocity and acceleration belong together: Hermite's rule over the step,
                // off by h⁴/720 of the fourth derivative of v, which is below ω⁴·slew·(some)
                let hermite = before.p + 0.5 * h * (before.v + joint.v)
                    + h * h / 12.0 * (before.a - joint.a);
                prop_assert!((joint.p - hermite).abs() < 1e-6, "{joint:?} {hermite}");
            }
        }
    }

    #[test]
    fn a_goal_that_stays_is_reached() {
        let mut joint = Joint {
            target: 0.0,
            slew: 1.0,
            p: 0.0,
            v: 0.0,
            a: 0.0,
        };
        for _ in 0..200 {
            joint.pass(0.4, 0.02);
        }
        assert!(joint.has_caught_up(0.4), "{joint:?}");
    }
}
