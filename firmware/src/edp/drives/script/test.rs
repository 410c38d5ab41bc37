extern crate std;

use std::vec;
use std::vec::Vec;

use super::*;
use protocol::canopen::sdo::Address;

fn node(id: u8) -> DriveId {
    DriveId::new(id).unwrap()
}

/// Every write of a script: where, and the bytes.
fn writes(mut script: Script, setup: &AxisSetup) -> Vec<(Address, Vec<u8>)> {
    let mut all = Vec::new();
    while let Some(write) = script.next(node(3), setup) {
        all.push((write.at, write.value.data().to_vec()));
        assert!(all.len() < usize::from(WRITES));
    }
    all
}

#[test]
fn interpolation_periods() {
    assert_eq!(interpolation_period(Micros(2000)), (2, -3));
    assert_eq!(interpolation_period(Micros(1000)), (1, -3));
    assert_eq!(interpolation_period(Micros(2500)), (25, -4));
    assert_eq!(interpolation_period(Micros(250)), (25, -5));
}

#[test]
fn a_stored_setup_ends_with_its_fingerprint_and_the_order_to_store() {
    let plain = AxisSetup::default();
    let stored = AxisSetup {
        stored: true,
        ..plain
    };
    let [date, time] = Script::fingerprint(node(3), &stored);
    let mut expected = writes(Script::new(), &plain);
    let at = |sub| Address::new(0x1020, sub);
    expected.push((at(1), date.to_le_bytes().to_vec()));
    expected.push((at(2), time.to_le_bytes().to_vec()));
    expected.push((Address::new(0x1010, 1), b"save".to_vec()));
    assert_eq!(writes(Script::new(), &stored), expected);
    let volatile = [
        (Address::new(0x60B8, 0), vec![0, 0]),
        (Address::new(0x6060, 0), vec![8]),
    ];
    assert_eq!(writes(Script::of_stored(), &stored), volatile);
}

/// An independent count of what the fingerprint is made of.
fn hashed(setup: &AxisSetup) -> [u32; 2] {
    let mut bytes = Vec::new();
    for (at, value) in writes(Script::new(), setup) {
        if at.index != 0x60B8 && at.index != 0x6060 {
            bytes.extend(at.index.to_le_bytes());
            bytes.push(at.sub);
            bytes.push(u8::try_from(value.len()).unwrap());
            bytes.extend(value);
        }
    }
    let hash = bytes.iter().fold(0xCBF2_9CE4_8422_2325_u64, |hash, byte| {
        (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01B3)
    });
    let days = u32::try_from((hash & 0xFFFF_FFFF) % 65535 + 1).unwrap();
    let ms = u32::try_from((hash >> 32) % 86_399_999 + 1).unwrap();
    [days, ms]
}

#[test]
fn the_fingerprint_is_a_time_of_day_and_another_for_every_other_setup() {
    let plain = AxisSetup::default();
    let own = Script::fingerprint(node(3), &plain);
    assert_eq!(own, hashed(&plain));
    let same = AxisSetup {
        mode: 10,
        stored: true,
        find: true,
        ..plain
    };
    assert_eq!(
        Script::fingerprint(node(3), &same),
        own,
        "not of the set-up"
    );
    let mut others = vec![Script::fingerprint(node(4), &plain), own];
    for other in [
        AxisSetup {
            sync_cob: 0x0E2,
            ..plain
        },
        AxisSetup {
            period: Micros(1000),
            ..plain
        },
        AxisSetup {
            master: 126,
            ..plain
        },
        AxisSetup {
            following_window: 999_999,
            ..plain
        },
        AxisSetup {
            quick_stop_deceleration: 99_999_999,
            ..plain
        },
        AxisSetup {
            max_torque: 1000,
            ..plain
        },
        AxisSetup {
            torque_offset: true,
            ..plain
        },
        AxisSetup {
            slot: Slot::new(1),
            ..plain
        },
    ] {
        others.push(Script::fingerprint(node(3), &other));
    }
    for [days, ms] in &others {
        assert!((1..=0xFFFF).contains(days) && (1..86_400_000).contains(ms));
    }
    others.sort_unstable();
    others.dedup();
    assert_eq!(others.len(), 10);
}
