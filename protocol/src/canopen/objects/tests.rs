extern crate std;
use std::collections::BTreeSet;

use super::super::pdo::Mapping;
use super::super::{axis, cia402};
use super::*;

#[test]
fn the_table_is_ascending_without_doubles() {
    assert!(TABLE.windows(2).all(|pair| pair[0].at < pair[1].at));
    for (place, object) in TABLE.iter().enumerate() {
        assert_eq!(find(object.at), Some(place));
        assert_eq!(slot(object.at.index, object.at.sub), place);
        assert!(has_index(object.at.index));
    }
    assert_eq!(find(Address::new(0x6040, 1)), None);
    assert!(!has_index(0x2000));
}

#[test]
fn initial_values_fit_their_types() {
    for object in &TABLE {
        let (low, high) = match object.data_type {
            DataType::I8 => (i64::from(i8::MIN), i64::from(i8::MAX)),
            DataType::I16 => (i64::from(i16::MIN), i64::from(i16::MAX)),
            DataType::I32 => (i64::from(i32::MIN), i64::from(i32::MAX)),
            DataType::U8 => (0, i64::from(u8::MAX)),
            DataType::U16 => (0, i64::from(u16::MAX)),
            DataType::U32 | DataType::Text => (0, i64::from(u32::MAX)),
        };
        match object.initial {
            Initial::Number(value) => assert!((low..=high).contains(&value), "{object:?}"),
            Initial::PlusNode(_) => assert_eq!(object.data_type, DataType::U32),
            Initial::Text(text) => {
                assert_eq!(object.data_type, DataType::Text);
                assert!(text.len() <= super::super::sdo::CAPACITY);
            }
        }
    }
}

#[test]
fn every_index_starts_at_sub_zero_and_counts_its_subs() {
    let indices: BTreeSet<_> = TABLE.iter().map(|object| object.at.index).collect();
    for index in indices {
        let subs = TABLE.iter().filter(|object| object.at.index == index);
        let highest = subs.clone().map(|object| object.at.sub).max().unwrap();
        let first = TABLE[slot(index, 0)];
        let is_list = (0x1600..0x1800).contains(&index) || (0x1A00..0x1C00).contains(&index);
        // 1003 counts the errors now stored, mapping objects the objects now mapped.
        if highest > 0 && !is_list && index != 0x1003 {
            assert_eq!(
                first.initial,
                Initial::Number(i64::from(highest)),
                "{index:#x}"
            );
        }
    }
}

#[test]
fn default_mappings_use_mappable_objects_of_the_right_length() {
    for (entries, receive) in [
        (&axis::RPDO1_CSP[..], true),
        (&axis::RPDO2_CST, true),
        (&axis::RPDO1_CSP_OFFSET, true),
        (&axis::RPDO2_CST_OFFSET, true),
        (&axis::TPDO1, false),
        (&axis::TPDO2, false),
    ] {
        assert!(Mapping::new(entries).is_ok());
        for entry in entries {
            let object = TABLE[find(entry.address()).unwrap()];
            assert_eq!(
                object.data_type.size().unwrap() * 8,
                usize::from(entry.bits())
            );
            let allowed = match object.mappable {
                Mappable::No => false,
                Mappable::Transmit => !receive,
                Mappable::Both => true,
            };
            assert!(allowed, "{object:?}");
        }
    }
}

#[test]
fn the_objects_a_conformant_drive_must_have_are_there() {
    let mandatory = [
        (0x1000, 0),
        (0x1001, 0),
        (0x1018, 1),
        (0x6040, 0),
        (0x6041, 0),
        (0x6060, 0),
        (0x6061, 0),
        (0x6502, 0),
    ];
    for (index, sub) in mandatory {
        assert!(find(Address::new(index, sub)).is_some(), "{index:#x}");
    }
    let device = TABLE[slot(0x1000, 0)].initial;
    assert_eq!(device, Initial::Number(0x0002_0192));
    let modes = TABLE[slot(0x6502, 0)].initial;
    assert_eq!(modes, Initial::Number(i64::from(cia402::SUPPORTED_MODES)));
}
