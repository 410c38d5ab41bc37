//! Elements of a path that are made while they are sent: a window of them, and a source that can begin anew.

use core::fmt;
use protocol::message::PathElement;
use std::collections::VecDeque;
use std::sync::Arc;

/// Elements kept behind the one that was asked for last: a node asks again for what it has not got, and at
/// most one request of [`PATH_BATCH`](protocol::message::PATH_BATCH) is on its way. Room for several lost answers, 8 kB.
const KEPT: usize = 64;

/// The elements of a path, the last of them [`PathElement::End`].
pub type Elements = Box<dyn Iterator<Item = PathElement> + Send>;

/// Where the elements of a path come from: the same ones every time.
pub trait PathSource: fmt::Debug + Send + Sync {
    /// All elements from the first one on.
    fn elements(&self) -> Elements;
}

impl PathSource for Arc<[PathElement]> {
    fn elements(&self) -> Elements {
        let all = self.clone();
        Box::new((0..all.len()).map_while(move |k| all.get(k).copied()))
    }
}

/// Some of the elements of a source, around the one that is wanted: at most as many as are kept behind it and
/// are asked for at once.
pub(super) struct Window {
    source: Arc<dyn PathSource>,
    rest: Elements,
    /// The number of the first one kept.
    first: u32,
    kept: VecDeque<PathElement>,
}

impl fmt::Debug for Window {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Window")
            .field("source", &self.source)
            .field("first", &self.first)
            .field("kept", &self.kept)
            .finish_non_exhaustive()
    }
}

impl Window {
    pub(super) fn new(source: &Arc<dyn PathSource>) -> Self {
        Self {
            source: source.clone(),
            rest: source.elements(),
            first: 0,
            kept: VecDeque::new(),
        }
    }

    /// The element of a number; none beyond the last. One that is not kept any more is made again, from the
    /// beginning of the path.
    pub(super) fn get(&mut self, number: u32) -> Option<PathElement> {
        if number < self.first {
            *self = Self::new(&self.source);
        }
        let place = number - self.first;
        let mut place = usize::try_from(place).ok()?;
        while self.kept.len() <= place {
            self.kept.push_back(self.rest.next()?);
            if self.kept.len() > KEPT {
                self.kept.pop_front();
                self.first = self.first.saturating_add(1);
                place = place.saturating_sub(1);
            }
        }
        self.kept.get(place).copied()
    }
}

#[cfg(test)]
mod test {
    use super::*;
    use proptest::prelude::*;
    use protocol::message::PathElement::{End, Feed};
    use std::sync::atomic::{AtomicUsize, Ordering};

    /// So many elements, each of which tells its number, and how often they were begun with.
    #[derive(Debug)]
    struct Counted(u32, AtomicUsize);

    fn element(number: u32) -> PathElement {
        #[expect(clippy::cast_precision_loss, reason = "small numbers")]
        let metres_per_second = number as f32;
        Feed { metres_per_second }
    }

    impl PathSource for Counted {
        fn elements(&self) -> Elements {
            self.1.fetch_add(1, Ordering::Relaxed);
            Box::new((0..self.0).map(element).chain([End]))
        }
    }

    fn window(count: u32) -> (Window, Arc<Counted>) {
        let source = Arc::new(Counted(count, AtomicUsize::new(0)));
        (
            Window::new(&(source.clone() as Arc<dyn PathSource>)),
            source,
        )
    }

    #[test]
    fn what_is_asked_for_again_is_kept_and_what_is_not_is_made_anew() {
        let (mut window, source) = window(100_000);
        for number in 0..=99_999 {
            assert_eq!(window.get(number), Some(element(number)));
            assert!(window.kept.len() <= KEPT);
        }
        assert_eq!(window.get(100_000), Some(End));
        assert_eq!(window.get(100_001), None);
        assert_eq!(window.get(99_990), Some(element(99_990)));
        assert_eq!(source.1.load(Ordering::Relaxed), 1);
        assert_eq!(window.get(7), Some(element(7)));
        assert_eq!(source.1.load(Ordering::Relaxed), 2);
    }

    proptest! {
        #[test]
        fn whatever_is_asked_for_is_what_the_source_says(
            asked in prop::collection::vec(0_u32..300, 1..40), count in 0_u32..200,
        ) {
            let (mut window, _) = window(count);
            for number in asked {
                let said = match number {
                    number if number < count => Some(element(number)),
                    number if number == count => Some(End),
                    _ => None,
                };
                prop_assert_eq!(window.get(number), said);
                prop_assert!(window.kept.len() <= KEPT);
            }
        }
    }
}
