//! The programmed feed along a path: from which s on which speed.

use crate::capacity::PATH_PIECES;
use motion::Pose;
use motion::path::METRES_PER_RADIAN;
use motion::pose::log;
use protocol::fault::PathProblem;

/// Changes of the feed ahead of what is sampled: there is at most one where a piece ends, or where one of
/// the eight points lies whose spans wait for those after them.
const FEED_CHANGES: usize = PATH_PIECES + 8;

/// The feeds of what is sampled and of what is not yet.
#[derive(Clone, Debug)]
pub(super) struct Feeds {
    /// The greatest, that of the instruction, m/s.
    most: f64,
    /// What holds until the first change, m/s.
    now: f64,
    /// From s on (m), so many m/s.
    changes: heapless::Deque<(f64, f64), FEED_CHANGES>,
    /// What the points of the open curve will add to the end of the path, m.
    pub(super) waiting_m: f64,
}

impl Feeds {
    pub(super) const fn new(most: f64) -> Self {
        Self {
            most,
            now: most,
            changes: heapless::Deque::new(),
            waiting_m: 0.0,
        }
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
        for _ in 0..FEED_CHANGES {
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
        let mut feeds = Feeds::new(0.125);
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
        let mut feeds = Feeds::new(0.1);
        for none in [0.0, -1.0, f32::NAN, f32::INFINITY] {
            assert_eq!(feeds.change(0.0, none), Err(PathProblem::Feed));
        }
        assert!((feeds.at(1.0) - 0.1).abs() < 1e-15);
    }

    #[test]
    fn changes_beyond_their_places_are_refused() {
        let mut feeds = Feeds::new(0.1);
        for k in 0..u32::try_from(FEED_CHANGES).unwrap() {
            feeds.change(f64::from(k), 0.05).unwrap();
        }
        assert_eq!(feeds.change(1e6, 0.05), Err(PathProblem::Feed));
    }
}
