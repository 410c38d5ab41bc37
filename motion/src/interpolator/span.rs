//! A duration of whole microseconds, and which part of it has passed, without a division.

/// The longest duration, µs: 71 minutes.
const MOST_US: u64 = u32::MAX as u64;
/// 2⁻³².
const PER_FRACTION: f32 = 1.0 / 4_294_967_296.0;
/// Quanta of an [`Angle`](crate::Angle), times s in 2⁻³² µs.
const QUANTA_PER_PART: f32 = 256.0 * 1e-6;

/// A duration, and its reciprocal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Span {
    us: u32,
    /// 2⁶⁴ over the duration in µs, rounded down.
    per_us: u64,
}

/// A part of a span: u in 2⁻³², and what that leaves of the time, s times quanta.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Part {
    pub(crate) u: u32,
    pub(crate) left: f32,
}

impl Part {
    /// u in 24 bits.
    #[inline]
    pub(crate) fn share(self) -> f32 {
        float(self.u) * PER_FRACTION
    }
}

impl Span {
    /// Of no duration: no part of it ever passes.
    pub(crate) const NONE: Self = Self { us: 0, per_us: 0 };

    /// `None` if it is longer than 71 minutes.
    pub(crate) fn new(us: u64) -> Option<Self> {
        if us > MOST_US {
            return None;
        }
        Some(Self {
            us: u32::try_from(us).unwrap_or(u32::MAX),
            // of one microsecond 2⁶⁴ − 1: there is no whole microsecond in it
            per_us: u64::MAX.checked_div(us).unwrap_or(0),
        })
    }

    pub(crate) const fn us(&self) -> u64 {
        self.us as u64
    }

    /// Which part of it has passed after so many µs, whole ones and 2⁻³²; `None` at its end and later.
    ///
    /// u is a product with a reciprocal, up to four too small; but what it leaves is exact.
    #[inline]
    pub(crate) fn part(&self, since_us: u64, fraction: u32) -> Option<Part> {
        // products of 32 bits each: one instruction
        let since = u32::try_from(since_us).ok().filter(|us| *us < self.us)?;
        let (high, low) = (upper(self.per_us), lower(self.per_us));
        let u = product(since, high)
            .wrapping_add(product(since, low) >> 32)
            .wrapping_add(product(fraction, high) >> 32);
        let u = u32::try_from(u).unwrap_or(u32::MAX);
        // in 2⁻³² µs, below the duration: so below 2⁶⁴
        let time = u64::from(since) << 32 | u64::from(fraction);
        let left = time.wrapping_sub(product(u, self.us));
        // at most four durations in 2⁻³² µs; of one longer than 17 minutes, nothing is lost with two bits
        let left = match u32::try_from(left) {
            Ok(left) => float(left),
            Err(_) => 4.0 * float(u32::try_from(left >> 2).unwrap_or(u32::MAX)),
        };
        Some(Part {
            u,
            left: left * QUANTA_PER_PART,
        })
    }
}

const fn product(x: u32, y: u32) -> u64 {
    (x as u64).wrapping_mul(y as u64)
}

/// The upper 32 bits.
const fn upper(x: u64) -> u32 {
    lower(x >> 32)
}

/// The lower 32 bits.
#[expect(clippy::cast_possible_truncation, reason = "the lower half")]
pub(super) const fn lower(x: u64) -> u32 {
    x as u32
}

/// An integer below 2³² as a float.
#[expect(clippy::cast_precision_loss, reason = "24 bits are enough")]
pub(crate) const fn float(x: u32) -> f32 {
    x as f32
}

/// The whole quanta of a small way, rounded towards 0.
#[expect(
    clippy::cast_possible_truncation,
    reason = "below 2^31: the coefficients were compared"
)]
pub(crate) const fn whole(quanta: f32) -> i64 {
    quanta as i32 as i64
}
