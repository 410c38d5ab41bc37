//! What a part of the system sends now, beside what a record says that it sent.
//!
//! A frame is on the wire later than it was made, and another may overtake it; but those of one identifier
//! keep their order. So every identifier of every bus is compared for itself. Of frames that are all alike, as
//! SYNC is, one is missing if the next was made before one was on the wire: none waits for so long.

use bus::candump::Entry;
use protocol::frame::{Frame, Id};
use protocol::time::Micros;
use std::collections::{BTreeMap, VecDeque};

/// What was made so long before the record's end may not have been on the wire by then, ns.
const TAIL_NS: u64 = 20_000_000;

/// The first thing that differs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Difference {
    /// When, ns: of the record if it says anything, else when the frame was made.
    pub(crate) at_ns: u64,
    /// Number of the bus.
    pub(crate) bus: usize,
    /// What the record says.
    pub(crate) recorded: Option<Frame>,
    /// What is sent now.
    pub(crate) replayed: Option<Frame>,
}

/// A frame as candump writes it.
pub(crate) fn shown(frame: Option<&Frame>) -> String {
    frame.map_or_else(
        || "nothing".to_owned(),
        |frame| {
            let entry = Entry {
                at: Micros(0),
                channel: String::new(),
                frame: *frame,
            };
            let line = entry.to_string();
            let (_, frame) = line.rsplit_once(' ').unwrap_or(("", &line));
            frame.to_owned()
        },
    )
}

/// An identifier that can be sorted.
fn number(id: Id) -> (bool, u32) {
    match id {
        Id::Standard(id) => (false, id.into()),
        Id::Extended(id) => (true, id),
    }
}

/// Frames made and not yet seen in the record.
type Waiting = VecDeque<(u64, Frame)>;

/// Frames of a part, compared.
#[derive(Debug, Default)]
pub(crate) struct Comparison {
    waiting: BTreeMap<(usize, (bool, u32)), Waiting>,
    same: u64,
    difference: Option<Difference>,
}

impl Comparison {
    /// How many frames were the same.
    pub(crate) const fn same(&self) -> u64 {
        self.same
    }

    /// The first difference.
    pub(crate) const fn difference(&self) -> Option<&Difference> {
        self.difference.as_ref()
    }

    /// A frame is sent now.
    pub(crate) fn made(&mut self, at_ns: u64, bus: usize, frame: Frame) {
        let waiting = self.waiting.entry((bus, number(frame.id()))).or_default();
        waiting.push_back((at_ns, frame));
    }

    /// The record has a frame that ends at `at_ns`.
    pub(crate) fn recorded(&mut self, at_ns: u64, bus: usize, frame: &Frame) {
        let waiting = self.waiting.entry((bus, number(frame.id()))).or_default();
        let made = waiting.pop_front();
        let Some((made_ns, made)) = made.filter(|(_, made)| made == frame) else {
            return self.differs(Difference {
                at_ns,
                bus,
                recorded: Some(*frame),
                replayed: made.map(|(_, frame)| frame),
            });
        };
        self.same += 1;
        let alike = |(next_ns, next): &(u64, Frame)| next == frame && *next_ns < at_ns;
        if waiting.front().is_some_and(alike) {
            waiting.pop_front();
            self.differs(Difference {
                at_ns: made_ns,
                bus,
                recorded: None,
                replayed: Some(made),
            });
        }
    }

    /// The record ends.
    pub(crate) fn end(&mut self, end_ns: u64) {
        let left = std::mem::take(&mut self.waiting);
        let lost = left.into_iter().flat_map(|((bus, _), waiting)| {
            let waiting = waiting.into_iter();
            waiting.map(move |(made_ns, frame)| (made_ns, bus, frame))
        });
        let first = lost.min_by_key(|(made_ns, ..)| *made_ns);
        if let Some((made_ns, bus, frame)) = first
            && made_ns + TAIL_NS < end_ns
        {
            self.differs(Difference {
                at_ns: made_ns,
                bus,
                recorded: None,
                replayed: Some(frame),
            });
        }
    }

    fn differs(&mut self, difference: Difference) {
        self.difference.get_or_insert(difference);
    }
}

#[cfg(test)]
mod test {
    use super::*;

    fn frame(id: u16, data: &[u8]) -> Frame {
        Frame::classic(Id::Standard(id), data).unwrap()
    }

    #[test]
    fn frames_may_overtake_each_other_but_not_their_like() {
        let mut comparison = Comparison::default();
        comparison.made(0, 0, frame(0x300, &[1]));
        comparison.made(0, 0, frame(0x300, &[2]));
        comparison.made(0, 0, frame(0x200, &[3]));
        comparison.recorded(10, 0, &frame(0x200, &[3]));
        comparison.recorded(20, 0, &frame(0x300, &[1]));
        comparison.recorded(30, 0, &frame(0x300, &[2]));
        comparison.end(1_000_000_000);
        assert_eq!((comparison.same(), comparison.difference()), (3, None));

        comparison.made(40, 0, frame(0x300, &[1]));
        comparison.made(40, 0, frame(0x300, &[2]));
        comparison.recorded(50, 0, &frame(0x300, &[2]));
        let difference = comparison.difference().unwrap();
        assert_eq!(difference.at_ns, 50);
        assert_eq!(shown(difference.recorded.as_ref()), "300#02");
        assert_eq!(shown(difference.replayed.as_ref()), "300#01");
    }

    #[test]
    fn one_missing_of_many_alike_is_found_where_it_is_missing() {
        for missing in 0..10_u64 {
            let mut comparison = Comparison::default();
            for k in 0..10 {
                let now_ns = 2_000_000 * k;
                comparison.made(now_ns, 0, frame(0x080, &[]));
                if k != missing {
                    comparison.recorded(now_ns + 55_000, 0, &frame(0x080, &[]));
                }
            }
            let difference = comparison.difference();
            // nothing tells the last from one that was not yet on the wire
            assert_eq!(difference.is_some(), missing < 9, "{missing}");
            if let Some(difference) = difference {
                assert_eq!(difference.at_ns, 2_000_000 * missing);
                assert_eq!(difference.recorded, None);
            }
        }
    }

    #[test]
    fn a_frame_on_another_bus_or_of_no_record_differs_unless_the_record_ended_meanwhile() {
        let mut comparison = Comparison::default();
        comparison.made(0, 0, frame(0x200, &[]));
        comparison.recorded(10, 1, &frame(0x200, &[]));
        let difference = comparison.difference().unwrap();
        assert_eq!((difference.bus, difference.replayed), (1, None));
        assert_eq!(shown(None), "nothing");

        for (end_ns, lost) in [(TAIL_NS, false), (TAIL_NS + 1, true)] {
            let mut comparison = Comparison::default();
            comparison.made(0, 0, frame(0x200, &[]));
            comparison.end(end_ns);
            assert_eq!(comparison.difference().is_some(), lost);
        }
    }
}
