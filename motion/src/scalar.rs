//! Comparisons and conversions of numbers that behave alike on every target.

/// Microseconds in one second.
pub(crate) const US_PER_S: f64 = 1e6;

/// The larger of two numbers; the first when they compare equal or not at all.
pub(crate) fn larger<T: PartialOrd>(a: T, b: T) -> T {
    if b > a { b } else { a }
}

/// The smaller of two numbers; the first when they compare equal or not at all.
pub(crate) fn smaller<T: PartialOrd>(a: T, b: T) -> T {
    if b < a { b } else { a }
}

/// `x` moved into `[lower, upper]`.
pub(crate) fn within(x: f64, lower: f64, upper: f64) -> f64 {
    larger(smaller(x, upper), lower)
}

/// -1, 0 or 1.
pub(crate) fn sign(x: f64) -> f64 {
    if x > 0.0 {
        1.0
    } else if x < 0.0 {
        -1.0
    } else {
        0.0
    }
}

/// An integer number of microseconds as a float: exact below 2^53 µs (285 years).
#[expect(
    clippy::cast_precision_loss,
    reason = "differences of times: far below 2^53 µs"
)]
pub(crate) fn float_us(us: u64) -> f64 {
    us as f64
}

/// The whole microseconds of a time ≥ 0 and the remaining fraction, in \[0, 1).
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a float to integer cast saturates, and the argument is not negative"
)]
pub(crate) fn split_us(us: f64) -> (u64, f64) {
    let whole = libm::floor(us);
    (whole as u64, us - whole)
}

/// 1/6: multiplied, where a division would cost ten times as much.
pub(crate) const SIXTH: f64 = 1.0 / 6.0;

/// The nearest float of 32 bits.
#[expect(clippy::cast_possible_truncation, reason = "24 bits are enough")]
pub(crate) const fn narrow(x: f64) -> f32 {
    x as f32
}
