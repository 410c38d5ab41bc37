//! Pieces one after the other, as one path.

use super::join::Join;
use super::{Blend, BlendError, Curve, PathPoint, Piece, Quintic, Tolerance};
use core::fmt;

/// Why a piece is not taken; the path stays as it was.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum QueueError {
    /// No room: discard what lies behind first.
    Full,
    /// The piece does not begin where the path ends.
    Gap,
    /// The corner cannot be blended. It may be pushed as it is.
    Corner(BlendError),
}

impl fmt::Display for QueueError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Full => f.write_str("no room for another piece"),
            Self::Gap => f.write_str("the piece does not begin where the path ends"),
            Self::Corner(error) => write!(f, "the corner cannot be blended: {error}"),
        }
    }
}

impl core::error::Error for QueueError {}

/// What is left of a piece after blending is not kept if it is rounding only, m.
const NOTHING_M: f64 = 1e-12;

/// Longer blends have the derivatives of their pieces by how they are made: what rounding of positions of 1 m leaves of p''
/// and ω', 1e-13/d² and 5e-12/d², is far below what a smooth join may jump. Of shorter ones one looks.
const SURE_M: f64 = 1e-4;

/// Up to N pieces, with one parameter s from the start of the first piece ever pushed.
///
/// Pieces are pushed at the end, blended with the one before if asked, and discarded at the beginning
/// when nobody goes back there any more. s never starts anew; it grows by the length of each piece.
///
/// ```
/// use motion::path::{Join, Path, Straight, Tolerance};
/// use motion::Pose;
/// use nalgebra::Vector3;
/// let at = |x, y| Pose::from_rotation_vector(Vector3::new(x, y, 0.0), Vector3::zeros());
/// let mut path = Path::<8>::new();
/// path.push(Straight::new(at(0.0, 0.0), at(0.1, 0.0))?)?;
/// let tolerance = Tolerance { metres: 1e-3, radians: 1e-2 };
/// let join = path.push_blended(Straight::new(at(0.1, 0.0), at(0.1, 0.1))?, &tolerance)?;
/// assert_eq!((join, path.len()), (Join::Smooth, 3));
/// assert_eq!(path.push(Straight::new(at(0.1, 0.1), at(0.0, 0.0))?)?, Join::Stop);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Path<const N: usize> {
    entries: heapless::Deque<Entry, N>,
    /// The end of the last piece.
    end: f64,
    /// The entry last asked for, from the first.
    cursor: usize,
    /// Blends are not shorter, m.
    shortest_blend: f64,
}

/// The part of a piece from one value of its own parameter to another.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Entry {
    piece: Piece,
    from: f64,
    to: f64,
    /// Parameter of the path where the part begins.
    start: f64,
    /// With what came before.
    join: Join,
}

impl Entry {
    fn end(&self) -> f64 {
        self.start + (self.to - self.from)
    }
}

impl<const N: usize> Default for Path<N> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const N: usize> Path<N> {
    /// No pieces yet.
    #[must_use]
    #[expect(
        clippy::inline_always,
        reason = "so that what is large is made where it stays, and not on the stack"
    )]
    #[inline(always)]
    pub const fn new() -> Self {
        const { assert!(N > 0, "a path holds at least one piece") }
        Self {
            entries: heapless::Deque::new(),
            end: 0.0,
            cursor: 0,
            shortest_blend: 0.0,
        }
    }

    /// The same, with corners left as they are, to stop in, where a blend would be shorter than this, m: for
    /// whoever samples the path and could not see it.
    #[must_use]
    pub const fn without_blends_below(mut self, shortest_blend: f64) -> Self {
        self.shortest_blend = shortest_blend;
        self
    }

    /// No pieces, as [`new`](Self::new), in the same place; the shortest blend stays as it was asked for.
    pub fn clear(&mut self) {
        self.entries.clear();
        self.end = 0.0;
        self.cursor = 0;
    }

    /// Pieces retained, blends included.
    #[must_use]
    pub fn len(&self) -> usize {
        self.entries.len()
    }

    /// Whether no piece is retained.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// Pieces that can still be pushed; a blended one takes two places.
    #[must_use]
    pub fn room(&self) -> usize {
        N.saturating_sub(self.len())
    }

    /// The least s that is retained, m.
    #[must_use]
    pub fn retained_from(&self) -> f64 {
        self.entry(0).map_or(self.end, |entry| entry.start)
    }

    /// The greatest s, m.
    #[must_use]
    pub fn end(&self) -> f64 {
        self.end
    }

    /// Up to which s no blend with a piece yet to come can change anything, m: half way along the last
    /// piece. If none comes, it is the [end](Self::end).
    #[must_use]
    pub fn settled(&self) -> f64 {
        self.last().map_or(self.end, |entry| {
            let half = 0.5 * entry.piece.length();
            entry.start
                + if half > entry.from {
                    half - entry.from
                } else {
                    0.0
                }
        })
    }

    /// Append a piece as it is. The first is joined to rest.
    ///
    /// # Errors
    /// [`QueueError::Full`], [`QueueError::Gap`].
    pub fn push(&mut self, piece: impl Into<Piece>) -> Result<Join, QueueError> {
        let piece = piece.into();
        self.append(&piece)
    }

    /// Append the next span of one curve through points: it has derivatives with the one before it by how both are made,
    /// which nobody needs to look at.
    ///
    /// # Errors
    /// [`QueueError::Full`]; [`QueueError::Gap`] if there is no piece before it.
    pub fn push_span(&mut self, span: &Quintic) -> Result<(), QueueError> {
        if self.room() == 0 {
            return Err(QueueError::Full);
        }
        if self.is_empty() {
            return Err(QueueError::Gap);
        }
        self.place_part(&(*span).into(), 0.0, Join::Smooth);
        Ok(())
    }

    /// Append a piece with a [`Blend`] in place of the corner before it. Where there is no corner, because
    /// the join is smooth or the path has no pieces, this is [`push`](Self::push).
    ///
    /// The last piece loses up to half of its length: see [`settled`](Self::settled).
    ///
    /// # Errors
    /// [`QueueError`].
    pub fn push_blended(
        &mut self,
        piece: impl Into<Piece>,
        tolerance: &Tolerance,
    ) -> Result<Join, QueueError> {
        self.append_blended(&piece.into(), tolerance)
    }

    // by reference, and in a frame of its own: the stack has one copy of a piece, whatever it was made of, and none
    // of what a blend takes where there is none
    #[inline(never)]
    fn append_blended(&mut self, piece: &Piece, tolerance: &Tolerance) -> Result<Join, QueueError> {
        let Some(last) = self.last().copied() else {
            return self.append(piece);
        };
        let (end, start) = (last.piece.at(last.to), piece.at(0.0));
        if Join::between(&end, &start).ok_or(QueueError::Gap)? == Join::Smooth {
            return self.append(piece);
        }
        let blend = Blend::between(&last.piece, piece, tolerance).map_err(QueueError::Corner)?;
        if blend.curve().length() < self.shortest_blend {
            return self.append(piece);
        }
        let to = last.to - blend.distance();
        let rest = to - last.from;
        let places = if rest > NOTHING_M { 2 } else { 1 };
        if self.room() < places {
            return Err(QueueError::Full);
        }
        let curve = *blend.curve();
        let sure = curve.length() > SURE_M;
        let join = |end: &dyn Fn() -> PathPoint, start: &dyn Fn() -> PathPoint| {
            if sure {
                Some(Join::Smooth)
            } else {
                Join::between(&end(), &start())
            }
        };
        let into = if rest > NOTHING_M {
            self.shorten(to);
            join(&|| last.piece.at(to), &|| curve.at(0.0))
        } else {
            // blended at both ends: nothing is left between the blends
            self.remove_last();
            match self.last() {
                Some(before) => join(&|| before.piece.at(before.to), &|| curve.at(0.0)),
                None => Some(last.join),
            }
        };
        self.place_part(&curve.into(), 0.0, into.unwrap_or(Join::Stop));
        let end = || curve.at(curve.length());
        let out = join(&end, &|| piece.at(blend.distance()));
        self.place_part(piece, blend.distance(), out.unwrap_or(Join::Stop));
        Ok(match (into, out) {
            (Some(Join::Smooth), Some(Join::Smooth)) => Join::Smooth,
            _ => Join::Stop,
        })
    }

    /// The point at s, m. Where two pieces meet, it is the start of the later one. Beyond what is retained
    /// the first or last piece goes on, as [`Curve::at`]; none without pieces.
    ///
    /// The piece is searched from the last one asked for: going along the path costs one step a piece,
    /// jumping about at most N.
    pub fn at(&mut self, s: f64) -> Option<PathPoint> {
        self.point(s, Piece::at)
    }

    /// The same as [`Curve::followed_at`].
    pub fn followed_at(&mut self, s: f64) -> Option<PathPoint> {
        self.point(s, Piece::followed_at)
    }

    fn point(&mut self, s: f64, evaluate: impl Fn(&Piece, f64) -> PathPoint) -> Option<PathPoint> {
        for _ in 0..N {
            let (Some(here), next) = (
                self.entry(self.cursor),
                self.entry(self.cursor.saturating_add(1)),
            ) else {
                break;
            };
            if s < here.start && self.cursor > 0 {
                self.cursor = self.cursor.saturating_sub(1);
            } else if next.is_some_and(|next| s >= next.start) {
                self.cursor = self.cursor.saturating_add(1);
            } else {
                break;
            }
        }
        let entry = self.entry(self.cursor)?;
        let end = entry.end();
        // so that the end of the path is the end of its last piece, to the bit
        let local = if s >= end {
            entry.to + (s - end)
        } else {
            entry.from + (s - entry.start)
        };
        Some(evaluate(&entry.piece, local))
    }

    /// The middles of pieces shorter than `short` that reach into the way from `from` to `to`, all in m, at most
    /// eight: where a path bends that samples `short` apart would miss.
    pub fn short_between(&self, from: f64, to: f64, short: f64) -> impl Iterator<Item = f64> {
        let found = self
            .entries
            .iter()
            .filter(move |entry| entry.end() > from && entry.start < to)
            .filter(move |entry| entry.end() - entry.start < short);
        found.map(|entry| 0.5 * (entry.start + entry.end())).take(8)
    }

    /// The first place after s where the tool must be at rest, m, the [end](Self::end) of what is known
    /// excepted.
    #[must_use]
    pub fn stop_after(&self, s: f64) -> Option<f64> {
        let mut stops = self.stops();
        stops.find(|stop| *stop > s)
    }

    /// The last place before s where the tool must be at rest, m, the
    /// [least s](Self::retained_from) excepted.
    #[must_use]
    pub fn stop_before(&self, s: f64) -> Option<f64> {
        self.stops().take_while(|stop| *stop < s).last()
    }

    /// Discard the pieces that end at s or before, but never the last one.
    pub fn discard_before(&mut self, s: f64) {
        for _ in 0..N {
            if self.len() < 2 || !self.entry(0).is_some_and(|entry| entry.end() <= s) {
                break;
            }
            let _ = self.entries.pop_front();
            self.cursor = self.cursor.saturating_sub(1);
        }
    }

    fn stops(&self) -> impl Iterator<Item = f64> + '_ {
        let inner = self.entries.iter().skip(1);
        inner
            .filter(|entry| entry.join == Join::Stop)
            .map(|entry| entry.start)
    }

    fn entry(&self, i: usize) -> Option<&Entry> {
        self.entries.get(i)
    }

    fn last(&self) -> Option<&Entry> {
        self.entries.back()
    }

    fn append(&mut self, piece: &Piece) -> Result<Join, QueueError> {
        if self.room() == 0 {
            return Err(QueueError::Full);
        }
        let join = match self.last() {
            None => Join::Stop,
            Some(last) => {
                Join::between(&last.piece.at(last.to), &piece.at(0.0)).ok_or(QueueError::Gap)?
            }
        };
        self.place_part(piece, 0.0, join);
        Ok(join)
    }

    fn place_part(&mut self, piece: &Piece, from: f64, join: Join) {
        let entry = Entry {
            piece: *piece,
            from,
            to: piece.length(),
            start: self.end,
            join,
        };
        let end = entry.end();
        if self.entries.push_back(entry).is_ok() {
            self.end = end;
        }
    }

    /// Let the last piece end earlier.
    fn shorten(&mut self, to: f64) {
        if let Some(entry) = self.entries.back_mut() {
            entry.to = to;
            self.end = entry.end();
        }
    }

    fn remove_last(&mut self) {
        if let Some(entry) = self.entries.pop_back() {
            self.end = entry.start;
        }
    }
}
