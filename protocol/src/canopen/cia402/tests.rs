use super::*;

#[test]
fn words_of_every_state_and_command() {
    for state in PowerState::ALL {
        assert_eq!(Statusword::of(state).state(), Some(state));
        let noise = Statusword::VOLTAGE | Statusword::REMOTE | Statusword::FOLLOWS | 1 << 7;
        assert_eq!(
            Statusword(Statusword::of(state).0 | noise).state(),
            Some(state)
        );
    }
    for command in Command::ALL {
        assert_eq!(Controlword::of(command).command(), command);
    }
}

#[test]
fn golden_words() {
    let decode = |word: u16| Statusword(word).state();
    assert_eq!(decode(0x0250), Some(PowerState::SwitchOnDisabled));
    assert_eq!(decode(0x0231), Some(PowerState::ReadyToSwitchOn));
    assert_eq!(decode(0x0233), Some(PowerState::SwitchedOn));
    assert_eq!(decode(0x1637), Some(PowerState::OperationEnabled));
    assert_eq!(decode(0x0217), Some(PowerState::QuickStopActive));
    assert_eq!(decode(0x0218), Some(PowerState::Fault));
    let commands = [
        (0x06, Command::Shutdown),
        (0x0E, Command::Shutdown),
        (0x07, Command::SwitchOn),
    ];
    for (word, command) in commands {
        assert_eq!(Controlword(word).command(), command);
    }
    for word in [0x00, 0x01, 0x04, 0x05, 0x08, 0x0D] {
        assert_eq!(
            Controlword(word).command(),
            Command::DisableVoltage,
            "{word:#x}"
        );
    }
    for word in [0x02, 0x03, 0x0A, 0x0B] {
        assert_eq!(Controlword(word).command(), Command::QuickStop, "{word:#x}");
    }
}

#[test]
fn every_controlword_and_statusword_decodes_to_something() {
    for word in 0..=u16::MAX {
        let _ = Controlword(word).command();
        let _ = Statusword(word).state();
    }
}

/// The whole transition table with the default options: rows are states, columns events.
#[test]
fn every_state_and_event() {
    use Action::{Coast, Energise, None, Resume, SwitchOff};
    use Power::{Disabled, Enabled, Fault, FaultReaction, NotReady, Ready, SwitchedOn};
    let options = Options::default();
    let quick = Action::Ramp(Ramp::QuickStop);
    let slow = Action::Ramp(Ramp::SlowDown);
    let leave = Power::Leaving { shutdown: false };
    let down = Power::Leaving { shutdown: true };
    let stopping = Power::QuickStop { stand: false };
    let standing = Power::QuickStop { stand: true };
    let to_fault = (FaultReaction, quick);
    let stay = |power| (power, None);
    // Booted, Shutdown, SwitchOn, Enable, DisableVoltage, QuickStop, FaultReset, Fault, Standstill
    #[rustfmt::skip]
    let table = [
        (NotReady, [(Disabled, None), stay(NotReady), stay(NotReady), stay(NotReady), stay(NotReady),
            stay(NotReady), stay(NotReady), (Fault, None), stay(NotReady)]),
        (Disabled, [stay(Disabled), (Ready, None), stay(Disabled), stay(Disabled), stay(Disabled),
            stay(Disabled), stay(Disabled), (Fault, None), stay(Disabled)]),
        (Ready, [stay(Ready), stay(Ready), (SwitchedOn, None), (SwitchedOn, None), (Disabled, None),
            (Disabled, None), stay(Ready), (Fault, None), stay(Ready)]),
        (SwitchedOn, [stay(SwitchedOn), (Ready, None), stay(SwitchedOn), (Enabled, Energise),
            (Disabled, None), (Disabled, None), stay(SwitchedOn), (Fault, None), stay(SwitchedOn)]),
        (Enabled, [stay(Enabled), (Ready, Coast), (leave, slow), stay(Enabled), (Disabled, Coast),
            (stopping, quick), stay(Enabled), to_fault, stay(Enabled)]),
        (leave, [stay(leave), stay(leave), stay(leave), (Enabled, Resume), (Disabled, Coast),
            (stopping, quick), stay(leave), to_fault, (SwitchedOn, SwitchOff)]),
        (down, [stay(down), stay(down), stay(down), (Enabled, Resume), (Disabled, Coast),
            (stopping, quick), stay(down), to_fault, (Ready, SwitchOff)]),
        (stopping, [stay(stopping), stay(stopping), stay(stopping), stay(stopping), (Disabled, Coast),
            stay(stopping), stay(stopping), to_fault, (Disabled, SwitchOff)]),
        (standing, [stay(standing), stay(standing), stay(standing), (Enabled, Resume),
            (Disabled, Coast), stay(standing), stay(standing), to_fault, stay(standing)]),
        (FaultReaction, [stay(FaultReaction); 7].into_iter()
            .chain([stay(FaultReaction), (Fault, SwitchOff)]).collect_9()),
        (Fault, [stay(Fault), stay(Fault), stay(Fault), stay(Fault), stay(Fault), stay(Fault),
            (Disabled, None), stay(Fault), stay(Fault)]),
    ];
    assert_eq!(table.len(), Power::ALL.len());
    for ((power, row), expected) in table.into_iter().zip(Power::ALL) {
        assert_eq!(power, expected);
        for (event, outcome) in Event::ALL.into_iter().zip(row) {
            assert_eq!(power.on(event, options), outcome, "{power:?} on {event:?}");
        }
    }
}

/// Nine transitions of one row.
trait Nine<T> {
    fn collect_9(self) -> [T; 9];
}

impl<T: Copy, I: Iterator<Item = T>> Nine<T> for I {
    fn collect_9(mut self) -> [T; 9] {
        core::array::from_fn(|_| self.next().unwrap())
    }
}

#[test]
fn option_codes_choose_the_stop() {
    let stop = |code| Options::quick_stop(code);
    assert_eq!(stop(0), Some(Stop::Coast));
    assert_eq!(stop(2), Some(Stop::ThenOff(Ramp::QuickStop)));
    assert_eq!(stop(5), Some(Stop::ThenStand(Ramp::SlowDown)));
    assert_eq!(stop(3), Some(Stop::ThenOff(Ramp::CurrentLimit)));
    assert_eq!(stop(8), Some(Stop::ThenStand(Ramp::VoltageLimit)));
    assert_eq!(stop(9), None);
    assert_eq!(
        (stop(-1), Options::off(2), Options::fault(5)),
        (None, None, None)
    );
    assert_eq!(Options::from_codes(2, 0, 1, 2), Some(Options::default()));
    assert_eq!(Options::from_codes(2, 0, 9, 2), None);
    let coast = Options::from_codes(0, 1, 0, 0).unwrap();
    let on = |command| Power::Enabled.on(Event::Command(command), coast);
    assert_eq!(on(Command::QuickStop), (Power::Disabled, Action::Coast));
    assert_eq!(on(Command::SwitchOn), (Power::SwitchedOn, Action::Coast));
    let ramp = Action::Ramp(Ramp::SlowDown);
    assert_eq!(
        on(Command::Shutdown),
        (Power::Leaving { shutdown: true }, ramp)
    );
    assert_eq!(
        Power::Enabled.on(Event::Fault, coast),
        (Power::Fault, Action::Coast)
    );
    assert_eq!(
        AbortConnection::from_code(3),
        Some(AbortConnection::QuickStop)
    );
    assert_eq!(AbortConnection::from_code(4), None);
    assert_eq!(Halt::from_code(2), Some(Halt(Ramp::QuickStop)));
    assert_eq!(Halt::from_code(3), Some(Halt(Ramp::CurrentLimit)));
    assert_eq!((Halt::from_code(0), Halt::from_code(5)), (None, None));
    let voltage = Stop::ThenOff(Ramp::VoltageLimit);
    assert_eq!(Options::fault(4), Some(voltage));
}

#[test]
fn the_master_leads_the_slave_to_every_goal_from_every_state() {
    for goal in Goal::ALL {
        for start in Power::ALL {
            let mut master = Master::default();
            master.set_goal(goal);
            master.reset_fault();
            let mut power = start;
            let mut before = Controlword::default();
            for _ in 0..8 {
                let word = master.next(Statusword::of(power.state()));
                let options = Options::default();
                if word.rises(before, Controlword::FAULT_RESET) {
                    power = power.on(Event::FaultReset, options).0;
                }
                before = word;
                for event in [
                    Event::Booted,
                    Event::Command(word.command()),
                    Event::Standstill,
                ] {
                    power = power.on(event, options).0;
                }
            }
            let reached = goal.reached(power.state());
            // A quick stop that stands is left only through "disabled".
            let stuck = start == Power::QuickStop { stand: true } && goal != Goal::Disabled;
            assert!(reached || stuck, "{goal:?} from {start:?}: {power:?}");
        }
    }
}

#[test]
fn a_fault_is_not_reset_without_a_request_and_by_one_edge_only() {
    let fault = Statusword::of(PowerState::Fault);
    let mut master = Master::default();
    master.set_goal(Goal::Enabled);
    let high = |word: Controlword| word.has(Controlword::FAULT_RESET);
    assert!((0..20).all(|_| !high(master.next(fault))));
    master.reset_fault();
    let words: [bool; 20] = core::array::from_fn(|_| high(master.next(fault)));
    assert!(!words[0], "bit 7 is low before it rises");
    assert_eq!(
        words.windows(2).filter(|pair| !pair[0] && pair[1]).count(),
        1
    );
    assert!(!words[19], "and falls again although the fault stays");
}

#[test]
fn modes_and_methods_keep_their_codes() {
    for mode in Mode::ALL {
        assert_eq!(Mode::from_code(mode.code()), Some(mode));
    }
    for method in HomingMethod::ALL {
        assert_eq!(HomingMethod::from_code(method.code()), Some(method));
    }
    assert_eq!(Mode::from_code(2), None);
    assert_eq!(HomingMethod::from_code(3), None);
    // bit n of 6502 is mode n + 1
    let bits = Mode::ALL.into_iter().filter(|mode| *mode != Mode::None);
    let bits = bits.fold(0_u32, |bits, mode| bits | 1 << (mode.code() - 1));
    assert_eq!((SUPPORTED_MODES, SUPPORTED_MODES), (0x3A5, bits));
    let cyclic = Mode::ALL.map(Mode::is_cyclic);
    assert_eq!(cyclic, [false, false, false, false, true, true, true]);
}
