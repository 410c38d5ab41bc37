//! Services of CiA 301 and CiA 305 that the node does not need every day, seen from the wire.

use protocol::canopen::cia402::Mode;
use protocol::canopen::emcy::{Emergency, ErrorCode};
use protocol::canopen::lss::{self, Answer, Fastscan, Identity, Request, Scan};
use protocol::canopen::nmt::{self, Command};
use protocol::canopen::node::{Function, frame, standard};
use protocol::canopen::sdo::{Abort, Address, BlockClient, Outcome};
use protocol::frame::Frame;
use protocol::time::Micros;

use super::bench::{Bench, axis_setup};
use crate::drive::DriveFault;

fn bench() -> Bench {
    let mut bench = Bench::new(&axis_setup(0, 10.0));
    bench.wait(200);
    bench
}

fn emergencies(bench: &Bench) -> Vec<(u64, ErrorCode)> {
    let decoded = bench
        .log
        .iter()
        .map(|item| (item.at_ns, Emergency::decode(&item.frame)));
    decoded
        .filter_map(|(at, emergency)| Some((at, emergency?.1.code)))
        .collect()
}

fn tpdos(bench: &Bench) -> usize {
    let cob = Some(bench.node.cob(Function::Tpdo1));
    let of = |item: &&crate::plant::robot::Sent| standard(&item.frame) == cob;
    bench.log.iter().filter(of).count()
}

#[test]
fn a_counted_sync_is_wanted_where_1019_says_so() {
    let mut bench = bench();
    bench.write(0x1019, &[4]);
    bench.nmt(Command::Start);
    bench.send(&frame(0x80, [1]));
    assert_eq!((tpdos(&bench), emergencies(&bench).len()), (1, 0));
    bench.send(&frame(0x80, []));
    assert_eq!(tpdos(&bench), 1);
    let codes: Vec<_> = emergencies(&bench).iter().map(|(_, code)| *code).collect();
    assert_eq!(codes, [ErrorCode::SYNC_LENGTH]);
}

#[test]
fn a_tpdo_begins_with_its_sync_and_a_late_rpdo_does_not_count() {
    let mut bench = bench();
    bench.write(0x1019, &[4]);
    let cob = u32::from(bench.node.cob(Function::Tpdo1)) | 1 << 30;
    bench.write_sub(0x1800, 1, &(cob | 1 << 31).to_le_bytes());
    bench.write_sub(0x1800, 2, &[2]);
    bench.write_sub(0x1800, 6, &[3]);
    bench.write_sub(0x1800, 1, &cob.to_le_bytes());
    bench.nmt(Command::Start);
    let sent = [1, 2, 3, 4, 1, 2].map(|counter| {
        let before = tpdos(&bench);
        bench.send(&frame(0x80, [counter]));
        tpdos(&bench) > before
    });
    assert_eq!(sent, [false, false, true, false, true, false]);

    // the window is 1 ms: an RPDO after 2 ms is thrown away
    bench.write(0x1007, &1000_u32.to_le_bytes());
    bench.send(&frame(0x80, [3]));
    bench.wait(2);
    let rpdo = bench.node.cob(Function::Rpdo1);
    bench.send(&frame(rpdo, [6, 0, 9, 0, 0, 0]));
    bench.send(&frame(0x80, [4]));
    assert_eq!(bench.read(0x607A, 0), 0);
    bench.send(&frame(rpdo, [6, 0, 9, 0, 0, 0]));
    bench.send(&frame(0x80, [1]));
    assert_eq!(bench.read(0x607A, 0), 9);
}

#[test]
fn errors_are_kept_and_cleared_and_emergencies_inhibited() {
    let mut bench = bench();
    // 20 ms
    bench.write(0x1015, &200_u16.to_le_bytes());
    bench
        .robot
        .inject(0, Some(DriveFault::Trip(ErrorCode::OVER_TEMPERATURE)));
    bench.wait(1);
    bench
        .robot
        .inject(0, Some(DriveFault::Trip(ErrorCode::UNDER_VOLTAGE)));
    bench.wait(30);
    let told = emergencies(&bench);
    assert_eq!(told.len(), 2);
    assert!(told[1].0 - told[0].0 >= 20_000_000, "{told:?}");
    assert_eq!(bench.read(0x1003, 0), 2);
    assert_eq!(bench.read(0x1003, 1), 0x3220);
    assert_eq!(bench.read(0x1003, 2), 0x4310);
    assert_eq!(bench.read(0x1001, 0), 0b1101);
    let at = Address::new(0x1003, 0);
    assert_eq!(
        bench.write(0x1003, &[1]),
        Outcome::Refused(at, Abort::Range)
    );
    assert_eq!(bench.write(0x1003, &[0]), Outcome::Downloaded(at));
    assert_eq!(bench.read(0x1003, 0), 0);
}

#[test]
fn a_lost_heartbeat_changes_the_nmt_state_as_1029_says() {
    for (behaviour, state) in [
        (0, nmt::State::PreOperational),
        (1, nmt::State::Operational),
        (2, nmt::State::Stopped),
    ] {
        let mut bench = bench();
        bench.write_sub(0x1029, 1, &[behaviour]);
        // node 127, 100 ms
        bench.write_sub(0x1016, 1, &0x007F_0064_u32.to_le_bytes());
        bench.nmt(Command::Start);
        bench.wait(150);
        assert_eq!(bench.robot.drive(0).unwrap().nmt_state(), state);
    }
}

#[test]
fn a_note_goes_in_and_out_in_blocks() {
    let mut bench = bench();
    let at = Address::new(0x2000, 0);
    let note: Vec<u8> = (0..=255).collect();
    let mut client = BlockClient::<256>::default();
    let first = client.download(Micros(0), at, &note).unwrap();
    assert_eq!(bench.converse(&mut client, first), Outcome::Downloaded(at));
    let mut client = BlockClient::<256>::default();
    let first = client.upload(Micros(0), at).unwrap();
    assert_eq!(bench.converse(&mut client, first), Outcome::Uploaded(at));
    assert_eq!(client.data(), note);
}

fn ask(bench: &mut Bench, frame: &Frame) -> Option<Answer> {
    let sent = bench.send(frame);
    let answer = sent
        .iter()
        .find(|item| standard(&item.frame) == Some(lss::SLAVE_COB));
    Answer::decode(answer?.frame.data())
}

#[test]
fn a_drive_loses_its_node_identifier_and_is_found_again() {
    let mut bench = bench();
    let serial = bench.read(0x1018, 4);
    let identity = Identity {
        vendor: 0,
        product: 402,
        revision: 0x0001_0000,
        serial,
    };
    let answers = lss::switch_selective(identity).map(|frame| ask(&mut bench, &frame));
    assert_eq!(answers, [None, None, None, Some(Answer::Switched)]);
    ask(&mut bench, &Request::NodeId(None).frame());
    ask(&mut bench, &Request::Store.frame());
    bench.nmt(Command::ResetNode);
    bench.log.clear();
    bench.wait(500);
    assert!(bench.log.is_empty(), "without identifier it says nothing");
    let unconfigured = Request::IdentifyUnconfigured.frame();
    assert_eq!(ask(&mut bench, &unconfigured), Some(Answer::Unconfigured));

    let mut scan = Fastscan::new();
    let found = loop {
        match scan.poll(Micros(bench.now_ns / 1000)) {
            Scan::Send(frame) => {
                for item in bench.send(&frame) {
                    scan.on_answer(item.frame.data());
                }
            }
            Scan::Wait => bench.wait(1),
            end @ (Scan::Found(_) | Scan::Nobody) => break end,
        }
    };
    assert_eq!(found, Scan::Found(identity));
    let node = protocol::canopen::node::NodeId::new(42);
    let done = ask(&mut bench, &Request::NodeId(node).frame());
    assert_eq!(
        done,
        Some(Answer::Done {
            request: 0x11,
            error: 0
        })
    );
    let release = Request::SwitchAll {
        configuration: false,
    };
    bench.send(&release.frame());
    bench.wait(200);
    let boot = bench.log.iter().map(|item| &item.frame);
    let boots: Vec<_> = boot.filter_map(nmt::decode_heartbeat).collect();
    assert_eq!(boots[0], (node.unwrap(), nmt::State::Initialising));
    bench.node = node.unwrap();
    assert_eq!(bench.read(0x1400, 1), 0x4000_022A, "the defaults follow");
    bench.start(Mode::Csp);
    assert!(tpdos(&bench) > 0);
}

#[test]
fn a_drive_on_a_classical_bus_has_no_slot_in_the_fast_profile() {
    let mut bench = bench();
    let at = Address::new(0x2010, 0);
    assert_eq!(
        bench.write(0x2010, &[1]),
        Outcome::Refused(at, Abort::DeviceState)
    );
    assert_eq!(bench.write(0x2010, &[0]), Outcome::Downloaded(at));
}
