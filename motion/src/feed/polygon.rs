//! Convex polygons in the half-plane x ≥ 0 of (u, x) = (s̈, ṡ²), around (0, 0).

use crate::scalar::{larger, smaller};

/// Most corners; one place more is used while a line cuts.
const CORNERS: usize = 11;
/// Most lines that bound a polygon: one for each side, without x ≥ 0.
pub(super) const LINES: usize = CORNERS - 1;

/// See [`Polygon::without_short_sides`]: then a side's direction is off by 6e-4 at most.
const SHORT: f32 = 1e-4;

/// Corners (u, x) counter-clockwise. Two of them are on x = 0, at both sides of (0, 0).
#[derive(Clone, Debug)]
pub(super) struct Polygon {
    corners: [[f32; 2]; CORNERS + 1],
    len: usize,
}

impl Polygon {
    /// |u| ≤ `most_u`, 0 ≤ x ≤ `most_x`
    pub(super) fn rectangle(most_u: f32, most_x: f32) -> Self {
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

    pub(super) fn corners(&self) -> impl Iterator<Item = &[f32; 2]> + Clone {
        self.corners.iter().take(self.len)
    }

    /// Two lines can cut without leaving out anything more.
    pub(super) fn has_room_for_two(&self) -> bool {
        self.len.saturating_add(2) <= CORNERS
    }

    /// Where |line·(u, x)| ≤ 1 does not hold, cuts such that it is at most `limit` ≤ 1.
    pub(super) fn cut_strip(&mut self, line: [f32; 2], limit: f32) {
        let (mut low, mut high) = (0.0, 0.0);
        for corner in self.corners() {
            let at = dot(line, *corner);
            low = smaller(low, at);
            high = larger(high, at);
        }
        if high > 1.0 {
            self.cut(line, limit);
        }
        if low < -1.0 {
            let [by_u, by_x] = line;
            self.cut([-by_u, -by_x], limit);
        }
    }

    /// The same with line\[0\]·|u| + line\[1\]·x ≤ 1.
    pub(super) fn cut_roof(&mut self, line: [f32; 2], limit: f32) {
        let [by_u, by_x] = line;
        let (mut ahead, mut behind) = (0.0, 0.0);
        for [u, x] in self.corners() {
            let (of_u, of_x) = (by_u * u, by_x * x);
            ahead = larger(ahead, of_x + of_u);
            behind = larger(behind, of_x - of_u);
        }
        if ahead > 1.0 {
            self.cut(line, limit);
        }
        if behind > 1.0 {
            self.cut([-by_u, by_x], limit);
        }
    }

    /// Cuts off what does not satisfy line·(u, x) ≤ limit, if there is anything.
    pub(super) fn cut_if_needed(&mut self, line: [f32; 2], limit: f32) {
        if self.corners().any(|corner| dot(line, *corner) > limit) {
            self.cut(line, limit);
        }
    }

    /// Nothing when full, which leaves out a corner: a convex polygon has at most one more when cut.
    fn push(&mut self, corner: [f32; 2]) {
        if let Some(free) = self.corners.get_mut(self.len) {
            *free = corner;
            self.len = self.len.saturating_add(1);
        }
    }

    /// Cuts off what does not satisfy line·(u, x) ≤ limit, limit > 0. Where there is no place for
    /// another corner, the one goes that takes least area with it: what is left is inside, and convex.
    pub(super) fn cut(&mut self, line: [f32; 2], limit: f32) {
        let above = |corner: &[f32; 2]| dot(line, *corner) - limit;
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
        let (mut least, mut at) = (f32::INFINITY, self.len);
        for (i, [before, corner, after]) in (0..self.len).zip(self.triples()) {
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
            self.len = self.len.saturating_sub(1);
        }
    }

    /// Each corner between its neighbours, the first one first.
    fn triples(&self) -> impl Iterator<Item = [[f32; 2]; 3]> {
        let mut after = self.corners().skip(1).chain(self.corners().take(1));
        let mut before = *self.corners().last().unwrap_or(&[0.0; 2]);
        self.corners().map(move |corner| {
            let out = [before, *corner, *after.next().unwrap_or(corner)];
            before = *corner;
            out
        })
    }

    /// Its sides but x ≥ 0, as line·(u, x) ≤ 1. Of a side through two corners, the outward normal is
    /// (Δx, −Δu); one without length is none.
    pub(super) fn lines(&self) -> impl Iterator<Item = [f32; 2]> {
        self.triples().filter_map(|[p, q, _]| {
            let [du, dx] = difference(q, p);
            let most = cross(p, [du, dx]);
            (most > 0.0).then(|| {
                let per = 1.0 / most;
                [dx * per, -du * per]
            })
        })
    }

    /// Without sides shorter than [`SHORT`] of both extents: the corners of one are off by 6e-8 of those, and so it
    /// would point anywhere, and cut off what is allowed. A corner less leaves what is inside.
    pub(super) fn without_short_sides(&self, extents: [f32; 2]) -> Self {
        let [most_u, most_x] = extents;
        let short = |a: &[f32; 2], b: &[f32; 2]| {
            let [u, x] = difference(*a, *b);
            u.abs() < SHORT * most_u && x.abs() < SHORT * most_x
        };
        let mut out = Self::EMPTY;
        for corner in self.corners() {
            let ([_, x], last) = (*corner, out.corners().last());
            match last {
                Some(last) if short(last, corner) && x > 0.0 => {}
                Some(last) if short(last, corner) => out.replace_last(*corner),
                _ => out.push(*corner),
            }
        }
        let around = out.corners().next().zip(out.corners().last());
        if around.is_some_and(|(first, last)| short(first, last) && last[1] > 0.0) {
            out.len = out.len.saturating_sub(1);
        }
        out
    }

    /// The corner before, if it is not one of those on x = 0, gives way to this one.
    fn replace_last(&mut self, corner: [f32; 2]) {
        if let Some(last) = self.corners.get_mut(self.len.saturating_sub(1))
            && last[1] > 0.0
        {
            *last = corner;
        } else {
            self.push(corner);
        }
    }
}

fn difference([a0, a1]: [f32; 2], [b0, b1]: [f32; 2]) -> [f32; 2] {
    [a0 - b0, a1 - b1]
}

pub(super) fn dot([a0, a1]: [f32; 2], [b0, b1]: [f32; 2]) -> f32 {
    a0 * b0 + a1 * b1
}

fn cross([a0, a1]: [f32; 2], [b0, b1]: [f32; 2]) -> f32 {
    a0 * b1 - a1 * b0
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use proptest::prelude::*;
    use std::vec::Vec;

    /// The least of limit − line·(u, x) over all lines: positive inside.
    fn depth(lines: &[[f32; 2]], limit: f32, point: [f32; 2]) -> f32 {
        lines.iter().fold(f32::INFINITY, |least, line| {
            smaller(least, limit - dot(*line, point))
        })
    }

    /// The same but for rounding of numbers up to 2.
    fn near(a: [f32; 2], b: [f32; 2]) -> bool {
        let [u, x] = difference(a, b);
        larger(u.abs(), x.abs()) < 1e-6
    }

    fn line() -> impl Strategy<Value = [f32; 2]> {
        // on x = 0, |u| ≤ 1 is inside: (0, 0) never lies on a side
        (-0.99..0.99f32, -3.0..3.0f32).prop_map(|(by_u, by_x)| [by_u, by_x])
    }

    proptest! {
        #[test]
        fn while_there_is_place_exactly_what_all_lines_allow_is_left(
            lines in prop::collection::vec(line(), 0..=CORNERS - 4),
            u in -1.0..1.0f32,
            x in 0.0..2.0f32,
        ) {
            let mut polygon = Polygon::rectangle(1.0, 2.0);
            for line in &lines {
                polygon.cut_if_needed(*line, 1.0);
            }
            let polygon = polygon.without_short_sides([1.0, 2.0]);
            let sides: Vec<_> = polygon.lines().collect();
            let (expected, is) = (depth(&lines, 1.0, [u, x]), depth(&sides, 1.0, [u, x]));
            // near a side, rounding decides: corners are exact to 3e-7, a side may be as short as 1e-4
            prop_assume!(expected.abs() > 1e-2 && is.abs() > 1e-2);
            prop_assert_eq!(expected > 0.0, is > 0.0, "{:?} {:?}", lines, polygon);
        }

        #[test]
        fn a_full_polygon_loses_something_more_but_nothing_that_is_not_allowed(
            lines in prop::collection::vec(line(), 30..60),
        ) {
            let mut polygon = Polygon::rectangle(1.0, 2.0);
            for line in &lines {
                polygon.cut_if_needed(*line, 1.0);
                prop_assert!(polygon.len <= CORNERS && polygon.len >= 3);
            }
            let polygon = polygon.without_short_sides([1.0, 2.0]);
            let sides: Vec<_> = polygon.lines().collect();
            prop_assert!(sides.len() <= LINES);
            for corner in polygon.corners() {
                // some roundings of numbers up to 6; of a side as short as 1e-4, of which it points off
                prop_assert!(depth(&lines, 1.0, *corner) > -1e-5);
                prop_assert!(depth(&sides, 1.0, *corner) > -1e-2);
            }
            for u in [-1.0, 1.0] {
                prop_assert!(polygon.corners().any(|c| near(*c, [u, 0.0])), "{:?}", polygon);
            }
        }
    }

    #[test]
    fn a_strip_and_a_roof_cut_at_both_sides() {
        let mut strip = Polygon::rectangle(2.0, 1.0);
        strip.cut_strip([1.0, 0.5], 1.0);
        let mut roof = Polygon::rectangle(2.0, 1.0);
        roof.cut_roof([1.0, 0.5], 1.0);
        // |u + x/2| ≤ 1 and |u| + x/2 ≤ 1 at x = 0 and x = 1
        for (polygon, corners) in [
            (strip, [[-1.0, 0.0], [1.0, 0.0], [0.5, 1.0], [-1.5, 1.0]]),
            (roof, [[-1.0, 0.0], [1.0, 0.0], [0.5, 1.0], [-0.5, 1.0]]),
        ] {
            assert_eq!(polygon.len, 4);
            for corner in corners {
                assert!(polygon.corners().any(|c| near(*c, corner)), "{polygon:?}");
            }
        }
    }
}
