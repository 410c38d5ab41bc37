//! Values longer than 256 bytes and program download, seen from the wire.

use protocol::canopen::cia402::Mode;
use protocol::canopen::nmt::Command;
use protocol::canopen::node::{Function, frame, standard};
use protocol::canopen::sdo::{Abort, Address, BlockClient, Client, ClientError, Outcome, Progress};
use protocol::time::Micros;

use super::bench::{Bench, axis_setup};
use crate::drive::{PROGRAM_CAPACITY, flash};

const DATA: Address = Address::new(0x1F50, 1);
/// What the clients of these tests hold.
const CLIENT: usize = PROGRAM_CAPACITY + 1;

fn bench() -> Bench {
    let mut bench = Bench::new(&axis_setup(0, 10.0));
    bench.wait(200);
    bench
}

fn program(len: usize) -> Vec<u8> {
    (0..len)
        .map(|k| u8::try_from((k * k + k / 256) % 251).unwrap())
        .collect()
}

/// Any of the two clients.
enum Any {
    Segments(Box<Client<CLIENT>>),
    Blocks(Box<BlockClient<CLIENT>>),
}

impl Any {
    fn new(blocks: bool) -> Self {
        if blocks {
            Self::Blocks(Box::default())
        } else {
            Self::Segments(Box::default())
        }
    }

    fn download(&mut self, value: &[u8]) -> Result<[u8; 8], ClientError> {
        match self {
            Self::Segments(client) => client.download(Micros(0), DATA, value),
            Self::Blocks(client) => client.download(Micros(0), DATA, value),
        }
    }

    fn upload(&mut self) -> [u8; 8] {
        let started = match self {
            Self::Segments(client) => client.upload(Micros(0), DATA),
            Self::Blocks(client) => client.upload(Micros(0), DATA),
        };
        started.unwrap()
    }

    fn on_answer(&mut self, data: &[u8]) -> Progress {
        match self {
            Self::Segments(client) => client.on_answer(Micros(0), data),
            Self::Blocks(client) => client.on_answer(Micros(0), data),
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

/// Runs a transfer to its end.
fn run(bench: &mut Bench, client: &mut Any, first: [u8; 8]) -> Outcome {
    let request = bench.node.cob(Function::SdoRequest);
    let answer = Some(bench.node.cob(Function::SdoAnswer));
    let mut waiting = std::collections::VecDeque::from([first]);
    // 64 KiB are 9363 segments, each with an answer or a millisecond
    for _ in 0..40_000 {
        let before = bench.log.len();
        match waiting.pop_front() {
            Some(next) => drop(bench.send(&frame(request, next))),
            None => bench.wait(1),
        }
        for item in bench.log.split_off(before) {
            if standard(&item.frame) != answer {
                continue;
            }
            match client.on_answer(item.frame.data()) {
                Progress::Send(next) => waiting.push_back(next),
                Progress::Done(outcome) => return outcome,
                Progress::End(last, outcome) => {
                    bench.send(&frame(request, last));
                    return outcome;
                }
                Progress::Ignored => {}
            }
            while let Some(segment) = client.next_segment() {
                waiting.push_back(segment);
            }
        }
    }
    panic!("the transfer never ended");
}

fn load(bench: &mut Bench, blocks: bool, value: &[u8]) -> Outcome {
    let mut client = Any::new(blocks);
    let first = client.download(value).unwrap();
    run(bench, &mut client, first)
}

/// 1F51, 1F56, 1F57.
fn told(bench: &mut Bench) -> [u32; 3] {
    [0x1F51, 0x1F56, 0x1F57].map(|index| bench.read(index, 1))
}

fn control(bench: &mut Bench, command: u8) -> Outcome {
    bench.write_sub(0x1F51, 1, &[command])
}

fn refused(index: u16) -> Outcome {
    Outcome::Refused(Address::new(index, 1), Abort::DeviceState)
}

#[test]
fn a_program_goes_in_and_out_by_segments_and_in_blocks_whatever_its_length() {
    // a byte, what one transfer held so far and one more, a block of 127 segments and one more, several, and all
    for len in [1, 256, 257, 889, 890, 5000, PROGRAM_CAPACITY] {
        for blocks in [false, true] {
            let mut bench = bench();
            let value = program(len);
            assert_eq!(told(&mut bench), [1, 0, flash::GOOD]);
            for command in [0, 3] {
                control(&mut bench, command);
            }
            assert_eq!(told(&mut bench), [0, 0, flash::NO_PROGRAM]);
            assert_eq!(load(&mut bench, blocks, &value), Outcome::Downloaded(DATA));
            let [running, crc, status] = told(&mut bench);
            assert_eq!((running, status), (0, flash::GOOD));
            assert_eq!(
                control(&mut bench, 1),
                Outcome::Downloaded(Address::new(0x1F51, 1))
            );
            // it survives a reset, and comes out the other way
            bench.nmt(Command::ResetNode);
            bench.wait(200);
            assert_eq!(told(&mut bench), [1, crc, flash::GOOD]);
            let mut client = Any::new(!blocks);
            let first = client.upload();
            assert_eq!(run(&mut bench, &mut client, first), Outcome::Uploaded(DATA));
            assert!(client.data() == value, "{len} {blocks}");
        }
    }
}

#[test]
fn what_is_too_long_is_refused_before_a_byte_of_it_comes() {
    let mut bench = bench();
    for command in [0, 3] {
        control(&mut bench, command);
    }
    for blocks in [false, true] {
        let outcome = load(&mut bench, blocks, &program(PROGRAM_CAPACITY + 1));
        assert_eq!(outcome, Outcome::Refused(DATA, Abort::Memory));
    }
    assert_eq!(told(&mut bench), [0, 0, flash::NO_PROGRAM]);
    // the client has a capacity, too
    let mut short = BlockClient::<8>::default();
    assert_eq!(
        short.download(Micros(0), DATA, &[0; 9]),
        Err(ClientError::TooLong)
    );
}

#[test]
fn a_program_is_only_taken_when_the_last_one_was_stopped_and_cleared() {
    let mut bench = bench();
    assert_eq!(load(&mut bench, false, &program(300)), refused(0x1F50));
    assert_eq!(told(&mut bench), [1, 0, flash::SECURED]);
    assert_eq!(control(&mut bench, 3), refused(0x1F51), "it runs");
    control(&mut bench, 0);
    assert_eq!(load(&mut bench, false, &program(300)), refused(0x1F50));
    assert_eq!(told(&mut bench), [0, 0, flash::NOT_CLEARED]);
    control(&mut bench, 3);
    assert_eq!(control(&mut bench, 1), refused(0x1F51), "there is none");
    assert_eq!(
        load(&mut bench, true, &program(300)),
        Outcome::Downloaded(DATA)
    );
    assert_eq!(load(&mut bench, true, &program(301)), refused(0x1F50));
    let at = Address::new(0x1F51, 1);
    assert_eq!(control(&mut bench, 4), Outcome::Refused(at, Abort::TooHigh));
    // under torque nothing of it is touched
    let mut bench = self::bench();
    bench.enable(Mode::Csp);
    assert_eq!(control(&mut bench, 0), refused(0x1F51));
    assert_eq!(bench.read(0x1F51, 1), 1);
}
