//! Object 1020: drives that have stored their set-up are not given it again, unless it is another one.

use super::layer::Bench;
use super::*;
use firmware::KnownDrives;
use hil_sim::drive::quirk::Quirk;
use protocol::canopen::sdo::{Address, Client};
use protocol::message::DriveFinding;

const STORED: KnownDrives<'static> = KnownDrives {
    identities: &[],
    find: false,
    stored: true,
};
const PLAIN: KnownDrives<'static> = KnownDrives {
    stored: false,
    ..STORED
};
const SAVE: &[u8] = b"save";
const QUICK_STOP_OPTION: Address = Address::new(0x605A, 0);

impl Bench {
    /// Objects of axis 3 that were written, each time.
    fn written(&self) -> Vec<u16> {
        let of_axis = self.requests.iter().filter(|(cob, _)| *cob == 0x603);
        let downloads = of_axis.filter(|(_, [head, ..])| head >> 5 == 1);
        downloads
            .map(|(_, [_, a, b, ..])| u16::from_le_bytes([*a, *b]))
            .collect()
    }

    /// Another master asks the drive of axis 3; the bytes of the answer.
    fn other_master(&mut self, request: [u8; 8]) -> [u8; 8] {
        let frame = protocol::canopen::node::frame(0x603, request);
        let mut answer = None;
        let now_ns = self.now_ns;
        self.robot.on_frame(0, now_ns, &frame, &mut |sent| {
            if sent.frame.id() == Id::Standard(0x583) {
                answer = Some(sent.frame.data().try_into().unwrap());
            }
        });
        answer.expect("drives answer at once")
    }

    fn write(&mut self, at: Address, value: &[u8]) {
        let mut sdo = Client::<8>::default();
        let answer = self.other_master(sdo.download(Micros(0), at, value).unwrap());
        assert_eq!(answer[0], 0x60, "{at:?}: {answer:?}");
    }

    fn read(&mut self, at: Address) -> u32 {
        let mut sdo = Client::<8>::default();
        let answer = self.other_master(sdo.upload(Micros(0), at).unwrap());
        let _ = sdo.on_answer(Micros(0), &answer);
        sdo.number().unwrap()
    }

    fn pair(&mut self) -> [u32; 2] {
        [1, 2].map(|sub| self.read(Address::new(0x1020, sub)))
    }
}

#[test]
fn what_is_stored_is_not_written_again_and_the_bring_up_is_shorter_by_that() {
    let mut b = Bench::new(&STORED, |_| {});
    let first = b.bring_up();
    let all = b.written();
    assert_eq!(all[all.len() - 3..], [0x1020, 0x1020, 0x1010]);
    let pair = b.pair();
    assert!(pair[0] > 0 && pair[1] > 0);
    b.restart(&STORED);
    let second = b.bring_up();
    assert_eq!((b.node.state(), b.found.len()), (NodeState::Disabled, 0));
    assert_eq!(b.written(), [0x60B8, 0x6060]);
    assert_eq!(b.pair(), pair);
    // a write takes a servo step, 2 ms; the drives are written to side by side
    let skipped = 2 * (all.len() as u64 - 2);
    println!("{first} ms, stored {second} ms; {} writes", all.len());
    assert!(
        (skipped - 4..=skipped + 4).contains(&(first - second)),
        "{first} ms, {second} ms; {skipped} ms of writes"
    );
    // and they do what they are told
    b.enable();
    assert_eq!((b.node.state(), b.fault), (NodeState::Unsynchronised, None));
}

#[test]
fn without_being_asked_to_the_node_neither_stores_nor_verifies() {
    let mut b = Bench::new(&PLAIN, |_| {});
    let first = b.bring_up();
    let all = b.written();
    assert_eq!(b.pair(), [0, 0]);
    b.restart(&PLAIN);
    assert_eq!(b.bring_up(), first);
    assert_eq!(b.written(), all);
    let asked = |(_, [_, low, high, _, ..]): &(u16, [u8; 8])| [*low, *high] == [0x20, 0x10];
    assert!(!b.requests.iter().any(asked));
}

#[test]
fn an_object_that_another_master_changed_and_stored_is_written_again_with_all_others() {
    let mut b = Bench::new(&STORED, |_| {});
    b.bring_up();
    let (all, pair) = (b.written(), b.pair());
    b.write(QUICK_STOP_OPTION, &6_u16.to_le_bytes());
    assert_eq!(
        b.pair(),
        [0, 0],
        "one written object makes it another set-up"
    );
    b.write(Address::new(0x1010, 1), SAVE);
    b.restart(&STORED);
    b.bring_up();
    assert_eq!(b.written(), all);
    assert_eq!((b.read(QUICK_STOP_OPTION), b.pair()), (2, pair));
    // and is stored again
    b.restart(&STORED);
    b.bring_up();
    assert_eq!(b.written().len(), 2);
}

#[test]
fn what_another_master_changed_and_did_not_store_is_gone_with_the_reset() {
    let mut b = Bench::new(&STORED, |_| {});
    b.bring_up();
    b.write(QUICK_STOP_OPTION, &6_u16.to_le_bytes());
    b.restart(&STORED);
    b.bring_up();
    assert_eq!(b.written(), [0x60B8, 0x6060]);
    assert_eq!(b.read(QUICK_STOP_OPTION), 2);
}

#[test]
fn another_setup_of_the_node_is_written() {
    let mut b = Bench::new(&STORED, |_| {});
    b.bring_up();
    let all = b.written();
    // it tells of a day later
    let [date, time] = b.pair();
    b.write(Address::new(0x1020, 1), &(date + 1).to_le_bytes());
    b.write(Address::new(0x1010, 1), SAVE);
    b.restart(&STORED);
    b.bring_up();
    assert_eq!((b.written(), b.pair()), (all, [date, time]));
}

#[test]
fn a_drive_without_the_object_is_configured_each_time_and_told_of() {
    let mut b = Bench::new(&STORED, |setup| {
        setup.axes[2].drive.quirks = Quirks::default().with(Quirk::NoVerifyConfiguration);
    });
    for round in 1..=2 {
        b.bring_up();
        assert_eq!(b.node.state(), NodeState::Disabled);
        let told = (0, Some(2), DriveFinding::SetupNotStored, None, None);
        assert_eq!(b.found, vec![told; round]);
        let all = b.written();
        // 1020:1 is refused, so nothing is stored
        assert_eq!((all.len() > 40, all.last()), (true, Some(&0x1020)));
        b.restart(&STORED);
    }
}

#[test]
fn after_a_fault_everything_is_written_and_nothing_stored() {
    let mut b = Bench::new(&STORED, |_| {});
    b.bring_up();
    let mut all = b.written();
    let epoch = b.enable();
    assert!(
        b.robot
            .inject(2, Some(DriveFault::Trip(ErrorCode::HARDWARE)))
    );
    b.run_ms(200);
    assert_eq!(b.node.state(), NodeState::Faulted);
    assert!(b.robot.inject(2, None));
    b.requests.clear();
    assert_eq!(b.ask(&Request::Acknowledge { epoch }), Reply::Accepted);
    b.run_ms(1000);
    assert_eq!(b.node.state(), NodeState::Disabled);
    all.truncate(all.len() - 3);
    assert_eq!(b.written(), all);
}
