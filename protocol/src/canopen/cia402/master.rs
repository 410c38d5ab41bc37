//! The node's side of the power state machine: which controlword leads towards a goal.

use super::{Command, Controlword, PowerState, Statusword};

/// Where the node wants the drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Goal {
    /// No torque, no voltage.
    Disabled,
    /// Prepared: one command from torque.
    SwitchedOn,
    /// Torque.
    Enabled,
    /// Stop now, by the drive's quick-stop option.
    QuickStop,
}

impl Goal {
    /// Every goal.
    pub const ALL: [Self; 4] = [
        Self::Disabled,
        Self::SwitchedOn,
        Self::Enabled,
        Self::QuickStop,
    ];

    /// The command that leads from `state` towards the goal.
    ///
    /// A fault or a quick stop is never left by itself: from `Fault` it needs
    /// [`Master::reset_fault`], from `QuickStopActive` the goal [`Goal::Disabled`].
    #[must_use]
    pub const fn command(self, state: PowerState) -> Command {
        match (self, state) {
            (Self::Disabled, _) => Command::DisableVoltage,
            (Self::QuickStop, _) | (_, PowerState::QuickStopActive) => Command::QuickStop,
            (
                _,
                PowerState::NotReadyToSwitchOn
                | PowerState::FaultReactionActive
                | PowerState::Fault,
            ) => Command::DisableVoltage,
            (_, PowerState::SwitchOnDisabled) => Command::Shutdown,
            (_, PowerState::ReadyToSwitchOn)
            | (Self::SwitchedOn, PowerState::SwitchedOn | PowerState::OperationEnabled) => {
                Command::SwitchOn
            }
            (Self::Enabled, PowerState::SwitchedOn | PowerState::OperationEnabled) => {
                Command::EnableOperation
            }
        }
    }

    /// Is the goal reached in `state`?
    #[must_use]
    pub const fn reached(self, state: PowerState) -> bool {
        match self {
            Self::Disabled => {
                matches!(state, PowerState::SwitchOnDisabled | PowerState::Fault)
            }
            Self::SwitchedOn => matches!(state, PowerState::SwitchedOn),
            Self::Enabled => matches!(state, PowerState::OperationEnabled),
            Self::QuickStop => matches!(
                state,
                PowerState::QuickStopActive
                    | PowerState::SwitchOnDisabled
                    | PowerState::ReadyToSwitchOn
                    | PowerState::SwitchedOn
                    | PowerState::Fault
            ),
        }
    }
}

/// How far a requested fault reset is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Reset {
    /// Not requested.
    #[default]
    Idle,
    /// Bit 7 must be seen low first.
    Low,
    /// Bit 7 is high until the drive leaves `Fault`, at most this many more words.
    High(u8),
}

/// How many words bit 7 stays high: a drive that evaluates every SYNC sees it, a lost frame or two
/// do no harm, and a fault whose cause is present does not keep the bit high for ever.
const RESET_WORDS: u8 = 8;

/// Leads one drive towards a goal, one controlword per cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Master {
    goal: Goal,
    reset: Reset,
}

impl Default for Master {
    fn default() -> Self {
        Self {
            goal: Goal::Disabled,
            reset: Reset::Idle,
        }
    }
}

impl Master {
    /// The goal.
    #[must_use]
    pub const fn goal(&self) -> Goal {
        self.goal
    }

    /// Sets the goal. It does not reset a fault.
    pub fn set_goal(&mut self, goal: Goal) {
        self.goal = goal;
    }

    /// Asks for one fault reset: one rising edge of bit 7.
    pub fn reset_fault(&mut self) {
        self.reset = Reset::Low;
    }

    /// The next controlword, given the last statusword.
    pub fn next(&mut self, status: Statusword) -> Controlword {
        let Some(state) = status.state() else {
            return Controlword::of(Command::DisableVoltage);
        };
        let word = Controlword::of(self.goal.command(state));
        if state == PowerState::FaultReactionActive {
            return word;
        }
        if state != PowerState::Fault {
            self.reset = Reset::Idle;
            return word;
        }
        match self.reset {
            Reset::Idle => word,
            Reset::Low => {
                self.reset = Reset::High(RESET_WORDS);
                word
            }
            Reset::High(left) => {
                self.reset = match left.checked_sub(1) {
                    Some(left) => Reset::High(left),
                    None => Reset::Idle,
                };
                Controlword(word.0 | Controlword::FAULT_RESET)
            }
        }
    }
}
