//! What drives in the field do otherwise than the book, to be chosen for the simulated one.

use protocol::canopen::cia402::{Controlword, Mode, Power, Statusword};
use protocol::canopen::emcy::{Emergency, ErrorCode};

use super::parameters::MS;
use super::{SimDrive, slots};

/// One thing that a drive does otherwise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u16)]
pub enum Quirk {
    /// It boots in 2 s.
    SlowBoot = 1 << 0,
    /// SDO answers come 10 ms late.
    SlowAnswers = 1 << 1,
    /// Homing never sets statusword bit 10, "reached".
    HomingNeverReached = 1 << 2,
    /// The interpolation period is an object of the vendor: 60C2 does not exist.
    NoInterpolationPeriod = 1 << 3,
    /// It trips when SYNC misses two periods, whatever 6007 says.
    TightSync = 1 << 4,
    /// When it is enabled for the first time it homes itself: it moves while it is commanded elsewhere.
    HomesItself = 1 << 5,
    /// It sends an emergency before its boot-up message.
    EmergencyBeforeBootUp = 1 << 6,
    /// The PDOs it sends at SYNC lack their last byte.
    ShortPdo = 1 << 7,
    /// The fault bit of its statusword comes and goes with every SYNC.
    FlickeringFault = 1 << 8,
    /// It does not store a node id that it is given by layer setting.
    ForgetsNode = 1 << 9,
    /// Its answers to the master of layer setting come 30 ms late.
    SlowLayer = 1 << 10,
    /// It does not know of object 1020.
    NoVerifyConfiguration = 1 << 11,
}

impl Quirk {
    /// Every quirk.
    pub const ALL: [Self; 12] = [
        Self::SlowBoot,
        Self::SlowAnswers,
        Self::HomingNeverReached,
        Self::NoInterpolationPeriod,
        Self::TightSync,
        Self::HomesItself,
        Self::EmergencyBeforeBootUp,
        Self::ShortPdo,
        Self::FlickeringFault,
        Self::ForgetsNode,
        Self::SlowLayer,
        Self::NoVerifyConfiguration,
    ];

    /// Its name on a command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::SlowBoot => "slow-boot",
            Self::SlowAnswers => "slow-answers",
            Self::HomingNeverReached => "homing-never-reached",
            Self::NoInterpolationPeriod => "no-interpolation-period",
            Self::TightSync => "tight-sync",
            Self::HomesItself => "homes-itself",
            Self::EmergencyBeforeBootUp => "emergency-before-boot-up",
            Self::ShortPdo => "short-pdo",
            Self::FlickeringFault => "flickering-fault",
            Self::ForgetsNode => "forgets-node",
            Self::SlowLayer => "slow-layer",
            Self::NoVerifyConfiguration => "no-verify-configuration",
        }
    }

    /// The quirk of a name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|quirk| quirk.name() == name)
    }
}

/// The quirks of a drive; by default none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Quirks(u16);

impl Quirks {
    /// These and one more.
    #[must_use]
    pub const fn with(self, quirk: Quirk) -> Self {
        Self(self.0 | quirk as u16)
    }

    /// Is it among them?
    #[must_use]
    pub const fn has(self, quirk: Quirk) -> bool {
        self.0 & quirk as u16 != 0
    }
}

/// What a drive with quirks remembers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Whims {
    /// [`Quirk::FlickeringFault`]: is it this SYNC's turn?
    pub(super) flicker: bool,
    /// [`Quirk::HomesItself`].
    pub(super) homing: OwnHoming,
}

/// How far a drive is that homes itself.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum OwnHoming {
    /// It has not begun.
    #[default]
    Due,
    /// It moves.
    Running,
    /// It has ended, or was ended.
    Over,
}

/// [`Quirk::SlowBoot`].
const SLOW_BOOT_NS: u64 = 2000 * MS;
/// [`Quirk::SlowAnswers`].
const SLOW_ANSWER_NS: u64 = 10 * MS;
/// [`Quirk::SlowLayer`].
pub(super) const SLOW_LAYER_NS: u64 = 30 * MS;
/// [`Quirk::TightSync`]: two periods and half a one of grace.
const TIGHT_HALF_PERIODS: u64 = 5;

impl SimDrive {
    /// From reset to boot-up, ns.
    pub(super) const fn boot_ns(&self) -> u64 {
        if self.p.quirks.has(Quirk::SlowBoot) {
            SLOW_BOOT_NS
        } else {
            self.p.boot_ns
        }
    }

    /// From an SDO request to its answer, ns.
    pub(super) const fn answer_ns(&self) -> u64 {
        if self.p.quirks.has(Quirk::SlowAnswers) {
            SLOW_ANSWER_NS
        } else {
            self.p.sdo_ns
        }
    }

    /// What this drive's statusword makes of the book's.
    pub(super) const fn spoilt(&self, word: Statusword) -> Statusword {
        let mut word = word.0;
        if self.p.quirks.has(Quirk::HomingNeverReached) && matches!(self.mode, Mode::Homing) {
            word &= !Statusword::TARGET_REACHED;
        }
        if self.p.quirks.has(Quirk::FlickeringFault) && self.whims.flicker {
            // the fault bit, and with it the pattern of the state "fault"
            word = word & !0x4F | 0x08;
        }
        Statusword(word)
    }

    /// The boot-up message is about to go.
    pub(super) fn before_boot_up(&mut self) {
        if self.p.quirks.has(Quirk::EmergencyBeforeBootUp) {
            let code = ErrorCode::UNDER_VOLTAGE;
            let emergency = Emergency {
                code,
                register: code.register(),
                detail: [0; 5],
            };
            self.outbox.push(emergency.frame(self.node));
        }
    }

    /// Watches SYNC more closely than the book wants.
    pub(super) fn watch_tightly(&mut self) {
        if !self.p.quirks.has(Quirk::TightSync) || self.power != Power::Enabled {
            return;
        }
        let limit = self.period_ns * TIGHT_HALF_PERIODS / 2;
        if self
            .last_sync_ns
            .is_some_and(|last| self.now_ns - last > limit)
        {
            self.last_sync_ns = None;
            self.fail(ErrorCode::SYNC_LOST);
        }
    }

    /// Torque is on and the brake open: does the drive home itself first?
    pub(super) fn begin_by_itself(&mut self) {
        if !self.p.quirks.has(Quirk::HomesItself) || self.whims.homing != OwnHoming::Due {
            return;
        }
        self.whims.homing = OwnHoming::Running;
        let speed = f64::from(self.od.get(slots::HOMING_FAST)) / self.scale.units_per_rad;
        let ramp = f64::from(self.od.get(slots::HOMING_ACCELERATION)) / self.scale.units_per_rad;
        self.servo.jog(speed, ramp);
    }

    /// Does it move of its own accord?
    pub(super) fn homes_itself(&self) -> bool {
        self.whims.homing == OwnHoming::Running
    }

    /// Ends what [`Self::begin_by_itself`] began.
    pub(super) fn end_by_itself(&mut self) {
        if self.homes_itself() {
            self.whims.homing = OwnHoming::Over;
        }
    }

    /// Is homing asked for and not begun?
    pub(super) fn homing_waits(&self) -> bool {
        let [low, high, ..] = self.od.get(slots::CONTROLWORD).to_le_bytes();
        let word = Controlword(u16::from_le_bytes([low, high]));
        self.homing == super::homing::Homing::Idle && word.has(Controlword::OPERATION_4)
    }
}
