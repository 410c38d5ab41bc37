//! What the Master Process is told before it starts: its robots, and every time-out by name.

use super::arm::{Arm, arm};
use core::fmt;
use motion::Pose;
use protocol::id::NodeId;
use protocol::message::ServoLaw;
use protocol::time::Micros;
use protocol::transfer::Mtu;
use robots::{RobotKind, VelocityFactor};

/// The Master Process and its cell.
#[derive(Clone, Debug)]
pub struct Config {
    /// Its own number on the wire.
    pub node: NodeId,
    /// The size of the frames it sends.
    pub mtu: Mtu,
    /// Its robots; everywhere else a robot is an index in this list.
    pub robots: Vec<RobotConfig>,
    /// Every period and time-out.
    pub timing: Timing,
    /// Take the lease although another coordinator holds it (a node agrees only at standstill).
    pub takeover: bool,
    /// Ask every node to publish its demand every n-th servo step; 0 = never. Only a CAN FD bus has
    /// room for every step.
    pub trace_every: u16,
    /// Switch torque off when a program has ended, before the lease is given back.
    pub torque_off_at_end: bool,
}

/// A robot of the cell, as the Master Process knows it.
#[derive(Clone, Debug)]
pub struct RobotConfig {
    /// Its name in tasks and messages.
    pub name: String,
    /// Its number on the wire.
    pub node: NodeId,
    /// Its kind: geometry and limits.
    pub arm: &'static dyn Arm,
    /// Its base in the world.
    pub t_world_base: Pose,
    /// Its tool.
    pub t_flange_tool: Pose,
    /// How its loops are closed.
    pub servo: ServoLaw,
    /// The share of the motors' hard velocity limit its node is configured with.
    pub velocity_factor: VelocityFactor,
}

impl RobotConfig {
    /// A robot named after its kind, with its default tool and place, at effector number `j` from 1.
    #[must_use]
    pub fn of(kind: RobotKind, j: u8) -> Option<Self> {
        let arm = arm(kind);
        Some(Self {
            name: kind.name().to_owned(),
            node: NodeId::effector(j)?,
            arm,
            t_world_base: Pose::identity(),
            t_flange_tool: arm.default_tool(),
            servo: ServoLaw::DrivePosition,
            velocity_factor: VelocityFactor::DEFAULT,
        })
    }
}

impl Config {
    /// A cell of robots, numbered as effectors 1, 2, … in their order, with every default.
    #[must_use]
    pub fn new(robots: Vec<RobotConfig>) -> Self {
        Self {
            node: NodeId::MP,
            mtu: Mtu::Fd,
            robots,
            timing: Timing::default(),
            takeover: false,
            trace_every: 0,
            torque_off_at_end: false,
        }
    }

    /// Everything in its range, every node number once, and room for every robot.
    ///
    /// # Errors
    /// The first mistake.
    pub fn check(&self) -> Result<(), ConfigError> {
        if self.robots.len() > MAX_ROBOTS {
            return Err(ConfigError::TooManyRobots {
                got: self.robots.len(),
            });
        }
        for (k, robot) in self.robots.iter().enumerate() {
            let earlier = self.robots.iter().take(k);
            if robot.node == self.node || earlier.clone().any(|other| other.node == robot.node) {
                return Err(ConfigError::NodeTwice { node: robot.node });
            }
            if earlier.clone().any(|other| other.name == robot.name) {
                return Err(ConfigError::NameTwice {
                    name: robot.name.clone(),
                });
            }
        }
        self.timing.check()
    }
}

/// The most robots of one coordinator: what its link can follow at once.
pub const MAX_ROBOTS: usize = 12;

/// Why a configuration cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ConfigError {
    /// Too many robots.
    #[error("{got} robots in the cell (expected at most {MAX_ROBOTS})")]
    TooManyRobots {
        /// How many.
        got: usize,
    },
    /// Two participants of one number.
    #[error(
        "node {node} twice in the cell (expected every number once, and not the coordinator's)"
    )]
    NodeTwice {
        /// The number.
        node: NodeId,
    },
    /// Two robots of one name.
    #[error("robot {name} twice in the cell (expected every name once)")]
    NameTwice {
        /// The name.
        name: String,
    },
    /// A time outside its range.
    #[error("{name} = {got} (expected {least} to {greatest} {unit})")]
    OutOfRange {
        /// Which parameter.
        name: &'static str,
        /// Its value.
        got: u32,
        /// The least allowed.
        least: u32,
        /// The greatest allowed.
        greatest: u32,
        /// The unit of the three.
        unit: &'static str,
    },
}

/// A parameter of [`Timing`], for help texts and for the check of ranges.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Parameter {
    /// Its name: that of the field.
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// Its value if nobody says otherwise.
    pub default: u32,
    /// The least allowed.
    pub least: u32,
    /// The greatest allowed.
    pub greatest: u32,
    /// Why it is what it is.
    pub why: &'static str,
}

impl fmt::Display for Parameter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            name,
            unit,
            default,
            least,
            greatest,
            why,
        } = self;
        write!(
            f,
            "{name} = {default} {unit} ({least} to {greatest}): {why}"
        )
    }
}

macro_rules! timing {
    ($( $name:ident = $default:literal, $unit:literal, $least:literal..=$greatest:literal, $why:literal; )+) => {
        /// Every period, span and count of the Master Process. See [`Timing::PARAMETERS`].
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub struct Timing { $( #[doc = concat!($why, " In ", $unit, ", ", stringify!($least), " to ", stringify!($greatest), ".")] pub $name: u32, )+ }

        impl Default for Timing {
            fn default() -> Self { Self { $( $name: $default, )+ } }
        }

        impl Timing {
            /// Every parameter with its unit, default, range and reason.
            pub const PARAMETERS: &'static [Parameter] = &[ $( Parameter {
                name: stringify!($name), unit: $unit, default: $default,
                least: $least, greatest: $greatest, why: $why,
            }, )+ ];

            /// Every value in its range.
            ///
            /// # Errors
            /// The first that is not.
            pub fn check(&self) -> Result<(), ConfigError> {
                let values = [ $( self.$name, )+ ];
                for (got, p) in values.into_iter().zip(Self::PARAMETERS) {
                    if !(p.least..=p.greatest).contains(&got) {
                        return Err(ConfigError::OutOfRange {
                            name: p.name, got, least: p.least, greatest: p.greatest, unit: p.unit,
                        });
                    }
                }
                Ok(())
            }
        }
    };
}

timing! {
    macrostep_ms = 20, "ms", 2..=1000, "One step of a behaviour: MRROC++'s macrostep of ten servo steps.";
    time_sync_ms = 20, "ms", 5..=1000, "Between two time messages: drift of a crystal is then below 1 µs.";
    retry_ms = 40, "ms", 5..=1000, "Before an unanswered request is repeated: a node answers within a macrostep.";
    tries = 8, "tries", 1..=100, "How often a request is sent before it counts as unanswered.";
    lease_ms = 100, "ms", 20..=2000, "How long a node moves on after the last valid command: five macrosteps.";
    command_ttl_ms = 100, "ms", 5..=2000, "After this a cyclic command must not be acted upon: as the lease.";
    stale_ms = 100, "ms", 5..=2000, "An image older than this is stale and is not computed with.";
    silence_ms = 500, "ms", 20..=10_000, "Without feedback for this long a node is lost.";
    identify_ms = 2000, "ms", 50..=60_000, "For a node to answer who it is: drives boot in up to 2 s, nodes sooner.";
    drives_ms = 10_000, "ms", 100..=120_000, "For a node to configure its drives: boot-up and some 40 objects each.";
    enable_ms = 5000, "ms", 100..=60_000, "For the drives to switch torque on and release their brakes.";
    home_ms = 600_000, "ms", 1000..=3_600_000, "For homing: axis after axis over their whole travel at coarse velocity.";
    rest_ms = 10_000, "ms", 100..=60_000, "For robots to come to rest after a stop.";
    start_lead_steps = 8, "macrosteps", 1..=100, "From asking several robots to move to their common start: room for retries.";
    knot_lead_steps = 5, "macrosteps", 2..=7, "How far ahead of their instant knots are sent: a stall this long moves nothing.";
    knot_repeats = 1, "messages", 0..=3, "How often a knot is sent again, a macrostep later: one lost message is no gap.";
}

impl Timing {
    /// The macrostep.
    #[must_use]
    pub const fn macrostep(&self) -> Micros {
        ms(self.macrostep_ms)
    }

    /// How many macrosteps a span is, rounded up, at least one.
    #[must_use]
    pub fn steps(&self, span_ms: u32) -> u32 {
        span_ms.div_ceil(if self.macrostep_ms == 0 {
            1
        } else {
            self.macrostep_ms
        })
    }
}

/// Milliseconds as a span.
#[must_use]
pub const fn ms(span: u32) -> Micros {
    Micros::from_millis(span as u64)
}

/// The instants of behaviours: i · macrostep. Bus time begins at 0 when the Master Process starts,
/// so 2³² steps of 20 ms are 2.7 years.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Grid {
    /// The macrostep, not zero.
    macrostep: Micros,
}

impl Grid {
    /// The grid of a timing.
    #[must_use]
    pub const fn new(timing: &Timing) -> Self {
        let macrostep = timing.macrostep();
        Self {
            macrostep: if macrostep.0 == 0 {
                Micros(1)
            } else {
                macrostep
            },
        }
    }

    /// The macrostep.
    #[must_use]
    pub const fn macrostep(self) -> Micros {
        self.macrostep
    }

    /// The macrostep, s.
    #[must_use]
    pub fn macrostep_s(self) -> f64 {
        self.macrostep.as_secs_f64()
    }

    /// The bus time of the instant i.
    #[must_use]
    pub const fn at(self, i: u32) -> Micros {
        Micros((i as u64).saturating_mul(self.macrostep.0))
    }

    /// The latest instant that is not after `now`.
    #[must_use]
    pub fn index(self, now: Micros) -> u32 {
        u32::try_from(now.0.checked_div(self.macrostep.0).unwrap_or(0)).unwrap_or(u32::MAX)
    }
}

#[cfg(test)]
mod test {
    use super::*;

    #[test]
    fn defaults_are_in_range_and_explained() {
        assert_eq!(Timing::default().check(), Ok(()));
        for p in Timing::PARAMETERS {
            assert!(p.why.len() > 20 && !p.unit.is_empty(), "{p}");
        }
    }

    #[test]
    fn a_time_out_of_range_names_itself() {
        let timing = Timing {
            lease_ms: 19,
            ..Timing::default()
        };
        let text = timing.check().unwrap_err().to_string();
        assert_eq!(text, "lease_ms = 19 (expected 20 to 2000 ms)");
    }

    #[test]
    fn a_number_or_a_name_twice_is_refused() {
        let track = RobotConfig::of(RobotKind::Irp6Track, 1).unwrap();
        let same_node = RobotConfig {
            name: "b".into(),
            ..track.clone()
        };
        let same_name = RobotConfig {
            node: NodeId::effector(2).unwrap(),
            ..track.clone()
        };
        assert!(matches!(
            Config::new(vec![track.clone(), same_node]).check(),
            Err(ConfigError::NodeTwice { .. })
        ));
        assert!(matches!(
            Config::new(vec![track, same_name]).check(),
            Err(ConfigError::NameTwice { .. })
        ));
    }

    #[test]
    fn instants_lie_on_the_grid() {
        let grid = Grid::new(&Timing::default());
        for (now, i) in [(0, 0), (19_999, 0), (20_000, 1), (1_000_000, 50)] {
            assert_eq!(grid.index(Micros(now)), i);
            assert!(grid.at(i).0 <= now && now < grid.at(i + 1).0);
        }
    }
}
