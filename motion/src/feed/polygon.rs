//! Convex polygons in the half-plane x ≥ 0 of (u, x) = (s̈, ṡ²), around (0, 0).

/// Most corners; one place more is used while a line cuts.
const CORNERS: usize = 13;
/// Most lines that bound a polygon: one for each side, without x ≥ 0.
pub(super) const LINES: usize = CORNERS - 1;

/// Corners (u, x) counter-clockwise. Two of them are on x = 0, at both sides of (0, 0).
#[derive(Clone, Debug)]
pub(super) struct Polygon {
    corners: [[f64; 2]; CORNERS + 1],
    len: usize,
}

impl Polygon {
    /// |u| ≤ `most_u`, 0 ≤ x ≤ `most_x`
    pub(super) fn rectangle(most_u: f64, most_x: f64) -> Self {
        let mut out = Self::EMPTY;
        for corner in [
            [-most_u, 0.0],
            [most_u, 0.0],
            [most_u, most_x],
            [-most_u, most_x],
        ] {
            out.push(corner);
        }
        out
    }

    const EMPTY: Self = Self {
        corners: [[0.0; 2]; CORNERS + 1],
        len: 0,
    };

    pub(super) fn corners(&self) -> impl Iterator<Item = &[f64; 2]> + Clone {
        self.corners.iter().take(self.len)
    }

    /// No line can cut without leaving out something more.
    pub(super) fn is_full(&self) -> bool {
        self.len >= CORNERS
    }

    /// Nothing when full, which leaves out a corner: a convex polygon has at most one more when cut.
    fn push(&mut self, corner: [f64; 2]) {
        if let Some(free) = self.corners.get_mut(self.len) {
            *free = corner;
            self.len += 1;
        }
    }

    /// Cuts off what does not satisfy line·(u, x) ≤ limit, limit > 0. Where there is no place for
    /// another corner, the one goes that takes least area with it: what is left is inside, and convex.
    pub(super) fn cut(&mut self, line: [f64; 2], limit: f64) {
        let above = |corner: &[f64; 2]| dot(line, *corner) - limit;
        let mut out = Self::EMPTY;
        let Some(last) = self.corners().last() else {
            return;
        };
        let (mut p, mut p_above) = (*last, above(last));
        for q in self.corners() {
            let q_above = above(q);
            if (p_above > 0.0) != (q_above > 0.0) {
                let share = p_above / (p_above - q_above);
                let ([pu, px], [qu, qx]) = (p, *q);
                out.push([pu + share * (qu - pu), px + share * (qx - px)]);
            }
            if q_above <= 0.0 {
                out.push(*q);
            }
            (p, p_above) = (*q, q_above);
        }
        if out.len > CORNERS {
            out.drop_least();
        }
        *self = out;
    }

    fn drop_least(&mut self) {
        let (mut least, mut at) = (f64::INFINITY, self.len);
        for (i, (before, corner, after)) in self.triples().enumerate() {
            let area = cross(difference(corner, before), difference(after, before));
            // those on x = 0 stay: (0, 0) is between them
            let [_, x] = corner;
            if x > 0.0 && area < least {
                (least, at) = (area, i);
            }
        }
        if at < self.len {
            if let Some(rest) = self.corners.get_mut(at..self.len) {
                rest.rotate_left(1);
            }
            self.len -= 1;
        }
    }

    /// Each corner with its neighbours.
    fn triples(&self) -> impl Iterator<Item = ([f64; 2], [f64; 2], [f64; 2])> {
        let n = self.len;
        let all = || self.corners().copied().cycle();
        let before = all().skip(n.saturating_sub(1));
        before
            .zip(all())
            .zip(all().skip(1))
            .take(n)
            .map(|((a, b), c)| (a, b, c))
    }

    /// Its sides but x ≥ 0, as line·(u, x) ≤ 1. Of a side through two corners, the outward normal is
    /// (Δx, −Δu); one without length is none.
    pub(super) fn lines(&self) -> impl Iterator<Item = [f64; 2]> {
        self.triples().filter_map(|(p, q, _)| {
            let ([pu, px], [qu, qx]) = (p, q);
            let most = cross(p, q);
            (most > 0.0).then(|| [(qx - px) / most, (pu - qu) / most])
        })
    }
}

fn difference([a0, a1]: [f64; 2], [b0, b1]: [f64; 2]) -> [f64; 2] {
    [a0 - b0, a1 - b1]
}

pub(super) fn dot([a0, a1]: [f64; 2], [b0, b1]: [f64; 2]) -> f64 {
    a0 * b0 + a1 * b1
}

fn cross([a0, a1]: [f64; 2], [b0, b1]: [f64; 2]) -> f64 {
    a0 * b1 - a1 * b0
}
