//! Homing inside the drive: mode 6 with methods 5, 33, 34, 35 and 37.
//!
//! ```text
//! method 5:  Switch ──home active──▶ Release ──home inactive──▶ Index ──pulse──▶ Stopping ─▶ Done
//!            (negative, fast)        (positive, slow)           (positive, slow)
//! 33, 34:                                                       Index (either direction)
//! 35, 37:                                                                                    Done
//! any phase that cannot end: Failed
//! ```

use protocol::canopen::cia402::HomingMethod;

/// Where homing is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Homing {
    /// Not started since the mode was chosen.
    #[default]
    Idle,
    /// Seeking the switch.
    Switch,
    /// Backing off until the switch releases.
    Release,
    /// Seeking the index; `since` is the count where the search began.
    Index { negative: bool, since: i64 },
    /// Found at the count: stopping.
    Stopping { at: i64 },
    /// Homed.
    Done,
    /// Not homed.
    Failed,
}

/// What homing wants of the drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Want {
    /// Go on.
    Nothing,
    /// Move: fast or slow, negative or positive.
    Move { fast: bool, negative: bool },
    /// Stop.
    Stop,
    /// The home position lies at this count.
    Home(i64),
}

/// What homing sees.
#[derive(Clone, Copy, Debug)]
#[expect(
    clippy::struct_excessive_bools,
    reason = "levels of four independent signals"
)]
pub(crate) struct View {
    pub(crate) count: i64,
    pub(crate) index: Option<i64>,
    pub(crate) home: bool,
    pub(crate) negative_limit: bool,
    pub(crate) positive_limit: bool,
    pub(crate) stands: bool,
    pub(crate) increments_per_turn: i64,
}

impl Homing {
    /// Starts (rising edge of controlword bit 4).
    pub(crate) const fn start(method: HomingMethod, view: &View) -> (Self, Want) {
        let since = view.count;
        match method {
            HomingMethod::NegativeSwitchAndIndex if view.home => (
                Self::Release,
                Want::Move {
                    fast: false,
                    negative: false,
                },
            ),
            HomingMethod::NegativeSwitchAndIndex => (
                Self::Switch,
                Want::Move {
                    fast: true,
                    negative: true,
                },
            ),
            HomingMethod::IndexNegative => {
                let negative = true;
                (
                    Self::Index { negative, since },
                    Want::Move {
                        fast: false,
                        negative,
                    },
                )
            }
            HomingMethod::IndexPositive => {
                let negative = false;
                (
                    Self::Index { negative, since },
                    Want::Move {
                        fast: false,
                        negative,
                    },
                )
            }
            HomingMethod::PresentPositionOld | HomingMethod::PresentPosition => {
                (Self::Done, Want::Home(view.count))
            }
        }
    }

    /// One substep.
    pub(crate) const fn step(self, view: &View) -> (Self, Want) {
        match self {
            Self::Switch if view.home => (
                Self::Release,
                Want::Move {
                    fast: false,
                    negative: false,
                },
            ),
            Self::Switch if view.negative_limit => (Self::Failed, Want::Stop),
            Self::Release if !view.home => (
                Self::Index {
                    negative: false,
                    since: view.count,
                },
                Want::Nothing,
            ),
            Self::Release if view.positive_limit => (Self::Failed, Want::Stop),
            Self::Index { negative, since } => {
                if let Some(at) = view.index {
                    return (Self::Stopping { at }, Want::Stop);
                }
                let blocked = if negative {
                    view.negative_limit
                } else {
                    view.positive_limit
                };
                // One turn and a tenth without a pulse: there is none.
                let far = (view.count - since).abs() * 10 > view.increments_per_turn * 11;
                if blocked || far {
                    (Self::Failed, Want::Stop)
                } else {
                    (self, Want::Nothing)
                }
            }
            Self::Stopping { at } if view.stands => (Self::Done, Want::Home(at)),
            Self::Idle
            | Self::Switch
            | Self::Release
            | Self::Stopping { .. }
            | Self::Done
            | Self::Failed => (self, Want::Nothing),
        }
    }

    /// Is a search under way?
    pub(crate) const fn is_running(self) -> bool {
        match self {
            Self::Switch | Self::Release | Self::Index { .. } | Self::Stopping { .. } => true,
            Self::Idle | Self::Done | Self::Failed => false,
        }
    }
}
