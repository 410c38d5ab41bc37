//! What stops a robot by wire, whatever its node does: the emergency stop, the brake, safe torque off, and the status
//! light. It runs in the tick, above everything else, and asks the node only for its state.

use crate::emergency::{Emergency, EmergencyStop, Wires};
use crate::light::Light;
use crate::torque::{Delays, Outputs, Permit, Torque};
use embedded_hal::digital::{InputPin, OutputPin};
use protocol::message::{NodeState, StopKind};
use protocol::time::Micros;

/// What an emergency stop does (IEC 60204-1).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Category {
    /// R3: torque off and brake at once.
    Zero,
    /// R2: the node brakes; when it stands, or behind this time (µs), the brake closes and torque goes off.
    One {
        /// µs.
        within: u32,
    },
}

/// What follows from a tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Guarded {
    /// The outputs from now on.
    pub outputs: Outputs,
    /// Whether one may move.
    pub emergency: Emergency,
    /// The node must be told to stop so, again and again.
    pub stop: Option<StopKind>,
}

/// The guard.
#[derive(Clone, Copy, Debug)]
pub struct Guard {
    category: Category,
    emergency: EmergencyStop,
    torque: Torque,
    /// Since when the emergency stop is not clear.
    since: Micros,
}

impl Guard {
    /// Latched, and without torque.
    #[must_use]
    pub fn new(now: Micros, category: Category, delays: Delays) -> Self {
        Self {
            category,
            emergency: EmergencyStop::default(),
            torque: Torque::new(now, delays),
            since: now,
        }
    }

    /// A tick. `state`: of the node, if there is one.
    pub fn tick(&mut self, now: Micros, wires: Wires, state: Option<NodeState>) -> Guarded {
        let was = self.emergency.state();
        let emergency = self.emergency.sample(now, wires);
        if was == Emergency::Clear && emergency != Emergency::Clear {
            self.since = now;
        }
        let asked = state.map_or(Permit::Locked, Permit::of);
        let (permit, at_once, stop) = match (emergency, self.category) {
            (Emergency::Clear, _) => (asked, false, None),
            (Emergency::Discrepant, _) | (_, Category::Zero) => {
                (Permit::Locked, true, Some(StopKind::TorqueOff))
            }
            (Emergency::Pressed | Emergency::AwaitingReset, Category::One { within }) => {
                let stands = asked != Permit::Open;
                let in_time = now.since(self.since).0 < u64::from(within);
                let permit = if stands || !in_time {
                    Permit::Locked
                } else {
                    // what was open stays open while the node brakes; nothing opens any more
                    match self.torque.outputs() {
                        Outputs { brake: true, .. } => Permit::Open,
                        Outputs { torque: true, .. } => Permit::Braked,
                        Outputs { .. } => Permit::Locked,
                    }
                };
                (permit, false, Some(StopKind::Quick))
            }
        };
        Guarded {
            outputs: self.torque.step(now, permit, at_once),
            emergency,
            stop,
        }
    }
}

/// The pins of it: three inputs of one type, three outputs of another.
#[derive(Debug)]
pub struct Panel<I, O> {
    /// High while the first contact of the emergency stop is closed.
    pub first: I,
    /// High while the second contact is closed.
    pub second: I,
    /// High while the reset button is pressed.
    pub reset: I,
    /// High: torque is allowed.
    pub torque: O,
    /// High: the brake opens.
    pub brake: O,
    /// High: the status light is on.
    pub light: O,
}

impl<I: InputPin, O: OutputPin> Panel<I, O> {
    /// What the wires say. A pin that cannot be read is an open contact, and no reset.
    pub fn wires(&mut self) -> Wires {
        Wires {
            first_closed: self.first.is_high().unwrap_or(false),
            second_closed: self.second.is_high().unwrap_or(false),
            reset: self.reset.is_high().unwrap_or(false),
        }
    }

    /// Set the outputs: what goes off goes before what comes on. A pin that cannot be set is the watchdog's affair:
    /// it is a fault of the processor.
    pub fn set(&mut self, now: Micros, outputs: Outputs, light: Light) {
        let _ = self.brake.set_state(outputs.brake.into());
        let _ = self.torque.set_state(outputs.torque.into());
        let _ = self.light.set_state(light.pattern().lit(now).into());
    }
}

#[cfg(test)]
mod test {
    use super::*;
    use crate::wire::Pin;
    use core::cell::Cell;

    const DELAYS: Delays = Delays {
        opens_after: 10_000,
        closes_within: 50_000,
    };
    const ONE: Category = Category::One { within: 400_000 };
    const CLOSED: Wires = Wires {
        first_closed: true,
        second_closed: true,
        reset: false,
    };
    const OPEN: Wires = Wires {
        first_closed: false,
        second_closed: false,
        reset: false,
    };

    struct Bench {
        guard: Guard,
        now: u64,
    }

    impl Bench {
        /// Reset, and the brake open.
        fn moving(category: Category) -> Self {
            let mut bench = Self {
                guard: Guard::new(Micros(0), category, DELAYS),
                now: 0,
            };
            let _ = bench.ticks(4, CLOSED, NodeState::Moving);
            let _ = bench.ticks(
                4,
                Wires {
                    reset: true,
                    ..CLOSED
                },
                NodeState::Moving,
            );
            let is = bench.ticks(40, CLOSED, NodeState::Moving);
            assert_eq!((is.emergency, is.stop), (Emergency::Clear, None));
            assert!(is.outputs.torque && is.outputs.brake);
            bench
        }

        fn ticks(&mut self, count: u64, wires: Wires, state: NodeState) -> Guarded {
            let mut last = None;
            for _ in 0..count {
                self.now += 500;
                last = Some(self.guard.tick(Micros(self.now), wires, Some(state)));
            }
            last.unwrap()
        }
    }

    #[test]
    fn nothing_has_torque_before_the_first_reset() {
        let mut guard = Guard::new(Micros(0), ONE, DELAYS);
        for k in 0..1000 {
            let is = guard.tick(Micros(500 * k), CLOSED, Some(NodeState::Moving));
            assert_eq!(is.outputs, Outputs::default());
            assert_eq!(is.stop, Some(StopKind::Quick));
        }
    }

    #[test]
    fn category_0_is_torque_off_within_two_ticks() {
        let mut bench = Bench::moving(Category::Zero);
        let is = bench.ticks(2, OPEN, NodeState::Moving);
        assert_eq!(is.outputs, Outputs::default());
        assert_eq!(is.stop, Some(StopKind::TorqueOff));
    }

    #[test]
    fn category_1_lets_the_node_brake_and_locks_when_it_stands() {
        let mut bench = Bench::moving(ONE);
        let is = bench.ticks(2, OPEN, NodeState::Moving);
        assert_eq!(is.stop, Some(StopKind::Quick));
        let is = bench.ticks(200, OPEN, NodeState::Stopping);
        assert!(is.outputs.brake, "100 ms: it brakes still");
        let is = bench.ticks(1, OPEN, NodeState::Faulted);
        assert_eq!(
            is.outputs,
            Outputs {
                torque: true,
                brake: false
            }
        );
        // 50 ms for the brake to close
        assert!(bench.ticks(99, OPEN, NodeState::Faulted).outputs.torque);
        assert_eq!(
            bench.ticks(1, OPEN, NodeState::Faulted).outputs,
            Outputs::default()
        );
    }

    #[test]
    fn category_1_does_not_wait_for_a_node_that_does_not_stop() {
        let mut bench = Bench::moving(ONE);
        // noticed with the second tick; 400 ms from there on are 800 ticks
        assert!(bench.ticks(2 + 799, OPEN, NodeState::Moving).outputs.brake);
        assert!(!bench.ticks(1, OPEN, NodeState::Moving).outputs.brake);
        assert_eq!(
            bench.ticks(100, OPEN, NodeState::Moving).outputs,
            Outputs::default()
        );
    }

    #[test]
    fn a_node_that_enables_itself_while_pressed_gets_nothing() {
        let mut bench = Bench::moving(ONE);
        let _ = bench.ticks(400, OPEN, NodeState::Faulted);
        for state in [NodeState::Enabling, NodeState::Holding, NodeState::Moving] {
            assert_eq!(bench.ticks(300, OPEN, state).outputs, Outputs::default());
            assert_eq!(bench.ticks(300, CLOSED, state).outputs, Outputs::default());
        }
    }

    #[test]
    fn a_discrepancy_is_torque_off_in_either_category() {
        let mut bench = Bench::moving(ONE);
        let half = Wires {
            second_closed: true,
            ..OPEN
        };
        let is = bench.ticks(30, half, NodeState::Stopping);
        assert_eq!(is.emergency, Emergency::Discrepant);
        assert_eq!(
            (is.outputs, is.stop),
            (Outputs::default(), Some(StopKind::TorqueOff))
        );
    }

    #[test]
    fn without_a_node_all_is_locked() {
        let mut bench = Bench::moving(ONE);
        let mut is = bench.guard.tick(Micros(bench.now), CLOSED, None);
        for k in 0..101 {
            is = bench.guard.tick(Micros(bench.now + 500 * k), CLOSED, None);
        }
        assert_eq!(is.outputs, Outputs::default());
    }

    #[test]
    fn each_pin_is_the_one_it_is_named() {
        let cells: [Cell<bool>; 6] = [const { Cell::new(false) }; 6];
        let pins = cells.each_ref().map(Pin);
        let [first, second, reset, torque, brake, light] = pins;
        let mut panel = Panel {
            first,
            second,
            reset,
            torque,
            brake,
            light,
        };
        for (k, pin) in pins.iter().enumerate().take(3) {
            pin.0.set(true);
            let Wires {
                first_closed,
                second_closed,
                reset,
            } = panel.wires();
            let read = [first_closed, second_closed, reset];
            assert_eq!(read, core::array::from_fn(|n| n == k));
            pin.0.set(false);
        }
        let dark = Light::Node(NodeState::Disabled);
        for (torque, brake) in [(true, false), (true, true), (false, false)] {
            // 1 s: the single flash of this pattern is over
            panel.set(Micros(1_000_000), Outputs { torque, brake }, dark);
            assert_eq!(
                [3, 4, 5].map(|k: usize| pins[k].0.get()),
                [torque, brake, false]
            );
        }
        panel.set(Micros(0), Outputs::default(), dark);
        assert!(pins[5].0.get());
    }
}
