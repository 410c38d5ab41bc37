//! What a servo step knows of the envelopes, found once: how fast paths may be held, and axes stopped.

use super::rate::{FeedRate, RateLimits};
use super::rate_ramp::RateRamp;
use super::span::Span;
use super::stop::{MARGIN, StopLimits};
use super::tail::fade_span;
use crate::knot::AxisEnvelope;
use crate::scalar::{US_PER_S, float_us, narrow};

/// How fast the feed rate of a path may change, and how fast axes may be stopped: constants of the envelopes' hard and
/// plan limits, not of their positions. Of no use where [`PathLimits::new`](super::PathLimits::new) refuses the envelopes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Braking<const N: usize> {
    /// Of the rate: per s and per s².
    pub(super) rate: StopLimits,
    /// How long a feed hold takes from rate 1, s.
    pub(super) hold_s: f64,
    pub(super) axes: [AxisBraking; N],
}

/// The same of one axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct AxisBraking {
    pub(super) stop: StopLimits,
    /// In which the acceleration fades on a stop tail.
    pub(super) fade: Span,
}

impl<const N: usize> Braking<N> {
    /// With the shortest feed hold.
    #[must_use]
    pub fn new(axes: &[AxisEnvelope; N]) -> Self {
        let rate = RateLimits::new(axes).narrow();
        let hold = RateRamp::new(FeedRate::FULL.parts(), 0.0, rate);
        Self {
            rate,
            hold_s: hold.map_or(0.0, |hold| float_us(hold.duration_us()) / US_PER_S),
            axes: axes.each_ref().map(|axis| AxisBraking {
                stop: StopLimits {
                    a: narrow(axis.hard.a * MARGIN),
                    j: narrow(axis.hard.j * MARGIN),
                },
                fade: fade_span(axis),
            }),
        }
    }
}
