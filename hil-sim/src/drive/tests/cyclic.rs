use protocol::canopen::axis::Target;
use protocol::canopen::cia402::{Goal, Mode, PowerState, Statusword};

use super::bench::{Bench, CYCLE_NS, Weight, axis_setup, units};

#[test]
fn enabling_takes_the_time_of_the_brake_and_holds_the_load() {
    let mut bench = Bench::loaded(&axis_setup(1, 10.0), Box::new(Weight(-0.5)));
    bench.start(Mode::Csp);
    bench.master.set_goal(Goal::Enabled);
    let mut enabled_at = None;
    let mut follows_at = None;
    for k in 0..60 {
        bench.cycle();
        if bench.status.state() == Some(PowerState::OperationEnabled) {
            enabled_at = enabled_at.or(Some(k));
        }
        if bench.status.has(Statusword::FOLLOWS) {
            follows_at = follows_at.or(Some(k));
        }
    }
    let (enabled_at, follows_at) = (enabled_at.unwrap(), follows_at.unwrap());
    // 25 ms are 12.5 cycles; the statusword is sampled at SYNC.
    assert!(
        (12..=14).contains(&(follows_at - enabled_at)),
        "{enabled_at} {follows_at}"
    );
    // The load sags by what the integrator needs to take over: 0.5 N·m of 60 mN·m/(rad/s)·60 1/s
    // and 80 1/s of stiffness is below a tenth of a radian.
    assert!(
        (bench.motor_rad() - 10.0).abs() < 0.1,
        "{}",
        bench.motor_rad()
    );
    bench.cycles(200);
    assert!(
        (bench.motor_rad() - 10.0).abs() < 0.01,
        "{}",
        bench.motor_rad()
    );
}

#[test]
fn disabling_closes_the_brake_before_the_torque_goes() {
    let mut bench = Bench::loaded(&axis_setup(1, 10.0), Box::new(Weight(-0.5)));
    bench.enable(Mode::Csp);
    bench.cycles(100);
    let before = bench.motor_rad();
    bench.master.set_goal(Goal::SwitchedOn);
    bench.cycles(50);
    assert_eq!(bench.state(), PowerState::SwitchedOn);
    assert!(bench.robot.plant(0).unwrap().is_braked());
    assert!(
        (bench.motor_rad() - before).abs() < 0.01,
        "{}",
        bench.motor_rad() - before
    );
}

/// Moves with csp along a trapezoid and tells the greatest following error (object 60F4), rad.
fn trapezoid(axis: usize, top_rad_s: f64) -> (f64, f64) {
    let setup = axis_setup(axis, 5.0);
    let increments = f64::from(setup.plant.increments_per_turn);
    let scale = increments * 1000.0 / core::f64::consts::TAU;
    let mut bench = Bench::loaded(&setup, Box::new(Weight(0.01)));
    bench.enable(Mode::Csp);
    let acceleration = 150.0;
    let (mut speed, mut position, mut worst) = (0.0_f64, 0.0_f64, 0.0_f64);
    let dt = 0.002;
    for k in 0..600 {
        let wanted = if k < 400 { top_rad_s } else { 0.0 };
        speed += (wanted - speed).clamp(-acceleration * dt, acceleration * dt);
        position += speed * dt;
        #[expect(
            clippy::cast_possible_truncation,
            reason = "a test's positions are small"
        )]
        let target = (position * scale) as i32;
        bench.target = Target::Position(target);
        bench.cycle();
        let error = f64::from(bench.read(0x60F4, 0).cast_signed()) / scale;
        worst = if error.abs() > worst {
            error.abs()
        } else {
            worst
        };
    }
    bench.cycles(200);
    (worst, bench.motor_rad() - 5.0 - position)
}

#[test]
fn csp_follows_within_its_window_on_every_axis() {
    for axis in 0..6 {
        let (worst, end) = trapezoid(axis, 50.0);
        assert!(worst > 1e-4 && worst < 0.05, "axis {axis}: {worst} rad");
        // At rest: within two increments of 2π/2000.
        assert!(end.abs() < 0.0063, "axis {axis}: {end} rad");
    }
}

#[test]
fn the_target_takes_effect_at_sync_not_before() {
    let mut bench = Bench::new(&axis_setup(0, 10.0));
    bench.enable(Mode::Csp);
    bench.syncs = false;
    bench.target = Target::Position(units(0.01));
    bench.cycle();
    assert!(
        (bench.motor_rad() - 10.0).abs() < 1e-3,
        "{}",
        bench.motor_rad() - 10.0
    );
    bench.syncs = true;
    bench.cycles(20);
    assert!(
        (bench.motor_rad() - 10.01).abs() < 2e-3,
        "{}",
        bench.motor_rad() - 10.0
    );
}

#[test]
fn csv_follows_a_velocity_and_cst_a_torque() {
    let mut bench = Bench::new(&axis_setup(0, 10.0));
    bench.enable(Mode::Csv);
    let speed = units(20.0).to_le_bytes();
    bench.write(0x60FF, &speed);
    bench.cycles(300);
    assert!(
        (bench.velocity() - 20.0).abs() < 0.3,
        "{}",
        bench.velocity()
    );

    let mut bench = Bench::new(&axis_setup(0, 10.0));
    bench.enable(Mode::Cst);
    // 600 ‰ of 525 mN·m = 0.315 N·m; friction 0.02 + 0.02·ω: ω = 14.75 rad/s.
    bench.target = Target::Torque(600);
    bench.cycles(300);
    assert!(
        (bench.velocity() - 14.75).abs() < 0.05,
        "{}",
        bench.velocity()
    );
    assert!(
        (bench.actual.torque - 600).abs() <= 2,
        "{}",
        bench.actual.torque
    );
}

#[test]
fn the_torque_is_limited_and_the_speed_too() {
    let mut bench = Bench::new(&axis_setup(0, 10.0));
    bench.enable(Mode::Cst);
    bench.write(0x6072, &500_u16.to_le_bytes());
    bench.target = Target::Torque(900);
    bench.cycles(200);
    assert!((bench.actual.torque - 500).abs() <= 2);
    assert!(bench.status.has(Statusword::LIMIT));
    // 60 turns a minute are 6.28 rad/s.
    bench.write(0x6080, &60_u32.to_le_bytes());
    bench.write(0x6072, &4000_u16.to_le_bytes());
    bench.cycles(300);
    assert!(bench.velocity() < 9.0, "{}", bench.velocity());
}

#[test]
fn software_limits_of_the_drive_cut_the_target() {
    let mut bench = Bench::new(&axis_setup(0, 10.0));
    bench.start(Mode::Csp);
    bench.write_sub(0x607D, 1, &units(-1.0).to_le_bytes());
    bench.write_sub(0x607D, 2, &units(1.0).to_le_bytes());
    bench.master.set_goal(Goal::Enabled);
    bench.cycles(40);
    for k in 0..100 {
        bench.target = Target::Position(units(0.02 * f64::from(k)));
        bench.cycle();
    }
    assert!(bench.status.has(Statusword::LIMIT));
    bench.cycles(100);
    assert!(
        (bench.motor_rad() - 11.0).abs() < 0.01,
        "{}",
        bench.motor_rad()
    );
}

#[test]
fn a_halt_stops_and_its_end_resumes() {
    let mut bench = Bench::new(&axis_setup(0, 10.0));
    bench.enable(Mode::Csv);
    bench.write(0x60FF, &units(20.0).to_le_bytes());
    bench.cycles(100);
    bench.talks = false;
    for (word, fast) in [(0x010F_u16, false), (0x000F, true)] {
        for _ in 0..200 {
            let [low, high] = word.to_le_bytes();
            let frame = protocol::canopen::node::frame(0x301, [low, high, 0, 0]);
            bench.send(&frame);
            bench.cycle();
        }
        assert_eq!(bench.velocity().abs() > 15.0, fast, "{}", bench.velocity());
        assert_eq!(bench.state(), PowerState::OperationEnabled);
    }
}

#[test]
fn two_lost_set_points_are_bridged_on_the_old_course() {
    let mut bench = Bench::new(&axis_setup(0, 10.0));
    bench.enable(Mode::Csp);
    let mut worst = 0.0_f64;
    let mut last = 0.0;
    for k in 0..200 {
        bench.target = Target::Position(units(0.04 * f64::from(k)));
        bench.talks = !(k == 120 || k == 121);
        bench.cycle();
        if k > 60 {
            let change = (bench.velocity() - last).abs();
            worst = if change > worst { change } else { worst };
        }
        last = bench.velocity();
    }
    assert_eq!(bench.state(), PowerState::OperationEnabled);
    // 20 rad/s throughout: a stop and restart would change it by 20 in one cycle.
    assert!(worst < 1.5, "{worst} rad/s in {CYCLE_NS} ns");
}
