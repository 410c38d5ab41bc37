use protocol::canopen::cia402::{Mode, PowerState};
use protocol::canopen::nmt::{self, Command, State};
use protocol::canopen::node::{NodeId, frame, standard};
use protocol::canopen::sdo::{Abort, Address, Outcome};
use protocol::frame::{Frame, Id};

use super::bench::{Bench, axis_setup};

fn bench() -> Bench {
    Bench::new(&axis_setup(0, 10.0))
}

fn on(bench: &Bench, cob: u16) -> Vec<(u64, Vec<u8>)> {
    let with = bench
        .log
        .iter()
        .filter(|item| standard(&item.frame) == Some(cob));
    with.map(|item| (item.at_ns, item.frame.data().to_vec()))
        .collect()
}

#[test]
fn it_boots_in_its_time_and_beats_every_100_ms() {
    let mut bench = bench();
    bench.wait(149);
    assert!(bench.log.is_empty());
    bench.wait(300);
    let beats = on(&bench, 0x701);
    assert_eq!(beats[0], (150_000_000, vec![0x00]));
    assert_eq!(beats[1], (250_000_000, vec![0x7F]));
    assert_eq!(beats[2], (350_000_000, vec![0x7F]));
}

#[test]
fn it_tells_who_it_is() {
    let mut bench = bench();
    bench.wait(200);
    assert_eq!(bench.read(0x1000, 0), 0x0002_0192);
    assert_eq!(bench.read(0x6502, 0), 0x3A5);
    assert_eq!(bench.text(0x1008), b"mrroc simulated servo drive");
    let refused = bench.write(0x6041, &[0, 0]);
    assert_eq!(
        refused,
        Outcome::Refused(Address::new(0x6041, 0), Abort::ReadOnly)
    );
}

#[test]
fn it_is_deaf_while_it_boots_and_sdo_is_silent_when_stopped() {
    let mut bench = bench();
    let request = frame(0x601, [0x40, 0, 0x10, 0, 0, 0, 0, 0]);
    assert!(bench.send(&request).is_empty());
    bench.wait(200);
    assert_eq!(bench.send(&request).len(), 1);
    bench.nmt(Command::Stop);
    assert!(bench.send(&request).is_empty());
    bench.wait(100);
    assert_eq!(on(&bench, 0x701).last().unwrap().1, [State::Stopped as u8]);
}

#[test]
fn sync_is_answered_by_one_tpdo_in_operational_only() {
    let mut bench = bench();
    bench.wait(200);
    assert!(bench.send(&frame(0x80, [])).is_empty());
    bench.nmt(Command::Start);
    let sent = bench.send(&frame(0x80, []));
    assert_eq!(sent.len(), 1);
    assert_eq!(sent[0].frame.id(), Id::Standard(0x181));
    // Switch-on disabled, voltage, remote, in step with SYNC; position 0, torque 0.
    assert_eq!(sent[0].frame.data(), [0x50, 0x03, 0, 0, 0, 0, 0, 0]);
}

#[test]
fn foreign_frames_are_ignored() {
    let mut bench = bench();
    bench.wait(200);
    bench.nmt(Command::Start);
    let flexible = Frame::fd(Id::Standard(0x80), &[]).unwrap();
    let extended = Frame::classic(Id::Extended(0x80), &[]).unwrap();
    for foreign in [
        frame(0x602, [0x40, 0, 0x10, 0, 0, 0, 0, 0]),
        frame(0x202, [0; 6]),
        flexible,
    ] {
        assert!(bench.send(&foreign).is_empty());
    }
    assert!(bench.send(&extended).is_empty());
    let other = NodeId::new(9).unwrap();
    let start = nmt::command_frame(Command::ResetNode, nmt::Target::Node(other));
    bench.send(&start);
    assert_eq!(
        bench.robot.drive(0).unwrap().nmt_state(),
        State::Operational
    );
}

#[test]
fn a_reset_restores_the_dictionary_and_boots_again() {
    let mut bench = bench();
    bench.enable(Mode::Csp);
    bench.write(0x1017, &[20, 0]);
    bench.nmt(Command::ResetNode);
    assert_eq!(bench.state(), PowerState::NotReadyToSwitchOn);
    bench.log.clear();
    bench.wait(200);
    assert_eq!(on(&bench, 0x701)[0].1, [0]);
    assert_eq!(bench.read(0x1017, 0), 100);
    assert_eq!(bench.read(0x6060, 0), 0);
}

#[test]
fn inputs_are_told_on_change_and_not_more_often_than_once_a_millisecond() {
    let mut axis = axis_setup(0, -1.9);
    axis.plant.bounce_s = 0.01;
    let mut bench = Bench::new(&axis);
    bench.enable(Mode::Cst);
    bench.log.clear();
    // −0.12 N·m of 525 mN·m rated: slowly over the switch.
    bench.target = protocol::canopen::axis::Target::Torque(-230);
    bench.cycles(100);
    let told = on(&bench, 0x281);
    assert!(told.len() >= 2, "{told:?}");
    assert!(
        told.windows(2)
            .all(|pair| pair[1].0 - pair[0].0 >= 1_000_000),
        "{told:?}"
    );
    assert_eq!(told.last().unwrap().1, [4, 0, 0, 0, 0, 0]);
}

#[test]
fn the_mapping_can_be_changed_over_the_wire() {
    let mut bench = bench();
    bench.wait(200);
    let communication = protocol::canopen::axis::tpdo1(bench.node);
    let entries = [
        protocol::canopen::pdo::Entry::new(0x6061, 0, 8),
        protocol::canopen::pdo::Entry::new(0x1001, 0, 8),
    ];
    let direction = protocol::canopen::pdo::Direction::Transmit;
    let setup = protocol::canopen::pdo::Setup::new(direction, 1, communication, &entries);
    for write in setup {
        let outcome = bench.write_sub(write.at.index, write.at.sub, write.value.data());
        assert_eq!(outcome, Outcome::Downloaded(write.at));
    }
    bench.write(0x6060, &[10]);
    bench.nmt(Command::Start);
    let sent = bench.send(&frame(0x80, []));
    assert_eq!(sent[0].frame.data(), [10, 0]);
}

#[test]
fn sync_may_have_another_identifier_and_a_late_answer_comes_late() {
    let mut axis = axis_setup(0, 10.0);
    axis.drive.sdo_ns = 10_000_000;
    let mut bench = Bench::new(&axis);
    bench.wait(200);
    let request = frame(0x601, [0x23, 0x05, 0x10, 0, 0x81, 0, 0, 0]);
    assert!(bench.send(&request).is_empty());
    bench.log.clear();
    bench.wait(20);
    assert_eq!(
        on(&bench, 0x581),
        [(210_000_000, vec![0x60, 0x05, 0x10, 0, 0, 0, 0, 0])]
    );
    bench.nmt(Command::Start);
    assert!(bench.send(&frame(0x80, [])).is_empty());
    assert_eq!(bench.send(&frame(0x81, [])).len(), 1);
}

proptest::proptest! {
    /// Whatever comes over the bus, the drive neither panics nor leaves its motor's torque unlimited.
    #[test]
    fn no_frame_breaks_the_drive(
        frames in proptest::collection::vec(
            (0..8_usize, proptest::collection::vec(proptest::prelude::any::<u8>(), 0..=8)),
            1..60,
        ),
        enabled in proptest::prelude::any::<bool>(),
    ) {
        let mut bench = bench();
        if enabled {
            bench.enable(Mode::Csp);
        } else {
            bench.wait(200);
        }
        let cobs = [0x000, 0x080, 0x201, 0x301, 0x401, 0x501, 0x601, 0x701];
        for (cob, data) in frames {
            let frame = Frame::classic(Id::Standard(cobs[cob]), &data).unwrap();
            bench.send(&frame);
            bench.wait(1);
            proptest::prop_assert!(bench.motor_rad().is_finite() && bench.velocity().is_finite());
        }
    }
}
