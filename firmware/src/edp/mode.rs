//! The EDP's state machine.
//!
//! ```text
//!            drives configured      enable         torque on
//!  Boot ──▶ Configuring ──▶ Disabled ──▶ Enabling ──▶ Unsynchronised ──▶ Synchronising
//!                              ▲  ▲          │            │   ▲  start │ ▲       │ homed
//!                              │  └─disable──┼────────────┘   └────────┼─┼───────┤ (stop)
//!                              │             │ torque on, homed        ▼ │       ▼
//!                              │             └──────────────────────▶ Moving ⇄ Holding
//!                              │ acknowledge, torque off                │ stop     ▲
//!                              │                                        ▼          │ at rest
//!                           Faulted ◀───────── at rest ───────────── Stopping ─────┘
//!                              │ acknowledge, torque on ──▶ Holding | Unsynchronised
//! ```
//! Any state with a bus goes to `Stopping` (or, with torque already off or to be cut at once, to
//! `Faulted`) when a fault is raised.

use protocol::fault::{Fault, Reaction};
use protocol::message::NodeState;

/// Where the arm rests when it does not move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rest {
    /// Not homed: motor positions count from wherever the robot was switched on.
    Unsynchronised,
    /// Homed.
    Holding,
}

/// The state, with the data only that state has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// Started; nothing is known of the drives.
    Boot,
    /// Drives are identified and configured, one SDO after the other.
    Configuring,
    /// Drives are configured; torque off, brakes closed.
    Disabled,
    /// Drives walk to "operation enabled".
    Enabling {
        /// Where the arm will rest.
        rest: Rest,
    },
    /// Torque on and at rest.
    Resting(Rest),
    /// Homing, one axis after the other.
    Synchronising,
    /// Executing an instruction.
    Moving {
        /// Where it started from: decides what may be asked for.
        from: Rest,
    },
    /// Coming to rest.
    Stopping {
        /// Where it will rest, if torque stays on.
        rest: Rest,
        /// Why, if it was not a commanded stop.
        fault: Option<Fault>,
        /// How.
        reaction: Reaction,
    },
    /// A fault is latched; the first one is kept.
    Faulted {
        /// The first fault.
        fault: Fault,
        /// Where the arm rests under torque; `None` with torque off.
        rest: Option<Rest>,
    },
}

/// What can happen to the state machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    /// The first step after power-up.
    Started,
    /// Every drive is configured.
    DrivesConfigured,
    /// The operator asks for torque; the axes are homed already or not.
    Enable {
        /// Are all axes homed?
        homed: bool,
    },
    /// Every drive follows its target.
    Enabled,
    /// The operator asks for torque off.
    Disable,
    /// The operator asks for homing.
    Synchronise,
    /// Every axis is homed.
    Synchronised,
    /// An instruction starts.
    Start,
    /// The instruction has ended and the arm is at rest.
    Ended,
    /// A stop was commanded.
    Stop(Reaction),
    /// The stop is complete: every set-point velocity is zero.
    AtRest,
    /// A fault was detected.
    Fault(Fault, Reaction),
    /// The operator acknowledges the latched fault; its cause is gone.
    Acknowledge,
}

impl Mode {
    /// The state after an event; `None` if the event is not allowed in this state.
    #[must_use]
    #[expect(
        clippy::too_many_lines,
        reason = "one table: splitting it would hide the gaps"
    )]
    #[expect(clippy::match_same_arms, reason = "an arm per edge of the diagram")]
    pub const fn on(self, event: Event) -> Option<Self> {
        use Event as E;
        Some(match (self, event) {
            (Self::Boot, E::Started) => Self::Configuring,
            (Self::Configuring, E::DrivesConfigured) => Self::Disabled,
            (Self::Disabled, E::Enable { homed }) => Self::Enabling {
                rest: if homed {
                    Rest::Holding
                } else {
                    Rest::Unsynchronised
                },
            },
            (Self::Enabling { rest }, E::Enabled) => Self::Resting(rest),
            (Self::Enabling { .. } | Self::Resting(_), E::Disable) => Self::Disabled,
            (Self::Resting(Rest::Unsynchronised), E::Synchronise) => Self::Synchronising,
            (Self::Synchronising, E::Synchronised) => Self::Resting(Rest::Holding),
            (Self::Resting(rest), E::Start) => Self::Moving { from: rest },
            (Self::Moving { from }, E::Ended) => Self::Resting(from),

            (Self::Moving { from }, E::Stop(reaction)) => Self::stopping(from, None, reaction),
            (Self::Synchronising, E::Stop(reaction)) => {
                Self::stopping(Rest::Unsynchronised, None, reaction)
            }
            (Self::Resting(rest), E::Stop(Reaction::PathStop)) => Self::Resting(rest),
            (
                Self::Resting(_) | Self::Enabling { .. },
                E::Stop(Reaction::QuickStop | Reaction::TorqueOff),
            )
            | (Self::Enabling { .. }, E::Stop(Reaction::PathStop)) => Self::Disabled,
            (Self::Disabled, E::Stop(_)) => Self::Disabled,
            // A stronger stop wins over a weaker one; a weaker one changes nothing.
            (
                Self::Stopping {
                    rest,
                    fault,
                    reaction,
                },
                E::Stop(stronger),
            ) => Self::stopping(rest, fault, strongest(reaction, stronger)),
            (
                Self::Stopping {
                    rest,
                    fault: None,
                    reaction: Reaction::PathStop,
                },
                E::AtRest,
            ) => Self::Resting(rest),
            (Self::Stopping { fault: None, .. }, E::AtRest) => Self::Disabled,
            (
                Self::Stopping {
                    rest,
                    fault: Some(fault),
                    reaction,
                },
                E::AtRest,
            ) => Self::Faulted {
                fault,
                rest: match reaction {
                    Reaction::PathStop => Some(rest),
                    Reaction::QuickStop | Reaction::TorqueOff => None,
                },
            },

            (Self::Faulted { fault, .. }, E::Stop(Reaction::QuickStop | Reaction::TorqueOff)) => {
                Self::Faulted { fault, rest: None }
            }
            (faulted @ Self::Faulted { .. }, E::Stop(Reaction::PathStop)) => faulted,
            (
                Self::Faulted {
                    rest: Some(rest), ..
                },
                E::Acknowledge,
            ) => Self::Resting(rest),
            (Self::Faulted { rest: None, .. }, E::Acknowledge) => Self::Configuring,

            (Self::Boot | Self::Configuring | Self::Disabled, E::Fault(fault, _)) => {
                Self::Faulted { fault, rest: None }
            }
            (Self::Enabling { .. }, E::Fault(fault, _)) => Self::Faulted { fault, rest: None },
            (Self::Resting(rest) | Self::Moving { from: rest }, E::Fault(fault, reaction)) => {
                Self::stopping(rest, Some(fault), reaction)
            }
            (Self::Synchronising, E::Fault(fault, reaction)) => {
                Self::stopping(Rest::Unsynchronised, Some(fault), reaction)
            }
            // The first fault is kept; the strongest reaction wins.
            (
                Self::Stopping {
                    rest,
                    fault: first,
                    reaction,
                },
                E::Fault(fault, stronger),
            ) => {
                let first = match first {
                    Some(first) => first,
                    None => fault,
                };
                Self::stopping(rest, Some(first), strongest(reaction, stronger))
            }
            (Self::Faulted { fault, rest }, E::Fault(_, reaction)) => Self::Faulted {
                fault,
                rest: match reaction {
                    Reaction::PathStop => rest,
                    Reaction::QuickStop | Reaction::TorqueOff => None,
                },
            },

            (
                Self::Boot
                | Self::Configuring
                | Self::Disabled
                | Self::Enabling { .. }
                | Self::Resting(_)
                | Self::Synchronising
                | Self::Moving { .. }
                | Self::Stopping { .. }
                | Self::Faulted { .. },
                _,
            ) => return None,
        })
    }

    /// R3 cuts torque at once: there is no deceleration to wait for.
    const fn stopping(rest: Rest, fault: Option<Fault>, reaction: Reaction) -> Self {
        match (reaction, fault) {
            (Reaction::TorqueOff, Some(fault)) => Self::Faulted { fault, rest: None },
            (Reaction::TorqueOff, None) => Self::Disabled,
            (Reaction::PathStop | Reaction::QuickStop, fault) => Self::Stopping {
                rest,
                fault,
                reaction,
            },
        }
    }

    /// Must the drives produce torque in this state?
    #[must_use]
    pub const fn torque(self) -> bool {
        match self {
            Self::Boot | Self::Configuring | Self::Disabled => false,
            Self::Enabling { .. }
            | Self::Resting(_)
            | Self::Synchronising
            | Self::Moving { .. }
            | Self::Stopping { .. } => true,
            Self::Faulted { rest, .. } => rest.is_some(),
        }
    }

    /// The latched or stopping fault.
    #[must_use]
    pub const fn fault(self) -> Option<Fault> {
        match self {
            Self::Faulted { fault, .. } => Some(fault),
            Self::Stopping { fault, .. } => fault,
            Self::Boot
            | Self::Configuring
            | Self::Disabled
            | Self::Enabling { .. }
            | Self::Resting(_)
            | Self::Synchronising
            | Self::Moving { .. } => None,
        }
    }
}

const fn strongest(a: Reaction, b: Reaction) -> Reaction {
    if a as u8 >= b as u8 { a } else { b }
}

impl From<Mode> for NodeState {
    fn from(mode: Mode) -> Self {
        match mode {
            Mode::Boot => Self::Boot,
            Mode::Configuring => Self::Configuring,
            Mode::Disabled => Self::Disabled,
            Mode::Enabling { .. } => Self::Enabling,
            Mode::Resting(Rest::Unsynchronised) => Self::Unsynchronised,
            Mode::Resting(Rest::Holding) => Self::Holding,
            Mode::Synchronising => Self::Synchronising,
            Mode::Moving { .. } => Self::Moving,
            Mode::Stopping { .. } => Self::Stopping,
            Mode::Faulted { .. } => Self::Faulted,
        }
    }
}

#[cfg(test)]
mod test {
    extern crate std;
    use super::*;
    use core::fmt::Write;
    use protocol::fault::Cause;
    use std::format;
    use std::string::String;

    const FIRST: Fault = Fault {
        cause: Cause::Underrun,
        axis: None,
        step: 7,
        during: NodeState::Moving,
    };
    const LATER: Fault = Fault {
        cause: Cause::DriveFault,
        axis: Some(2),
        step: 9,
        during: NodeState::Stopping,
    };

    fn states() -> [(&'static str, Mode); 15] {
        use Reaction::{PathStop, QuickStop};
        let (u, h) = (Rest::Unsynchronised, Rest::Holding);
        [
            ("Boot", Mode::Boot),
            ("Configuring", Mode::Configuring),
            ("Disabled", Mode::Disabled),
            ("Enabling u", Mode::Enabling { rest: u }),
            ("Enabling h", Mode::Enabling { rest: h }),
            ("Resting u", Mode::Resting(u)),
            ("Resting h", Mode::Resting(h)),
            ("Synchronising", Mode::Synchronising),
            ("Moving u", Mode::Moving { from: u }),
            ("Moving h", Mode::Moving { from: h }),
            (
                "Stopping path",
                Mode::Stopping {
                    rest: h,
                    fault: None,
                    reaction: PathStop,
                },
            ),
            (
                "Stopping path!",
                Mode::Stopping {
                    rest: h,
                    fault: Some(FIRST),
                    reaction: PathStop,
                },
            ),
            (
                "Stopping quick!",
                Mode::Stopping {
                    rest: h,
                    fault: Some(FIRST),
                    reaction: QuickStop,
                },
            ),
            (
                "Faulted on",
                Mode::Faulted {
                    fault: FIRST,
                    rest: Some(h),
                },
            ),
            (
                "Faulted off",
                Mode::Faulted {
                    fault: FIRST,
                    rest: None,
                },
            ),
        ]
    }

    fn events() -> [(&'static str, Event); 17] {
        use Reaction::{PathStop, QuickStop, TorqueOff};
        [
            ("Started", Event::Started),
            ("DrivesConfigured", Event::DrivesConfigured),
            ("Enable", Event::Enable { homed: false }),
            ("Enable homed", Event::Enable { homed: true }),
            ("Enabled", Event::Enabled),
            ("Disable", Event::Disable),
            ("Synchronise", Event::Synchronise),
            ("Synchronised", Event::Synchronised),
            ("Start", Event::Start),
            ("Ended", Event::Ended),
            ("AtRest", Event::AtRest),
            ("Stop R1", Event::Stop(PathStop)),
            ("Stop R2", Event::Stop(QuickStop)),
            ("Stop R3", Event::Stop(TorqueOff)),
            ("Fault R1", Event::Fault(LATER, PathStop)),
            ("Fault R3", Event::Fault(LATER, TorqueOff)),
            ("Acknowledge", Event::Acknowledge),
        ]
    }

    fn name(mode: Mode) -> String {
        match mode {
            Mode::Stopping {
                rest,
                fault,
                reaction,
            } => {
                format!(
                    "Stopping({rest:?},{:?},{reaction:?})",
                    fault.map(|f| f.cause)
                )
            }
            Mode::Faulted { fault, rest } => format!("Faulted({:?},{rest:?})", fault.cause),
            other => format!("{other:?}"),
        }
    }

    #[test]
    fn every_state_and_event() {
        let mut table = String::new();
        for (s, state) in states() {
            for (e, event) in events() {
                let next = state.on(event).map_or_else(|| "-".into(), name);
                writeln!(table, "{s} | {e} | {next}").unwrap();
            }
        }
        let golden = include_str!("mode.table");
        if std::env::var_os("BLESS").is_some() {
            std::fs::write(
                concat!(env!("CARGO_MANIFEST_DIR"), "/src/edp/mode.table"),
                &table,
            )
            .unwrap();
        } else {
            assert_eq!(
                table, golden,
                "run with BLESS=1 to accept, then review the difference"
            );
        }
    }

    #[test]
    fn a_reaction_never_de_escalates_and_the_first_fault_is_kept() {
        for (_, state) in states() {
            for reaction in [Reaction::PathStop, Reaction::QuickStop, Reaction::TorqueOff] {
                let Some(next) = state.on(Event::Fault(LATER, reaction)) else {
                    panic!("{state:?} must accept a fault");
                };
                if let Some(first) = state.fault() {
                    assert_eq!(next.fault(), Some(first), "{state:?}");
                } else {
                    assert_eq!(next.fault(), Some(LATER), "{state:?}");
                }
                if !state.torque() {
                    assert!(
                        !next.torque(),
                        "{state:?} + {reaction:?} must not switch torque on"
                    );
                }
                if reaction == Reaction::TorqueOff {
                    assert!(!next.torque(), "{state:?}");
                }
            }
        }
    }

    #[test]
    fn only_acknowledge_leaves_faulted() {
        for (name, event) in events() {
            let faulted = Mode::Faulted {
                fault: FIRST,
                rest: None,
            };
            let next = faulted.on(event);
            if event != Event::Acknowledge {
                assert!(
                    next.is_none_or(|n| matches!(n, Mode::Faulted { .. })),
                    "{name}"
                );
            }
        }
    }
}
