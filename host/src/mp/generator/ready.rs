//! The handshake: from silence to a robot that can be commanded.

use crate::mp::checklist::mismatch;
use crate::mp::command::{Commands, RobotCommand};
use crate::mp::config::Timing;
use crate::mp::failure::{Awaited, Failure};
use crate::mp::robot::{Image, Link};
use crate::mp::subsystem::MpSubsystem;
use agent::args::{E, F};
use agent::{Generator, X};
use protocol::message::NodeState;

/// How far a robot is brought.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Readiness {
    /// We know who it is; no lease.
    Identified,
    /// We hold the lease; torque as it is.
    Leased,
    /// Torque is on.
    Enabled,
}

/// `f^2(c_0, e_c)`: brings a list of robots to a [`Readiness`], each at its own pace.
///
/// Every wait has a limit and an error of its own, so that the one missing thing is named. A latched
/// fault is an error too, or is acknowledged once if that was asked for.
#[derive(Clone, Debug)]
pub struct GetReady {
    robots: Vec<usize>,
    goal: Readiness,
    acknowledge: bool,
    timing: Timing,
}

/// Where one robot's handshake is, and since which instant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stage {
    at: At,
    since: u32,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum At {
    Identify,
    Acquire,
    Drives { acknowledged: bool },
    Servo,
    Enable { asked: bool },
    Ready,
}

impl GetReady {
    /// These robots.
    #[must_use]
    pub const fn new(robots: Vec<usize>, goal: Readiness, timing: Timing) -> Self {
        Self {
            robots,
            goal,
            acknowledge: false,
            timing,
        }
    }

    /// Acknowledge latched faults on the way.
    #[must_use]
    pub const fn acknowledging(mut self) -> Self {
        self.acknowledge = true;
        self
    }

    /// One robot, one step: where it is next, and what it is told.
    fn advance(
        &self,
        stage: &mut Stage,
        image: &Image,
        i: u32,
    ) -> Result<Option<RobotCommand>, Failure> {
        let to = |stage: &mut Stage, at: At| *stage = Stage { at, since: i };
        match stage.at {
            At::Identify if image.is_asked() => {
                self.patience(*stage, i, image, Awaited::Identity)?;
                Ok(None)
            }
            At::Identify => match image.link() {
                Link::Silent => {
                    self.patience(*stage, i, image, Awaited::Identity)?;
                    Ok(Some(RobotCommand::Identify))
                }
                Link::Identified { identity } | Link::Leased { identity, .. } => {
                    if let Some(failure) = mismatch(image, identity) {
                        return Err(failure);
                    }
                    match (self.goal, image.epoch()) {
                        (Readiness::Identified, _) => to(stage, At::Ready),
                        (_, Some(_)) => to(
                            stage,
                            At::Drives {
                                acknowledged: false,
                            },
                        ),
                        (_, None) => {
                            to(stage, At::Acquire);
                            return Ok(Some(RobotCommand::Acquire));
                        }
                    }
                    Ok(None)
                }
            },
            At::Acquire => {
                if image.epoch().is_some() {
                    to(
                        stage,
                        At::Drives {
                            acknowledged: false,
                        },
                    );
                }
                Ok(None)
            }
            At::Drives { acknowledged } => self.drives(stage, image, i, acknowledged),
            At::Servo if image.is_asked() => Ok(None),
            At::Servo => {
                to(stage, At::Enable { asked: false });
                Ok(None)
            }
            At::Enable { asked } => match image.state() {
                Some(NodeState::Unsynchronised | NodeState::Holding) if !image.is_asked() => {
                    to(stage, At::Ready);
                    Ok(None)
                }
                Some(NodeState::Disabled) if !asked => {
                    to(stage, At::Enable { asked: true });
                    Ok(Some(RobotCommand::Enable))
                }
                Some(NodeState::Faulted) => Err(faulted(image)),
                _ => {
                    self.patience(*stage, i, image, Awaited::Torque)?;
                    Ok(None)
                }
            },
            At::Ready => Ok(None),
        }
    }

    fn drives(
        &self,
        stage: &mut Stage,
        image: &Image,
        i: u32,
        acknowledged: bool,
    ) -> Result<Option<RobotCommand>, Failure> {
        match image.state() {
            Some(NodeState::Disabled | NodeState::Holding) => {
                if self.goal == Readiness::Enabled {
                    *stage = Stage {
                        at: At::Servo,
                        since: i,
                    };
                    return Ok(Some(RobotCommand::SelectServo(image.config().servo)));
                }
                *stage = Stage {
                    at: At::Ready,
                    since: i,
                };
            }
            Some(NodeState::Unsynchronised) => {
                let at = if self.goal == Readiness::Enabled {
                    At::Enable { asked: false }
                } else {
                    At::Ready
                };
                *stage = Stage { at, since: i };
            }
            Some(NodeState::Faulted) if self.acknowledge && !acknowledged => {
                *stage = Stage {
                    at: At::Drives { acknowledged: true },
                    since: i,
                };
                return Ok(Some(RobotCommand::Acknowledge));
            }
            // after an acknowledgement the image needs a moment to show it
            Some(NodeState::Faulted) if !acknowledged => return Err(faulted(image)),
            _ => self.patience(*stage, i, image, Awaited::Drives)?,
        }
        Ok(None)
    }

    fn patience(
        &self,
        stage: Stage,
        i: u32,
        image: &Image,
        awaited: Awaited,
    ) -> Result<(), Failure> {
        let span_ms = match awaited {
            Awaited::Identity => self.timing.identify_ms,
            Awaited::Drives => self.timing.drives_ms,
            Awaited::Torque => self.timing.enable_ms,
            Awaited::Homing => self.timing.home_ms,
            Awaited::Rest => self.timing.rest_ms,
        };
        if i.saturating_sub(stage.since) < self.timing.steps(span_ms) {
            return Ok(());
        }
        Err(Failure::TimedOut {
            who: image.who(),
            awaited,
            span_ms,
            seen: seen(image),
        })
    }
}

/// How far a node came, for the message.
fn seen(image: &Image) -> String {
    let Some(state) = image.state() else {
        return "no fresh feedback".to_owned();
    };
    let missing: Vec<&str> = image
        .arm()
        .axes()
        .iter()
        .enumerate()
        .filter(|(axis, _)| image.drives_ready() >> axis & 1 == 0)
        .map(|(_, axis)| axis.name)
        .collect();
    if state == NodeState::Configuring && !missing.is_empty() {
        format!("{state:?}; no drive-ready event of {}", missing.join(", "))
    } else {
        format!("{state:?}")
    }
}

fn faulted(image: &Image) -> Failure {
    match image.fault() {
        Some(fault) => Failure::Fault {
            who: image.who(),
            fault,
            axis: fault.axis.and_then(|axis| image.axis_name(axis)),
        },
        None => Failure::TimedOut {
            who: image.who(),
            awaited: Awaited::Torque,
            span_ms: 0,
            seen: "Faulted, but the fault is not told".to_owned(),
        },
    }
}

impl Generator<MpSubsystem> for GetReady {
    type Own = Vec<Stage>;
    type Args = F<(), E, ()>;

    fn first(&self, x: X<'_, MpSubsystem, Self::Args>) -> (Vec<Stage>, Commands) {
        let mut stages = vec![
            Stage {
                at: At::Identify,
                since: x.i()
            };
            self.robots.len()
        ];
        let commands = self.next(&mut stages, x);
        (stages, commands)
    }

    fn next(&self, stages: &mut Vec<Stage>, x: X<'_, MpSubsystem, Self::Args>) -> Commands {
        let mut commands = Commands::none();
        for (robot, stage) in self.robots.iter().zip(stages) {
            let Some(image) = x.e().get(*robot) else {
                continue;
            };
            match self.advance(stage, image, x.i()) {
                Ok(Some(command)) => commands.robots.push((*robot, command)),
                Ok(None) => {}
                Err(failure) => return commands.and(Commands::give_up(failure)),
            }
        }
        commands
    }

    fn terminal(&self, stages: &Vec<Stage>, _: X<'_, MpSubsystem, Self::Args>) -> bool {
        stages.iter().all(|stage| stage.at == At::Ready)
    }
}
