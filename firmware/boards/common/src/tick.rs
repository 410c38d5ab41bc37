//! All that a tick does, from the pins to the pins: guard, light, the watchdog's food, and what is to be remembered.

use crate::alive::{Alive, Token};
use crate::emergency::Emergency;
use crate::guard::{Category, Guard, Panel};
use crate::light::Light;
use crate::reset::{Record, WORDS};
use crate::rim::Call;
use crate::torque::Delays;
use embedded_hal::digital::{InputPin, OutputPin};
use protocol::message::NodeState;
use protocol::time::Micros;

/// The tick of a board with these pins.
#[derive(Debug)]
pub struct Tick<I, O> {
    guard: Guard,
    panel: Panel<I, O>,
    record: Record,
}

/// What follows from a tick and is not done by it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ticked {
    /// For the node.
    pub call: Option<Call>,
    /// The watchdog is to be fed now.
    pub feed: bool,
    /// To be remembered over the next reset, if it is not remembered already.
    pub remember: Option<[u32; WORDS]>,
}

impl<I: InputPin, O: OutputPin> Tick<I, O> {
    /// Latched, and without torque. `record`: what is remembered already.
    pub fn new(
        now: Micros,
        panel: Panel<I, O>,
        category: Category,
        delays: Delays,
        record: Record,
    ) -> Self {
        Self {
            guard: Guard::new(now, category, delays),
            panel,
            record,
        }
    }

    /// A tick. `state`: of the node, if there is one.
    pub fn run(&mut self, now: Micros, state: Option<NodeState>, alive: &mut Alive) -> Ticked {
        let is = self.guard.tick(now, self.panel.wires(), state);
        alive.tell(now, Token::Tick);
        let feed = alive.feed(now);
        let missing = alive.missing();
        self.panel
            .set(now, is.outputs, Light::of(state, missing, is.emergency));
        let record = Record {
            state: state.unwrap_or(NodeState::Boot),
            missing,
            ..self.record
        };
        let remember = (record != self.record).then(|| record.write());
        self.record = record;
        // an open contact concerns everybody; that nobody has reset yet, this robot alone
        let everybody = matches!(is.emergency, Emergency::Pressed | Emergency::Discrepant);
        Ticked {
            call: is.stop.map(|kind| Call { kind, everybody }),
            feed,
            remember,
        }
    }
}

#[cfg(test)]
mod test {
    use super::*;
    use crate::alive::Periods;
    use crate::reset::ResetCause;
    use crate::wire::Pin;
    use core::cell::Cell;
    use protocol::message::StopKind;

    const PERIODS: Periods = Periods {
        tokens: [1000, 3000, 4000],
        opens: 1500,
    };
    const DELAYS: Delays = Delays {
        opens_after: 10_000,
        closes_within: 50_000,
    };

    #[test]
    fn from_the_first_reset_to_the_emergency_stop_and_a_step_that_hangs() {
        let pins: [Cell<bool>; 6] = [const { Cell::new(false) }; 6];
        let [first, second, reset, torque, brake, light] =
            [0, 1, 2, 3, 4, 5].map(|k: usize| Pin(&pins[k]));
        let panel = Panel {
            first,
            second,
            reset,
            torque,
            brake,
            light,
        };
        let record = Record::begin(&[0; WORDS], ResetCause::PowerOn).now;
        let mut tick = Tick::new(Micros(0), panel, Category::Zero, DELAYS, record);
        let mut alive = Alive::new(Micros(0), PERIODS);
        let mut fed = 0;
        let mut remembered = record.write();
        let mut run = |from: u64, to: u64, state, runs: bool| {
            let mut last = None;
            for now in (from..to).step_by(500).map(Micros) {
                let ticked = tick.run(now, Some(state), &mut alive);
                fed += u32::from(ticked.feed);
                remembered = ticked.remember.unwrap_or(remembered);
                last = ticked.call;
                if runs {
                    alive.tell(now, Token::Step);
                    alive.tell(now, Token::Idle);
                }
            }
            (
                last,
                [torque.0.get(), brake.0.get()],
                fed,
                Record::read(&remembered).unwrap(),
            )
        };
        first.0.set(true);
        second.0.set(true);
        let call = |everybody| {
            Some(Call {
                kind: StopKind::TorqueOff,
                everybody,
            })
        };
        // nobody has reset: this robot alone, and nobody is told on the bus
        let (called, outputs, food, _) = run(500, 100_000, NodeState::Disabled, true);
        assert_eq!((called, outputs), (call(false), [false; 2]));
        // the window opens at 1.5 ms and the ticks are 0.5 ms apart: at most 66, and every 2 ms at least
        assert!((49..=66).contains(&food), "{food}");
        reset.0.set(true);
        let (called, outputs, _, _) = run(100_000, 200_000, NodeState::Holding, true);
        assert_eq!((called, outputs), (None, [true; 2]));
        first.0.set(false);
        let (called, outputs, before, record) = run(200_000, 201_000, NodeState::Moving, true);
        assert_eq!(
            (called, outputs, record.state),
            (call(true), [false; 2], NodeState::Moving)
        );
        // the step hangs: the food ends, and it is remembered whose token was missing
        let (_, _, food, record) = run(201_000, 300_000, NodeState::Moving, false);
        assert!(food <= before + 1);
        assert_eq!(record.missing, Some(Token::Step));
    }
}
