//! Homing inside the drive: mode 6 with methods 1, 2, 5, 17, 18, 33, 34, 35 and 37.
//!
//! ```text
//! 1, 2, 5:  Seek ──switch──▶ Release ──no switch──▶ Index ──pulse──▶ Stopping ─▶ Done
//! 17, 18:   Seek ──switch──▶ Release ──no switch───────────────────▶ Stopping ─▶ Done
//!           (fast, towards)  (slow, away)           (slow, away)
//! 33, 34:                                           Index (either direction)
//! 35, 37:                                                                        Done
//! any phase that cannot end: Failed
//! ```

use protocol::canopen::cia402::HomingMethod;

/// The switch a method goes for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Switch {
    /// The home switch, at the negative side.
    Home,
    /// The negative limit switch.
    NegativeLimit,
    /// The positive limit switch.
    PositiveLimit,
}

impl Switch {
    /// Does it lie in negative direction?
    const fn is_negative(self) -> bool {
        match self {
            Self::Home | Self::NegativeLimit => true,
            Self::PositiveLimit => false,
        }
    }

    const fn level(self, view: &View) -> bool {
        match self {
            Self::Home => view.home,
            Self::NegativeLimit => view.negative_limit,
            Self::PositiveLimit => view.positive_limit,
        }
    }

    /// Is the way towards it blocked by another switch?
    const fn blocked(self, view: &View) -> bool {
        match self {
            Self::Home => view.negative_limit,
            Self::NegativeLimit | Self::PositiveLimit => false,
        }
    }

    /// Is the way back from it blocked?
    const fn blocked_back(self, view: &View) -> bool {
        if self.is_negative() {
            view.positive_limit
        } else {
            view.negative_limit
        }
    }
}

/// Where homing is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Homing {
    /// Not started since the mode was chosen.
    #[default]
    Idle,
    /// Seeking the switch; afterwards the index, or not.
    Seek { switch: Switch, index: bool },
    /// Backing off until the switch releases.
    Release { switch: Switch, index: bool },
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
        match method {
            HomingMethod::NegativeSwitchAndIndex => Self::seek(Switch::Home, true, view),
            HomingMethod::NegativeLimitAndIndex => Self::seek(Switch::NegativeLimit, true, view),
            HomingMethod::PositiveLimitAndIndex => Self::seek(Switch::PositiveLimit, true, view),
            HomingMethod::NegativeLimit => Self::seek(Switch::NegativeLimit, false, view),
            HomingMethod::PositiveLimit => Self::seek(Switch::PositiveLimit, false, view),
            HomingMethod::IndexNegative => Self::seek_index(true, view),
            HomingMethod::IndexPositive => Self::seek_index(false, view),
            HomingMethod::PresentPositionOld | HomingMethod::PresentPosition => {
                (Self::Done, Want::Home(view.count))
            }
        }
    }

    const fn seek(switch: Switch, index: bool, view: &View) -> (Self, Want) {
        if switch.level(view) {
            return Self::release(switch, index);
        }
        let want = Want::Move {
            fast: true,
            negative: switch.is_negative(),
        };
        (Self::Seek { switch, index }, want)
    }

    const fn release(switch: Switch, index: bool) -> (Self, Want) {
        let want = Want::Move {
            fast: false,
            negative: !switch.is_negative(),
        };
        (Self::Release { switch, index }, want)
    }

    const fn seek_index(negative: bool, view: &View) -> (Self, Want) {
        let want = Want::Move {
            fast: false,
            negative,
        };
        let since = view.count;
        (Self::Index { negative, since }, want)
    }

    /// One substep.
    pub(crate) const fn step(self, view: &View) -> (Self, Want) {
        match self {
            Self::Seek { switch, index } if switch.level(view) => Self::release(switch, index),
            Self::Seek { switch, .. } if switch.blocked(view) => (Self::Failed, Want::Stop),
            Self::Release { switch, index } if !switch.level(view) => {
                if index {
                    // on in the same direction
                    let negative = !switch.is_negative();
                    let since = view.count;
                    (Self::Index { negative, since }, Want::Nothing)
                } else {
                    (Self::Stopping { at: view.count }, Want::Stop)
                }
            }
            Self::Release { switch, .. } if switch.blocked_back(view) => (Self::Failed, Want::Stop),
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
            | Self::Seek { .. }
            | Self::Release { .. }
            | Self::Stopping { .. }
            | Self::Done
            | Self::Failed => (self, Want::Nothing),
        }
    }

    /// Is a search under way?
    pub(crate) const fn is_running(self) -> bool {
        match self {
            Self::Seek { .. }
            | Self::Release { .. }
            | Self::Index { .. }
            | Self::Stopping { .. } => true,
            Self::Idle | Self::Done | Self::Failed => false,
        }
    }
}
