extern crate std;

use std::vec::Vec;

use proptest::prelude::*;

use super::*;
use crate::time::Micros;

fn node(id: u8) -> NodeId {
    NodeId::new(id).unwrap()
}

const DRIVE: Identity = Identity {
    vendor: 0x1234_5678,
    product: 402,
    revision: 0x0001_0000,
    serial: 7,
};

fn ask(slave: &mut Slave, request: Request) -> (Option<Answer>, Option<Effect>) {
    let (answer, effect) = slave.on_request(request.frame().data());
    (answer.and_then(|bytes| Answer::decode(&bytes)), effect)
}

/// Bytes as python-canopen's `lss.py` sends and expects them.
#[test]
fn golden_frames() {
    let frame = Request::SwitchAll {
        configuration: true,
    }
    .frame();
    assert_eq!(frame.id(), crate::frame::Id::Standard(0x7E5));
    assert_eq!(frame.data(), [4, 1, 0, 0, 0, 0, 0, 0]);
    assert_eq!(
        Request::NodeId(Some(node(5))).frame().data(),
        [0x11, 5, 0, 0, 0, 0, 0, 0]
    );
    assert_eq!(
        Request::NodeId(None).frame().data(),
        [0x11, 255, 0, 0, 0, 0, 0, 0]
    );
    assert_eq!(
        Request::BitRate(BitRate::K250).frame().data(),
        [0x13, 0, 3, 0, 0, 0, 0, 0]
    );
    assert_eq!(
        Request::ActivateBitRate(0x1234).frame().data(),
        [0x15, 0x34, 0x12, 0, 0, 0, 0, 0]
    );
    assert_eq!(
        Request::InquireIdentity(3).frame().data(),
        [0x5D, 0, 0, 0, 0, 0, 0, 0]
    );
    let [vendor, .., serial] = switch_selective(DRIVE);
    assert_eq!(vendor.data(), [0x40, 0x78, 0x56, 0x34, 0x12, 0, 0, 0]);
    assert_eq!(serial.data(), [0x43, 7, 0, 0, 0, 0, 0, 0]);
}

#[test]
fn in_waiting_only_switching_and_identifying_are_answered() {
    let mut slave = Slave::new(DRIVE, Some(node(3)));
    for request in [
        Request::NodeId(Some(node(5))),
        Request::BitRate(BitRate::M1),
        Request::ActivateBitRate(1),
        Request::Store,
        Request::InquireIdentity(0),
        Request::InquireNodeId,
        Request::IdentifyUnconfigured,
    ] {
        assert_eq!(ask(&mut slave, request), (None, None), "{request:?}");
    }
    assert_eq!(slave.pending(), Some(node(3)));
}

#[test]
fn in_configuration_everything_is_answered() {
    let mut slave = Slave::new(DRIVE, Some(node(3)));
    ask(
        &mut slave,
        Request::SwitchAll {
            configuration: true,
        },
    );
    assert!(slave.is_configuration());
    for (part, value) in (0..).zip(DRIVE.parts()) {
        let answer = ask(&mut slave, Request::InquireIdentity(part)).0;
        assert_eq!(answer, Some(Answer::Part(part, value)));
    }
    let ok = |request| Some(Answer::Done { request, error: 0 });
    let new = Some(node(9));
    assert_eq!(
        ask(&mut slave, Request::NodeId(new)),
        (ok(0x11), Some(Effect::NodeId(new)))
    );
    // the old one is in force until the reset
    let answer = ask(&mut slave, Request::InquireNodeId).0;
    assert_eq!(answer, Some(Answer::NodeId(Some(node(3)))));
    assert_eq!(
        ask(&mut slave, Request::BitRate(BitRate::K500)),
        (ok(0x13), Some(Effect::BitRate(BitRate::K500)))
    );
    assert_eq!(
        ask(&mut slave, Request::ActivateBitRate(20)),
        (None, Some(Effect::Activate(20)))
    );
    assert_eq!(
        ask(&mut slave, Request::Store),
        (ok(0x17), Some(Effect::Store))
    );
    let back = Request::SwitchAll {
        configuration: false,
    };
    assert_eq!(ask(&mut slave, back), (None, Some(Effect::Released)));
    assert_eq!(ask(&mut slave, back), (None, None), "it waits already");
    slave.reset();
    assert_eq!(slave.active(), new);
    slave.on_request(
        Request::SwitchAll {
            configuration: true,
        }
        .frame()
        .data(),
    );
    let answer = ask(&mut slave, Request::InquireNodeId).0;
    assert_eq!(answer, Some(Answer::NodeId(new)));
    // not stored: gone with the next power-up
    ask(&mut slave, Request::NodeId(Some(node(10))));
    slave.restart();
    assert_eq!((slave.active(), slave.is_configuration()), (new, false));
}

#[test]
fn bad_node_ids_and_bit_rates_are_refused() {
    let mut slave = Slave::new(DRIVE, None);
    slave.on_request(&[4, 1, 0, 0, 0, 0, 0, 0]);
    for id in [0, 128, 254] {
        let (answer, effect) = slave.on_request(&[0x11, id, 0, 0, 0, 0, 0, 0]);
        assert_eq!((answer.unwrap()[1], effect), (1, None), "{id}");
    }
    for (table, index) in [(0, 5), (0, 9), (1, 0)] {
        let (answer, effect) = slave.on_request(&[0x13, table, index, 0, 0, 0, 0, 0]);
        assert_eq!((answer.unwrap()[1], effect), (1, None), "{table} {index}");
    }
    assert_eq!(slave.on_request(&[4, 2, 0, 0, 0, 0, 0, 0]), (None, None));
    assert!(slave.is_configuration(), "mode 2 is none");
    assert_eq!(slave.on_request(&[0x11, 5]), (None, None), "short frames");
}

#[test]
fn switch_selective_wants_the_whole_identity_in_order() {
    let answers = |slave: &mut Slave, frames: &[Frame]| -> usize {
        let answered = |f: &&Frame| slave.on_request(f.data()).0.is_some();
        frames.iter().filter(answered).count()
    };
    let frames = switch_selective(DRIVE);
    let mut slave = Slave::new(DRIVE, None);
    assert_eq!(answers(&mut slave, &frames), 1);
    assert!(slave.is_configuration());
    let mut slave = Slave::new(DRIVE, None);
    assert_eq!(answers(&mut slave, &frames[1..]), 0);
    let [a, b, c, d] = frames;
    assert_eq!(answers(&mut slave, &[a, c, b, d]), 0);
    let other = Identity { serial: 8, ..DRIVE };
    assert_eq!(answers(&mut slave, &switch_selective(other)), 0);
    assert!(!slave.is_configuration());
}

#[test]
fn identify_wants_the_identity_in_the_range() {
    let range = |low: u32, high: u32| {
        let with = |serial| Identity { serial, ..DRIVE };
        let mut slave = Slave::new(DRIVE, Some(node(1)));
        let frames = identify(with(low), with(high));
        let answers: Vec<_> = frames
            .iter()
            .filter_map(|f| slave.on_request(f.data()).0)
            .collect();
        !answers.is_empty()
    };
    assert!(range(7, 7) && range(0, 100));
    assert!(!range(8, 100) && !range(0, 6));
}

/// Runs a scan against slaves, of which some frames may be lost.
fn scan(slaves: &mut [Slave], mut lost: impl FnMut() -> bool) -> Scan {
    let (mut scan, mut now) = (Fastscan::new(), Micros(0));
    // 1 + 4·33 questions
    for _ in 0..134 {
        match scan.poll(now) {
            Scan::Send(frame) => {
                for slave in slaves.iter_mut() {
                    if let (Some(answer), _) = slave.on_request(frame.data())
                        && !lost()
                    {
                        scan.on_answer(&answer);
                    }
                }
            }
            Scan::Wait => panic!("the window has passed"),
            end @ (Scan::Found(_) | Scan::Nobody) => return end,
        }
        assert_eq!(scan.poll(now), Scan::Wait);
        now = now + ANSWER_WINDOW;
    }
    panic!("the scan never ended");
}

#[test]
fn a_scan_of_nobody_ends_at_once() {
    assert_eq!(scan(&mut [], || false), Scan::Nobody);
    let configured = Slave::new(DRIVE, Some(node(1)));
    assert_eq!(scan(&mut [configured], || false), Scan::Nobody);
}

proptest! {
    #[test]
    fn scans_find_every_device_the_least_first(parts in prop::collection::btree_set(any::<[u32; 4]>(), 1..5)) {
        let identities: Vec<_> = parts.into_iter().map(Identity::from_parts).collect();
        let mut slaves: Vec<_> = identities.iter().map(|id| Slave::new(*id, None)).collect();
        for (id, expected) in (1..).zip(&identities) {
            prop_assert_eq!(scan(&mut slaves, || false), Scan::Found(*expected));
            let chosen: Vec<_> = slaves.iter_mut().filter(|s| s.is_configuration()).collect();
            prop_assert_eq!(chosen.len(), 1);
            for slave in chosen {
                ask(slave, Request::NodeId(NodeId::new(id)));
                ask(slave, Request::SwitchAll { configuration: false });
                slave.reset();
            }
        }
        prop_assert_eq!(scan(&mut slaves, || false), Scan::Nobody);
    }

    #[test]
    fn a_scan_with_lost_answers_ends_and_chooses_nobody_wrong(
        id in any::<[u32; 4]>(), lost in prop::collection::vec(prop::bool::weighted(0.02), 140),
    ) {
        let mut slaves = [Slave::new(Identity::from_parts(id), None)];
        let mut lost = lost.into_iter();
        if let Scan::Found(found) = scan(&mut slaves, || lost.next().unwrap_or(false)) {
            prop_assert_eq!(found, Identity::from_parts(id));
            prop_assert!(slaves[0].is_configuration());
        }
    }

    #[test]
    fn no_frame_breaks_the_slave(frames in prop::collection::vec(prop::collection::vec(any::<u8>(), 0..=8), 0..60)) {
        let mut slave = Slave::new(DRIVE, None);
        for frame in frames {
            let _ = slave.on_request(&frame);
            let _ = Answer::decode(&frame);
        }
    }
}
