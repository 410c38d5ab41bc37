//! The programmed feed along a path: from which s on which speed.

use motion::Pose;
use motion::path::METRES_PER_RADIAN;
use motion::pose::log;
use protocol::fault::PathProblem;

/// The feeds of what is sampled and of what is not yet, with room for W changes ahead of what is sampled.
#[derive(Clone, Debug)]
pub(super) struct Feeds<const W: usize> {
    /// The greatest, that of the instruction, m/s.
    most: f64,
    /// What holds until the first change, m/s.
    now: f64,
    /// From s on (m), so many m/s.
    changes: heapless::Deque<(f64, f64), W>,
    /// What the points of the open curve will add to the end of the path, m.
    pub(super) waiting_m: f64,
}

impl<const W: usize> Feeds<W> {
    #[expect(
        clippy::inline_always,
        reason = "so that what is large is made where it stays, and not on the stack"
    )]
    #[inline(always)]
    pub(super) const fn new(most: f64) -> Self {
        Self {
            most,
            now: most,
            changes: heapless::Deque::new(),
            waiting_m: 0.0,
        }
    }

    /// As new, in the same place.
    pub(super) fn begin(&mut self, most: f64) {
        self.most = most;
        self.now = most;
        self.changes.clear();
        self.waiting_m = 0.0;
    }

    /// How many changes can be taken now.
    pub(super) fn room(&self) -> usize {
        W.saturating_sub(self.changes.len())
    }

    /// Another feed, from where the path ends once its waiting points are made spans.
    ///
    /// # Errors
    /// A feed that is none.
    pub(super) fn change(&mut self, end: f64, feed: f32) -> Result<(), PathProblem> {
        let feed = f64::from(feed);
        if !(feed > 0.0 && feed.is_finite()) {
            return Err(PathProblem::Feed);
        }
        let feed = if feed < self.most { feed } else { self.most };
        let from = end + self.waiting_m;
        if let Some(last) = self.changes.back_mut()
            && last.0 >= from
        {
            last.1 = feed;
            return Ok(());
        }
        // full: only a caller that takes more elements than there is room for gets here
        let full = PathProblem::Feed;
        self.changes.push_back((from, feed)).map_err(|_| full)
    }

    /// The feed at s, which never decreases from one question to the next.
    pub(super) fn at(&mut self, s: f64) -> f64 {
        for _ in 0..W {
            match self.changes.front() {
                Some((from, feed)) if *from <= s => self.now = *feed,
                _ => break,
            }
            let _ = self.changes.pop_front();
        }
        self.now
    }
}

/// What the way between two points adds to the parameter of a path, m: see [`METRES_PER_RADIAN`].
pub(super) fn chord(from: &Pose, to: &Pose) -> f64 {
    let way = to.position - from.position;
    let turn = log(&(to.rotation * from.rotation.transpose()));
    let (way, turn) = (way.dot(&way), turn.dot(&turn));
    let turned = METRES_PER_RADIAN * libm::sqrt(turn);
    let gone = libm::sqrt(way);
    if turned > gone { turned } else { gone }
}

#[cfg(test)]
mod test {
    use super::*;

    #[test]
    fn a_feed_holds_from_where_it_was_said_and_never_above_the_instructions() {
        let mut feeds = Feeds::<4>::new(0.125);
        feeds.change(1.0, 0.25).unwrap();
        feeds.change(1.0, 0.0625).unwrap();
        feeds.waiting_m = 0.5;
        feeds.change(1.0, 7.0).unwrap();
        let wanted = [0.125, 0.125, 0.0625, 0.0625, 0.125, 0.125];
        for (s, wanted) in [0.0, 0.999, 1.0, 1.499, 1.5, 9.0].into_iter().zip(wanted) {
            assert!((feeds.at(s) - wanted).abs() < 1e-15, "{s}");
        }
    }

    #[test]
    fn a_feed_that_is_none_is_refused_and_changes_nothing() {
        let mut feeds = Feeds::<4>::new(0.1);
        for none in [0.0, -1.0, f32::NAN, f32::INFINITY] {
            assert_eq!(feeds.change(0.0, none), Err(PathProblem::Feed));
        }
        assert!((feeds.at(1.0) - 0.1).abs() < 1e-15);
    }

    #[test]
    fn changes_beyond_their_places_are_refused() {
        let mut feeds = Feeds::<8>::new(0.1);
        for k in 0..8 {
            assert_eq!(feeds.room(), 8 - k);
            feeds
                .change(f64::from(u32::try_from(k).unwrap()), 0.05)
                .unwrap();
        }
        assert_eq!(feeds.room(), 0);
        assert_eq!(feeds.change(1e6, 0.05), Err(PathProblem::Feed));
    }
}
