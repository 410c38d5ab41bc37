extern crate std;
use std::vec::Vec;

use proptest::prelude::*;

use super::super::sdo::Address;
use super::super::sync::Sync;
use super::*;

const STATUS: Entry = Entry::new(0x6041, 0, 16);
const POSITION: Entry = Entry::new(0x6064, 0, 32);
const GAP: Entry = Entry::new(0x0005, 0, 8);

fn mapping(entries: &[Entry]) -> Mapping {
    Mapping::new(entries).unwrap()
}

#[test]
fn golden_entry_and_payload() {
    assert_eq!(POSITION.0, 0x6064_0020);
    assert_eq!(POSITION.address(), Address::new(0x6064, 0));
    let map = mapping(&[STATUS, GAP, POSITION]);
    let payload = map.pack(|entry| if entry == STATUS { 0x0637 } else { 0x1234_5678 });
    assert_eq!(payload.data(), [0x37, 0x06, 0x00, 0x78, 0x56, 0x34, 0x12]);
    let frame = payload.frame(0x185);
    assert_eq!(frame.id(), crate::frame::Id::Standard(0x185));
    assert_eq!(frame.data(), payload.data());
}

#[test]
fn gaps_are_left_out_and_longer_frames_accepted() {
    let map = mapping(&[STATUS, GAP, POSITION]);
    let mut seen = Vec::new();
    let data = [0x37, 0x06, 0xFF, 0x78, 0x56, 0x34, 0x12, 0xEE];
    map.unpack(&data, |entry, value| seen.push((entry, value)))
        .unwrap();
    assert_eq!(seen, [(STATUS, 0x0637), (POSITION, 0x1234_5678)]);
    assert!(
        map.unpack(&data[..6], |_, _| panic!("nothing is written"))
            .is_err()
    );
}

#[test]
fn invalid_mappings_are_refused() {
    let wide = Entry::new(0x6064, 0, 40);
    assert_eq!(Mapping::new(&[wide, POSITION]), Err(MappingError::TooLong));
    assert_eq!(
        Mapping::new(&[Entry::new(0x6064, 0, 0)]),
        Err(MappingError::Bits)
    );
    assert_eq!(
        Mapping::new(&[Entry::new(0x6064, 0, 65)]),
        Err(MappingError::Bits)
    );
    let bit = Entry::new(0x60FD, 0, 1);
    assert_eq!(Mapping::new(&[bit; 9]), Err(MappingError::TooMany));
}

#[test]
fn transmission_codes() {
    for code in 0..=255 {
        match Transmission::from_code(code) {
            Some(kind) => assert_eq!(kind.code(), code),
            None => assert!((241..=253).contains(&code)),
        }
    }
}

#[test]
fn a_synchronous_rpdo_waits_for_sync_and_the_last_one_counts() {
    let communication = Communication::new(0x205, Transmission::SyncCyclic(1));
    let mut rpdo = Rpdo::new(communication, mapping(&[STATUS]));
    assert_eq!(rpdo.on_sync(), None);
    assert_eq!(rpdo.on_data(Micros(0), &[1, 0]), Received::Latched);
    assert_eq!(rpdo.on_data(Micros(0), &[2, 0]), Received::Latched);
    assert_eq!(rpdo.on_data(Micros(0), &[3]), Received::WrongLength);
    assert_eq!(rpdo.on_sync(), Payload::new(&[2, 0]));
    assert_eq!(rpdo.on_sync(), None);
}

#[test]
fn an_event_rpdo_takes_effect_at_once_and_its_timer_runs_out_once() {
    let communication = Communication::new(0x205, Transmission::EventProfile).event(5);
    let mut rpdo = Rpdo::new(communication, mapping(&[STATUS]));
    assert!(!rpdo.timed_out(Micros(1_000_000)));
    let payload = Payload::new(&[1, 0]).unwrap();
    assert_eq!(rpdo.on_data(Micros(0), &[1, 0]), Received::Now(payload));
    assert!(!rpdo.timed_out(Micros(5000)));
    assert!(rpdo.timed_out(Micros(5001)));
    assert!(!rpdo.timed_out(Micros(9000)));
    let off = Communication {
        enabled: false,
        ..communication
    };
    assert_eq!(
        Rpdo::new(off, mapping(&[])).on_data(Micros(0), &[]),
        Received::Disabled
    );
}

#[test]
fn a_cyclic_tpdo_comes_at_every_nth_sync() {
    let communication = Communication::new(0x185, Transmission::SyncCyclic(3));
    let mut tpdo = Tpdo::new(communication, mapping(&[STATUS]));
    let sent: Vec<bool> = (0..7)
        .map(|k| tpdo.on_sync(Micros(k), Sync::Plain, Payload::default()))
        .collect();
    assert_eq!(sent, [false, false, true, false, false, true, false]);
    assert!(!tpdo.poll(Micros(100), Payload::default()));
}

#[test]
fn a_cyclic_tpdo_begins_with_its_value_of_the_sync_counter() {
    let communication = Communication {
        sync_start: 2,
        ..Communication::new(0x185, Transmission::SyncCyclic(2))
    };
    let mut tpdo = Tpdo::new(communication, mapping(&[STATUS]));
    let mut sent = |counters: [u8; 6]| {
        counters.map(|n| tpdo.on_sync(Micros(0), Sync::Counted(n), Payload::default()))
    };
    // overflow 4: the counter says when to begin, afterwards the PDO counts itself
    let begins = [false, true, false, true, false, true];
    assert_eq!(sent([1, 2, 3, 4, 1, 2]), begins);
    tpdo.reset();
    // without a counter the start value has no meaning
    assert!(tpdo.on_sync(Micros(0), Sync::Plain, Payload::default()));
}

#[test]
fn an_acyclic_tpdo_comes_at_the_sync_after_a_change() {
    let communication = Communication::new(0x185, Transmission::SyncAcyclic);
    let mut tpdo = Tpdo::new(communication, mapping(&[STATUS]));
    let (a, b) = (
        Payload::new(&[1, 0]).unwrap(),
        Payload::new(&[2, 0]).unwrap(),
    );
    let sent = [a, a, b, b].map(|payload| tpdo.on_sync(Micros(0), Sync::Plain, payload));
    assert_eq!(sent, [true, false, true, false]);
}

#[test]
fn an_event_tpdo_respects_inhibit_and_event_times() {
    let communication = Communication::new(0x285, Transmission::EventProfile)
        .inhibit(10)
        .event(4);
    let mut tpdo = Tpdo::new(communication, mapping(&[STATUS]));
    let (a, b) = (
        Payload::new(&[1, 0]).unwrap(),
        Payload::new(&[2, 0]).unwrap(),
    );
    assert!(tpdo.poll(Micros(0), a), "first");
    assert!(!tpdo.poll(Micros(500), b), "inhibited");
    assert!(tpdo.poll(Micros(1000), b), "changed");
    assert!(!tpdo.poll(Micros(4999), b), "unchanged");
    assert!(tpdo.poll(Micros(5000), b), "event timer");
    assert!(
        !tpdo.on_sync(Micros(5000), Sync::Plain, a),
        "SYNC has no effect"
    );
}

#[test]
fn golden_setup() {
    let communication = Communication::new(0x283, Transmission::EventProfile).inhibit(10);
    let entries = [Entry::new(0x60FD, 0, 32), Entry::new(0x60B9, 0, 16)];
    let writes: Vec<_> = Setup::new(Direction::Transmit, 2, communication, &entries)
        .map(|write| (write.at.index, write.at.sub, write.value.data().to_vec()))
        .collect();
    let word = |value: u32| value.to_le_bytes().to_vec();
    let expected = [
        (0x1801, 1, word(0xC000_0283)),
        (0x1A01, 0, [0].to_vec()),
        (0x1A01, 1, word(0x60FD_0020)),
        (0x1A01, 2, word(0x60B9_0010)),
        (0x1A01, 0, [2].to_vec()),
        (0x1801, 2, [255].to_vec()),
        (0x1801, 3, [10, 0].to_vec()),
        (0x1801, 5, [0, 0].to_vec()),
        (0x1801, 1, word(0x4000_0283)),
    ];
    assert_eq!(writes, expected);
    let receive = Setup::new(Direction::Receive, 1, communication, &[]);
    assert!(
        receive
            .clone()
            .all(|write| (write.at.index, write.at.sub) != (0x1400, 3))
    );
    assert_eq!(receive.count(), 6);
}

fn entry() -> impl Strategy<Value = Entry> {
    (0x2000_u16.., any::<u8>(), 1..=32_u8)
        .prop_map(|(index, sub, bits)| Entry::new(index, sub, bits))
}

proptest! {
    #[test]
    fn what_is_packed_is_unpacked(
        parts in prop::collection::vec((entry(), any::<u64>()), 0..=8),
        junk in prop::collection::vec(any::<u8>(), 0..=12),
    ) {
        let entries: Vec<_> = parts.iter().map(|part| part.0).collect();
        let bits: u32 = entries.iter().map(|entry| u32::from(entry.bits())).sum();
        let map = Mapping::new(&entries);
        prop_assert_eq!(map.is_ok(), bits <= 64);
        if let Ok(map) = map {
            let mut values = parts.iter();
            let payload = map.pack(|_| values.next().unwrap().1);
            let mut seen = Vec::new();
            map.unpack(payload.data(), |_, value| seen.push(value)).unwrap();
            let cut = |(entry, value): &(Entry, u64)| value & ((1_u64 << entry.bits()) - 1);
            prop_assert_eq!(seen, parts.iter().map(cut).collect::<Vec<_>>());
            let _ = map.unpack(&junk, |_, _| ());
        }
    }
}
