//! Block transfer: goldens, what breaks it, and any value.

use super::super::block::crc;
use super::*;

fn bytes(first: u8, rest: [u8; 7]) -> [u8; 8] {
    let [a, b, c, d, e, f, g] = rest;
    [first, a, b, c, d, e, f, g]
}

fn abort_of(answer: [u8; 8]) -> Abort {
    assert_eq!(answer[0], 0x80);
    Abort::from_code(u32::from_le_bytes(tail(answer)))
}

/// The check value of CRC-16 with polynomial 1021 and start value 0 ("123456789") is 31C3.
#[test]
fn the_crc_is_that_of_the_standard() {
    assert_eq!(crc(b"123456789"), 0x31C3);
}

#[test]
fn golden_block_download() {
    let mut server = Server::<CAPACITY>::default();
    let mut od = objects(b"before");
    let mut ask = |request: [u8; 8]| server.on_request(NOW, &request, &mut od);
    // 10 bytes with CRC: the answer welcomes 127 segments
    let start = bytes(0xC6, [0, 0x20, 7, 10, 0, 0, 0]);
    assert_eq!(ask(start), Some([0xA4, 0, 0x20, 7, 127, 0, 0, 0]));
    assert_eq!(ask(*b"\x01irp6 dr"), None);
    assert_eq!(
        ask(*b"\x82ive\0\0\0\0"),
        Some([0xA2, 2, 127, 0, 0, 0, 0, 0])
    );
    let [low, high] = crc(b"irp6 drive").to_le_bytes();
    // four unused bytes in the last segment
    assert_eq!(
        ask(bytes(0xD1, [low, high, 0, 0, 0, 0, 0])),
        Some(bytes(0xA1, [0; 7]))
    );
    assert_eq!(od.0[&AT], b"irp6 drive");
    assert_eq!(server.deadline(), None);
}

#[test]
fn golden_block_upload() {
    let mut server = Server::<CAPACITY>::default();
    let mut od = objects(b"irp6 drive");
    let start = bytes(0xA4, [0, 0x20, 7, 127, 0, 0, 0]);
    let answer = server.on_request(NOW, &start, &mut od);
    assert_eq!(answer, Some([0xC6, 0, 0x20, 7, 10, 0, 0, 0]));
    assert_eq!(server.next_segment(), None, "before the client's start");
    assert_eq!(server.on_request(NOW, &bytes(0xA3, [0; 7]), &mut od), None);
    assert_eq!(server.next_segment(), Some(*b"\x01irp6 dr"));
    assert_eq!(server.next_segment(), Some(*b"\x82ive\0\0\0\0"));
    assert_eq!(server.next_segment(), None);
    let [low, high] = crc(b"irp6 drive").to_le_bytes();
    let answer = server.on_request(NOW, &bytes(0xA2, [2, 127, 0, 0, 0, 0, 0]), &mut od);
    assert_eq!(answer, Some(bytes(0xD1, [low, high, 0, 0, 0, 0, 0])));
    assert_eq!(server.on_request(NOW, &bytes(0xA1, [0; 7]), &mut od), None);
    assert_eq!(server.deadline(), None);
}

#[test]
fn golden_client_frames() {
    let mut client = BlockClient::<16>::default();
    let start = client.download(NOW, AT, b"irp6 drive").unwrap();
    assert_eq!(start, bytes(0xC6, [0, 0x20, 7, 10, 0, 0, 0]));
    // the server wants one segment per block
    let next = client.on_answer(NOW, &[0xA4, 0, 0x20, 7, 1, 0, 0, 0]);
    assert_eq!(next, Progress::Send(*b"\x01irp6 dr"));
    assert_eq!(client.next_segment(), None);
    let next = client.on_answer(NOW, &[0xA2, 1, 1, 0, 0, 0, 0, 0]);
    assert_eq!(next, Progress::Send(*b"\x81ive\0\0\0\0"));
    let [low, high] = crc(b"irp6 drive").to_le_bytes();
    let next = client.on_answer(NOW, &[0xA2, 1, 1, 0, 0, 0, 0, 0]);
    assert_eq!(
        next,
        Progress::Send(bytes(0xD1, [low, high, 0, 0, 0, 0, 0]))
    );
    let next = client.on_answer(NOW, &bytes(0xA1, [0; 7]));
    assert_eq!(next, Progress::Done(Outcome::Downloaded(AT)));
}

#[test]
fn a_wrong_crc_changes_nothing() {
    let mut server = Server::<CAPACITY>::default();
    let mut od = objects(b"before");
    let mut ask = |request: [u8; 8]| server.on_request(NOW, &request, &mut od);
    ask(bytes(0xC6, [0, 0x20, 7, 7, 0, 0, 0]));
    ask(*b"\x81irp6 dr");
    let answer = ask(bytes(0xC1, [0, 0, 0, 0, 0, 0, 0])).unwrap();
    assert_eq!(abort_of(answer), Abort::Crc);
    assert_eq!(od.0[&AT], b"before");
}

#[test]
fn without_crc_the_field_does_not_count() {
    let mut server = Server::<CAPACITY>::default();
    let mut od = objects(b"before");
    let mut ask = |request: [u8; 8]| server.on_request(NOW, &request, &mut od);
    ask(bytes(0xC2, [0, 0x20, 7, 7, 0, 0, 0]));
    ask(*b"\x81irp6 dr");
    assert_eq!(
        ask(bytes(0xC1, [9, 9, 0, 0, 0, 0, 0])),
        Some(bytes(0xA1, [0; 7]))
    );
    assert_eq!(od.0[&AT], b"irp6 dr");
}

#[test]
fn bad_block_sizes_lengths_and_sequences_abort() {
    for size in [0, 128, 255] {
        let start = bytes(0xA4, [0, 0x20, 7, size, 0, 0, 0]);
        let answer = Server::<CAPACITY>::default().on_request(NOW, &start, &mut objects(b"x"));
        assert_eq!(abort_of(answer.unwrap()), Abort::BlockSize, "{size}");
    }
    let mut server = Server::<CAPACITY>::default();
    let mut od = objects(b"irp6 drive");
    server.on_request(NOW, &bytes(0xA4, [0, 0x20, 7, 2, 0, 0, 0]), &mut od);
    server.on_request(NOW, &bytes(0xA3, [0; 7]), &mut od);
    while server.next_segment().is_some() {}
    let answer = server.on_request(NOW, &bytes(0xA2, [3, 2, 0, 0, 0, 0, 0]), &mut od);
    assert_eq!(abort_of(answer.unwrap()), Abort::Sequence);
    for (announced, expected) in [(6, Abort::TooLong), (8, Abort::TooShort)] {
        let mut server = Server::<CAPACITY>::default();
        let mut ask = |request: [u8; 8]| server.on_request(NOW, &request, &mut od);
        ask(bytes(0xC2, [0, 0x20, 7, announced, 0, 0, 0]));
        ask(*b"\x81irp6 dr");
        let answer = ask(bytes(0xC1, [0; 7])).unwrap();
        assert_eq!(abort_of(answer), expected);
    }
    let too_long = bytes(0xC6, [0, 0x20, 7, 1, 1, 0, 0]);
    let answer = Server::<CAPACITY>::default().on_request(NOW, &too_long, &mut od);
    assert_eq!(abort_of(answer.unwrap()), Abort::Memory);
}

#[test]
fn more_segments_than_the_buffer_holds_abort() {
    let mut server = Server::<CAPACITY>::default();
    let mut od = objects(b"before");
    // no length announced
    server.on_request(NOW, &bytes(0xC4, [0, 0x20, 7, 0, 0, 0, 0]), &mut od);
    let refused = (1..=127_u8)
        .filter_map(|n| server.on_request(NOW, &[n, 1, 1, 1, 1, 1, 1, 1], &mut od))
        .map(abort_of)
        .next();
    assert_eq!(refused, Some(Abort::Memory));
    assert_eq!(od.0[&AT], b"before");
}

#[test]
fn answers_that_confirm_nothing_are_not_answered_for_ever() {
    let mut client = BlockClient::<16>::default();
    client.download(NOW, AT, b"irp6 drive").unwrap();
    client.on_answer(NOW, &[0xA4, 0, 0x20, 7, 2, 0, 0, 0]);
    let mut answers = 0;
    let outcome = loop {
        answers += 1;
        while client.next_segment().is_some() {}
        match client.on_answer(NOW, &[0xA2, 0, 2, 0, 0, 0, 0, 0]) {
            Progress::Send(_) => {}
            Progress::End(_, outcome) => break outcome,
            other => panic!("{other:?}"),
        }
    };
    assert_eq!(outcome, Outcome::Broken(AT, Abort::Sequence));
    assert_eq!(answers, u32::from(RETRIES) + 1);
}

#[test]
fn a_short_value_may_come_without_blocks() {
    let mut server = Server::<CAPACITY>::default();
    let start = bytes(0xA4, [0, 0x20, 7, 127, 4, 0, 0]);
    let answer = server.on_request(NOW, &start, &mut objects(&[1, 2]));
    assert_eq!(answer, Some([0x4B, 0, 0x20, 7, 1, 2, 0, 0]));
}
