//! An encoder that stands still while the axis is told to move.
//!
//! The following error says so too, but its window is as wide as a healthy axis at full speed needs it, and behind a
//! frozen encoder the axis runs away meanwhile: the drive's loop gets nothing for its torque. A healthy axis may lag
//! behind, but it moves.

use protocol::units::UNITS_PER_INCREMENT;

/// How far the demand may move while the encoder counts nothing, drive units: half of the following error's window at
/// rest, and twice what was found where friction holds an axis at the beginning of a motion (92 increments, with the
/// original's law). At 16 rad/s and 4000 increments a turn that is 10 steps of 2 ms.
const STILL: i64 = 200 * UNITS_PER_INCREMENT;

/// Watches one axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Stuck {
    /// The position that was measured, and the demand when it was first, drive units.
    since: Option<(i64, i64)>,
}

impl Stuck {
    /// Forget what was: the axis has no torque.
    pub(super) const fn reset(&mut self) {
        self.since = None;
    }

    /// Another step: has the demand moved too far since the measured position last changed?
    /// Both in drive units, of the same instant.
    pub(super) fn step(&mut self, measured: i64, demanded: i64) -> bool {
        match self.since {
            Some((before, began)) if before == measured => {
                demanded.saturating_sub(began).saturating_abs() > STILL
            }
            _ => {
                self.since = Some((measured, demanded));
                false
            }
        }
    }
}

#[cfg(test)]
mod test {
    use super::*;
    use proptest::prelude::*;

    const INCREMENT: i64 = UNITS_PER_INCREMENT;

    #[test]
    fn a_frozen_encoder_is_found_when_the_demand_has_moved_two_hundred_increments() {
        let mut stuck = Stuck::default();
        // 21 increments a step: 210 after ten
        let found = (0..20).position(|step| stuck.step(7, 500 + 21 * INCREMENT * step));
        assert_eq!(found, Some(10));
        stuck.reset();
        assert!(!stuck.step(7, i64::MAX) && stuck.step(7, i64::MIN));
    }

    proptest! {
        /// An axis that lags behind as one of first order does, a tenth of the way in a step, is well whatever is
        /// demanded: it counts when the demand is ten increments away.
        #[test]
        fn a_lag_is_no_frozen_encoder(
            steps in proptest::collection::vec(-100..100_i64, 1..300),
            share in 0.1..1.0_f64,
        ) {
            let (mut stuck, mut demand, mut place) = (Stuck::default(), 0_i64, 0.0_f64);
            for step in steps {
                demand += step * INCREMENT;
                #[expect(clippy::cast_precision_loss, clippy::cast_possible_truncation, reason = "small")]
                let measured = {
                    place += share * (demand as f64 - place);
                    libm::floor(place / INCREMENT as f64) as i64 * INCREMENT
                };
                prop_assert!(!stuck.step(measured, demand));
            }
        }
    }
}
