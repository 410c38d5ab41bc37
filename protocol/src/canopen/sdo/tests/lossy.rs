//! A wire that loses and doubles frames: every transfer ends, and only in the truth.

use std::collections::VecDeque;

use super::*;

/// Longer than two blocks of 127 segments.
const LONG: usize = 2000;

/// The client of either kind.
enum Any {
    Segments(Client<LONG>),
    Blocks(BlockClient<LONG>),
}

impl Any {
    fn on_answer(&mut self, now: Micros, data: &[u8]) -> Progress {
        match self {
            Self::Segments(client) => client.on_answer(now, data),
            Self::Blocks(client) => client.on_answer(now, data),
        }
    }

    fn poll(&mut self, now: Micros) -> Option<Progress> {
        match self {
            Self::Segments(client) => client.poll(now),
            Self::Blocks(client) => client.poll(now),
        }
    }

    fn next_segment(&mut self) -> Option<[u8; 8]> {
        match self {
            Self::Segments(_) => None,
            Self::Blocks(client) => client.next_segment(),
        }
    }

    fn data(&self) -> &[u8] {
        match self {
            Self::Segments(client) => client.data(),
            Self::Blocks(client) => client.data(),
        }
    }
}

/// What the wire does to one frame.
#[derive(Clone, Copy, Debug)]
enum Fate {
    Arrives,
    Lost,
    Doubled,
}

fn fates() -> impl Strategy<Value = Vec<Fate>> {
    let fate = prop_oneof![
        20 => Just(Fate::Arrives),
        1 => Just(Fate::Lost),
        1 => Just(Fate::Doubled),
    ];
    prop::collection::vec(fate, 0..900)
}

/// Both directions of a wire; where `fates` ends, everything arrives.
struct Wire {
    fates: std::vec::IntoIter<Fate>,
    to_server: VecDeque<[u8; 8]>,
    to_client: VecDeque<[u8; 8]>,
}

impl Wire {
    fn put(&mut self, to_server: bool, frame: [u8; 8]) {
        let copies = match self.fates.next().unwrap_or(Fate::Arrives) {
            Fate::Arrives => 1,
            Fate::Lost => 0,
            Fate::Doubled => 2,
        };
        let queue = if to_server {
            &mut self.to_server
        } else {
            &mut self.to_client
        };
        queue.extend(std::iter::repeat_n(frame, copies));
    }
}

/// Runs one transfer to its end. Each turn without a frame lets time pass.
fn transfer(
    client: &mut Any,
    server: &mut Server<LONG>,
    od: &mut Objects,
    first: [u8; 8],
    fates: Vec<Fate>,
) -> Outcome {
    let mut wire = Wire {
        fates: fates.into_iter(),
        to_server: VecDeque::new(),
        to_client: VecDeque::new(),
    };
    let mut now = Micros(0);
    wire.put(true, first);
    // 2000 bytes are 286 segments, each with its answer, plus what is repeated: far below this bound.
    for _ in 0..20_000 {
        let progress = if let Some(request) = wire.to_server.pop_front() {
            if let Some(answer) = server.on_request(now, &request, od) {
                wire.put(false, answer);
            }
            while let Some(segment) = server.next_segment() {
                wire.put(false, segment);
            }
            None
        } else if let Some(answer) = wire.to_client.pop_front() {
            Some(client.on_answer(now, &answer))
        } else {
            now = now + Micros(50_000);
            if let Some(abort) = server.poll(now) {
                wire.put(false, abort);
            }
            client.poll(now)
        };
        match progress {
            Some(Progress::Send(frame)) => wire.put(true, frame),
            Some(Progress::Done(outcome)) => return outcome,
            Some(Progress::End(frame, outcome)) => {
                server.on_request(now, &frame, od);
                return outcome;
            }
            Some(Progress::Ignored) | None => {}
        }
        while let Some(segment) = client.next_segment() {
            wire.put(true, segment);
        }
    }
    panic!("the transfer never ended");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn a_download_ends_in_the_value_or_an_abort(
        value in prop::collection::vec(any::<u8>(), 1..=LONG),
        fates in fates(),
        blocks in any::<bool>(),
    ) {
        let mut od = objects(b"before");
        let mut client = if blocks { Any::Blocks(BlockClient::default()) } else { Any::Segments(Client::default()) };
        let first = match &mut client {
            Any::Segments(client) => client.download(NOW, AT, &value),
            Any::Blocks(client) => client.download(NOW, AT, &value),
        }.unwrap();
        let outcome = transfer(&mut client, &mut Server::<LONG>::default(), &mut od, first, fates);
        let stored = &od.0[&AT];
        prop_assert!(stored == b"before" || *stored == value, "{:?}: {:?}", outcome, stored);
        if outcome == Outcome::Downloaded(AT) {
            prop_assert_eq!(stored, &value);
        }
    }

    #[test]
    fn an_upload_ends_in_the_value_or_an_abort(
        value in prop::collection::vec(any::<u8>(), 1..=LONG),
        fates in fates(),
        blocks in any::<bool>(),
    ) {
        let mut od = objects(&value);
        let mut client = if blocks { Any::Blocks(BlockClient::default()) } else { Any::Segments(Client::default()) };
        let first = match &mut client {
            Any::Segments(client) => client.upload(NOW, AT),
            Any::Blocks(client) => client.upload(NOW, AT),
        }.unwrap();
        let outcome = transfer(&mut client, &mut Server::<LONG>::default(), &mut od, first, fates);
        if outcome == Outcome::Uploaded(AT) {
            prop_assert_eq!(client.data(), &value[..]);
        }
    }

    #[test]
    fn without_loss_every_block_transfer_succeeds(value in prop::collection::vec(any::<u8>(), 0..=LONG)) {
        let mut od = objects(b"before");
        let mut client = BlockClient::<LONG>::default();
        let first = client.download(NOW, AT, &value).unwrap();
        let mut client = Any::Blocks(client);
        let outcome = transfer(&mut client, &mut Server::<LONG>::default(), &mut od, first, Vec::new());
        prop_assert_eq!(outcome, Outcome::Downloaded(AT));
        prop_assert_eq!(&od.0[&AT], &value);
        let mut client = BlockClient::<LONG>::default();
        let first = client.upload(NOW, AT).unwrap();
        let mut client = Any::Blocks(client);
        let outcome = transfer(&mut client, &mut Server::<LONG>::default(), &mut od, first, Vec::new());
        prop_assert_eq!(outcome, Outcome::Uploaded(AT));
        prop_assert_eq!(client.data(), &value[..]);
    }

    #[test]
    fn no_frame_breaks_block_transfer(frames in prop::collection::vec(prop::collection::vec(any::<u8>(), 0..=8), 0..40)) {
        let (mut client, mut server) = (BlockClient::<32>::default(), Server::<CAPACITY>::default());
        let mut od = objects(&[1; 40]);
        for frame in frames {
            let _ = client.download(NOW, AT, &[3; 20]);
            let _ = client.on_answer(NOW, &frame);
            let _ = client.next_segment();
            let _ = server.on_request(NOW, &frame, &mut od);
            let _ = server.next_segment();
        }
    }
}
