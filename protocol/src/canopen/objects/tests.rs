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
    assert!(!has_index(0x2001));
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
            DataType::U32 | DataType::Text | DataType::Domain => (0, i64::from(u32::MAX)),
        };
        match object.initial {
            Initial::Number(value) => assert!((low..=high).contains(&value), "{object:?}"),
            Initial::PlusNode(_) => assert_eq!(object.data_type, DataType::U32),
            Initial::Text(text) => {
                assert!(object.data_type.size().is_none());
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
        assert_eq!(group(index).is_some(), highest > 0, "{index:#x}");
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

#[test]
fn defaults_lie_within_limits_and_limits_within_types() {
    for object in &TABLE {
        let Some((low, high)) = object.limits else {
            continue;
        };
        let (low, high) = (i64::from(low), i64::from(high));
        let bits = u32::try_from(object.data_type.size().unwrap() * 8).unwrap();
        let span = if object.data_type.is_signed() {
            (-(1_i64 << (bits - 1)), (1_i64 << (bits - 1)) - 1)
        } else {
            (0, (1_i64 << bits) - 1)
        };
        assert!(span.0 <= low && low <= high && high <= span.1, "{object:?}");
        let Initial::Number(initial) = object.initial else {
            panic!("{object:?}");
        };
        assert!((low..=high).contains(&initial), "{object:?}");
    }
}

fn sheet() -> std::string::String {
    let mut text = std::string::String::new();
    let sheet = eds::Sheet {
        file_name: "drive.eds",
        description: "drive",
        order_code: "1",
    };
    eds::write(&mut text, &sheet, &|object: &Object| {
        (object.at.index == index::RATED_TORQUE).then_some(777)
    })
    .unwrap();
    text
}

#[test]
fn golden_sections_of_the_data_sheet() {
    let text = sheet();
    for section in [
        "[6076]\nParameterName=Motor rated torque\nObjectType=0x7\nDataType=0x0007\nAccessType=ro\n\
         DefaultValue=0x309\nPDOMapping=0\n\n",
        "[6041]\nParameterName=Statusword\nObjectType=0x7\nDataType=0x0006\nAccessType=ro\n\
         DefaultValue=0x0\nPDOMapping=1\n\n",
        "[607A]\nParameterName=Target position\nObjectType=0x7\nDataType=0x0004\nAccessType=rww\n\
         DefaultValue=0\nPDOMapping=1\n\n",
        "[605D]\nParameterName=Halt option code\nObjectType=0x7\nDataType=0x0003\nAccessType=rw\n\
         DefaultValue=1\nPDOMapping=0\nLowLimit=1\nHighLimit=4\n\n",
        "[1800]\nParameterName=TPDO communication parameter\nObjectType=0x9\nSubNumber=6\n\n\
         [1800sub0]\nParameterName=Highest sub-index supported\n",
        "[1800sub1]\nParameterName=COB-ID used by TPDO\nObjectType=0x7\nDataType=0x0007\nAccessType=rw\n\
         DefaultValue=$NODEID+0x40000180\nPDOMapping=0\n\n",
    ] {
        let head = &section[..=section.find('\n').unwrap()];
        let from = text.find(head).unwrap();
        assert!(
            text[from..].starts_with(section),
            "{}",
            &text[from..from + 200]
        );
    }
}

#[test]
fn the_data_sheet_lists_every_index_once() {
    let text = sheet();
    let indices: BTreeSet<_> = TABLE.iter().map(|object| object.at.index).collect();
    let listed: std::vec::Vec<_> = text
        .lines()
        .filter_map(|line| {
            let (number, index) = line.split_once("=0x")?;
            number.parse::<u16>().ok()?;
            u16::from_str_radix(index, 16).ok()
        })
        .collect();
    assert_eq!(listed.len(), indices.len());
    assert_eq!(listed.iter().copied().collect::<BTreeSet<_>>(), indices);
    let sections = text.lines().filter(|line| line.starts_with('[')).count();
    let groups = indices.iter().filter(|i| group(**i).is_some()).count();
    // FileInfo, DeviceInfo, DummyUsage, Comments and three lists
    assert_eq!(sections, 7 + TABLE.len() + groups);
}

/// `BLESS=1 cargo test -p mrroc-protocol` writes the page anew.
#[test]
fn the_documentation_is_that_of_the_table() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/objects.md");
    let mut table = std::string::String::new();
    markdown::write(&mut table).unwrap();
    let page = std::fs::read_to_string(path).unwrap();
    let (text, old) = page.split_once("| object |").unwrap();
    if std::env::var_os("BLESS").is_some() {
        std::fs::write(path, std::format!("{text}{table}")).unwrap();
        return;
    }
    let old = std::format!("| object |{old}");
    assert!(old == table, "docs/objects.md: BLESS=1 writes it anew");
}
