//! Drive units, encoder increments, motor radians: the factor group.

use super::dictionary::Dictionary;

/// Unit conversions of the factor group.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Scale {
    /// Units are `count · numerator / denominator + offset`.
    numerator: i64,
    denominator: i64,
    pub(super) offset: i64,
    pub(super) units_per_rad: f64,
    pub(super) rad_per_increment: f64,
    pub(super) nm_per_mille: f64,
}

impl Scale {
    pub(super) fn read(od: &Dictionary) -> Self {
        use protocol::canopen::objects::index;
        let ratio = |index| (i64::from(od.at(index, 1)), i64::from(od.at(index, 2)));
        let (increments, turns) = ratio(index::ENCODER_RESOLUTION);
        let (motor, shaft) = ratio(index::GEAR_RATIO);
        let (feed, feed_turns) = ratio(index::FEED_CONSTANT);
        // units = count · (turns/increments) · (shaft/motor) · (feed/feed turns)
        let numerator = turns.saturating_mul(shaft).saturating_mul(feed);
        let denominator = increments
            .saturating_mul(motor)
            .saturating_mul(feed_turns)
            .max(1);
        let rad_per_increment = core::f64::consts::TAU * to_f64(turns) / to_f64(increments.max(1));
        Self {
            numerator,
            denominator,
            offset: 0,
            units_per_rad: to_f64(numerator) / to_f64(denominator) / rad_per_increment,
            rad_per_increment,
            nm_per_mille: f64::from(od.at(index::RATED_TORQUE, 0)) * 1e-6,
        }
    }

    /// Drive units of an encoder count.
    pub(super) const fn units(&self, count: i64) -> i64 {
        let wide = count as i128 * self.numerator as i128;
        let exact = wide.div_euclid(self.denominator as i128);
        // At most 2⁶³ units: the counts of any travel are far below.
        #[expect(clippy::cast_possible_truncation, reason = "see above")]
        let units = exact as i64;
        units.saturating_add(self.offset)
    }

    /// Motor radians of drive units.
    pub(super) fn rad_of_units(&self, units: i64) -> f64 {
        to_f64(units - self.offset) / self.units_per_rad
    }

    /// Drive units of motor radians, to the nearest.
    #[expect(clippy::cast_possible_truncation, reason = "saturates")]
    pub(super) fn units_of_rad(&self, rad: f64) -> i64 {
        let units = rad * self.units_per_rad + to_f64(self.offset);
        (units + if units < 0.0 { -0.5 } else { 0.5 }) as i64
    }

    /// Motor radians of an encoder count: the middle of the increment.
    pub(super) fn rad(&self, count: i64) -> f64 {
        (to_f64(count) + 0.5) * self.rad_per_increment
    }
}

/// An integer as a number; exact below 2⁵³.
#[expect(
    clippy::cast_precision_loss,
    reason = "counts and units stay below 2^53"
)]
pub(super) const fn to_f64(value: i64) -> f64 {
    value as f64
}

/// The nearest integer, saturated to 32 bits.
#[expect(clippy::cast_possible_truncation, reason = "saturates")]
pub(super) fn to_i32(value: f64) -> i32 {
    (value + if value < 0.0 { -0.5 } else { 0.5 }) as i32
}
