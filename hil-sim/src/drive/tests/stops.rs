//! Option codes: how an axis at 20 rad/s is stopped, and what comes after.

use protocol::canopen::axis::Target;
use protocol::canopen::cia402::{Goal, PowerState};
use protocol::canopen::emcy::ErrorCode;
use protocol::canopen::node::frame;
use protocol::canopen::sdo::{Abort, Address, Outcome};

use super::bench::{Bench, axis_setup};
use super::safety::moving;
use crate::drive::DriveFault;
use crate::drive::parameters::MS;

/// Time from 20 rad/s to below 1 rad/s, ms, to a millisecond; at most a second.
fn standstill_ms(bench: &mut Bench) -> u64 {
    for ms in 0..1000 {
        if bench.velocity().abs() < 1.0 {
            return ms;
        }
        bench.wait(1);
    }
    panic!("still {} rad/s", bench.velocity());
}

/// A quick stop with option `code` and greatest torque `per_mille`: how long it takes, ms, and the least torque of every
/// fourth of a millisecond, ‰.
fn quick_stop(code: i16, per_mille: u16) -> (Bench, u64, i32) {
    let mut bench = moving();
    bench.write(0x605A, &code.to_le_bytes());
    bench.write(0x6072, &per_mille.to_le_bytes());
    bench.write(0x1006, &0_u32.to_le_bytes());
    let [a, b, c, d] = bench.actual.position.to_le_bytes();
    bench.send(&frame(0x201, [0x02, 0, a, b, c, d]));
    bench.send(&frame(0x80, []));
    assert_eq!(bench.state(), PowerState::QuickStopActive);
    let (mut least, mut quarters) = (0, 0);
    while bench.velocity().abs() >= 1.0 {
        assert!(quarters < 4000, "still {} rad/s", bench.velocity());
        bench.pass_ns(MS / 4);
        quarters += 1;
        let [low, high, ..] = bench.read(0x6077, 0).to_le_bytes();
        let torque = i32::from(i16::from_le_bytes([low, high]));
        least = if torque < least { torque } else { least };
    }
    (bench, quarters / 4, least)
}

#[test]
fn a_stop_at_the_current_limit_uses_the_greatest_torque_and_no_more() {
    let mut last = u64::MAX;
    for per_mille in [150_u16, 300, 600] {
        let (mut bench, ms, torque) = quick_stop(3, per_mille);
        let most = i32::from(per_mille);
        // the limit cuts what the loop asks for; a few of thousand are the current loop's
        assert!(
            (-most - 5..=5 - most * 9 / 10).contains(&torque),
            "{per_mille}: {torque}"
        );
        // more torque, less time: at 300 ‰ 19 rad/s take 17 ms, and the last bit is regulated
        assert!(ms < last && (5..100).contains(&ms), "{per_mille}: {ms} ms");
        last = ms;
        bench.wait(100);
        assert_eq!(bench.state(), PowerState::SwitchOnDisabled);
        assert!(bench.robot.plant(0).unwrap().is_braked());
    }
}

#[test]
fn a_stop_at_the_voltage_limit_does_not_ask_for_the_greatest_torque() {
    let (_, limited, _) = quick_stop(3, 300);
    let (_, free, torque) = quick_stop(4, 300);
    assert!(free + 5 < limited, "{free} ms, {limited} ms");
    // beyond 6072, within the 4000 ‰ of the power stage
    assert!((-4005..-900).contains(&torque), "{torque}");
}

#[test]
fn codes_5_to_8_stand_with_torque_and_let_it_go_on() {
    for code in [5, 6, 7, 8] {
        let (mut bench, ..) = quick_stop(code, 4000);
        bench.wait(300);
        assert_eq!(bench.state(), PowerState::QuickStopActive, "{code}");
        assert!(!bench.robot.plant(0).unwrap().is_braked(), "{code}");
        let stood = bench.motor_rad();
        bench.wait(300);
        // an increment
        assert!((bench.motor_rad() - stood).abs() < 1.6e-3, "{code}");
        bench.talks = false;
        bench.cycles(2);
        let [a, b, c, d] = bench.actual.position.to_le_bytes();
        bench.target = Target::Position(bench.actual.position);
        bench.send(&frame(0x201, [0x0F, 0, a, b, c, d]));
        bench.cycle();
        assert_eq!(bench.state(), PowerState::OperationEnabled, "{code}");
        assert!((bench.motor_rad() - stood).abs() < 5e-3, "{code}: it jumps");
    }
}

#[test]
fn every_halt_option_stops_the_axis_and_keeps_it_enabled() {
    // 19 rad/s at 200 and 500 rad/s², and at all the torque there is
    for (code, range) in [(1_i16, 85..=110), (2, 33..=48), (3, 2..=20), (4, 2..=20)] {
        let mut bench = moving();
        assert!(matches!(
            bench.write(0x605D, &code.to_le_bytes()),
            Outcome::Downloaded(_)
        ));
        bench.write(0x1006, &0_u32.to_le_bytes());
        let [a, b, c, d] = bench.actual.position.to_le_bytes();
        bench.send(&frame(0x201, [0x0F, 1, a, b, c, d]));
        bench.send(&frame(0x80, []));
        let ms = standstill_ms(&mut bench);
        assert!(range.contains(&ms), "{code}: {ms} ms");
        bench.wait(100);
        assert_eq!(bench.state(), PowerState::OperationEnabled);
        assert!(!bench.robot.plant(0).unwrap().is_braked());
    }
}

#[test]
fn every_fault_reaction_ends_in_fault_with_the_brake_closed() {
    for (code, range) in [
        (0_i16, 1..=1000),
        (1, 85..=110),
        (2, 33..=48),
        (3, 2..=20),
        (4, 2..=20),
    ] {
        let mut bench = moving();
        bench.write(0x605E, &code.to_le_bytes());
        bench.write(0x1006, &0_u32.to_le_bytes());
        bench
            .robot
            .inject(0, Some(DriveFault::Trip(ErrorCode::OVER_TEMPERATURE)));
        bench.wait(1);
        let state = if code == 0 {
            PowerState::Fault
        } else {
            PowerState::FaultReactionActive
        };
        assert_eq!(bench.state(), state, "{code}");
        let ms = standstill_ms(&mut bench);
        assert!(range.contains(&ms), "{code}: {ms} ms");
        bench.wait(200);
        assert_eq!(bench.state(), PowerState::Fault);
        assert!(bench.robot.plant(0).unwrap().is_braked());
    }
}

#[test]
fn a_ramp_that_never_ends_is_given_up() {
    use crate::plant::axis::EncoderFault;
    let mut bench = moving();
    bench.write(0x6065, &u32::MAX.to_le_bytes());
    // tells a speed for ever
    bench
        .robot
        .inject(0, Some(DriveFault::Encoder(EncoderFault::Drifting)));
    bench.master.set_goal(Goal::QuickStop);
    bench.cycles(5);
    assert!(matches!(
        bench.state(),
        PowerState::QuickStopActive | PowerState::SwitchOnDisabled | PowerState::Fault
    ));
    // 20 rad/s at 500 rad/s², half as long again, and 200 ms
    bench.wait((60 + 200) + 40);
    assert!(bench.robot.plant(0).unwrap().is_braked() && bench.now_ns > MS);
}

#[test]
fn codes_that_no_standard_has_are_refused() {
    let mut bench = Bench::new(&axis_setup(0, 10.0));
    bench.wait(200);
    for (index, code, abort) in [
        (0x605A, 9_i16, Abort::TooHigh),
        (0x605A, -1, Abort::TooLow),
        (0x605B, 2, Abort::TooHigh),
        (0x605C, 2, Abort::TooHigh),
        (0x605D, 0, Abort::TooLow),
        (0x605D, 5, Abort::TooHigh),
        (0x605E, 5, Abort::TooHigh),
        (0x6007, 4, Abort::TooHigh),
    ] {
        let refused = Outcome::Refused(Address::new(index, 0), abort);
        assert_eq!(
            bench.write(index, &code.to_le_bytes()),
            refused,
            "{index:x} {code}"
        );
    }
}
