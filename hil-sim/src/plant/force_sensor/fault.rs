//! How a force sensor on a bus can be wrong.

use super::Six;
use protocol::force_torque::{Reading, Status};

/// What is wrong with a force sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ForceFault {
    /// It sends nothing.
    Silent,
    /// Its values are at the end of its range, and it says so.
    Saturated,
    /// It says that it bears more than it may.
    OverForce,
    /// It says that it has failed, and tells zeros.
    Failed,
    /// It tells what it told last, as new samples.
    Frozen,
    /// It sends its last sample again and again, number and all.
    Repeating,
    /// The two frames of a sample have different numbers.
    Torn,
}

impl ForceFault {
    /// Every one.
    pub const ALL: [Self; 7] = [
        Self::Silent,
        Self::Saturated,
        Self::OverForce,
        Self::Failed,
        Self::Frozen,
        Self::Repeating,
        Self::Torn,
    ];

    /// Its name on a command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Silent => "silent",
            Self::Saturated => "saturated",
            Self::OverForce => "over-force",
            Self::Failed => "failed",
            Self::Frozen => "frozen",
            Self::Repeating => "repeating",
            Self::Torn => "torn",
        }
    }

    /// The fault of a name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|fault| fault.name() == name)
    }

    /// The two halves that it tells instead of a sample, if the one before was `last`: those with force and with moment.
    pub(super) fn told(self, reading: Reading, last: Reading, range: &Six) -> Option<[Reading; 2]> {
        let status = reading.status;
        let told = match self {
            Self::Silent => return None,
            Self::Saturated => {
                let [fx, fy, fz, mx, my, mz] = (*range).into();
                let saturated = true;
                let status = Status {
                    saturated,
                    ..status
                };
                Reading::new([fx, fy, fz], [mx, my, mz], reading.number, status)
            }
            Self::OverForce => Reading {
                status: Status {
                    over_force: true,
                    ..status
                },
                ..reading
            },
            Self::Failed => Reading {
                force: [0; 3],
                moment: [0; 3],
                status: Status {
                    failed: true,
                    ..status
                },
                ..reading
            },
            Self::Frozen => Reading {
                number: reading.number,
                ..last
            },
            Self::Repeating => last,
            Self::Torn => {
                let number = reading.number.wrapping_add(1);
                return Some([reading, Reading { number, ..reading }]);
            }
        };
        Some([told, told])
    }
}
