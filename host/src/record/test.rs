use super::*;
use mcap::McapError;
use proptest::prelude::*;
use protocol::frame::Id;
use std::io::Cursor;

fn about() -> About {
    About {
        version: "1.2.3".into(),
        arguments: vec!["run".into(), "a \"b\".toml".into()],
        mtu: Mtu::Fd,
        buses: vec!["mp".into(), "irp6-postument.0".into()],
        files: [(PathBuf::from("a \"b\".toml"), "title = \"żółw\"\n".into())].into(),
    }
}

fn events() -> Vec<(u64, Event)> {
    let short = Frame::classic(Id::Standard(0x80), &[]).unwrap();
    let long = Frame::fd(Id::Extended(0x1234_5678), &[7; 64]).unwrap();
    let step = MasterStep {
        received: 3,
        stop: true,
    };
    vec![
        (1_000, Event::Frame(1, short)),
        (1_001, Event::Frame(0, long)),
        (20_000_000, Event::Step(step)),
        // later written than it was
        (19_999_999, Event::Frame(1, short)),
    ]
}

fn written(events: &[(u64, Event)]) -> Vec<u8> {
    let robots = [("irp6-postument".to_owned(), 2)];
    let mut writer = Writer::new(Cursor::new(Vec::new()), &about(), &robots).unwrap();
    for (at_ns, event) in events {
        writer.event(*at_ns, event).unwrap();
    }
    writer.joints(20_000_000, 0, &[0.5, -1.0]).unwrap();
    writer.finish().unwrap().into_inner()
}

/// What a record says: of which run, what happened, whether it is complete.
type Said = (About, Vec<(u64, Event)>, bool);

fn read(bytes: &[u8]) -> Result<Said, RecordError> {
    let mut record = Reader::open(bytes)?;
    let mut events = Vec::new();
    while let Some(event) = record.next_event()? {
        events.push(event);
    }
    Ok((record.about().clone(), events, record.is_complete()))
}

#[test]
fn what_is_written_is_read_again() {
    let bytes = written(&events());
    let (read_about, read_events, complete) = read(&bytes).unwrap();
    assert_eq!(read_about, about());
    assert_eq!(read_events, events());
    assert!(complete);
}

#[test]
fn a_record_that_was_cut_off_is_read_as_far_as_it_goes() {
    // more than a chunk
    let many: Vec<_> = (0..40_000)
        .map(|k| events()[usize::from(k % 2 == 0)].clone())
        .collect();
    let bytes = written(&many);
    let (_, read_events, complete) = read(&bytes[..bytes.len() * 2 / 3]).unwrap();
    assert!(!complete);
    assert!(read_events.len() > many.len() / 4 && read_events.len() < many.len());
    assert_eq!(read_events, many[..read_events.len()]);
}

#[test]
fn a_record_with_one_wrong_bit_is_an_error_or_another_record() {
    let bytes = written(&events());
    for at in 0..bytes.len() {
        for bit in 0..8 {
            let mut bytes = bytes.clone();
            bytes[at] ^= 1 << bit;
            if let Err(RecordError::Mcap(error)) = read(&bytes) {
                assert!(!matches!(error, McapError::Io(_)), "byte {at}: {error}");
            }
        }
    }
}

#[test]
fn other_files_are_told_apart() {
    for bytes in [&b""[..], b"(0.000051) mp 00B#01FF\n"] {
        let error = read(bytes).unwrap_err();
        assert!(!error.to_string().contains('\n'), "{error}");
    }
    let mut foreign = mcap::Writer::new(Cursor::new(Vec::new())).unwrap();
    foreign
        .add_channel(0, "/odom", "cdr", &BTreeMap::new())
        .unwrap();
    foreign.finish().unwrap();
    let bytes = foreign.into_inner().into_inner();
    let error = read(&bytes).unwrap_err().to_string();
    assert!(error.contains("metadata `mrroc`"), "{error}");
}

#[test]
fn joints_are_as_ros_writes_them() {
    let names = ["a".to_owned(), "bc".to_owned()];
    let bytes = cdr::joints(2_000_000_003, "r", &names, &[1.0]);
    let expected: Vec<u8> = [
        &[0, 1, 0, 0][..],
        &[2, 0, 0, 0, 3, 0, 0, 0],
        &[2, 0, 0, 0, b'r', 0, 0, 0],
        &[2, 0, 0, 0],
        &[2, 0, 0, 0, b'a', 0, 0, 0],
        &[3, 0, 0, 0, b'b', b'c', 0, 0],
        &[1, 0, 0, 0],
        &1.0_f64.to_le_bytes(),
        &[0, 0, 0, 0, 0, 0, 0, 0],
    ]
    .concat();
    assert_eq!(bytes, expected);
}

proptest! {
    #[test]
    fn frames_and_steps_survive(id in 0_u32..1 << 29, fd: bool, data in proptest::collection::vec(any::<u8>(), 0..9), received: u32, stop: bool) {
        let id = if id < 0x800 { Id::Standard(u16::try_from(id).unwrap()) } else { Id::Extended(id) };
        let frame = if fd { Frame::fd(id, &data) } else { Frame::classic(id, &data) }.unwrap();
        prop_assert_eq!(cdr::to_frame(&cdr::frame(&frame)), Some(frame));
        let step = MasterStep { received, stop };
        prop_assert_eq!(cdr::to_step(&cdr::step(step)), Some(step));
    }

    #[test]
    fn nonsense_is_no_frame_and_no_step(bytes in proptest::collection::vec(any::<u8>(), 0..100)) {
        prop_assert_eq!(cdr::to_frame(&bytes), None);
        prop_assert_eq!(cdr::to_step(&bytes), None);
    }
}
