use super::*;
use proptest::prelude::*;

#[test]
fn lines_of_can_utils() {
    for (text, id, fd, data) in [
        (
            "(1436509052.249713) vcan0 044#2A366C2BBA",
            Id::Standard(0x44),
            false,
            5,
        ),
        (
            "(1436509052.249713) vcan0 18EF0102#",
            Id::Extended(0x18EF_0102),
            false,
            0,
        ),
        ("(0.000000) can0 7FF##1", Id::Standard(0x7FF), true, 0),
        (
            "(0.000001) can0 1FFFFFFF##1000102030405060708090A0B",
            Id::Extended(0x1FFF_FFFF),
            true,
            12,
        ),
    ] {
        let entry = parse(text).unwrap();
        assert_eq!((entry.frame.id(), entry.frame.is_fd()), (id, fd), "{text}");
        assert_eq!(entry.frame.data().len(), data);
        assert_eq!(entry.to_string(), text);
    }
    // The direction that `candump -x` adds, lower case, other flags.
    assert!(parse("(1.000000) can0 123#aabb R").is_ok());
    assert!(parse("(1.000000) can0 123##0aabb").is_ok());
}

#[test]
fn what_is_no_line() {
    for (text, part) in [
        ("x", "expected"),
        ("(1.000000) can0", "expected"),
        ("(1.000000) can0 123", "expected"),
        ("(1.000000) can0 123#00 Q", "expected"),
        ("(1.000000) can0 123##", "expected"),
        ("(1.000000) can0 123##é", "expected"),
        ("1.000000 can0 123#", "time"),
        ("(1.0) can0 123#", "time"),
        ("(-1.000000) can0 123#", "time"),
        ("(+1.000000) can0 123#", "time"),
        ("(99999999999999999999.000000) can0 123#", "time"),
        ("(1.000000) sixteen-letters1 123#", "channel"),
        ("(1.000000) can0 800#", "identifier"),
        ("(1.000000) can0 12#", "identifier"),
        ("(1.000000) can0 +23#", "identifier"),
        ("(1.000000) can0 40000000#", "identifier"),
        ("(1.000000) can0 20000004#0000000000000000", "error frames"),
        ("(1.000000) can0 123#R", "remote"),
        ("(1.000000) can0 123#1", "data"),
        ("(1.000000) can0 123#+1", "data"),
        ("(1.000000) can0 123#0é", "data"),
        ("(1.000000) can0 123#000102030405060708", "0 to 8"),
        ("(1.000000) can0 123##1000102030405060708", "64"),
    ] {
        let error = parse(text).unwrap_err().to_string();
        assert!(
            error.contains(part) && !error.contains('\n'),
            "{text}: {error}"
        );
    }
}

fn read(text: &[u8]) -> Result<Vec<Entry>, String> {
    Reader::new(text)
        .collect::<Result<_, _>>()
        .map_err(|error| error.to_string())
}

#[test]
fn errors_tell_the_line() {
    let good = "(1.000000) a 123#00\n";
    assert_eq!(
        read(format!("{good}\r\n\n{good}").as_bytes())
            .unwrap()
            .len(),
        2
    );
    assert_eq!(
        read(format!("{good}(1.000000) a 123#00").as_bytes())
            .unwrap()
            .len(),
        2
    );
    let backwards = format!("{good}\n(0.999999) a 123#00\n");
    assert!(
        read(backwards.as_bytes())
            .unwrap_err()
            .starts_with("line 3: time goes backwards")
    );
    let long = format!("{good}{}", "x".repeat(1 << 20));
    assert_eq!(
        read(long.as_bytes()).unwrap_err(),
        "line 2: longer than 256 bytes"
    );
    assert_eq!(read(b"\xFF\n").unwrap_err(), "line 1: not text");
    assert_eq!(
        read(b"(1.000000)\0a 123#\n").unwrap_err(),
        "line 1: not text"
    );
    let mut reader = Reader::new(&b"x\ny\n"[..]);
    assert!(reader.next().unwrap().is_err());
    assert!(reader.next().is_none());
}

proptest! {
    #[test]
    fn what_is_written_is_read(
        frames in proptest::collection::vec(
            (0u64..1 << 50, any::<bool>(), 0u32..1 << 29, any::<bool>(), proptest::collection::vec(any::<u8>(), 0..=64)),
            0..20,
        ),
    ) {
        let (mut writer, mut at, mut sent) = (Writer::new(Vec::new()), Micros(0), Vec::new());
        for (after, extended, id, fd, data) in frames {
            at = Micros(at.0 + after / 100);
            let id = if extended { Id::Extended(id) } else { Id::Standard((id % 0x800) as u16) };
            let len = protocol::frame::fd_length(data.len()).unwrap();
            let frame = if fd {
                let padded: Vec<u8> = data.iter().copied().chain([0; 64]).take(len).collect();
                Frame::fd(id, &padded)
            } else {
                Frame::classic(id, &data[..data.len().min(8)])
            };
            let entry = Entry { at, channel: "mp".into(), frame: frame.unwrap() };
            writer.write(entry.at, &entry.channel, &entry.frame).unwrap();
            sent.push(entry);
        }
        writer.flush().unwrap();
        prop_assert_eq!(read(&writer.out), Ok(sent));
    }

    #[test]
    fn any_bytes_are_read_or_refused(text in proptest::collection::vec(any::<u8>(), 0..600)) {
        let _ = read(&text);
    }

    #[test]
    fn any_near_line_is_read_or_refused(text in "\\(?[0-9]{0,3}\\.?[0-9]{0,7}\\)? ?[a-z0]{0,4} ?[0-9A-F]{0,9}#{0,2}[0-9a-fR]{0,20}") {
        if let Ok(entry) = parse(&text) {
            prop_assert_eq!(parse(&entry.to_string()).unwrap(), entry);
        }
    }
}
