//! Fewer points, none of the extremes lost.

use super::scale::finite;

/// The most points of a line.
pub(super) const MAX_POINTS: usize = 2000;

/// Keeps of every run of points those that are first, least or greatest in x or y, and the last
/// of all. Points that are not finite are dropped.
pub(super) fn decimate(points: impl Iterator<Item = [f64; 2]>) -> Vec<[f64; 2]> {
    const KEPT: usize = 5;
    let points: Vec<[f64; 2]> = points.filter(|p| p.iter().all(|v| finite(*v))).collect();
    if points.len() <= MAX_POINTS {
        return points;
    }
    let run = points.len().div_ceil((MAX_POINTS - 1) / KEPT);
    let mut kept = Vec::with_capacity(MAX_POINTS);
    for run in points.chunks(run) {
        let pick = |before: &dyn Fn(&[f64; 2], &[f64; 2]) -> bool| {
            run.iter()
                .enumerate()
                .fold(0, |best, (index, point)| match run.get(best) {
                    Some(champion) if before(point, champion) => index,
                    _ => best,
                })
        };
        let mut indices = [
            0,
            pick(&|[a, _], [b, _]| a < b),
            pick(&|[a, _], [b, _]| a > b),
            pick(&|[_, a], [_, b]| a < b),
            pick(&|[_, a], [_, b]| a > b),
        ];
        indices.sort_unstable();
        let mut last = None;
        for index in indices {
            if last != Some(index) {
                kept.extend(run.get(index).copied());
            }
            last = Some(index);
        }
    }
    kept.extend(points.last().copied());
    kept
}

#[cfg(test)]
mod test {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn extremes_ends_and_order_survive(
            values in prop::collection::vec(-1e3..1e3f64, 1..9000),
        ) {
            let points: Vec<[f64; 2]> = values.iter().zip(0i32..).map(|(v, i)| [f64::from(i), *v]).collect();
            let kept = decimate(points.iter().copied());
            prop_assert!(kept.len() <= MAX_POINTS);
            prop_assert_eq!(kept[0].map(f64::to_bits), points[0].map(f64::to_bits));
            prop_assert_eq!(kept.last().unwrap().map(f64::to_bits), points.last().unwrap().map(f64::to_bits));
            prop_assert!(kept.windows(2).all(|w| w[0][0] <= w[1][0]));
            let peak = |points: &[[f64; 2]]| points.iter().map(|p| p[1]).fold(f64::MIN, |a, b| if b > a { b } else { a });
            let pit = |points: &[[f64; 2]]| points.iter().map(|p| p[1]).fold(f64::MAX, |a, b| if b < a { b } else { a });
            prop_assert_eq!(peak(&kept).to_bits(), peak(&points).to_bits());
            prop_assert_eq!(pit(&kept).to_bits(), pit(&points).to_bits());
        }
    }

    #[test]
    fn what_is_not_finite_is_dropped() {
        let kept = decimate([[0.0, f64::NAN], [1.0, 2.0], [f64::INFINITY, 0.0]].into_iter());
        assert_eq!(kept, [[1.0, 2.0]]);
    }
}
