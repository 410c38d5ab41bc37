//! A joint recorded at every servo step, in words and numbers.

/// Start, extremes and end of a recorded joint, rad.
#[must_use]
pub fn summary(name: &str, curve: &[f64]) -> String {
    let [start, end] = [curve.first(), curve.last()].map(|q| q.copied().unwrap_or(f64::NAN));
    let low = curve.iter().copied().min_by(f64::total_cmp).unwrap_or(f64::NAN);
    let high = curve.iter().copied().max_by(f64::total_cmp).unwrap_or(f64::NAN);
    format!("{name}: {start:.4} rad, from {low:.4} to {high:.4}, back at {end:.4}")
}

/// The greatest distance of two recorded joints, shifted in time such that it is least: rad. They
/// begin and end at rest; of the shift at most 2 s are tried, in servo steps.
#[must_use]
pub fn apart(a: &[f64], b: &[f64]) -> f64 {
    let last = b.len().saturating_sub(1);
    let distance = |shift: usize| {
        a.iter()
            .enumerate()
            .map(|(k, q)| (q - b[(k + shift).saturating_sub(SHIFT).min(last)]).abs())
            .max_by(f64::total_cmp)
    };
    (0..2 * SHIFT).filter_map(distance).min_by(f64::total_cmp).unwrap_or(f64::NAN)
}

/// 2 s of servo steps.
const SHIFT: usize = 1000;
