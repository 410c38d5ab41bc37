//! Option codes: how a drive stops (objects 605A to 605E) and what it does about a lost
//! connection (object 6007).

/// How an axis is slowed down.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Ramp {
    /// The profile deceleration, object 6084.
    SlowDown,
    /// The quick-stop deceleration, object 6085.
    QuickStop,
    /// As fast as the greatest torque allows, object 6072.
    CurrentLimit,
    /// As fast as the power stage can at the voltage it has, whatever 6072 says.
    VoltageLimit,
}

/// How a drive stops and what comes after.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Stop {
    /// Torque off at once; the axis coasts until the brake holds it.
    Coast,
    /// Ramp down, then torque off.
    ThenOff(Ramp),
    /// Ramp down, then stand with torque.
    ThenStand(Ramp),
}

/// What a drive does when its connection is lost (object 6007).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum AbortConnection {
    /// 0: nothing.
    Nothing,
    /// 1: fault.
    Fault,
    /// 2: disable voltage.
    DisableVoltage,
    /// 3: quick stop.
    QuickStop,
}

impl AbortConnection {
    /// The reaction of a code.
    #[must_use]
    pub const fn from_code(code: i16) -> Option<Self> {
        Some(match code {
            0 => Self::Nothing,
            1 => Self::Fault,
            2 => Self::DisableVoltage,
            3 => Self::QuickStop,
            _ => return None,
        })
    }
}

/// How the drive halts while bit 8 is set (object 605D); it stays enabled.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Halt(pub Ramp);

impl Halt {
    /// 1: slow-down ramp, 2: quick-stop ramp, 3: current limit, 4: voltage limit.
    #[must_use]
    pub const fn from_code(code: i16) -> Option<Self> {
        Some(Self(match code {
            1 => Ramp::SlowDown,
            2 => Ramp::QuickStop,
            3 => Ramp::CurrentLimit,
            4 => Ramp::VoltageLimit,
            _ => return None,
        }))
    }
}

/// The option codes the power state machine obeys.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Options {
    /// 605A.
    pub quick_stop: Stop,
    /// 605B.
    pub shutdown: Stop,
    /// 605C.
    pub disable: Stop,
    /// 605E; never [`Stop::ThenStand`].
    pub fault: Stop,
}

impl Options {
    /// The codes of 605A, 605B, 605C, 605E; `None` if one is not offered.
    #[must_use]
    pub const fn from_codes(
        quick_stop: i16,
        shutdown: i16,
        disable: i16,
        fault: i16,
    ) -> Option<Self> {
        let (Some(quick_stop), Some(shutdown), Some(disable), Some(fault)) = (
            Self::quick_stop(quick_stop),
            Self::off(shutdown),
            Self::off(disable),
            Self::fault(fault),
        ) else {
            return None;
        };
        Some(Self {
            quick_stop,
            shutdown,
            disable,
            fault,
        })
    }

    /// 605A: 0 coast; 1, 2 slow-down or quick-stop ramp, 3, 4 current or voltage limit, then off; 5 to 8 the same and
    /// stand.
    #[must_use]
    pub const fn quick_stop(code: i16) -> Option<Stop> {
        Some(match code {
            0 => Stop::Coast,
            1 => Stop::ThenOff(Ramp::SlowDown),
            2 => Stop::ThenOff(Ramp::QuickStop),
            3 => Stop::ThenOff(Ramp::CurrentLimit),
            4 => Stop::ThenOff(Ramp::VoltageLimit),
            5 => Stop::ThenStand(Ramp::SlowDown),
            6 => Stop::ThenStand(Ramp::QuickStop),
            7 => Stop::ThenStand(Ramp::CurrentLimit),
            8 => Stop::ThenStand(Ramp::VoltageLimit),
            _ => return None,
        })
    }

    /// 605B and 605C: 0 coast, 1 slow-down ramp then off.
    #[must_use]
    pub const fn off(code: i16) -> Option<Stop> {
        Some(match code {
            0 => Stop::Coast,
            1 => Stop::ThenOff(Ramp::SlowDown),
            _ => return None,
        })
    }

    /// 605E: 0 coast; 1, 2 slow-down or quick-stop ramp, 3, 4 current or voltage limit, then off.
    #[must_use]
    pub const fn fault(code: i16) -> Option<Stop> {
        Some(match code {
            0 => Stop::Coast,
            1 => Stop::ThenOff(Ramp::SlowDown),
            2 => Stop::ThenOff(Ramp::QuickStop),
            3 => Stop::ThenOff(Ramp::CurrentLimit),
            4 => Stop::ThenOff(Ramp::VoltageLimit),
            _ => return None,
        })
    }
}

impl Default for Options {
    /// Defaults of the drive: quick stop and faults ramp down at 6085 and switch off, disabling
    /// ramps down at 6084, shutting down coasts.
    fn default() -> Self {
        Self {
            quick_stop: Stop::ThenOff(Ramp::QuickStop),
            shutdown: Stop::Coast,
            disable: Stop::ThenOff(Ramp::SlowDown),
            fault: Stop::ThenOff(Ramp::QuickStop),
        }
    }
}
