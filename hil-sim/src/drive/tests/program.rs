//! Values longer than 256 bytes and program download, seen from the wire.

use protocol::canopen::cia402::Mode;
use protocol::canopen::nmt::Command;
use protocol::canopen::sdo::{Abort, Address, BlockClient, Client, ClientError, Outcome};
use protocol::time::Micros;

use super::bench::{Bench, Converse, axis_setup};
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

/// Either of the two clients.
fn client(blocks: bool) -> Box<dyn Converse> {
    if blocks {
        Box::new(BlockClient::<CLIENT>::default())
    } else {
        Box::new(Client::<CLIENT>::default())
    }
}

fn load(bench: &mut Bench, blocks: bool, value: &[u8]) -> Outcome {
    let mut client = client(blocks);
    let first = client.download(DATA, value).unwrap();
    bench.converse(&mut *client, first)
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
            let mut client = client(!blocks);
            let first = client.upload(DATA).unwrap();
            assert_eq!(bench.converse(&mut *client, first), Outcome::Uploaded(DATA));
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
