extern crate std;

mod block;
mod lossy;

use std::collections::BTreeMap;
use std::vec::Vec;

use proptest::prelude::*;

use super::*;

/// An object dictionary of byte strings.
#[derive(Default)]
struct Objects(BTreeMap<Address, Vec<u8>>);

impl ObjectAccess for Objects {
    fn len(&self, at: Address) -> Result<usize, Abort> {
        self.0.get(&at).map(Vec::len).ok_or(Abort::NoObject)
    }
    fn read(&self, at: Address, into: &mut [u8]) -> Result<usize, Abort> {
        let value = self.0.get(&at).ok_or(Abort::NoObject)?;
        into[..value.len()].copy_from_slice(value);
        Ok(value.len())
    }
    fn write(&mut self, at: Address, data: &[u8]) -> Result<(), Abort> {
        let value = self.0.get_mut(&at).ok_or(Abort::NoObject)?;
        *value = data.to_vec();
        Ok(())
    }
}

const AT: Address = Address::new(0x2000, 7);
const NOW: Micros = Micros(0);

fn objects(value: &[u8]) -> Objects {
    Objects(BTreeMap::from([(AT, value.to_vec())]))
}

/// Exchanges frames until the client is done.
fn exchange(
    client: &mut Client,
    server: &mut Server,
    objects: &mut Objects,
    mut request: [u8; 8],
) -> Outcome {
    for _ in 0..200 {
        let answer = server
            .on_request(NOW, &request, objects)
            .expect("an answer");
        match client.on_answer(NOW, &answer) {
            Progress::Send(next) => request = next,
            Progress::Done(outcome) => return outcome,
            other => panic!("{other:?}"),
        }
    }
    panic!("endless transfer");
}

#[test]
fn golden_expedited_frames() {
    let mut client = Client::<8>::default();
    let mode = client.download(NOW, Address::new(0x6060, 0), &[8]).unwrap();
    assert_eq!(mode, [0x2F, 0x60, 0x60, 0, 8, 0, 0, 0]);
    let mut client = Client::<8>::default();
    let period = client
        .download(NOW, Address::new(0x1017, 0), &[0xE8, 3])
        .unwrap();
    assert_eq!(period, [0x2B, 0x17, 0x10, 0, 0xE8, 3, 0, 0]);
    let mut client = Client::<8>::default();
    let word = client.download(NOW, AT, &[1, 2, 3, 4]).unwrap();
    assert_eq!(word, [0x23, 0x00, 0x20, 7, 1, 2, 3, 4]);
    let mut client = Client::<8>::default();
    assert_eq!(
        client.upload(NOW, AT).unwrap(),
        [0x40, 0x00, 0x20, 7, 0, 0, 0, 0]
    );

    let mut server = Server::<CAPACITY>::default();
    let answer = server.on_request(NOW, &word, &mut objects(&[0; 4]));
    assert_eq!(answer, Some([0x60, 0x00, 0x20, 7, 0, 0, 0, 0]));
    let read = [0x40, 0x00, 0x20, 7, 0, 0, 0, 0];
    let answer = server.on_request(NOW, &read, &mut objects(&[0x34, 0x12]));
    assert_eq!(answer, Some([0x4B, 0x00, 0x20, 7, 0x34, 0x12, 0, 0]));
}

#[test]
fn golden_segmented_upload() {
    let mut server = Server::<CAPACITY>::default();
    let mut od = objects(b"irp6 drive");
    let mut ask = |request: [u8; 8]| server.on_request(NOW, &request, &mut od).unwrap();
    assert_eq!(
        ask([0x40, 0, 0x20, 7, 0, 0, 0, 0]),
        [0x41, 0, 0x20, 7, 10, 0, 0, 0]
    );
    assert_eq!(ask([0x60, 0, 0, 0, 0, 0, 0, 0]), *b"\x00irp6 dr");
    assert_eq!(ask([0x70, 0, 0, 0, 0, 0, 0, 0]), *b"\x19ive\0\0\0\0");
}

#[test]
fn golden_segmented_download() {
    let mut client = Client::<16>::default();
    let start = client.download(NOW, AT, b"irp6 drive").unwrap();
    assert_eq!(start, [0x21, 0, 0x20, 7, 10, 0, 0, 0]);
    let next = client.on_answer(NOW, &[0x60, 0, 0x20, 7, 0, 0, 0, 0]);
    assert_eq!(next, Progress::Send(*b"\x00irp6 dr"));
    let next = client.on_answer(NOW, &[0x20, 0, 0, 0, 0, 0, 0, 0]);
    assert_eq!(next, Progress::Send(*b"\x19ive\0\0\0\0"));
    let next = client.on_answer(NOW, &[0x30, 0, 0, 0, 0, 0, 0, 0]);
    assert_eq!(next, Progress::Done(Outcome::Downloaded(AT)));
}

#[test]
fn golden_abort() {
    let request = [0x40, 0x01, 0x20, 0, 0, 0, 0, 0];
    let answer = Server::<CAPACITY>::default().on_request(NOW, &request, &mut objects(&[]));
    assert_eq!(answer, Some([0x80, 0x01, 0x20, 0, 0x00, 0x00, 0x02, 0x06]));
}

#[test]
fn a_refusal_reaches_the_client() {
    let (mut client, mut server) = (Client::default(), Server::<CAPACITY>::default());
    let at = Address::new(0x2001, 0);
    let request = client.upload(NOW, at).unwrap();
    let outcome = exchange(&mut client, &mut server, &mut objects(&[1]), request);
    assert_eq!(outcome, Outcome::Refused(at, Abort::NoObject));
    assert!(client.is_idle());
}

#[test]
fn a_wrong_toggle_aborts_and_changes_nothing() {
    let mut server = Server::<CAPACITY>::default();
    let mut od = objects(b"before");
    let start = [0x21, 0, 0x20, 7, 10, 0, 0, 0];
    server.on_request(NOW, &start, &mut od).unwrap();
    let wrong = *b"\x10irp6 dr";
    let answer = server.on_request(NOW, &wrong, &mut od).unwrap();
    assert_eq!(
        Abort::from_code(u32::from_le_bytes(tail(answer))),
        Abort::Toggle
    );
    assert_eq!(od.0[&AT], b"before");
    assert_eq!(server.deadline(), None);
}

#[test]
fn a_length_that_was_not_announced_aborts() {
    for (announced, expected) in [(3, Abort::TooLong), (9, Abort::TooShort)] {
        let mut server = Server::<CAPACITY>::default();
        let mut od = objects(b"before");
        server
            .on_request(NOW, &[0x21, 0, 0x20, 7, announced, 0, 0, 0], &mut od)
            .unwrap();
        let answer = server.on_request(NOW, b"\x01irp6 dr", &mut od).unwrap();
        assert_eq!(Abort::from_code(u32::from_le_bytes(tail(answer))), expected);
        assert_eq!(od.0[&AT], b"before");
    }
}

#[test]
fn more_than_the_capacity_is_refused_before_it_is_sent() {
    let request = [0x21, 0, 0x20, 7, 0x01, 0x01, 0, 0];
    let answer = Server::<CAPACITY>::default()
        .on_request(NOW, &request, &mut objects(&[1]))
        .unwrap();
    assert_eq!(
        Abort::from_code(u32::from_le_bytes(tail(answer))),
        Abort::Memory
    );
    let long = [0; CAPACITY + 1];
    assert_eq!(
        Client::<CAPACITY>::default().download(NOW, AT, &long),
        Err(ClientError::TooLong)
    );
}

#[test]
fn both_sides_give_up_in_time() {
    let timeout = Micros(1000);
    let mut client = Client::<8>::new(timeout);
    client.upload(NOW, AT).unwrap();
    assert_eq!(client.upload(NOW, AT), Err(ClientError::Busy));
    assert_eq!(client.poll(Micros(999)), None);
    let abort = [0x80, 0, 0x20, 7, 0, 0, 0x04, 0x05];
    let expected = Progress::End(abort, Outcome::TimedOut(AT));
    assert_eq!(client.poll(Micros(1000)), Some(expected));
    assert!(client.is_idle());

    let mut server = Server::<CAPACITY>::new(timeout);
    assert_eq!(server.poll(Micros(5000)), None);
    server
        .on_request(NOW, &[0x21, 0, 0x20, 7, 10, 0, 0, 0], &mut objects(&[1]))
        .unwrap();
    assert_eq!(server.poll(Micros(999)), None);
    assert_eq!(server.poll(Micros(1000)), Some(abort));
    assert_eq!(server.poll(Micros(2000)), None);
}

#[test]
fn every_abort_code_is_its_own() {
    for abort in Abort::ALL {
        assert_eq!(Abort::from_code(abort.code()), *abort);
        assert!(!abort.text().is_empty());
    }
    assert_eq!(Abort::from_code(7), Abort::Other(7));
}

proptest! {
    #[test]
    fn any_value_is_written_and_read_back(value in prop::collection::vec(any::<u8>(), 0..=CAPACITY)) {
        let (mut client, mut server) = (Client::default(), Server::<CAPACITY>::default());
        let mut od = objects(&[0xAA]);
        let request = client.download(NOW, AT, &value).unwrap();
        let outcome = exchange(&mut client, &mut server, &mut od, request);
        prop_assert_eq!(outcome, Outcome::Downloaded(AT));
        prop_assert_eq!(&od.0[&AT], &value);
        let request = client.upload(NOW, AT).unwrap();
        let outcome = exchange(&mut client, &mut server, &mut od, request);
        prop_assert_eq!(outcome, Outcome::Uploaded(AT));
        prop_assert_eq!(client.data(), &value[..]);
    }

    #[test]
    fn no_frame_breaks_either_side(frames in prop::collection::vec(prop::collection::vec(any::<u8>(), 0..=8), 0..40)) {
        let (mut client, mut server) = (Client::<32>::default(), Server::<CAPACITY>::default());
        let mut od = objects(&[1; 40]);
        for frame in frames {
            let _ = client.upload(NOW, AT);
            let _ = client.on_answer(NOW, &frame);
            let _ = server.on_request(NOW, &frame, &mut od);
        }
    }
}
