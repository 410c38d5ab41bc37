//! The power state machine of the drive.

use super::{Command, Options, PowerState, Ramp, Stop};

/// What happens to the power state machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Event {
    /// The drive finished booting.
    Booted,
    /// The controlword's command (evaluated at every controlword, not only on change).
    Command(Command),
    /// Bit 7 rose and no cause of a fault is left.
    FaultReset,
    /// A fault.
    Fault,
    /// The ramp reached standstill.
    Standstill,
}

impl Event {
    /// Every event.
    pub const ALL: [Self; 9] = [
        Self::Booted,
        Self::Command(Command::Shutdown),
        Self::Command(Command::SwitchOn),
        Self::Command(Command::EnableOperation),
        Self::Command(Command::DisableVoltage),
        Self::Command(Command::QuickStop),
        Self::FaultReset,
        Self::Fault,
        Self::Standstill,
    ];
}

/// What the drive does about a transition.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Action {
    /// Nothing.
    None,
    /// Torque on, open the brake, follow set-points when it is open.
    Energise,
    /// Follow set-points again.
    Resume,
    /// Ramp down; tell [`Event::Standstill`].
    Ramp(Ramp),
    /// Close the brake, then torque off.
    SwitchOff,
    /// Torque off and close the brake at once.
    Coast,
}

/// The power state with what belongs to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Power {
    /// `NotReadyToSwitchOn`.
    NotReady,
    /// `SwitchOnDisabled`.
    Disabled,
    /// `ReadyToSwitchOn`.
    Ready,
    /// `SwitchedOn`.
    SwitchedOn,
    /// `OperationEnabled`.
    Enabled,
    /// Still `OperationEnabled`, ramping down to leave it.
    Leaving {
        /// To `ReadyToSwitchOn`, not to `SwitchedOn`?
        shutdown: bool,
    },
    /// `QuickStopActive`.
    QuickStop {
        /// Stand with torque afterwards, instead of switching off?
        stand: bool,
    },
    /// `FaultReactionActive`.
    FaultReaction,
    /// `Fault`.
    Fault,
}

impl Power {
    /// Every state.
    pub const ALL: [Self; 11] = [
        Self::NotReady,
        Self::Disabled,
        Self::Ready,
        Self::SwitchedOn,
        Self::Enabled,
        Self::Leaving { shutdown: false },
        Self::Leaving { shutdown: true },
        Self::QuickStop { stand: false },
        Self::QuickStop { stand: true },
        Self::FaultReaction,
        Self::Fault,
    ];

    /// What the statusword says.
    #[must_use]
    pub const fn state(self) -> PowerState {
        match self {
            Self::NotReady => PowerState::NotReadyToSwitchOn,
            Self::Disabled => PowerState::SwitchOnDisabled,
            Self::Ready => PowerState::ReadyToSwitchOn,
            Self::SwitchedOn => PowerState::SwitchedOn,
            Self::Enabled | Self::Leaving { .. } => PowerState::OperationEnabled,
            Self::QuickStop { .. } => PowerState::QuickStopActive,
            Self::FaultReaction => PowerState::FaultReactionActive,
            Self::Fault => PowerState::Fault,
        }
    }

    /// The state after `event`, and what the drive does about it.
    #[must_use]
    pub const fn on(self, event: Event, options: Options) -> (Self, Action) {
        match (self, event) {
            (_, Event::Fault) => self.fault(options),
            (Self::NotReady, Event::Booted) | (Self::Fault, Event::FaultReset) => {
                (Self::Disabled, Action::None)
            }
            (_, Event::Standstill) => self.standstill(),
            (_, Event::Command(command)) => self.command(command, options),
            (_, Event::Booted | Event::FaultReset) => (self, Action::None),
        }
    }

    const fn fault(self, options: Options) -> (Self, Action) {
        match self {
            Self::NotReady | Self::Disabled | Self::Ready | Self::SwitchedOn => {
                (Self::Fault, Action::None)
            }
            Self::Enabled | Self::Leaving { .. } | Self::QuickStop { .. } => match options.fault {
                Stop::Coast => (Self::Fault, Action::Coast),
                Stop::ThenOff(ramp) | Stop::ThenStand(ramp) => {
                    (Self::FaultReaction, Action::Ramp(ramp))
                }
            },
            Self::FaultReaction | Self::Fault => (self, Action::None),
        }
    }

    const fn standstill(self) -> (Self, Action) {
        match self {
            Self::Leaving { shutdown: true } => (Self::Ready, Action::SwitchOff),
            Self::Leaving { shutdown: false } => (Self::SwitchedOn, Action::SwitchOff),
            Self::QuickStop { stand: false } => (Self::Disabled, Action::SwitchOff),
            Self::FaultReaction => (Self::Fault, Action::SwitchOff),
            Self::NotReady
            | Self::Disabled
            | Self::Ready
            | Self::SwitchedOn
            | Self::Enabled
            | Self::QuickStop { stand: true }
            | Self::Fault => (self, Action::None),
        }
    }

    const fn command(self, command: Command, options: Options) -> (Self, Action) {
        match self {
            Self::NotReady | Self::FaultReaction | Self::Fault => (self, Action::None),
            Self::Disabled => match command {
                Command::Shutdown => (Self::Ready, Action::None),
                Command::SwitchOn
                | Command::EnableOperation
                | Command::DisableVoltage
                | Command::QuickStop => (self, Action::None),
            },
            Self::Ready => match command {
                Command::Shutdown => (self, Action::None),
                // "Enable operation" passes through SwitchedOn: its next evaluation goes on.
                Command::SwitchOn | Command::EnableOperation => (Self::SwitchedOn, Action::None),
                Command::DisableVoltage | Command::QuickStop => (Self::Disabled, Action::None),
            },
            Self::SwitchedOn => match command {
                Command::Shutdown => (Self::Ready, Action::None),
                Command::SwitchOn => (self, Action::None),
                Command::EnableOperation => (Self::Enabled, Action::Energise),
                Command::DisableVoltage | Command::QuickStop => (Self::Disabled, Action::None),
            },
            Self::Enabled => self.enabled(command, options),
            Self::Leaving { .. } => match command {
                Command::EnableOperation => (Self::Enabled, Action::Resume),
                Command::Shutdown | Command::SwitchOn => (self, Action::None),
                Command::DisableVoltage | Command::QuickStop => self.enabled(command, options),
            },
            Self::QuickStop { stand } => match command {
                Command::DisableVoltage => (Self::Disabled, Action::Coast),
                // Transition 16, only where the option code lets the drive stand.
                Command::EnableOperation if stand => (Self::Enabled, Action::Resume),
                Command::EnableOperation
                | Command::Shutdown
                | Command::SwitchOn
                | Command::QuickStop => (self, Action::None),
            },
        }
    }

    const fn enabled(self, command: Command, options: Options) -> (Self, Action) {
        match command {
            Command::EnableOperation => (self, Action::None),
            Command::DisableVoltage => (Self::Disabled, Action::Coast),
            Command::QuickStop => match options.quick_stop {
                Stop::Coast => (Self::Disabled, Action::Coast),
                Stop::ThenOff(ramp) => (Self::QuickStop { stand: false }, Action::Ramp(ramp)),
                Stop::ThenStand(ramp) => (Self::QuickStop { stand: true }, Action::Ramp(ramp)),
            },
            Command::Shutdown => match options.shutdown {
                Stop::Coast => (Self::Ready, Action::Coast),
                Stop::ThenOff(ramp) | Stop::ThenStand(ramp) => {
                    (Self::Leaving { shutdown: true }, Action::Ramp(ramp))
                }
            },
            Command::SwitchOn => match options.disable {
                Stop::Coast => (Self::SwitchedOn, Action::Coast),
                Stop::ThenOff(ramp) | Stop::ThenStand(ramp) => {
                    (Self::Leaving { shutdown: false }, Action::Ramp(ramp))
                }
            },
        }
    }
}
