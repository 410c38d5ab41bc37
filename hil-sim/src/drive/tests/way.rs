//! pp and pv: the handshake, the windows, halt, software limits, and the bits of the statusword.

use protocol::canopen::cia402::{Controlword, Mode, Statusword};
use protocol::canopen::node::{Function, frame};

use super::bench::{Bench, UNITS_PER_RAD, axis_setup, units};

const ENABLED: u16 = 0x0F;
const NEW: u16 = ENABLED | Controlword::OPERATION_4;

/// A drive in a mode, without friction of the node: words come over SDO.
fn bench(mode: Mode) -> Bench {
    let mut bench = Bench::new(&axis_setup(0, 10.0));
    bench.enable(mode);
    bench.talks = false;
    bench
}

fn word(bench: &mut Bench, word: u16) {
    bench.write(0x6040, &word.to_le_bytes());
}

fn target(bench: &mut Bench, rad: f64) {
    bench.write(0x607A, &units(rad).to_le_bytes());
}

fn status(bench: &mut Bench) -> Statusword {
    Statusword(u16::try_from(bench.read(0x6041, 0)).unwrap())
}

fn has(bench: &mut Bench, bit: u16) -> bool {
    status(bench).has(bit)
}

/// Where the drive is, motor radians since it was switched on.
fn at(bench: &mut Bench) -> f64 {
    f64::from(bench.read(0x6064, 0).cast_signed()) / UNITS_PER_RAD
}

/// A tenth of an increment is 0.00016 rad; the loop rests within an increment or two.
const NEAR: f64 = 0.004;

fn near(a: f64, b: f64) -> bool {
    (a - b).abs() < NEAR
}

#[test]
fn a_set_point_is_taken_once_and_reached() {
    let mut bench = bench(Mode::Pp);
    let start = at(&mut bench);
    assert!(
        !has(&mut bench, Statusword::TARGET_REACHED),
        "no target yet"
    );
    target(&mut bench, start + 5.0);
    bench.wait(50);
    assert!(near(at(&mut bench), start), "a target alone moves nothing");
    word(&mut bench, NEW);
    assert!(has(&mut bench, Statusword::FOLLOWS), "taken");
    bench.wait(20);
    assert!(!has(&mut bench, Statusword::TARGET_REACHED), "on its way");
    word(&mut bench, ENABLED);
    assert!(
        !has(&mut bench, Statusword::FOLLOWS),
        "the next one may come"
    );
    // 5 rad at 50 rad/s and 200 rad/s² is a triangle of 2·√(5/200) s = 316 ms
    bench.wait(250);
    assert!(!has(&mut bench, Statusword::TARGET_REACHED));
    bench.wait(150);
    assert!(has(&mut bench, Statusword::TARGET_REACHED));
    assert!(near(at(&mut bench), start + 5.0), "{}", at(&mut bench));
    assert!(!has(&mut bench, Statusword::DEVIATION));
    // nothing moves again by itself
    bench.wait(100);
    assert!(near(at(&mut bench), start + 5.0));
}

#[test]
fn one_set_point_waits_and_bit_12_stays_until_it_is_on_its_way() {
    let mut bench = bench(Mode::Pp);
    let start = at(&mut bench);
    for rad in [3.0, 1.0] {
        target(&mut bench, start + rad);
        word(&mut bench, NEW);
        word(&mut bench, ENABLED);
    }
    assert!(has(&mut bench, Statusword::FOLLOWS), "one waits: no room");
    target(&mut bench, start + 9.0);
    word(&mut bench, NEW);
    word(&mut bench, ENABLED);
    let mut farthest = start;
    for _ in 0..80 {
        bench.wait(10);
        let now = at(&mut bench);
        farthest = if now > farthest { now } else { farthest };
    }
    // the loop overshoots its reference by some increments
    assert!(
        farthest > start + 3.0 - NEAR && farthest < start + 3.0 + 0.02,
        "first to the first: {farthest}"
    );
    assert!(near(at(&mut bench), start + 1.0), "the third was not taken");
    assert!(!has(&mut bench, Statusword::FOLLOWS));
    assert!(has(&mut bench, Statusword::TARGET_REACHED));
}

#[test]
fn a_set_point_at_once_replaces_the_one_on_its_way_and_relative_ones_add_up() {
    let mut bench = bench(Mode::Pp);
    let start = at(&mut bench);
    target(&mut bench, start + 8.0);
    word(&mut bench, NEW);
    word(&mut bench, ENABLED);
    bench.wait(100);
    target(&mut bench, start - 1.0);
    word(&mut bench, NEW | Controlword::CHANGE_AT_ONCE);
    word(&mut bench, ENABLED);
    bench.wait(900);
    assert!(near(at(&mut bench), start - 1.0));
    for _ in 0..2 {
        bench.write(0x607A, &units(0.5).to_le_bytes());
        word(&mut bench, NEW | Controlword::RELATIVE);
        word(&mut bench, ENABLED);
        bench.wait(300);
    }
    assert!(near(at(&mut bench), start));
}

#[test]
fn halt_stops_and_letting_go_continues() {
    let mut bench = bench(Mode::Pp);
    let start = at(&mut bench);
    target(&mut bench, start + 8.0);
    word(&mut bench, NEW);
    bench.wait(150);
    word(&mut bench, NEW | Controlword::HALT);
    // at most 50 rad/s at 200 rad/s²
    bench.wait(300);
    let halted = at(&mut bench);
    assert!(halted > start + 1.0 && halted < start + 7.5, "{halted}");
    assert!(has(&mut bench, Statusword::TARGET_REACHED), "it stands");
    bench.wait(100);
    assert!(near(at(&mut bench), halted));
    word(&mut bench, NEW);
    bench.wait(600);
    assert!(near(at(&mut bench), start + 8.0));
}

#[test]
fn software_limits_cut_the_target() {
    let mut bench = bench(Mode::Pp);
    let start = at(&mut bench);
    bench.write_sub(0x607D, 1, &units(start - 1.0).to_le_bytes());
    bench.write_sub(0x607D, 2, &units(start + 2.0).to_le_bytes());
    target(&mut bench, start + 5.0);
    word(&mut bench, NEW);
    bench.wait(600);
    assert!(has(&mut bench, Statusword::LIMIT));
    assert!(near(at(&mut bench), start + 2.0));
}

#[test]
fn disabling_forgets_the_target() {
    let mut bench = bench(Mode::Pp);
    let start = at(&mut bench);
    target(&mut bench, start + 8.0);
    word(&mut bench, NEW);
    bench.wait(100);
    word(&mut bench, 0x07);
    bench.wait(600);
    let stopped = at(&mut bench);
    word(&mut bench, ENABLED);
    bench.wait(500);
    assert!(near(at(&mut bench), stopped), "it does not go on by itself");
}

#[test]
fn a_velocity_is_reached_by_a_ramp_and_zero_speed_is_told() {
    let mut bench = bench(Mode::Pv);
    bench.wait(50);
    assert!(has(&mut bench, Statusword::FOLLOWS), "it stands");
    bench.write(0x60FF, &units(20.0).to_le_bytes());
    // 20 rad/s at 200 rad/s² take 100 ms
    bench.wait(50);
    let half = bench.velocity();
    // the loop lags the ramp of 10 rad/s by a few milliseconds
    assert!((half - 10.0).abs() < 2.0, "{half}");
    assert!(!has(&mut bench, Statusword::TARGET_REACHED));
    bench.wait(200);
    assert!(
        (bench.velocity() - 20.0).abs() < 0.5,
        "{}",
        bench.velocity()
    );
    assert!(has(&mut bench, Statusword::TARGET_REACHED));
    assert!(!has(&mut bench, Statusword::FOLLOWS), "it moves");
    bench.write(0x60FF, &units(-5.0).to_le_bytes());
    bench.wait(300);
    assert!((bench.velocity() + 5.0).abs() < 0.5);
    bench.write(0x60FF, &0_i32.to_le_bytes());
    bench.wait(300);
    assert!(has(&mut bench, Statusword::FOLLOWS));
}

#[test]
fn a_velocity_ends_at_the_software_limit() {
    let mut bench = bench(Mode::Pv);
    let start = at(&mut bench);
    bench.write_sub(0x607D, 1, &units(start - 1.0).to_le_bytes());
    bench.write_sub(0x607D, 2, &units(start + 3.0).to_le_bytes());
    bench.write(0x60FF, &units(20.0).to_le_bytes());
    let mut farthest = start;
    for _ in 0..100 {
        bench.wait(10);
        let now = at(&mut bench);
        farthest = if now > farthest { now } else { farthest };
    }
    // the loop may overshoot its reference by some increments
    assert!(farthest < start + 3.0 + 0.02, "{farthest}");
    assert!(near(at(&mut bench), start + 3.0));
    assert!(has(&mut bench, Statusword::LIMIT));
    bench.write(0x60FF, &units(-20.0).to_le_bytes());
    bench.wait(1000);
    assert!(near(at(&mut bench), start - 1.0), "and back to the other");
}

/// Bits 10 to 13 of every mode, enabled and at rest, before anything was asked for.
#[test]
fn bits_10_to_13_at_rest_in_every_mode() {
    let table = [
        (Mode::None, [false, false, false, false]),
        // nothing to reach
        (Mode::Pp, [false, false, false, false]),
        // velocity 0 is reached, and is zero speed
        (Mode::Pv, [true, false, true, false]),
        // stands, not homed
        (Mode::Homing, [true, false, false, false]),
        // follows
        (Mode::Csp, [false, false, true, false]),
        (Mode::Csv, [false, false, true, false]),
        (Mode::Cst, [false, false, true, false]),
    ];
    assert_eq!(table.map(|(mode, _)| mode), Mode::ALL);
    for (mode, expected) in table {
        let mut bench = Bench::new(&axis_setup(0, 10.0));
        bench.start(mode);
        bench
            .master
            .set_goal(protocol::canopen::cia402::Goal::Enabled);
        bench.cycles(40);
        let word = status(&mut bench);
        let bits = [
            Statusword::TARGET_REACHED,
            Statusword::LIMIT,
            Statusword::FOLLOWS,
            Statusword::DEVIATION,
        ];
        assert_eq!(bits.map(|bit| word.has(bit)), expected, "{mode:?}");
    }
}

#[test]
fn pp_works_over_pdo_too() {
    let mut bench = bench(Mode::Pp);
    let start = at(&mut bench);
    let rpdo = |bench: &mut Bench, word: u16, rad: f64| {
        let [a, b, c, d] = units(rad).to_le_bytes();
        let [low, high] = word.to_le_bytes();
        let cob = bench.node.cob(Function::Rpdo1);
        bench.send(&frame(cob, [low, high, a, b, c, d]));
        bench.cycle();
    };
    rpdo(&mut bench, ENABLED, start + 2.0);
    rpdo(&mut bench, NEW, start + 2.0);
    rpdo(&mut bench, ENABLED, start + 2.0);
    bench.cycles(200);
    assert!(near(at(&mut bench), start + 2.0));
}
