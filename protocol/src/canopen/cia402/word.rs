//! Controlword (object 6040) and statusword (object 6041).

use super::PowerState;

/// The command of a controlword's bits 0 to 3.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Command {
    /// Towards `ReadyToSwitchOn`.
    Shutdown,
    /// To `SwitchedOn`; from `OperationEnabled` it disables operation.
    SwitchOn,
    /// To `OperationEnabled`.
    EnableOperation,
    /// Torque off at once.
    DisableVoltage,
    /// Quick stop.
    QuickStop,
}

impl Command {
    /// Every command.
    pub const ALL: [Self; 5] = [
        Self::Shutdown,
        Self::SwitchOn,
        Self::EnableOperation,
        Self::DisableVoltage,
        Self::QuickStop,
    ];
}

/// The controlword.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Controlword(pub u16);

impl Controlword {
    /// Bit 4: in homing, start on its rising edge; in pp, a new set-point on its rising edge.
    pub const OPERATION_4: u16 = 1 << 4;
    /// Bit 5: in pp, the new set-point counts at once, not behind the one on its way.
    pub const CHANGE_AT_ONCE: u16 = 1 << 5;
    /// Bit 6: in pp, the new set-point is relative to the one before.
    pub const RELATIVE: u16 = 1 << 6;
    /// Bit 7: reset the fault on its rising edge.
    pub const FAULT_RESET: u16 = 1 << 7;
    /// Bit 8: halt.
    pub const HALT: u16 = 1 << 8;

    /// The word of a command.
    #[must_use]
    pub const fn of(command: Command) -> Self {
        Self(match command {
            Command::Shutdown => 0x06,
            Command::SwitchOn => 0x07,
            Command::EnableOperation => 0x0F,
            Command::DisableVoltage => 0x00,
            Command::QuickStop => 0x02,
        })
    }

    /// The command of the word. Bit 1 clear is "disable voltage", whatever else is set.
    #[must_use]
    pub const fn command(self) -> Command {
        match self.0 & 0x0F {
            0x06 | 0x0E => Command::Shutdown,
            0x07 => Command::SwitchOn,
            0x0F => Command::EnableOperation,
            word if word & 0x02 == 0 => Command::DisableVoltage,
            _ => Command::QuickStop,
        }
    }

    /// Is `bit` set?
    #[must_use]
    pub const fn has(self, bit: u16) -> bool {
        self.0 & bit != 0
    }

    /// Did `bit` rise from `before` to this word?
    #[must_use]
    pub const fn rises(self, before: Self, bit: u16) -> bool {
        self.has(bit) && !before.has(bit)
    }
}

/// The statusword.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Statusword(pub u16);

impl Statusword {
    /// Bit 4: the power stage has its voltage.
    pub const VOLTAGE: u16 = 1 << 4;
    /// Bit 7: warning.
    pub const WARNING: u16 = 1 << 7;
    /// Bit 8, of the maker: the drive is in step with SYNC.
    pub const IN_SYNC: u16 = 1 << 8;
    /// Bit 9: the drive obeys the controlword.
    pub const REMOTE: u16 = 1 << 9;
    /// Bit 10: the target is reached (pp, pv), the axis stands (homing, while halted).
    pub const TARGET_REACHED: u16 = 1 << 10;
    /// Bit 11: a limit of the drive cuts the set-point.
    pub const LIMIT: u16 = 1 << 11;
    /// Bit 12: csp, csv, cst: the drive follows the set-point; homing: the axis is homed; pp: the
    /// set-point was taken; pv: the axis stands.
    pub const FOLLOWS: u16 = 1 << 12;
    /// Bit 13: csp, pp: following error; homing: homing error.
    pub const DEVIATION: u16 = 1 << 13;

    /// The word of a power state, other bits clear.
    #[must_use]
    pub const fn of(state: PowerState) -> Self {
        Self(match state {
            PowerState::NotReadyToSwitchOn => 0x00,
            PowerState::SwitchOnDisabled => 0x40,
            PowerState::ReadyToSwitchOn => 0x21,
            PowerState::SwitchedOn => 0x23,
            PowerState::OperationEnabled => 0x27,
            PowerState::QuickStopActive => 0x07,
            PowerState::FaultReactionActive => 0x0F,
            PowerState::Fault => 0x08,
        })
    }

    /// The power state the word tells; `None` if its bits name none.
    #[must_use]
    pub const fn state(self) -> Option<PowerState> {
        Some(match self.0 & 0x4F {
            0x00 => PowerState::NotReadyToSwitchOn,
            0x40 => PowerState::SwitchOnDisabled,
            0x0F => PowerState::FaultReactionActive,
            0x08 => PowerState::Fault,
            _ => match self.0 & 0x6F {
                0x21 => PowerState::ReadyToSwitchOn,
                0x23 => PowerState::SwitchedOn,
                0x27 => PowerState::OperationEnabled,
                0x07 => PowerState::QuickStopActive,
                _ => return None,
            },
        })
    }

    /// Is `bit` set?
    #[must_use]
    pub const fn has(self, bit: u16) -> bool {
        self.0 & bit != 0
    }
}
