//! Touch probes 1 and 2: latch the position at an edge of a digital input, a switch, or the encoder's zero impulse.
//!
//! Positions are those at the end of the substep in which an edge is seen, 0.25 ms at most; the zero impulse has its own.
//! Time stamps are always those of the end of the substep, on the drive's clock, which counts from power-up.

use protocol::canopen::cia402::probe;

use super::{SimDrive, slots};

/// The levels an edge of which can be a trigger, and the zero impulse.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Signals {
    /// Probe inputs 1 and 2, home switch, negative and positive limit switch.
    levels: [bool; 5],
}

/// What triggers a probe.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Source {
    /// The zero impulse.
    Index,
    /// One of the [`Signals`].
    Level(usize),
}

impl Source {
    /// Of the function byte of probe `number` (0 or 1), where bits 2 and 3 may leave it to object 60D0.
    fn of(function: u16, number: usize, object_60d0: i32) -> Option<Self> {
        Some(match function & probe::SOURCE {
            0 => Self::Level(number),
            probe::ZERO_IMPULSE => Self::Index,
            probe::BY_OBJECT => match object_60d0 {
                probe::source::INPUT_1 => Self::Level(0),
                probe::source::INPUT_2 => Self::Level(1),
                probe::source::ZERO_IMPULSE => Self::Index,
                probe::source::HOME => Self::Level(2),
                probe::source::NEGATIVE_LIMIT => Self::Level(3),
                probe::source::POSITIVE_LIMIT => Self::Level(4),
                _ => return None,
            },
            _ => return None,
        })
    }
}

/// One probe: its function byte, what was latched, in encoder counts and ns modulo 2³², and how many edges were.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Probe {
    function: u16,
    /// At the positive and the negative edge.
    latched: [Option<i64>; 2],
    stamps: [u32; 2],
    edges: [u16; 2],
}

impl Probe {
    /// Takes a new function byte: switching the probe on forgets what was latched.
    const fn set_function(&mut self, function: u16) {
        let on = function & probe::ENABLE != 0;
        let was_on = self.function & probe::ENABLE != 0;
        if !on || !was_on {
            self.latched = [None; 2];
            self.stamps = [0; 2];
            self.edges = [0; 2];
        }
        self.function = function;
    }

    /// An edge, 0 positive or 1 negative, of its source at `count`, stamped so.
    fn on_edge(&mut self, edge: usize, count: i64, stamp: u32) {
        let wanted = [probe::POSITIVE_EDGE, probe::NEGATIVE_EDGE][edge];
        if self.function & probe::ENABLE == 0 || self.function & wanted == 0 {
            return;
        }
        self.edges[edge] = self.edges[edge].wrapping_add(1);
        if self.function & probe::CONTINUOUS != 0 || self.latched[edge].is_none() {
            self.latched[edge] = Some(count);
            self.stamps[edge] = stamp;
        }
    }

    fn status(&self) -> u16 {
        let bit = |on: bool, bit| if on { bit } else { 0 };
        bit(self.function & probe::ENABLE != 0, probe::ENABLED)
            | bit(self.latched[0].is_some(), probe::POSITIVE_STORED)
            | bit(self.latched[1].is_some(), probe::NEGATIVE_STORED)
    }
}

/// Both probes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Probes {
    each: [Probe; 2],
    before: Signals,
    /// The drive's clock, ns modulo 2³².
    clock: u32,
}

impl Probes {
    /// Takes object 60B8: a byte for each.
    pub(super) fn set_function(&mut self, function: u16) {
        let [first, second] = function.to_le_bytes();
        self.each[0].set_function(u16::from(first));
        self.each[1].set_function(u16::from(second));
    }

    /// The signals at the end of a substep, at `count`, with a zero impulse at its own; did the status change?
    fn step(&mut self, now: Signals, count: i64, index: Option<i64>, sources: [i32; 2]) -> bool {
        let before = self.status();
        for (number, one) in self.each.iter_mut().enumerate() {
            match Source::of(one.function, number, sources[number]) {
                Some(Source::Index) => {
                    // the ideal pulse has no width: both edges lie at the same count
                    if let Some(count) = index {
                        one.on_edge(0, count, self.clock);
                        one.on_edge(1, count, self.clock);
                    }
                }
                Some(Source::Level(level)) => {
                    match (self.before.levels[level], now.levels[level]) {
                        (false, true) => one.on_edge(0, count, self.clock),
                        (true, false) => one.on_edge(1, count, self.clock),
                        (false, false) | (true, true) => {}
                    }
                }
                None => {}
            }
        }
        self.before = now;
        self.status() != before
    }

    /// Object 60B9.
    pub(super) fn status(&self) -> u16 {
        self.each[0].status() | self.each[1].status() << 8
    }
}

impl SimDrive {
    /// Object 60B8 may have changed.
    pub(super) fn on_probe_function(&mut self) {
        let [low, high, ..] = self.od.get(slots::TOUCH_PROBE).to_le_bytes();
        let before = self.probes.status();
        self.probes.set_function(u16::from_le_bytes([low, high]));
        if self.probes.status() != before {
            self.poll_at_ns = 0;
        }
    }

    /// The probes in one substep; did their status change?
    pub(super) fn probe(&mut self) -> bool {
        let signals = Signals {
            levels: [
                self.external & 1 != 0,
                self.external & 2 != 0,
                self.sensed.home,
                self.sensed.negative_limit,
                self.sensed.positive_limit,
            ],
        };
        let on = |probe: &Probe| probe.function & probe::ENABLE != 0;
        if !self.probes.each.iter().any(on) {
            self.probes.before = signals;
            return false;
        }
        let [a, b, c, d, ..] = self.now_ns.to_le_bytes();
        self.probes.clock = u32::from_le_bytes([a, b, c, d]);
        let sources =
            [slots::PROBE_SOURCE_1, slots::PROBE_SOURCE_2].map(|slot| self.od.signed(slot));
        self.probes
            .step(signals, self.sensed.count, self.sensed.index, sources)
    }

    /// Writes what the probes latched into the dictionary.
    pub(super) fn publish_probes(&mut self) {
        self.od
            .set(slots::TOUCH_PROBE_STATUS, u32::from(self.probes.status()));
        let places = [
            [slots::TOUCH_PROBE_POSITIVE, slots::TOUCH_PROBE_NEGATIVE],
            [slots::TOUCH_PROBE_2_POSITIVE, slots::TOUCH_PROBE_2_NEGATIVE],
        ];
        let stamps = [
            [slots::PROBE_1_POSITIVE_TIME, slots::PROBE_1_NEGATIVE_TIME],
            [slots::PROBE_2_POSITIVE_TIME, slots::PROBE_2_NEGATIVE_TIME],
        ];
        let counters = [
            [slots::PROBE_1_POSITIVE_EDGES, slots::PROBE_1_NEGATIVE_EDGES],
            [slots::PROBE_2_POSITIVE_EDGES, slots::PROBE_2_NEGATIVE_EDGES],
        ];
        let slots = places.into_iter().zip(stamps).zip(counters);
        for (one, ((places, stamps), counters)) in self.probes.each.iter().zip(slots) {
            for edge in 0..2 {
                let units = one.latched[edge].map_or(0, |count| self.scale.units(count));
                self.od
                    .set_signed(places[edge], protocol::units::modulo(units));
                self.od.set(stamps[edge], one.stamps[edge]);
                self.od.set(counters[edge], u32::from(one.edges[edge]));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at_index(probes: &mut Probes, count: i64) -> bool {
        probes.step(Signals::default(), 0, Some(count), [1, 2])
    }

    fn latched(probes: &Probes) -> [Option<i64>; 2] {
        probes.each[0].latched
    }

    #[test]
    fn one_shot_keeps_the_first_index() {
        let mut p = Probes::default();
        assert!(!at_index(&mut p, 1), "off");
        p.set_function(probe::INDEX_ONCE);
        assert_eq!(p.status(), probe::ENABLED);
        assert!(at_index(&mut p, 10));
        assert!(!at_index(&mut p, 20));
        assert_eq!(latched(&p), [Some(10), None]);
        p.set_function(0);
        assert_eq!((p.status(), latched(&p)), (0, [None, None]));
    }

    #[test]
    fn continuous_takes_every_index_and_both_edges() {
        let mut p = Probes::default();
        p.set_function(probe::INDEX_ONCE | probe::CONTINUOUS | probe::NEGATIVE_EDGE);
        at_index(&mut p, 10);
        at_index(&mut p, 20);
        assert_eq!(latched(&p), [Some(20), Some(20)]);
        assert_eq!((p.status(), p.each[0].edges), (7, [2, 2]));
    }

    #[test]
    fn without_the_zero_impulse_as_source_it_latches_nothing() {
        let mut p = Probes::default();
        p.set_function(probe::ENABLE | probe::POSITIVE_EDGE);
        assert!(!at_index(&mut p, 10));
    }

    #[test]
    fn each_source_has_a_number_and_others_trigger_nothing() {
        let by_object = probe::ENABLE | probe::BY_OBJECT | probe::POSITIVE_EDGE;
        for (number, level) in [(1, 0), (2, 1), (-1, 2), (-2, 3), (-3, 4)] {
            assert_eq!(Source::of(by_object, 0, number), Some(Source::Level(level)));
        }
        assert_eq!(Source::of(by_object, 1, 5), Some(Source::Index));
        assert_eq!(Source::of(by_object, 1, 3), None);
        assert_eq!(Source::of(probe::SOURCE, 0, 1), None, "reserved");
    }
}
