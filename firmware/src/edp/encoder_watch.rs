//! An encoder that does not follow what the axis is told: it stands still, or goes the other way.
//!
//! The following error says so too, but its window is as wide as a healthy axis at full speed needs it, and meanwhile
//! the axis runs away: behind a frozen encoder the drive's loop gets nothing for its torque, and behind one that
//! counts the wrong way it pushes ever harder. A healthy axis may lag behind, but it moves, and not away.

use protocol::units::UNITS_PER_INCREMENT;

/// How far the demand may move while the encoder counts nothing, in windows of the following error at rest, where the
/// loop is closed here: twice what was found where friction holds an axis of the IRp-6 at the beginning of a motion (92
/// increments of 400, with the original's law). At 16 rad/s and 4000 increments a turn that is 10 steps of 2 ms.
const STILL: Share = Share(1, 1);
/// The same where the drive closes the loop, which is stiffer: see `hil-sim/README.md` for what was found.
const STILL_IN_DRIVE: Share = Share(1, 2);

/// How far the encoder may go against the demand, drive units: twice what an axis that lags 10 ms behind goes on when
/// its demand turns round at 900 rad/s², a·τ²/2 = 0.045 rad, of 4000 increments a turn,
const AWAY: i64 = 60 * UNITS_PER_INCREMENT;
/// or this, if it is more: an axis without gears swings by some milliradians more after its brake has opened.
const AWAY_SHARE: Share = Share(3, 5);
/// How far the demand must have gone meanwhile, drive units.
const TOLD: i64 = 5 * UNITS_PER_INCREMENT;
/// How far the encoder may go where the demand stands: an axis may give way to what pushes it, one without gears by some
/// ten milliradians when its brake opens, but half of the window without becoming slower is more than that.
const AWAY_AT_REST: Share = Share(1, 1);

/// A share of the following error's window at rest, in 2⁻ᵏ: divisions of 64 bits cost a microcontroller hundreds of instructions.
#[derive(Clone, Copy)]
struct Share(i64, u32);

impl Share {
    /// Drive units, of a window in them.
    const fn of(self, window: i64) -> i64 {
        window.saturating_mul(self.0) >> self.1
    }
}

/// What an encoder does that it should not.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Suspicion {
    /// It stands still.
    Still,
    /// It goes away from where it should, and no slower.
    Away,
}

/// Watches one axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct EncoderWatch {
    /// The position that was measured, and the demand when it was first, drive units.
    still: Option<(i64, i64)>,
    /// The last pair that had not moved apart, or of which the first stood.
    apart: Option<(i64, i64)>,
    /// Steps since then.
    steps: i64,
    /// What was measured last.
    last: i64,
}

impl EncoderWatch {
    /// Forget what was: the axis has no torque.
    pub(super) const fn reset(&mut self) {
        (self.still, self.apart) = (None, None);
    }

    /// Another step. Both in drive units, at most 2⁶¹, of the same instant, and so is the window of the following error at rest;
    /// `in_drive`: the drive closes the loop.
    pub(super) fn step(
        &mut self,
        measured: i64,
        demanded: i64,
        window: i64,
        in_drive: bool,
    ) -> Option<Suspicion> {
        if self.goes_away(measured, demanded, window) {
            return Some(Suspicion::Away);
        }
        match self.still {
            Some((before, began)) if before == measured => {
                let most = if in_drive { STILL_IN_DRIVE } else { STILL };
                let far = demanded.wrapping_sub(began).wrapping_abs() > most.of(window);
                far.then_some(Suspicion::Still)
            }
            _ => {
                self.still = Some((measured, demanded));
                None
            }
        }
    }

    /// Have the two moved apart, one against the other, far enough, and in this step as fast as in the others? What is
    /// pushed off by something it has met becomes slower.
    fn goes_away(&mut self, measured: i64, demanded: i64, window: i64) -> bool {
        let moved = measured.wrapping_sub(core::mem::replace(&mut self.last, measured));
        let (way, told) = self.apart.map_or((0, 0), |(before, began)| {
            (measured.wrapping_sub(before), demanded.wrapping_sub(began))
        });
        // towards the demand, from wherever, is no way off
        let off = measured.wrapping_sub(demanded);
        let nearer = (off < 0) != (moved < 0);
        let with = told != 0 && (way < 0) == (told < 0);
        if moved == 0 || way == 0 || nearer || with {
            self.apart = Some((measured, demanded));
            self.steps = 0;
            return false;
        }
        self.steps = self.steps.saturating_add(1);
        let far = way.wrapping_abs();
        if far <= AWAY {
            // the least of them
            return false;
        }
        let keeps = moved.wrapping_abs().saturating_mul(self.steps) >= far;
        let most = if told.wrapping_abs() > TOLD {
            AWAY.max(AWAY_SHARE.of(window))
        } else {
            AWAY_AT_REST.of(window)
        };
        keeps && far > most
    }
}

#[cfg(test)]
mod test {
    use super::*;
    use proptest::prelude::*;

    const INCREMENT: i64 = UNITS_PER_INCREMENT;
    /// That of the IRp-6.
    const WINDOW: i64 = 400 * INCREMENT;

    #[test]
    fn a_frozen_encoder_is_found_when_the_demand_has_moved_far_enough() {
        for (in_drive, increments) in [(false, 21), (true, 11)] {
            let mut watch = EncoderWatch::default();
            // 210 or 110 after ten
            let mut step = |k| watch.step(7, 500 + increments * INCREMENT * k, WINDOW, in_drive);
            let found = (0..20).position(|k| step(k).is_some());
            assert_eq!(found, Some(10));
            watch.reset();
            assert_eq!(watch.step(7, 1 << 60, WINDOW, in_drive), None);
            assert_eq!(
                watch.step(7, -(1 << 60), WINDOW, in_drive),
                Some(Suspicion::Still)
            );
        }
    }

    #[test]
    fn an_encoder_that_goes_the_other_way_is_found_and_one_that_is_pushed_back_is_not() {
        // 16 increments a step against 16
        let mut watch = EncoderWatch::default();
        let found = (0..20).find(|k| {
            watch.step(-16 * INCREMENT * k, 16 * INCREMENT * k, WINDOW, true)
                == Some(Suspicion::Away)
        });
        assert_eq!(found, Some(4));
        // the same way, but ever slower
        let mut watch = EncoderWatch::default();
        let mut place = 0;
        for k in 0..30 {
            place -= (16 - k).max(0) * INCREMENT;
            assert_ne!(
                watch.step(place, INCREMENT * k, WINDOW, true),
                Some(Suspicion::Away),
                "{k}"
            );
        }
        // far ahead of a demand that comes, it goes to meet it
        let mut watch = EncoderWatch::default();
        for k in 0..60 {
            let found = watch.step((1000 - 16 * k) * INCREMENT, k * INCREMENT, WINDOW, true);
            assert_ne!(found, Some(Suspicion::Away), "{k}");
        }
        // pushed away at rest, and on its way back when the demand goes on
        let mut watch = EncoderWatch::default();
        for (k, place) in (0..).zip((0..18).chain((0..18).rev())) {
            let told = if k < 18 { 0 } else { 6 * k };
            let found = watch.step(10 * INCREMENT * place, -told * INCREMENT, WINDOW, true);
            assert_ne!(found, Some(Suspicion::Away), "{k}");
        }
        // at rest it may be pushed away, but not for ever
        let mut watch = EncoderWatch::default();
        let found = (0..100).find(|k| watch.step(10 * INCREMENT * k, 0, WINDOW, true).is_some());
        assert_eq!(found, Some(21));
    }

    proptest! {
        /// An axis that lags behind as one of first order does, a tenth of the way in a step, is well whatever is
        /// demanded: it counts when the demand is ten increments away. While it stands the demand may go from as far as a
        /// step brings it back to ten increments on the other side: 75 + 21, of 100 that are found.
        #[test]
        fn a_lag_is_no_frozen_encoder(
            steps in proptest::collection::vec(-75..=75_i64, 1..300),
            share in 0.1..1.0_f64,
        ) {
            let (mut watch, mut demand, mut place) = (EncoderWatch::default(), 0_i64, 0.0_f64);
            for step in steps {
                demand += step * INCREMENT;
                let measured = lagging(&mut place, share, demand);
                prop_assert_ne!(watch.step(measured, demand, WINDOW, true), Some(Suspicion::Still));
            }
        }

        /// Nor does it run away, whatever it is told within 900 rad/s² (0.0036 rad a step and step, two increments and a
        /// third of 4000 a turn), if it lags by 10 ms, a fifth of the way in a step, at most.
        #[test]
        fn an_axis_that_turns_round_does_not_run_away(
            pieces in proptest::collection::vec((-2..=2_i64, 1..40_usize), 1..60),
            share in 0.2..1.0_f64,
        ) {
            let (mut watch, mut demand, mut velocity, mut place) = (EncoderWatch::default(), 0_i64, 0_i64, 0.0_f64);
            for (acceleration, steps) in pieces {
                for _ in 0..steps {
                    velocity = (velocity + acceleration * INCREMENT).clamp(-60 * INCREMENT, 60 * INCREMENT);
                    demand += velocity;
                    let measured = lagging(&mut place, share, demand);
                    prop_assert_ne!(watch.step(measured, demand, WINDOW, true), Some(Suspicion::Away));
                }
            }
        }
    }

    /// A share of the way in a step, in whole increments.
    #[expect(
        clippy::cast_precision_loss,
        clippy::cast_possible_truncation,
        reason = "small"
    )]
    fn lagging(place: &mut f64, share: f64, demand: i64) -> i64 {
        *place += share * (demand as f64 - *place);
        libm::floor(*place / INCREMENT as f64) as i64 * INCREMENT
    }
}
