//! Cubic splines "not a knot" by brute force: all coefficients from one dense system.

use nalgebra::Vector3;

/// A spline through points over given parameters, four or more.
pub(crate) struct Spline {
    t: Vec<f64>,
    /// Of each span, ascending in t less the knot before.
    spans: Vec<[Vector3<f64>; 4]>,
}

impl Spline {
    /// Each span passes both its points; first and second derivatives agree at inner points; the third at
    /// the second and the last but one.
    pub(crate) fn new(t: &[f64], p: &[Vector3<f64>]) -> Self {
        let spans = t.len() - 1;
        let (mut m, mut right) = (
            vec![vec![0.0; 4 * spans]; 4 * spans],
            vec![Vector3::zeros(); 4 * spans],
        );
        let mut row = 0;
        let h = |i: usize| t[i + 1] - t[i];
        // derivative k of a span at x = c·monomials
        let monomials = |k: usize, x: f64| -> [f64; 4] {
            match k {
                0 => [1.0, x, x * x, x * x * x],
                1 => [0.0, 1.0, 2.0 * x, 3.0 * x * x],
                2 => [0.0, 0.0, 2.0, 6.0 * x],
                _ => [0.0, 0.0, 0.0, 6.0],
            }
        };
        let mut add = |terms: &[(usize, [f64; 4], f64)], value: Vector3<f64>| {
            for (span, c, sign) in terms {
                for k in 0..4 {
                    m[row][4 * span + k] += sign * c[k];
                }
            }
            right[row] = value;
            row += 1;
        };
        for i in 0..spans {
            add(&[(i, monomials(0, 0.0), 1.0)], p[i]);
            add(&[(i, monomials(0, h(i)), 1.0)], p[i + 1]);
        }
        for i in 1..spans {
            for k in [1, 2] {
                add(
                    &[
                        (i - 1, monomials(k, h(i - 1)), 1.0),
                        (i, monomials(k, 0.0), -1.0),
                    ],
                    Vector3::zeros(),
                );
            }
        }
        for i in [1, spans - 1] {
            add(
                &[
                    (i - 1, monomials(3, 0.0), 1.0),
                    (i, monomials(3, 0.0), -1.0),
                ],
                Vector3::zeros(),
            );
        }
        let x = solve(m, right);
        Self {
            t: t.to_vec(),
            spans: x.chunks(4).map(|c| [c[0], c[1], c[2], c[3]]).collect(),
        }
    }

    /// Value, first, second and third derivative.
    pub(crate) fn at(&self, t: f64) -> [Vector3<f64>; 4] {
        let i = self
            .t
            .iter()
            .rposition(|knot| *knot <= t)
            .unwrap_or(0)
            .min(self.spans.len() - 1);
        let ([a, b, c, d], x) = (self.spans[i], t - self.t[i]);
        [
            a + (b + (c + d * x) * x) * x,
            b + (c * 2.0 + d * (3.0 * x)) * x,
            c * 2.0 + d * (6.0 * x),
            d * 6.0,
        ]
    }
}

/// Accumulated chords.
pub(crate) fn chords(p: &[Vector3<f64>]) -> Vec<f64> {
    let mut t = vec![0.0];
    for pair in p.windows(2) {
        t.push(t[t.len() - 1] + (pair[1] - pair[0]).norm());
    }
    t
}

/// Gaussian elimination with row pivoting.
fn solve(mut m: Vec<Vec<f64>>, mut right: Vec<Vector3<f64>>) -> Vec<Vector3<f64>> {
    let n = m.len();
    for column in 0..n {
        let pivot = (column..n)
            .max_by(|a, b| m[*a][column].abs().total_cmp(&m[*b][column].abs()))
            .unwrap();
        m.swap(column, pivot);
        right.swap(column, pivot);
        for row in column + 1..n {
            let factor = m[row][column] / m[column][column];
            if factor != 0.0 {
                let (above, below) = m.split_at_mut(row);
                for (x, y) in below[0].iter_mut().zip(&above[column]) {
                    *x -= factor * y;
                }
                right[row] = right[row] - right[column] * factor;
            }
        }
    }
    for row in (0..n).rev() {
        let mut x = right[row];
        for k in row + 1..n {
            x -= right[k] * m[row][k];
        }
        right[row] = x / m[row][row];
    }
    right
}
