//! Bus time.

// schema: begin

/// An instant or a span in microseconds of bus time (monotonic; never the wall clock).
#[derive(
    Clone,
    Copy,
    Debug,
    Default,
    PartialEq,
    Eq,
    PartialOrd,
    Ord,
    Hash,
    serde::Serialize,
    serde::Deserialize,
)]
pub struct Micros(pub u64);

// schema: end

impl Micros {
    /// From milliseconds.
    #[must_use]
    pub const fn from_millis(ms: u64) -> Self {
        Self(ms.saturating_mul(1000))
    }

    /// The span from `earlier` to `self`, zero if `earlier` is later.
    #[must_use]
    pub const fn since(self, earlier: Self) -> Self {
        Self(self.0.saturating_sub(earlier.0))
    }

    /// In seconds.
    #[must_use]
    #[expect(
        clippy::cast_precision_loss,
        reason = "exact below 2^53 µs = 285 years"
    )]
    pub const fn as_secs_f64(self) -> f64 {
        self.0 as f64 * 1e-6
    }
}

impl From<Micros> for core::time::Duration {
    fn from(time: Micros) -> Self {
        Self::from_micros(time.0)
    }
}

impl core::ops::Add for Micros {
    type Output = Self;
    fn add(self, span: Self) -> Self {
        Self(self.0.saturating_add(span.0))
    }
}
