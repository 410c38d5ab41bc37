//! Touch probes on digital inputs and switches, seen from the wire, while the axis moves at 20 rad/s.

use protocol::canopen::sdo::{Abort, Address, Outcome};

use super::bench::Bench;
use super::safety::{moving, run};
use crate::plant::robot::SUBSTEP_NS;

/// Positive and negative edge of probe 1, of probe 2.
const PLACES: [u16; 4] = [0x60BA, 0x60BB, 0x60BC, 0x60BD];
const STAMPS: [u16; 4] = [0x60D1, 0x60D2, 0x60D3, 0x60D4];
const EDGES: [u16; 4] = [0x60D5, 0x60D6, 0x60D7, 0x60D8];

fn all(bench: &mut Bench, indices: [u16; 4]) -> [i32; 4] {
    indices.map(|index| bench.read(index, 0).cast_signed())
}

/// Sets the probe inputs between two cycles; where the axis was then, drive units.
fn set(bench: &mut Bench, levels: u16) -> i32 {
    assert!(bench.robot.set_inputs(0, levels));
    let at = bench.read(0x6064, 0).cast_signed();
    run(bench, 1);
    at
}

/// 20 rad/s for a substep are 3183 units; a latched position lies within two of them behind the edge.
fn is_behind(place: i32, edge: i32) -> bool {
    (0..2 * 3183 + 2000).contains(&(place - edge))
}

#[test]
fn both_edges_of_both_inputs_are_latched_where_they_were_once_or_every_time() {
    for continuous in [false, true] {
        let mut bench = moving();
        // both probes, both edges, on their inputs
        let byte: u16 = 0x31 | if continuous { 2 } else { 0 };
        bench.write(0x60B8, &(byte | byte << 8).to_le_bytes());
        run(&mut bench, 2);
        assert_eq!(bench.read(0x60B9, 0), 0x0101);
        let mut seen = [[0; 4]; 2];
        for seen in &mut seen {
            // up 1, up 2, down 1, down 2
            let [up1, up2, down1, down2] = [1, 3, 2, 0].map(|levels| {
                let at = set(&mut bench, levels);
                run(&mut bench, 3);
                at
            });
            *seen = [up1, down1, up2, down2];
        }
        let edges = if continuous { seen[1] } else { seen[0] };
        let places = all(&mut bench, PLACES);
        for (place, edge) in places.into_iter().zip(edges) {
            assert!(is_behind(place, edge), "{continuous}: {place} {edge}");
        }
        // every edge counts, latched or not
        assert_eq!(all(&mut bench, EDGES), [2; 4]);
        assert_eq!(bench.read(0x60B9, 0), 0x0707);
        // the levels are there for everybody to read, and the status went out by itself
        bench.robot.set_inputs(0, 0x8001);
        run(&mut bench, 1);
        assert_eq!(bench.read(0x60FD, 0) >> 16, 0x8001);
        assert_eq!(bench.inputs.unwrap().touch_probe, 0x0707);
        // off: forgotten
        bench.write(0x60B8, &[0, 0]);
        run(&mut bench, 1);
        assert_eq!(
            (all(&mut bench, PLACES), all(&mut bench, EDGES)),
            ([0; 4], [0; 4])
        );
        assert_eq!(bench.read(0x60B9, 0), 0);
    }
}

#[test]
fn an_edge_that_is_not_asked_for_is_none() {
    let mut bench = moving();
    // probe 2 only, its negative edge only
    bench.write(0x60B8, &0x2100_u16.to_le_bytes());
    for levels in [1, 0, 2] {
        set(&mut bench, levels);
    }
    assert_eq!(
        (all(&mut bench, PLACES), bench.read(0x60B9, 0)),
        ([0; 4], 0x0100)
    );
    let edge = set(&mut bench, 0);
    let [.., place] = all(&mut bench, PLACES);
    assert!(is_behind(place, edge));
    assert_eq!(all(&mut bench, EDGES), [0, 0, 0, 1]);
}

#[test]
fn a_switch_can_be_the_trigger() {
    let mut axis = super::bench::axis_setup(0, 10.0);
    axis.plant.bounce_s = 0.0;
    // it releases on the way up
    (axis.plant.switch_rad, axis.plant.switch_hysteresis_rad) = (12.0, 0.0);
    let mut bench = Bench::new(&axis);
    bench.enable(protocol::canopen::cia402::Mode::Csp);
    // probe 1 by object 60D0: the home switch, its negative edge
    bench.write_sub(0x60D0, 1, &(-1_i16).to_le_bytes());
    bench.write(0x60B8, &0x29_u16.to_le_bytes());
    run(&mut bench, 100);
    let rad = f64::from(bench.read(0x60BB, 0).cast_signed()) / super::bench::UNITS_PER_RAD;
    // it counts from power-up, at 10 rad
    assert!((2.0..2.02).contains(&rad), "{rad}");
    assert_eq!(bench.read(0x60D6, 0), 1);
    // reserved numbers trigger nothing; what is out of range is refused
    assert_eq!(
        bench.write_sub(0x60D0, 1, &6_i16.to_le_bytes()),
        Outcome::Refused(Address::new(0x60D0, 1), Abort::TooHigh)
    );
}

/// From an instant to a stamp of 32 bits after it, ns.
fn after(bench: &mut Bench, index: u16, ns: u64) -> u32 {
    let [a, b, c, d, ..] = ns.to_le_bytes();
    bench
        .read(index, 0)
        .wrapping_sub(u32::from_le_bytes([a, b, c, d]))
}

#[test]
fn each_edge_is_stamped_with_the_substep_in_which_it_was() {
    let substep = u32::try_from(SUBSTEP_NS).unwrap();
    for continuous in [false, true] {
        let mut bench = moving();
        let byte: u16 = 0x31 | if continuous { 2 } else { 0 };
        bench.write(0x60B8, &(byte | byte << 8).to_le_bytes());
        run(&mut bench, 2);
        // up 1, up 2, down 1, down 2, in two rounds
        let mut instants = [[0; 4]; 2];
        for instants in &mut instants {
            let [up1, up2, down1, down2] = [1, 3, 2, 0].map(|levels| {
                let at = bench.robot.now_ns();
                assert!(bench.robot.set_inputs(0, levels));
                run(&mut bench, 3);
                at
            });
            *instants = [up1, down1, up2, down2];
        }
        let expected = if continuous { instants[1] } else { instants[0] };
        for (index, at) in STAMPS.into_iter().zip(expected) {
            let late = after(&mut bench, index, at);
            // an input is looked at once a substep: at the end of the next
            assert!(
                (1..=substep).contains(&late),
                "{continuous} {index:X}: {late} ns"
            );
        }
        bench.write(0x60B8, &[0, 0]);
        run(&mut bench, 1);
        assert_eq!(all(&mut bench, STAMPS), [0; 4], "off: forgotten");
    }
}

#[test]
fn between_two_zero_impulses_lies_the_time_of_a_turn() {
    let mut bench = moving();
    // probe 1, every zero impulse, positive edge
    bench.write(0x60B8, &0x17_u16.to_le_bytes());
    let mut stamps = Vec::new();
    for _ in 0..2500 {
        run(&mut bench, 1);
        let stamp = bench.read(STAMPS[0], 0);
        if stamp != 0 && stamps.last() != Some(&stamp) {
            stamps.push(stamp);
        }
    }
    // 5 s at 20 rad/s are 15.9 turns; the clock of 32 bits overflows once in 4.3 s
    assert!((14..=16).contains(&stamps.len()), "{}", stamps.len());
    assert!(!stamps.is_sorted());
    for pair in stamps.windows(2) {
        let turn_s = f64::from(pair[1].wrapping_sub(pair[0])) * 1e-9;
        // two instants to a substep each; at 20 rad/s the axis wavers by less than that
        let expected = core::f64::consts::TAU / 20.0;
        assert!((turn_s - expected).abs() < 0.000_5, "{turn_s} s");
    }
}
