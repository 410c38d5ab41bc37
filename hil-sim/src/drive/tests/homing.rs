use protocol::canopen::cia402::{
    Controlword, Goal, HomingMethod, Mode, PowerState, Statusword, input, probe,
};
use protocol::canopen::node::frame;

use super::bench::{Bench, axis_setup, units};
use crate::drive::DriveFault;

/// Runs the drive's own homing; the cycles it took, `None` if it did not end in 20 s.
fn home(bench: &mut Bench, method: HomingMethod) -> Option<u64> {
    bench.start(Mode::Homing);
    bench.write(0x6098, &method.code().to_le_bytes());
    bench.master.set_goal(Goal::Enabled);
    bench.cycles(40);
    bench.talks = false;
    let node = bench.node.get();
    for k in 0..10_000 {
        let word = (0x000F | Controlword::OPERATION_4).to_le_bytes();
        bench.send(&frame(0x300 + u16::from(node), [word[0], word[1], 0, 0]));
        bench.cycle();
        let done = bench.status.has(Statusword::FOLLOWS) || bench.status.has(Statusword::DEVIATION);
        if k > 2 && done && bench.status.has(Statusword::TARGET_REACHED) {
            return Some(k);
        }
    }
    None
}

#[test]
fn method_5_ends_at_the_index_above_the_switch() {
    for axis in [0, 5] {
        let mut bench = Bench::new(&axis_setup(axis, 9.0));
        home(&mut bench, HomingMethod::NegativeSwitchAndIndex).unwrap();
        assert!(bench.status.has(Statusword::FOLLOWS));
        // The true angle is 0 where the object 6064 is 0, to an increment.
        let turn = f64::from(axis_setup(axis, 0.0).plant.increments_per_turn) * 1000.0;
        let position = f64::from(bench.actual.position) * core::f64::consts::TAU / turn;
        let error = bench.motor_rad() - position;
        assert!(error.abs() < 0.005, "axis {axis}: {error} rad");
        assert!(
            bench.motor_rad().abs() < 0.2,
            "stops near the index: {}",
            bench.motor_rad()
        );
    }
}

#[test]
fn method_5_started_on_the_switch_backs_off_first() {
    let mut bench = Bench::new(&axis_setup(0, -3.0));
    home(&mut bench, HomingMethod::NegativeSwitchAndIndex).unwrap();
    assert!(bench.status.has(Statusword::FOLLOWS));
    assert!(bench.motor_rad().abs() < 0.2);
}

#[test]
fn methods_33_and_34_take_the_next_index_in_their_direction() {
    let turn = core::f64::consts::TAU;
    for (method, expected) in [
        (HomingMethod::IndexNegative, turn),
        (HomingMethod::IndexPositive, 2.0 * turn),
    ] {
        let mut bench = Bench::new(&axis_setup(0, 10.0));
        home(&mut bench, method).unwrap();
        let home = bench.motor_rad() - f64::from(bench.actual.position) / f64::from(units(1.0));
        assert!((home - expected).abs() < 0.005, "{method:?}: {home}");
    }
}

#[test]
fn methods_35_and_37_take_the_present_position_with_the_offset() {
    for method in [
        HomingMethod::PresentPositionOld,
        HomingMethod::PresentPosition,
    ] {
        let mut bench = Bench::new(&axis_setup(0, 10.0));
        bench.wait(200);
        bench.write(0x607C, &1_234_000_i32.to_le_bytes());
        home(&mut bench, method).unwrap();
        // Holding may move by an increment.
        assert!(
            (bench.actual.position - 1_234_000).abs() <= 2000,
            "{}",
            bench.actual.position
        );
    }
}

#[test]
fn homing_fails_without_index_and_at_the_limit_switch() {
    let mut bench = Bench::new(&axis_setup(0, 10.0));
    bench.robot.inject(0, Some(DriveFault::IndexMissing));
    home(&mut bench, HomingMethod::IndexPositive).unwrap();
    assert!(bench.status.has(Statusword::DEVIATION) && !bench.status.has(Statusword::FOLLOWS));
    assert_eq!(bench.state(), PowerState::OperationEnabled);
    // A turn and a tenth, and the way to stop.
    let way = bench.motor_rad() - 10.0;
    assert!(way > 6.9 && way < 7.5, "{way}");

    let mut axis = axis_setup(0, 10.0);
    axis.plant.limit_rad = [0.0, 100.0];
    let mut bench = Bench::new(&axis);
    bench.robot.inject(0, Some(DriveFault::SwitchStuck(false)));
    home(&mut bench, HomingMethod::NegativeSwitchAndIndex).unwrap();
    assert!(bench.status.has(Statusword::DEVIATION));
    assert!(
        bench.motor_rad() < 0.0 && bench.motor_rad() > -2.0,
        "{}",
        bench.motor_rad()
    );
    assert_eq!(
        bench.inputs.unwrap().inputs & input::NEGATIVE_LIMIT,
        input::NEGATIVE_LIMIT
    );
}

/// What the node does: coarse in csp to the switch, back off, touch probe at the index.
#[test]
fn the_node_can_home_over_the_wire() {
    let mut bench = Bench::new(&axis_setup(1, 9.0));
    bench.enable(Mode::Csp);
    let mut position = 0.0;
    let mut step = |bench: &mut Bench, rad: f64| {
        position += rad;
        bench.target = protocol::canopen::axis::Target::Position(units(position));
        bench.cycle();
    };
    let home = |bench: &Bench| {
        bench
            .inputs
            .is_some_and(|inputs| inputs.inputs & input::HOME != 0)
    };
    let mut rested = 0;
    let mut ramp: i32 = 0;
    // MRROC++: −0.03 rad a step, ramped up in ten steps; the switch must be seen three times.
    while rested < 3 {
        ramp = (ramp + 1).min(10);
        step(&mut bench, -0.003 * f64::from(ramp));
        rested = if home(&bench) { rested + 1 } else { 0 };
        assert!(bench.motor_rad() > -4.0, "the switch was not told");
    }
    for _ in 0..50 {
        step(&mut bench, 0.0);
    }
    assert!(home(&bench));
    bench.write(0x60B8, &probe::INDEX_ONCE.to_le_bytes());
    while home(&bench) {
        step(&mut bench, 0.007);
    }
    let found = |bench: &Bench| {
        bench
            .inputs
            .is_some_and(|inputs| inputs.touch_probe & probe::POSITIVE_STORED != 0)
    };
    while !found(&bench) {
        step(&mut bench, 0.007);
        assert!(bench.motor_rad() < 1.0, "the index was not told");
    }
    let latched = f64::from(bench.read(0x60BA, 0).cast_signed());
    let actual = f64::from(bench.read(0x6064, 0).cast_signed());
    // The true angle from the latched index is the true angle, to an increment.
    let angle = (actual - latched) / f64::from(units(1.0));
    assert!(
        (angle - bench.motor_rad()).abs() < 0.0032,
        "{angle} {}",
        bench.motor_rad()
    );
}

/// Switches at 0 and 20 rad: the axis starts between them, or on the one that is sought.
#[test]
fn methods_17_and_18_take_the_edge_of_a_limit_switch_and_1_and_2_the_index_behind_it() {
    let turn = core::f64::consts::TAU;
    for (method, expected, on_switch) in [
        (HomingMethod::NegativeLimit, 0.0, -1.0),
        (HomingMethod::PositiveLimit, 20.0, 21.0),
        // the index lies at multiples of a turn
        (HomingMethod::NegativeLimitAndIndex, turn, -1.0),
        (HomingMethod::PositiveLimitAndIndex, 3.0 * turn, 21.0),
    ] {
        for start in [10.0, on_switch] {
            let mut axis = axis_setup(0, start);
            axis.plant.limit_rad = [0.0, 20.0];
            let mut bench = Bench::new(&axis);
            home(&mut bench, method).unwrap();
            assert!(bench.status.has(Statusword::FOLLOWS), "{method:?}");
            let home = bench.motor_rad() - f64::from(bench.actual.position) / f64::from(units(1.0));
            // an increment is 0.0016 rad; the edge is seen once in a substep, 3.5 rad/s · 0.25 ms. The
            // pulse at 0 itself may count for the negative switch, whose edge it is.
            let error = home - expected;
            let at_edge = method == HomingMethod::NegativeLimitAndIndex && home.abs() < 0.005;
            assert!(
                error.abs() < 0.005 || at_edge,
                "{method:?} from {start}: {home}"
            );
        }
    }
}
