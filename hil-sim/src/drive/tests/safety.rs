use protocol::canopen::axis::Target;
use protocol::canopen::cia402::{Command, Controlword, Goal, Mode, PowerState, Statusword};
use protocol::canopen::emcy::ErrorCode;
use protocol::canopen::nmt::{self, State};
use protocol::canopen::node::{NodeId, frame};

use super::bench::{Bench, axis_setup, units};
use crate::drive::DriveFault;
use crate::plant::axis::EncoderFault;

/// A bench that moves at 20 rad/s in csp.
pub(super) fn moving() -> Bench {
    let mut bench = Bench::new(&axis_setup(0, 10.0));
    bench.enable(Mode::Csp);
    run(&mut bench, 100);
    assert!(
        (bench.velocity() - 20.0).abs() < 0.5,
        "{}",
        bench.velocity()
    );
    bench.log.clear();
    bench
}

/// Goes on at 20 rad/s from the last target.
pub(super) fn run(bench: &mut Bench, cycles: u32) {
    for _ in 0..cycles {
        if let Target::Position(position) = bench.target {
            bench.target = Target::Position(position + units(0.04));
        }
        bench.cycle();
    }
}

/// Quick stop at 500 rad/s² from 20 rad/s is 0.4 rad; with it goes the way of 7 ms until the
/// drive notices (0.14 rad).
fn assert_stopped_within(bench: &Bench, from_rad: f64, most_rad: f64) {
    let way = bench.motor_rad() - from_rad;
    assert!(way > 0.1 && way < most_rad, "{way} rad");
    assert!(bench.velocity().abs() < 1e-9);
    assert!(bench.robot.plant(0).unwrap().is_braked());
}

#[test]
fn the_drive_stops_by_itself_when_sync_is_lost() {
    let mut bench = moving();
    (bench.talks, bench.syncs) = (false, false);
    let from = bench.motor_rad();
    // The last SYNC was 2 ms ago; patience is 7 ms: three periods and a half.
    bench.cycles(2);
    assert_eq!(bench.state(), PowerState::OperationEnabled);
    bench.cycles(1);
    assert_eq!(bench.state(), PowerState::QuickStopActive);
    assert_eq!(bench.emergencies(), [ErrorCode::SYNC_LOST]);
    bench.cycles(100);
    assert_eq!(bench.state(), PowerState::SwitchOnDisabled);
    assert_stopped_within(&bench, from, 0.65);
}

#[test]
fn the_drive_stops_by_itself_when_set_points_are_missing() {
    let mut bench = moving();
    bench.talks = false;
    let from = bench.motor_rad();
    // The set-point for the next SYNC was sent: it is the fourth that finds three missing.
    bench.cycles(3);
    assert_eq!(bench.state(), PowerState::OperationEnabled);
    bench.cycles(1);
    assert_eq!(bench.state(), PowerState::QuickStopActive);
    assert_eq!(bench.emergencies(), [ErrorCode::RPDO_TIMEOUT]);
    bench.cycles(100);
    assert_stopped_within(&bench, from, 0.65);
    // Nothing moves again without a fresh way through the state machine.
    bench.talks = true;
    let word = Controlword::of(Command::EnableOperation).0;
    let [low, high] = word.to_le_bytes();
    for _ in 0..50 {
        bench.talks = false;
        bench.send(&frame(0x201, [low, high, 0, 0, 0, 0]));
        bench.cycle();
    }
    assert_eq!(bench.state(), PowerState::SwitchOnDisabled);
}

#[test]
fn a_commanded_quick_stop_ramps_down_and_switches_off() {
    let mut bench = moving();
    let from = bench.motor_rad();
    bench.master.set_goal(Goal::QuickStop);
    bench.cycles(5);
    assert_eq!(bench.state(), PowerState::QuickStopActive);
    bench.cycles(100);
    assert_eq!(bench.state(), PowerState::SwitchOnDisabled);
    assert_stopped_within(&bench, from, 0.65);
    assert!(bench.emergencies().is_empty());
}

#[test]
fn quick_stop_option_6_stands_with_torque_and_resumes() {
    let mut bench = moving();
    bench.write(0x605A, &6_i16.to_le_bytes());
    bench.master.set_goal(Goal::QuickStop);
    bench.cycles(100);
    assert_eq!(bench.state(), PowerState::QuickStopActive);
    assert!(!bench.robot.plant(0).unwrap().is_braked());
    bench.talks = false;
    bench.target = Target::Position(bench.actual.position);
    for _ in 0..5 {
        let [a, b, c, d] = bench.actual.position.to_le_bytes();
        bench.send(&frame(0x201, [0x0F, 0, a, b, c, d]));
        bench.cycle();
    }
    assert_eq!(bench.state(), PowerState::OperationEnabled);
}

#[test]
fn disable_voltage_drops_the_torque_at_once() {
    let mut bench = moving();
    bench.master.set_goal(Goal::Disabled);
    bench.cycles(2);
    assert_eq!(bench.state(), PowerState::SwitchOnDisabled);
    bench.cycles(100);
    assert!(bench.robot.plant(0).unwrap().is_braked());
}

#[test]
fn a_fault_stops_latches_and_is_reset_by_an_edge_only() {
    let mut bench = moving();
    bench
        .robot
        .inject(0, Some(DriveFault::Trip(ErrorCode::HARDWARE)));
    bench.cycles(2);
    assert_eq!(bench.state(), PowerState::FaultReactionActive);
    bench.cycles(100);
    assert_eq!(bench.state(), PowerState::Fault);
    assert_eq!(bench.emergencies(), [ErrorCode::HARDWARE]);
    assert_eq!((bench.read(0x1001, 0), bench.read(0x603F, 0)), (1, 0x5400));
    assert_eq!((bench.read(0x1003, 0), bench.read(0x1003, 1)), (1, 0x5400));
    // The cause is present: it cannot be reset.
    bench.master.reset_fault();
    bench.cycles(20);
    assert_eq!(bench.state(), PowerState::Fault);
    // A bit that stays high is no edge.
    bench.talks = false;
    let hold = |bench: &mut Bench, word: u16, cycles: u32| {
        for _ in 0..cycles {
            let [low, high] = word.to_le_bytes();
            bench.send(&frame(0x201, [low, high, 0, 0, 0, 0]));
            bench.cycle();
        }
    };
    hold(&mut bench, Controlword::FAULT_RESET, 5);
    bench.robot.inject(0, None);
    hold(&mut bench, Controlword::FAULT_RESET, 20);
    assert_eq!(bench.state(), PowerState::Fault);
    hold(&mut bench, 0, 2);
    hold(&mut bench, Controlword::FAULT_RESET, 2);
    assert_eq!(bench.state(), PowerState::SwitchOnDisabled);
    assert_eq!(bench.emergencies(), [ErrorCode::HARDWARE, ErrorCode::NONE]);
    assert_eq!(bench.read(0x1001, 0), 0);
}

#[test]
fn a_frozen_encoder_is_a_following_error() {
    let mut bench = moving();
    bench.write(0x6065, &units(0.5).to_le_bytes());
    bench
        .robot
        .inject(0, Some(DriveFault::Encoder(EncoderFault::Frozen)));
    run(&mut bench, 100);
    assert!(
        bench.emergencies().contains(&ErrorCode::FOLLOWING_ERROR),
        "{:?}",
        bench.emergencies()
    );
    assert!(matches!(
        bench.state(),
        PowerState::Fault | PowerState::FaultReactionActive
    ));
}

#[test]
fn a_blocked_axis_trips_by_its_following_error() {
    let mut axis = axis_setup(0, 10.0);
    axis.plant.stop_rad = [-20.0, 12.0];
    let mut bench = Bench::new(&axis);
    bench.enable(Mode::Csp);
    run(&mut bench, 200);
    let code = bench.emergencies();
    assert_eq!(code, [ErrorCode::FOLLOWING_ERROR]);
    assert_eq!(bench.state(), PowerState::Fault);
}

#[test]
fn too_much_current_trips() {
    let mut axis = axis_setup(0, 10.0);
    axis.drive.over_current_a = 5.0;
    axis.plant.stop_rad = [-20.0, 11.0];
    let mut bench = Bench::new(&axis);
    bench.enable(Mode::Cst);
    // 1200 ‰ of 525 mN·m over 0.105 N·m/A: 6 A.
    bench.target = Target::Torque(1200);
    bench.cycles(50);
    assert_eq!(bench.emergencies(), [ErrorCode::OVER_CURRENT]);
    assert_eq!(bench.state(), PowerState::Fault);
    assert_eq!(bench.read(0x1001, 0), 0b11);
}

#[test]
fn the_heartbeat_of_the_node_is_watched_even_if_it_never_came() {
    let mut bench = Bench::new(&axis_setup(0, 10.0));
    bench.wait(200);
    let watched = ((0x7E_u32 << 16) + 50).to_le_bytes();
    bench.write_sub(0x1016, 1, &watched);
    let node = NodeId::new(0x7E).unwrap();
    bench.write(0x6060, &[8]);
    bench.nmt(nmt::Command::Start);
    bench.master.set_goal(Goal::Enabled);
    for _ in 0..20 {
        bench.cycles(10);
        bench.send(&nmt::heartbeat_frame(node, State::Operational));
    }
    assert_eq!(bench.state(), PowerState::OperationEnabled);
    for _ in 0..35 {
        if bench.emergencies().is_empty() {
            bench.cycle();
        }
    }
    assert_eq!(bench.emergencies(), [ErrorCode::HEARTBEAT]);
    bench.cycles(60);
    assert_eq!(
        bench.state(),
        PowerState::SwitchedOn,
        "no torque while it is missing"
    );
    bench.send(&nmt::heartbeat_frame(node, State::Operational));
    bench.cycles(10);
    assert_eq!(bench.state(), PowerState::OperationEnabled);

    let mut bench = Bench::new(&axis_setup(0, 10.0));
    bench.wait(200);
    bench.write_sub(0x1016, 1, &watched);
    bench.wait(100);
    bench.start(Mode::Csp);
    bench.master.set_goal(Goal::Enabled);
    bench.cycles(40);
    assert_eq!(bench.emergencies(), [ErrorCode::HEARTBEAT], "never heard");
    assert_eq!(bench.state(), PowerState::SwitchedOn);
}

#[test]
fn leaving_operational_while_moving_is_a_lost_connection() {
    for command in [nmt::Command::Stop, nmt::Command::EnterPreOperational] {
        let mut bench = moving();
        let from = bench.motor_rad();
        bench.nmt(command);
        assert_eq!(bench.state(), PowerState::QuickStopActive);
        bench.talks = false;
        bench.cycles(100);
        assert_eq!(bench.state(), PowerState::SwitchOnDisabled);
        assert_stopped_within(&bench, from, 0.6);
    }
}

#[test]
fn the_abort_connection_option_chooses_the_reaction() {
    for (code, expected) in [
        (0_i16, PowerState::OperationEnabled),
        (1, PowerState::Fault),
        (2, PowerState::SwitchOnDisabled),
        (3, PowerState::SwitchOnDisabled),
    ] {
        let mut bench = moving();
        bench.write(0x6007, &code.to_le_bytes());
        (bench.talks, bench.syncs) = (false, false);
        bench.cycles(100);
        assert_eq!(bench.state(), expected, "option {code}");
    }
}

#[test]
fn a_silent_drive_says_nothing_and_stops_by_itself() {
    let mut bench = moving();
    bench.robot.inject(0, Some(DriveFault::Silent));
    bench.cycles(150);
    assert!(bench.log.is_empty());
    assert_eq!(bench.state(), PowerState::SwitchOnDisabled);
    bench.robot.inject(0, None);
    bench.cycles(60);
    assert!(!bench.log.is_empty());
}

#[test]
fn a_short_pdo_is_reported_and_ignored() {
    let mut bench = moving();
    bench.send(&frame(0x201, [0, 0]));
    assert_eq!(bench.emergencies(), [ErrorCode::PDO_LENGTH]);
    run(&mut bench, 5);
    assert_eq!(bench.state(), PowerState::OperationEnabled);
    assert!(bench.status.has(Statusword::FOLLOWS));
}
