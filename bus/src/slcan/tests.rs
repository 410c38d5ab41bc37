use super::text::{Cutter, Heard, write};
use super::{Slcan, Statistics};
use crate::{Bus, BusError, now};
use proptest::prelude::*;
use protocol::frame::{Frame, Id};
use protocol::time::Micros;
use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};

fn heard(bytes: &[u8]) -> Vec<Heard> {
    let mut all = Vec::new();
    Cutter::default().feed(bytes, &mut |one| all.push(one));
    all
}

fn classic(id: Id, data: &[u8]) -> Frame {
    Frame::classic(id, data).unwrap()
}

/// The examples of Lawicel's manual (CANUSB, "t10021133", "T0000010021133", with and without stamp).
#[test]
fn frames_of_the_manual() {
    let standard = Heard::Frame(classic(Id::Standard(0x100), &[0x11, 0x33]));
    let extended = Heard::Frame(classic(Id::Extended(0x100), &[0x11, 0x33]));
    assert_eq!(heard(b"t10021133\r"), [standard]);
    assert_eq!(heard(b"t10021133D4F2\r"), [standard]);
    assert_eq!(heard(b"T0000010021133\r"), [extended]);
    assert_eq!(heard(b"zt10021133\r"), [standard]);
    let mut line = Vec::new();
    write(&mut line, &classic(Id::Standard(0x7FF), &[]));
    write(&mut line, &classic(Id::Extended(0x1FFF_FFFF), &[0xAB]));
    assert_eq!(line, b"t7FF0\rT1FFFFFFF1AB\r");
}

#[test]
fn what_is_no_frame() {
    assert_eq!(heard(b"\rz\rZ\r"), [Heard::Nothing; 3]);
    assert_eq!(heard(b"\x07t1000\x07"), [Heard::Refusal; 2]);
    for line in [
        "t8000",
        "t1009",
        "t10",
        "t1002113",
        "t100211334",
        "T200000000",
        "r1000",
        "t100g",
        "V1013",
        "t1001+1",
        "tFFF0",
        "t1000D4F",
        "\u{fc}",
    ] {
        assert_eq!(
            heard(format!("{line}\r").as_bytes()),
            [Heard::Unknown],
            "{line}"
        );
    }
    // too long: left out to its end, and the next line counts again
    let mut long = vec![b't'; 100_000];
    long.extend_from_slice(b"\rt1000\r");
    let frame = Heard::Frame(classic(Id::Standard(0x100), &[]));
    assert_eq!(heard(&long), [Heard::Unknown, frame]);
}

proptest! {
    #[test]
    fn a_frame_survives_its_line_however_that_is_cut(
        extended: bool, id in 0u32..=0x1FFF_FFFF,
        data in proptest::collection::vec(any::<u8>(), 0..=8), cut in 0usize..28,
    ) {
        let id = if extended { Id::Extended(id) } else { Id::Standard((id % 0x800) as u16) };
        let frame = classic(id, &data);
        let mut line = Vec::new();
        write(&mut line, &frame);
        let (first, second) = line.split_at(cut.min(line.len()));
        let mut cutter = Cutter::default();
        let mut all = Vec::new();
        cutter.feed(first, &mut |one| all.push(one));
        cutter.feed(second, &mut |one| all.push(one));
        prop_assert_eq!(all, [Heard::Frame(frame)]);
    }

    #[test]
    fn any_bytes_are_borne(bytes in proptest::collection::vec(any::<u8>(), 0..500)) {
        let ends = bytes.iter().filter(|byte| matches!(byte, 7 | b'\r')).count();
        prop_assert_eq!(heard(&bytes).len(), ends);
    }
}

/// An adapter of ours at the other end of a TCP connection.
fn pair() -> (Slcan, TcpStream) {
    let listener = TcpListener::bind(("127.0.0.1", 0)).unwrap();
    let port = listener.local_addr().unwrap().port();
    let adapter = Slcan::tcp("127.0.0.1", port).unwrap();
    let (far, _) = listener.accept().unwrap();
    (adapter, far)
}

fn soon() -> Micros {
    now() + Micros::from_millis(10_000)
}

#[test]
fn both_directions_over_tcp() {
    let (adapter, far) = pair();
    both_directions(adapter, far);
}

/// A pseudo terminal: a serial device to whoever opens it, without a cable.
#[cfg(unix)]
#[test]
fn both_directions_over_a_serial_device_and_its_end_is_told() {
    use serialport::{SerialPort as _, TTYPort};
    use std::time::Duration;
    let open = || {
        let (mut far, near) = TTYPort::pair().unwrap();
        far.set_timeout(Duration::from_secs(10)).unwrap();
        let adapter = Slcan::device(&near.name().unwrap()).unwrap();
        (adapter, far, near)
    };
    let (adapter, far, _near) = open();
    both_directions(adapter, far);
    // as when the plug is pulled
    let (mut adapter, far, near) = open();
    drop((far, near));
    let error = adapter.wait(soon()).unwrap_err();
    assert!(matches!(error, BusError::Lost { .. }), "{error}");
}

/// Both ends of a line; `far` is where the adapter's firmware would be.
fn both_directions(mut adapter: Slcan, mut far: impl Read + Write) {
    let sent = classic(Id::Extended(0x0123_4567), &[1, 2]);
    adapter.send(&sent).unwrap();
    let expected = b"\rC\rS8\rO\rT0123456720102\r";
    let mut bytes = vec![0; expected.len()];
    far.read_exact(&mut bytes).unwrap();
    assert_eq!(bytes, expected);
    assert_eq!(adapter.receive().unwrap(), None);
    far.write_all(b"\x07\r\rZ\rnonsense\rt1231FF\rt1240\r")
        .unwrap();
    adapter.wait(soon()).unwrap();
    let first = adapter.receive().unwrap().map(|received| received.frame);
    assert_eq!(first, Some(classic(Id::Standard(0x123), &[0xFF])));
    adapter.wait(soon()).unwrap();
    let second = adapter.receive().unwrap().map(|received| received.frame);
    assert_eq!(second, Some(classic(Id::Standard(0x124), &[])));
    let (refused, ignored, dropped) = (1, 1, 0);
    let statistics = Statistics {
        refused,
        ignored,
        dropped,
    };
    assert_eq!(adapter.statistics(), statistics);
}

#[test]
fn fd_is_refused_and_the_end_of_the_line_is_told() {
    let (mut adapter, far) = pair();
    let fd = Frame::fd(Id::Extended(1), &[0; 12]).unwrap();
    assert!(matches!(
        adapter.send(&fd),
        Err(BusError::FdUnsupported { .. })
    ));
    drop(far);
    assert!(matches!(adapter.wait(soon()), Err(BusError::Lost { .. })));
}

#[test]
fn an_adapter_that_is_not_there_is_told_in_one_line() {
    let error = Slcan::device("/dev/mrroc-none0").unwrap_err().to_string();
    assert!(error.starts_with("slcan:/dev/mrroc-none0: "), "{error}");
    assert!(!error.contains('\n'));
    let free = TcpListener::bind(("127.0.0.1", 0))
        .unwrap()
        .local_addr()
        .unwrap()
        .port();
    assert!(matches!(
        Slcan::tcp("127.0.0.1", free),
        Err(BusError::Open { .. })
    ));
}
