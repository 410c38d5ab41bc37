//! The drive profile CiA 402: power states, words, modes, option codes.
//!
//! ```text
//!   NotReadyToSwitchOn ──▶ SwitchOnDisabled ◀────────────────────────┐
//!                          │ ▲ Shutdown                              │ fault reset (edge of bit 7)
//!                          ▼ │                                       │
//!                     ReadyToSwitchOn                              Fault
//!                          │ ▲ SwitchOn                              ▲
//!                          ▼ │                                       │ reaction done
//!                       SwitchedOn                       FaultReactionActive ◀── fault, any state
//!                          │ ▲ EnableOperation
//!                          ▼ │                 QuickStop
//!                    OperationEnabled ─────────────────────▶ QuickStopActive ──▶ SwitchOnDisabled
//! ```

mod master;
mod option;
mod slave;
mod word;

pub use master::{Goal, Master};
pub use option::{AbortConnection, Halt, Options, Ramp, Stop};
pub use slave::{Action, Event, Power};
pub use word::{Command, Controlword, Statusword};

/// The power state a statusword tells.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PowerState {
    /// Booting.
    NotReadyToSwitchOn,
    /// Ready for commands; no high voltage may be applied.
    SwitchOnDisabled,
    /// High voltage may be applied.
    ReadyToSwitchOn,
    /// High voltage is applied, no torque.
    SwitchedOn,
    /// Torque; the drive follows its set-points.
    OperationEnabled,
    /// Stopping, or standing after a quick stop.
    QuickStopActive,
    /// Stopping because of a fault.
    FaultReactionActive,
    /// No torque until the fault is reset.
    Fault,
}

impl PowerState {
    /// Every state.
    pub const ALL: [Self; 8] = [
        Self::NotReadyToSwitchOn,
        Self::SwitchOnDisabled,
        Self::ReadyToSwitchOn,
        Self::SwitchedOn,
        Self::OperationEnabled,
        Self::QuickStopActive,
        Self::FaultReactionActive,
        Self::Fault,
    ];
}

/// Modes of operation (objects 6060, 6061).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[repr(i8)]
pub enum Mode {
    /// None chosen.
    #[default]
    None = 0,
    /// Profile position: the drive makes the way to the target itself.
    Pp = 1,
    /// Profile velocity: the drive makes the way to the target velocity itself.
    Pv = 3,
    /// Homing.
    Homing = 6,
    /// Cyclic synchronous position: the drive closes the position loop.
    Csp = 8,
    /// Cyclic synchronous velocity: the drive closes the velocity loop.
    Csv = 9,
    /// Cyclic synchronous torque: the node closes the loop.
    Cst = 10,
}

impl Mode {
    /// Every mode the drive of this system has.
    pub const ALL: [Self; 7] = [
        Self::None,
        Self::Pp,
        Self::Pv,
        Self::Homing,
        Self::Csp,
        Self::Csv,
        Self::Cst,
    ];

    /// The mode of a code.
    #[must_use]
    pub const fn from_code(code: i8) -> Option<Self> {
        Some(match code {
            0 => Self::None,
            1 => Self::Pp,
            3 => Self::Pv,
            6 => Self::Homing,
            8 => Self::Csp,
            9 => Self::Csv,
            10 => Self::Cst,
            _ => return None,
        })
    }

    /// The code of object 6060.
    #[must_use]
    pub const fn code(self) -> i8 {
        self as i8
    }

    /// Does the drive follow a new set-point at every SYNC?
    #[must_use]
    pub const fn is_cyclic(self) -> bool {
        match self {
            Self::Csp | Self::Csv | Self::Cst => true,
            Self::None | Self::Pp | Self::Pv | Self::Homing => false,
        }
    }
}

/// Supported modes (object 6502): pp, pv, homing, csp, csv, cst.
pub const SUPPORTED_MODES: u32 = 1 << 0 | 1 << 2 | 1 << 5 | 1 << 7 | 1 << 8 | 1 << 9;

/// Digital outputs, object 60FE: the upper half is the manufacturer's, here the tool's.
pub mod output {
    /// The object's value for these levels of the tool's outputs.
    #[must_use]
    pub const fn levels(tool: u16) -> u32 {
        (tool as u32) << 16
    }

    /// The levels of the tool's outputs in the object's value.
    #[must_use]
    pub const fn tool(levels: u32) -> u16 {
        (levels >> 16) as u16
    }
}

/// Bits of the digital inputs, object 60FD.
pub mod input {
    /// Negative limit switch.
    pub const NEGATIVE_LIMIT: u32 = 1 << 0;
    /// Positive limit switch.
    pub const POSITIVE_LIMIT: u32 = 1 << 1;
    /// Home switch.
    pub const HOME: u32 = 1 << 2;
    /// The maker's: the first of 16 inputs for whoever needs them; this and the next are probe inputs 1 and 2.
    pub const FIRST_FREE: u32 = 1 << 16;
}

/// Bits of the touch-probe function (object 60B8) and status (object 60B9), probe 1; those of probe 2 lie 8 higher.
pub mod probe {
    /// Function: probe 1 is on.
    pub const ENABLE: u16 = 1 << 0;
    /// Function: every edge counts, not only the first.
    pub const CONTINUOUS: u16 = 1 << 1;
    /// Function: the trigger is the encoder's zero impulse, not the probe input.
    pub const ZERO_IMPULSE: u16 = 1 << 2;
    /// Function: the trigger is what object 60D0 says.
    pub const BY_OBJECT: u16 = 2 << 2;
    /// Function: the bits that choose the trigger.
    pub const SOURCE: u16 = 3 << 2;
    /// Function: sample at the positive edge.
    pub const POSITIVE_EDGE: u16 = 1 << 4;
    /// Function: sample at the negative edge.
    pub const NEGATIVE_EDGE: u16 = 1 << 5;
    /// What the node writes to latch the position at the next index pulse.
    pub const INDEX_ONCE: u16 = ENABLE | ZERO_IMPULSE | POSITIVE_EDGE;

    /// Status: probe 1 is on.
    pub const ENABLED: u16 = 1 << 0;
    /// Status: object 60BA holds a position.
    pub const POSITIVE_STORED: u16 = 1 << 1;
    /// Status: object 60BB holds a position.
    pub const NEGATIVE_STORED: u16 = 1 << 2;

    /// What object 60D0 can say; the negative ones are the maker's.
    pub mod source {
        /// Probe input 1.
        pub const INPUT_1: i32 = 1;
        /// Probe input 2.
        pub const INPUT_2: i32 = 2;
        /// The encoder's zero impulse.
        pub const ZERO_IMPULSE: i32 = 5;
        /// The home switch.
        pub const HOME: i32 = -1;
        /// The negative limit switch.
        pub const NEGATIVE_LIMIT: i32 = -2;
        /// The positive limit switch.
        pub const POSITIVE_LIMIT: i32 = -3;
    }
}

/// The homing methods of the drive (object 6098).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(i8)]
pub enum HomingMethod {
    /// Negative limit switch, then the first index pulse in positive direction after it released.
    NegativeLimitAndIndex = 1,
    /// Positive limit switch, then the first index pulse in negative direction after it released.
    PositiveLimitAndIndex = 2,
    /// Home switch at the negative side, then the first index pulse in positive direction after it
    /// released.
    NegativeSwitchAndIndex = 5,
    /// Where the negative limit switch releases.
    NegativeLimit = 17,
    /// Where the positive limit switch releases.
    PositiveLimit = 18,
    /// The first index pulse in negative direction.
    IndexNegative = 33,
    /// The first index pulse in positive direction.
    IndexPositive = 34,
    /// The present position (old number).
    PresentPositionOld = 35,
    /// The present position.
    PresentPosition = 37,
}

impl HomingMethod {
    /// Every method, in the order of object 60E3.
    pub const ALL: [Self; 9] = [
        Self::NegativeLimitAndIndex,
        Self::PositiveLimitAndIndex,
        Self::NegativeSwitchAndIndex,
        Self::NegativeLimit,
        Self::PositiveLimit,
        Self::IndexNegative,
        Self::IndexPositive,
        Self::PresentPositionOld,
        Self::PresentPosition,
    ];

    /// The method of a code.
    #[must_use]
    pub const fn from_code(code: i8) -> Option<Self> {
        Some(match code {
            1 => Self::NegativeLimitAndIndex,
            2 => Self::PositiveLimitAndIndex,
            5 => Self::NegativeSwitchAndIndex,
            17 => Self::NegativeLimit,
            18 => Self::PositiveLimit,
            33 => Self::IndexNegative,
            34 => Self::IndexPositive,
            35 => Self::PresentPositionOld,
            37 => Self::PresentPosition,
            _ => return None,
        })
    }

    /// The code of object 6098.
    #[must_use]
    pub const fn code(self) -> i8 {
        self as i8
    }
}

#[cfg(test)]
mod tests;
