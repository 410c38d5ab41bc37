//! A joint recorded at every servo step, in words and numbers.

/// Start, extremes and end of a recorded joint, rad.
#[must_use]
pub fn summary(name: &str, curve: &[f64]) -> String {
    let [start, end] = [curve.first(), curve.last()].map(|q| q.copied().unwrap_or(f64::NAN));
    let low = curve
        .iter()
        .copied()
        .min_by(f64::total_cmp)
        .unwrap_or(f64::NAN);
    let high = curve
        .iter()
        .copied()
        .max_by(f64::total_cmp)
        .unwrap_or(f64::NAN);
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
    (0..2 * SHIFT)
        .filter_map(distance)
        .min_by(f64::total_cmp)
        .unwrap_or(f64::NAN)
}

/// 2 s of servo steps.
const SHIFT: usize = 1000;

#[cfg(test)]
mod test {
    use super::*;
    use crate::nod;

    /// 8 s with a nod after so many seconds of rest, larger by a factor.
    fn recorded(rest_s: f64, factor: f64) -> Vec<f64> {
        (0..4000)
            .map(|k| factor * nod(f64::from(k) * 0.002 - rest_s)[0])
            .collect()
    }

    #[test]
    fn curves_that_only_began_at_another_time_are_not_apart() {
        for (a, b) in [(0.1, 0.9), (0.9, 0.1), (0.5, 0.5)] {
            // rounding of the instants only
            assert!(
                apart(&recorded(a, 1.0), &recorded(b, 1.0)) < 1e-12,
                "{a} and {b}"
            );
        }
    }

    #[test]
    fn curves_of_another_shape_are_apart() {
        // a tenth of the greatest angle, which is 0.075 rad
        let distance = apart(&recorded(0.1, 1.0), &recorded(0.4, 1.1));
        assert!((distance - 0.0075).abs() < 2e-4, "{distance}");
    }

    #[test]
    fn a_summary_names_start_extremes_and_end() {
        let text = summary("wrist", &[1.0, 1.5, 0.25, 1.125]);
        assert_eq!(
            text,
            "wrist: 1.0000 rad, from 0.2500 to 1.5000, back at 1.1250"
        );
    }
}
