//! Faults of a drive bus: who goes off it, and what the node and the drives do about it.

use super::scenario::{ends, moving, rests, resumes};
use super::*;
use bus::wire::{BusFault, Tap};

fn break_bus(c: &mut Coordinator, fault: Option<BusFault>) {
    assert!(c.cell.set_bus_fault(DRIVE_BUS, fault));
}

fn bus_state(c: &mut Coordinator, tap: Tap) -> State {
    c.cell.wire_mut(DRIVE_BUS).unwrap().state(tap)
}

#[test]
fn a_drive_whose_frames_are_wrecked_goes_off_the_bus_alone_and_the_node_stops_in_three_steps() {
    let (mut c, onset) = moving();
    break_bus(&mut c, Some(BusFault::Wrecked(3)));
    let (cause, axis, steps) = ends(&mut c, onset);
    assert_eq!((cause, axis), (Cause::DriveSilent, Some(2)));
    assert!(steps <= 3, "{steps}");
    rests(&mut c);
    for tap in [0, 1, 2, 4, 5, 6] {
        assert_eq!(bus_state(&mut c, tap), State::Active, "tap {tap}");
    }
    // it recovers again and again, in vain: every 100 ms it has a heartbeat to send
    assert!(c.cell.wire_mut(DRIVE_BUS).unwrap().statistics().bus_off >= 1);
    // mended, it is back by itself; nothing moves without an acknowledgement
    break_bus(&mut c, None);
    rests(&mut c);
    assert_eq!(bus_state(&mut c, 3), State::Active);
    assert_eq!(c.state(), Some(NodeState::Faulted));
    resumes(&mut c);
}

#[test]
fn a_drive_that_becomes_error_passive_says_so_and_the_node_stops_before_it_is_off() {
    let (mut c, onset) = moving();
    let (from_ns, node) = (c.cell.now_ns(), node_of(&c, 3));
    c.cell.wire_mut(DRIVE_BUS).unwrap().disturb(LineFault {
        from_ns,
        // TPDO1 of the fourth drive: its emergency gets through
        id: Some(Id::Standard(0x180 + node)),
        sender: Some(4),
        count: 18,
        disturbance: Disturbance::Bit(40),
    });
    let (cause, axis, steps) = ends(&mut c, onset);
    assert_eq!((cause, axis), (Cause::DriveFault, Some(3)));
    assert!(steps <= 3, "{steps}");
    let wire = c.cell.wire_mut(DRIVE_BUS).unwrap();
    assert_eq!(
        (wire.statistics().bus_off, wire.statistics().errors),
        (0, 18)
    );
    rests(&mut c);
    assert_eq!(bus_state(&mut c, 4), State::Active);
    resumes(&mut c);
}

/// The CANopen node of an axis.
fn node_of(c: &Coordinator, axis: usize) -> u16 {
    let robot = c.cell.robots().next().unwrap().1;
    u16::from(robot.drive(axis).unwrap().node().get())
}

#[test]
fn the_whole_bus_may_be_stuck_shorted_or_cut_and_every_side_stops_alone() {
    for (fault, cause) in [
        (BusFault::StuckDominant, Cause::DriveSilent),
        (BusFault::Short, Cause::DriveSilent),
        // between the node and its drives, and behind the third of them
        (BusFault::Cut(0), Cause::DriveSilent),
        (BusFault::Cut(3), Cause::DriveSilent),
    ] {
        let (mut c, onset) = moving();
        let frames = c.cell.wire_mut(DRIVE_BUS).unwrap().statistics().frames;
        break_bus(&mut c, Some(fault));
        let (found, axis, steps) = ends(&mut c, onset);
        let first = if fault == BusFault::Cut(3) { 3 } else { 0 };
        assert_eq!((found, axis), (cause, Some(first)), "{fault}");
        assert!(steps <= 3, "{fault}: {steps}");
        // drives that hear nothing stop by themselves, after 3.5 periods and a ramp
        rests(&mut c);
        let robot = c.cell.robots().next().unwrap().1;
        for axis in 0..6 {
            assert!(
                robot.plant(axis).unwrap().is_braked(),
                "{fault}: axis {axis}"
            );
        }
        let mut told = Vec::new();
        while let Some(change) = c.cell.take_change() {
            assert_eq!(change.bus, "irp6-postument.0");
            told.push(change.state);
        }
        let wire = c.cell.wire_mut(DRIVE_BUS).unwrap();
        let through = wire.statistics().frames - frames;
        let states: Vec<State> = (0..7).map(|tap| wire.state(tap)).collect();
        match fault {
            BusFault::StuckDominant => {
                // nobody was sending when it began
                assert_eq!((through, states), (0, vec![State::Passive; 7]));
                assert_eq!(told, [State::Passive]);
            }
            BusFault::Short => {
                // drives recover by themselves, in vain; the node's rim does not
                assert_eq!((through, states[0]), (0, State::BusOff));
                assert_eq!(told.last(), Some(&State::BusOff));
                assert!(wire.statistics().bus_off >= 7);
            }
            // who is alone on its side is error-passive at most: nobody acknowledges
            BusFault::Cut(_) | BusFault::Wrecked(_) => {
                assert_eq!(wire.statistics().bus_off, 0);
                assert!(!told.contains(&State::BusOff), "{fault}: {told:?}");
            }
        }
        // mended: what waited on the node's side is of the past
        wire.clear(NODE_TAP);
        break_bus(&mut c, None);
        c.cell.wire_mut(DRIVE_BUS).unwrap().recover(NODE_TAP);
        rests(&mut c);
        assert_eq!(c.state(), Some(NodeState::Faulted), "{fault}");
        resumes(&mut c);
    }
}
