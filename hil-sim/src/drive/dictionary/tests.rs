use protocol::canopen::axis;
use protocol::canopen::pdo::{Communication, Direction, Setup, Transmission};

use super::*;

fn dictionary() -> Dictionary {
    let drive = DriveParameters::new(2000, 8.0, 0.105, 2.0e-5, 77);
    Dictionary::new(NodeId::new(5).unwrap(), &drive)
}

fn write(od: &mut Dictionary, index: u16, sub: u8, data: &[u8]) -> Result<(), Abort> {
    od.write(Address::new(index, sub), data)
}

#[test]
fn defaults_know_the_node_and_the_motor() {
    let od = dictionary();
    assert_eq!(od.at(0x1400, 1), 0x4000_0205);
    assert_eq!(od.at(0x1801, 1), 0x4000_0285);
    assert_eq!(od.at(0x1802, 1), 0xC000_0385);
    assert_eq!(od.at(0x1018, 4), 77);
    assert_eq!(od.at(0x608F, 1), 2000);
    assert_eq!(od.at(0x6092, 1), 2_000_000);
    assert_eq!((od.at(0x6075, 0), od.at(0x6076, 0)), (2000, 210));
}

#[test]
fn every_object_is_read_with_its_length() {
    let od = dictionary();
    let happened =
        |object: &&objects::Object| object.at.index != index::ERROR_HISTORY || object.at.sub == 0;
    for object in TABLE.iter().filter(happened) {
        let mut into = [0; 64];
        let len = od.read(object.at, &mut into).unwrap();
        assert_eq!(len, od.len(object.at).unwrap());
        assert_eq!(len, object.data_type.size().unwrap_or(len));
    }
    let mut name = [0; 64];
    let len = od.read(Address::new(0x1008, 0), &mut name).unwrap();
    assert_eq!(&name[..len], b"mrroc simulated servo drive");
}

#[test]
fn refusals_are_typed() {
    let mut od = dictionary();
    let mut refuse = |index, sub, data: &[u8]| write(&mut od, index, sub, data).unwrap_err();
    assert_eq!(refuse(0x2001, 0, &[0]), Abort::NoObject);
    assert_eq!(refuse(0x6040, 1, &[0]), Abort::NoSubIndex);
    assert_eq!(refuse(0x6041, 0, &[0, 0]), Abort::ReadOnly);
    assert_eq!(refuse(0x1000, 0, &[0; 4]), Abort::ReadOnly);
    assert_eq!(refuse(0x6040, 0, &[0]), Abort::TooShort);
    assert_eq!(refuse(0x6040, 0, &[0; 4]), Abort::TooLong);
    assert_eq!(refuse(0x6060, 0, &[2]), Abort::Range);
    assert_eq!(refuse(0x605A, 0, &[9, 0]), Abort::TooHigh);
    assert_eq!(refuse(0x6098, 0, &[3]), Abort::Range);
    assert_eq!(refuse(0x6091, 1, &[0; 4]), Abort::TooLow);
    assert_eq!(refuse(0x1019, 0, &[1]), Abort::Range);
    assert_eq!(refuse(0x605B, 0, &[2, 0]), Abort::TooHigh);
    assert_eq!(refuse(0x605D, 0, &[0, 0]), Abort::TooLow);
    assert_eq!(refuse(0x2000, 0, &[b'x'; 257]), Abort::TooLong);
    assert_eq!(refuse(0x1010, 1, b"nope"), Abort::Storage);
    let od_live = &mut dictionary();
    od_live.energised = true;
    assert_eq!(
        write(od_live, 0x608F, 1, &[1, 0, 0, 0]),
        Err(Abort::DeviceState)
    );
}

#[test]
fn negative_numbers_survive() {
    let mut od = dictionary();
    write(&mut od, 0x6071, 0, &[0xFE, 0xFF]).unwrap();
    assert_eq!(od.at(0x6071, 0).cast_signed(), -2);
    let mut into = [0; 2];
    od.read(Address::new(0x6071, 0), &mut into).unwrap();
    assert_eq!(into, [0xFE, 0xFF]);
}

#[test]
fn the_setup_of_a_pdo_is_accepted_in_its_order_only() {
    let mut od = dictionary();
    let communication = Communication::new(0x205, Transmission::SyncCyclic(1));
    let writes: Vec<_> =
        Setup::new(Direction::Receive, 1, communication, &axis::RPDO2_CST).collect();
    for step in &writes {
        od.write(step.at, step.value.data()).unwrap();
    }
    assert_eq!(od.at(0x1600, 0), 2);
    assert_eq!(od.at(0x1600, 2), 0x6071_0010);
    // The PDO is active again: its mapping and its identifier are locked.
    assert_eq!(write(&mut od, 0x1600, 0, &[0]), Err(Abort::DeviceState));
    let other = 0x4000_0206_u32.to_le_bytes();
    assert_eq!(write(&mut od, 0x1400, 1, &other), Err(Abort::DeviceState));
}

#[test]
fn mappings_that_cannot_be_are_refused() {
    let mut od = dictionary();
    write(&mut od, 0x1400, 1, &0xC000_0205_u32.to_le_bytes()).unwrap();
    write(&mut od, 0x1600, 0, &[0]).unwrap();
    let mut map = |sub, entry: u32| write(&mut od, 0x1600, sub, &entry.to_le_bytes());
    assert_eq!(map(1, 0x6041_0010), Err(Abort::NotMappable), "read only");
    assert_eq!(map(1, 0x607A_0010), Err(Abort::NotMappable), "wrong length");
    assert_eq!(map(1, 0x2001_0010), Err(Abort::NoObject));
    assert_eq!(map(1, 0x6040_0110), Err(Abort::NoSubIndex));
    for sub in 1..=3 {
        map(sub, 0x607A_0020).unwrap();
    }
    assert_eq!(write(&mut od, 0x1600, 0, &[3]), Err(Abort::PdoLength));
    assert_eq!(write(&mut od, 0x1600, 0, &[9]), Err(Abort::TooHigh));
    write(&mut od, 0x1600, 0, &[2]).unwrap();
    let heartbeat = 0x0705_u32.to_le_bytes();
    assert_eq!(
        write(&mut od, 0x1400, 1, &heartbeat),
        Err(Abort::Range),
        "reserved identifier"
    );
}

#[test]
fn storing_and_restoring() {
    let mut od = dictionary();
    write(&mut od, 0x1017, 0, &[50, 0]).unwrap();
    od.reset();
    assert_eq!(od.at(0x1017, 0), 100);
    write(&mut od, 0x1017, 0, &[50, 0]).unwrap();
    write(&mut od, 0x1010, 1, b"save").unwrap();
    od.reset();
    assert_eq!(od.at(0x1017, 0), 50);
    write(&mut od, 0x1011, 1, b"load").unwrap();
    od.reset();
    assert_eq!(od.at(0x1017, 0), 100);
}

#[test]
fn errors_that_have_not_happened_are_no_data() {
    let mut od = dictionary();
    let read = |od: &Dictionary, sub| od.read(Address::new(0x1003, sub), &mut [0; 4]);
    assert_eq!(read(&od, 1), Err(Abort::NoData));
    od.set(super::super::slots::ERROR_COUNT, 1);
    assert_eq!((read(&od, 1), read(&od, 2)), (Ok(4), Err(Abort::NoData)));
}

#[test]
fn a_note_is_kept_and_stored() {
    let mut od = dictionary();
    let note = b"axis 3: belt replaced, 2 mm of play";
    let read = |od: &Dictionary| {
        let mut into = [0; 256];
        let len = od.read(Address::new(0x2000, 0), &mut into).unwrap();
        into[..len].to_vec()
    };
    write(&mut od, 0x2000, 0, note).unwrap();
    assert_eq!(read(&od), note);
    od.reset();
    assert_eq!(read(&od), b"");
    write(&mut od, 0x2000, 0, note).unwrap();
    write(&mut od, 0x1010, 1, b"save").unwrap();
    od.reset();
    assert_eq!(read(&od), note);
    write(&mut od, 0x1011, 1, b"load").unwrap();
    od.reset();
    assert_eq!(read(&od), b"");
}

#[test]
fn another_configuration_is_not_the_verified_one() {
    let mut od = dictionary();
    let verified = |od: &Dictionary| (od.at(0x1020, 1), od.at(0x1020, 2));
    let sign = |od: &mut Dictionary| {
        write(od, 0x1020, 1, &[1, 2, 0, 0]).unwrap();
        write(od, 0x1020, 2, &[3, 4, 0, 0]).unwrap();
    };
    sign(&mut od);
    write(&mut od, 0x607A, 0, &[9; 4]).unwrap();
    write(&mut od, 0x1010, 1, b"save").unwrap();
    assert_eq!(
        verified(&od),
        (0x201, 0x403),
        "a set-point is no configuration"
    );
    write(&mut od, 0x1017, 0, &[50, 0]).unwrap();
    assert_eq!(verified(&od), (0, 0));
    od.reset();
    assert_eq!(verified(&od), (0x201, 0x403), "the stored one is back");
}

#[test]
fn another_node_identifier_moves_the_defaults_that_contain_it() {
    let mut od = dictionary();
    let off = 0xC000_0205_u32.to_le_bytes();
    write(&mut od, 0x1400, 1, &off).unwrap();
    od.set_node(NodeId::new(5).unwrap(), NodeId::new(9).unwrap());
    assert_eq!(od.at(0x1801, 1), 0x4000_0289);
    assert_eq!(od.at(0x1400, 1), 0xC000_0205, "what was written stays");
    od.reset();
    assert_eq!(od.at(0x1400, 1), 0x4000_0209);
}
