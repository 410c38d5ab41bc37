//! Keeping a node, in virtual time and over a wire that loses: who it is, its first fault, its next image.
#![forbid(unsafe_code)]

#[path = "maintenance/bench.rs"]
mod bench;
#[path = "maintenance/master.rs"]
mod master;

use bench::{Bench, ROBOT, TARGET, image_of, program};
use bus::wire::Kind;
use firmware::Station;
use firmware::update::image::CRC;
use hil_sim::cell::{Cell, Wiring};
use host::error::Error;
use host::maintenance::Sending;
use master::Master;
use protocol::fault::Cause;
use protocol::maintenance::{
    ImageHeader, ImagePhase, MaintenanceRefusal, ResetCause, Slot, Standing,
};
use protocol::message::{NodeState, ServoLaw};
use protocol::time::Micros;
use protocol::transfer::Mtu;
use robots::TrackRule;

fn refusal<T: std::fmt::Debug>(result: Result<T, Error>) -> MaintenanceRefusal {
    match result {
        Err(Error::Maintenance { refusal, .. }) => refusal,
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_node_says_who_it_is_and_why_it_started() {
    let mut bench = Bench::new();
    let mut client = bench.client(3);
    let who = client.identify().unwrap();
    assert_eq!(
        (who.robot.as_str(), who.target.as_str()),
        ("conveyor", TARGET)
    );
    assert_eq!(who.schema_hash, protocol::schema::SCHEMA_HASH);
    let plain = client.identify_plainly().unwrap();
    assert_eq!(
        (who.unique_id, who.config_crc),
        (plain.unique_id, plain.config_crc)
    );
    let image = who.image.unwrap();
    assert_eq!((image.slot, image.version), (Slot::A, (0, 1, 0)));
    let report = client.reset_cause().unwrap();
    assert_eq!((report.cause, report.boots), (ResetCause::PowerOn, 1));
    // 2.5 s at 2 ms, and what the questions took
    assert!((1200..1400).contains(&report.steps), "{}", report.steps);
    assert_eq!(client.first_fault().unwrap(), None);
    bench.reset();
    let report = bench.client(3).reset_cause().unwrap();
    assert_eq!((report.cause, report.boots), (ResetCause::Watchdog, 2));
}

#[test]
fn the_signals_before_the_first_fault_in_motion_survive_a_reset_and_a_bad_bus() {
    let mut bench = Bench::new();
    let mut master = Master::join(&mut bench);
    master.enable(&mut bench);
    master.start(&mut bench);
    master.hold(&mut bench, 1000);
    assert_eq!(bench.state(), NodeState::Moving);
    master.stop_all(&mut bench);
    bench.run(2000);
    assert_eq!(bench.state(), NodeState::Faulted);

    let mut client = bench.client(3);
    let record = client.first_fault().unwrap().unwrap();
    assert_eq!(record.fault.cause, Cause::EmergencyStop);
    assert_eq!(record.fault.during, NodeState::Moving);
    assert_eq!(
        (record.instruction, record.boot, record.samples),
        (9, 1, 145)
    );
    let samples = client.samples(&record).unwrap();
    assert_eq!(samples.len(), 145);
    let steps: Vec<u32> = samples.iter().map(|sample| sample.step).collect();
    assert!(steps.windows(2).skip(95).all(|pair| pair[1] == pair[0] + 1));
    assert!(
        steps
            .windows(2)
            .take(94)
            .all(|pair| pair[1] == pair[0] + 10)
    );
    // the stop came by the bus, after that step and before the next
    assert_eq!(steps.last(), Some(&(record.fault.step + 1)));
    // it stood still, then it moved: forward, and with what the record says of it in between
    let moving: Vec<_> = samples
        .iter()
        .filter(|s| s.state == NodeState::Moving)
        .collect();
    assert!(moving.len() > 90, "{}", moving.len());
    let way: Vec<i32> = moving.iter().map(|sample| sample.axes[0].actual).collect();
    assert!(way.windows(2).all(|pair| pair[1] >= pair[0]));
    assert!(way[way.len() - 1] > way[0] + 1000, "{way:?}");
    assert!(samples.iter().any(|sample| sample.axes[0].current_ma != 0));
    assert!(samples[..144].iter().all(|sample| sample.fault == 0));
    assert_eq!(samples[144].fault, 14);

    bench.reset();
    for (loss, twice) in [(None, true), (Some(50), false), (Some(19), true)] {
        (bench.loss, bench.twice) = (loss, twice);
        let mut client = bench.client(4);
        let again = client.first_fault().unwrap().unwrap();
        assert_eq!(again, record, "{loss:?}");
        assert_eq!(client.samples(&again).unwrap(), samples, "{loss:?}");
    }
    (bench.loss, bench.twice) = (None, false);

    // only the holder of the lease may forget it, and only this one
    let mut client = bench.client(3);
    let lease = |refusal| matches!(refusal, MaintenanceRefusal::NoLease { .. });
    assert!(lease(refusal(client.clear(&record))));
    client.acquire().unwrap();
    let other = protocol::maintenance::FaultRecord {
        record: record.record ^ 1,
        ..record
    };
    assert_eq!(refusal(client.clear(&other)), MaintenanceRefusal::NoRecord);
    client.clear(&record).unwrap();
    assert_eq!(client.first_fault().unwrap(), None);
    assert_eq!(
        refusal(client.samples(&record)),
        MaintenanceRefusal::NoRecord
    );
    client.release().unwrap();
    bench.reset();
    assert_eq!(bench.client(3).first_fault().unwrap(), None);
}

#[test]
fn an_image_comes_through_a_bus_that_loses_and_doubles() {
    for (loss, twice) in [
        (None, false),
        (None, true),
        (Some(300), false),
        (Some(170), true),
    ] {
        let mut bench = Bench::new();
        (bench.loss, bench.twice) = (loss, twice);
        let bytes = program(7000);
        let header = image_of(&bytes, (0, 2, 0));
        let mut client = bench.client(3);
        client.acquire().unwrap();
        let mut told = Vec::new();
        let status = client
            .send_image(&header, &bytes, |sending| told.push(sending))
            .unwrap();
        assert_eq!(
            (status.phase, status.slot),
            (ImagePhase::Activated, Slot::B)
        );
        assert_eq!(told.first(), Some(&Sending::Bytes { done: 0, of: 7000 }));
        assert!(
            told.ends_with(&[Sending::Verified, Sending::Activated]),
            "{told:?}"
        );
        client.release().unwrap();
        (bench.loss, bench.twice) = (None, false);
        bench.reset();
        let mut client = bench.client(3);
        let running = client.identify().unwrap().image.unwrap();
        assert_eq!(
            (running.version, running.standing),
            ((0, 2, 0), Standing::Trial)
        );
        let lease = refusal(client.confirm());
        assert!(matches!(lease, MaintenanceRefusal::NoLease { .. }));
        client.acquire().unwrap();
        client.confirm().unwrap();
        assert_eq!(refusal(client.confirm()), MaintenanceRefusal::NotOnTrial);
        bench.reset();
        let running = bench.client(3).identify().unwrap().image.unwrap();
        assert_eq!(
            (running.version, running.standing),
            ((0, 2, 0), Standing::Confirmed)
        );
    }
}

#[test]
fn a_bus_that_drops_ends_the_lease_and_the_next_attempt_goes_on_where_it_was() {
    let mut bench = Bench::new();
    let bytes = program(7000);
    let header = image_of(&bytes, (0, 2, 0));
    // away for longer than the lease, and back while the request is still repeated
    bench.away = Some((600, Micros::from_millis(1300)));
    let mut client = bench.client(3);
    client.acquire().unwrap();
    let lost = refusal(client.send_image(&header, &bytes, |_| {}));
    assert_eq!(lost, MaintenanceRefusal::NoLease { epoch: 0 });
    let next = client.image_status().unwrap().next;
    assert!(next > 0 && next < 7000, "{next}");

    // away for good
    bench.away = Some((bench.sent + 300, Micros::from_millis(100_000)));
    let mut client = bench.client(3);
    client.acquire().unwrap();
    let silent = client.send_image(&header, &bytes, |_| {});
    assert!(matches!(silent, Err(Error::Silent { .. })), "{silent:?}");
    bench.back_at = Micros(0);

    let mut first = None;
    let mut client = bench.client(4);
    client.acquire().unwrap();
    client
        .send_image(&header, &bytes, |sending| {
            first.get_or_insert(sending);
        })
        .unwrap();
    let Some(Sending::Bytes { done, of: 7000 }) = first else {
        panic!("{first:?}");
    };
    assert!(done > next, "{done} after {next}");
    bench.reset();
    let running = bench.client(3).identify().unwrap().image.unwrap();
    assert_eq!(running.version, (0, 2, 0));
}

#[test]
fn a_reset_in_the_middle_leaves_the_old_image_and_the_next_attempt_begins_anew() {
    let mut bench = Bench::new();
    let bytes = program(7000);
    let header = image_of(&bytes, (0, 2, 0));
    bench.away = Some((600, Micros::from_millis(100_000)));
    let mut client = bench.client(3);
    client.acquire().unwrap();
    assert!(client.send_image(&header, &bytes, |_| {}).is_err());
    bench.reset();
    let mut client = bench.client(3);
    let running = client.identify().unwrap().image.unwrap();
    assert_eq!(
        (running.version, running.standing),
        ((0, 1, 0), Standing::Confirmed)
    );
    assert_eq!(client.image_status().unwrap().phase, ImagePhase::None);
    client.acquire().unwrap();
    client.send_image(&header, &bytes, |_| {}).unwrap();
}

#[test]
fn two_who_want_to_write_do_not_get_in_each_others_way() {
    let mut bench = Bench::new();
    let (mine, others) = (program(3000), program(2000));
    bench.away = Some((300, Micros::from_millis(100_000)));
    let mut first = bench.client(3);
    first.acquire().unwrap();
    assert!(
        first
            .send_image(&image_of(&mine, (0, 2, 0)), &mine, |_| {})
            .is_err()
    );
    bench.back_at = Micros(0);
    let mut first = bench.client(3);
    first.acquire().unwrap();
    let mut second = bench.client(4);
    let held = second.acquire();
    assert!(
        matches!(held, Err(Error::LeaseHeld { holder: 3, .. })),
        "{held:?}"
    );
    // anyone may look on
    assert_eq!(second.image_status().unwrap().phase, ImagePhase::Receiving);
    let refused = refusal(second.send_image(&image_of(&others, (0, 3, 0)), &others, |_| {}));
    assert!(matches!(refused, MaintenanceRefusal::NoLease { .. }));
    // the first one has gone: its lease ends, and what it left behind is told and dropped
    bench.run(1500);
    let mut second = bench.client(4);
    second.acquire().unwrap();
    let mut told = Vec::new();
    let header = image_of(&others, (0, 3, 0));
    second
        .send_image(&header, &others, |sending| told.push(sending))
        .unwrap();
    let dropped = Sending::Dropped {
        image: CRC.checksum(&mine),
    };
    assert_eq!(told.first(), Some(&dropped));
}

#[test]
fn what_may_not_be_is_refused_and_nothing_is_written() {
    let mut bench = Bench::new();
    let before = bench.flash.lock().unwrap().clone();
    let bytes = program(1000);
    let header = image_of(&bytes, (0, 2, 0));
    let mut client = bench.client(3);
    client.acquire().unwrap();
    let mut send = |header: &ImageHeader| refusal(client.send_image(header, &bytes, |_| {}));
    for (robot, target, length, expected) in [
        ("polycrank", TARGET, 1000, MaintenanceRefusal::WrongRobot),
        (
            "conveyor",
            "stm32g474",
            1000,
            MaintenanceRefusal::WrongTarget,
        ),
        (
            "conveyor",
            TARGET,
            0,
            MaintenanceRefusal::WrongLength { capacity: 8192 },
        ),
        (
            "conveyor",
            TARGET,
            8193,
            MaintenanceRefusal::WrongLength { capacity: 8192 },
        ),
    ] {
        let wrong = ImageHeader {
            robot: robot.try_into().unwrap(),
            target: target.try_into().unwrap(),
            length,
            ..header.clone()
        };
        assert_eq!(send(&wrong), expected);
    }
    client.release().unwrap();
    // torque on: with the lease of the master itself nobody may write, and without it neither
    let mut master = Master::join(&mut bench);
    master.enable(&mut bench);
    let mut client = bench.client(1);
    // the same number as the master's: the lease is its own, and anew
    client.acquire().unwrap();
    let on = refusal(client.send_image(&header, &bytes, |_| {}));
    let state = NodeState::Unsynchronised;
    assert_eq!(on, MaintenanceRefusal::TorqueOn { state });
    assert_eq!(
        refusal(client.confirm()),
        MaintenanceRefusal::TorqueOn { state }
    );
    assert_eq!(
        client.first_fault().unwrap(),
        None,
        "anyone may read, also now"
    );
    client.release().unwrap();
    assert_eq!(*bench.flash.lock().unwrap(), before);

    // other bytes than announced
    bench.reset();
    let mut wrong = bytes.clone();
    wrong[999] ^= 1;
    let mut client = bench.client(3);
    client.acquire().unwrap();
    let got = CRC.checksum(&wrong);
    assert_eq!(
        refusal(client.send_image(&header, &wrong, |_| {})),
        MaintenanceRefusal::WrongCrc { got }
    );
    bench.reset();
    let running = bench.client(3).identify().unwrap().image.unwrap();
    assert_eq!(
        (running.version, running.standing),
        ((0, 1, 0), Standing::Confirmed)
    );
}

#[test]
fn a_node_without_a_keeper_says_who_it_is_and_nothing_else() {
    let mut bench = Bench::new();
    let station = Station {
        effector: ROBOT.effector(),
        unique_id: 5,
        mtu: Mtu::Classic,
        law: ServoLaw::DrivePosition,
        velocity_factor: 0.5,
        one_wire: false,
        track: TrackRule::Keep,
    };
    bench.cell = Cell::new(Kind::Classic);
    bench
        .cell
        .add(ROBOT, &station, &Wiring::classic(&[0]), 1)
        .unwrap();
    let mut client = bench.client(3);
    assert!(matches!(
        client.identify(),
        Err(Error::Silent {
            waited_ms: 1800,
            ..
        })
    ));
    assert_eq!(client.identify_plainly().unwrap().unique_id, 5);
    let taken = client.acquire();
    assert!(taken.is_ok(), "{taken:?}");
}
