use super::*;
use crate::bit_timing::{M_CAN, Rate, classic, fd};
use core::cell::RefCell;
use std::rc::Rc;
use std::vec;
use std::vec::Vec;

const CLOCK: u32 = 170_000_000;

/// A controller as its manual tells: registers that mean what they mean, and memory.
#[derive(Debug)]
pub(crate) struct Model {
    registers: [u32; 0x104 / 4],
    memory: [u32; MEMORY],
    /// Frames on the wire, in the order in which they were sent.
    wire: Vec<Frame>,
    dead: bool,
}

impl Model {
    /// As it is without power.
    fn new() -> Rc<RefCell<Self>> {
        Rc::new(RefCell::new(Self {
            registers: [0; 0x104 / 4],
            memory: [0xA5A5_A5A5; MEMORY],
            wire: vec![],
            dead: false,
        }))
    }

    fn write(&mut self, word: usize, value: u32) {
        let configuring = self.registers[CCCR] & (INIT | CHANGE) == INIT | CHANGE;
        match word {
            CCCR if self.dead => {}
            // the right to change goes with the initialisation
            CCCR if value & INIT == 0 => {
                self.registers[CCCR] = value & !CHANGE;
                // with nobody else on the wire, 128 times 11 recessive bits are soon there
                self.registers[PSR] &= !BUS_OFF;
            }
            DBTP | NBTP | TSCC | TDCR | RXGFC | TXBC if !configuring => {
                panic!("word {word} is protected")
            }
            IR => self.registers[IR] &= !value,
            TXBAR => self.registers[TXBRP] |= value,
            TXBCR => self.registers[TXBRP] &= !value,
            _ if RXFA.contains(&word) => {
                let queue = RXFA.iter().position(|a| *a == word).unwrap();
                let status = &mut self.registers[RXFS[queue]];
                assert_eq!(*status >> 8 & 3, value, "acknowledged in order");
                let fill = (*status & 0xF) - 1;
                *status = fill | (((value + 1) % 3) << 8);
            }
            TXEFA => self.registers[TXEFS] = 0,
            _ => self.registers[word] = value,
        }
    }

    /// A frame comes; into which queue the filter says. `false` if it is full.
    pub(crate) fn receive(&mut self, frame: &Frame, stamp: u16) -> bool {
        let filter = self.memory[0];
        let [action, id, mask] = [filter >> 27 & 7, filter >> 16 & 0x7FF, filter & 0x7FF];
        assert_eq!(filter >> 30, 2, "an identifier and a mask");
        let queue = match frame.id() {
            Id::Standard(it) if u32::from(it) & mask == id & mask => action as usize - 1,
            _ => 0,
        };
        let status = self.registers[RXFS[queue]];
        let (fill, get) = (status & 0xF, status >> 8 & 3);
        if fill == 3 {
            self.registers[IR] |= LOST[queue];
            return false;
        }
        let put = (get + fill) % 3;
        let (words, _) = element::write(frame, false);
        let at = RECEIVED[queue] + put as usize * element::WORDS;
        self.memory[at..at + element::WORDS].copy_from_slice(&words);
        self.memory[at + 1] |= u32::from(stamp);
        self.registers[RXFS[queue]] = get << 8 | (fill + 1);
        self.registers[IR] |= NEW;
        true
    }

    /// Too many errors.
    pub(crate) fn go_off(&mut self) {
        self.registers[PSR] = BUS_OFF;
        self.registers[CCCR] |= INIT;
        self.registers[IR] |= BUS_OFF_CHANGED;
    }

    pub(crate) fn is_off(&self) -> bool {
        self.registers[PSR] & BUS_OFF != 0
    }

    pub(crate) fn wire(&self) -> &[Frame] {
        &self.wire
    }

    /// The wire is free: the lowest identifier goes, of equals that in the lowest buffer.
    pub(crate) fn send(&mut self, stamp: u16) {
        let pending = self.registers[TXBRP];
        let frame = |k: usize| {
            let at = TO_SEND + k * element::WORDS;
            let words: [u32; element::WORDS] =
                self.memory[at..at + element::WORDS].try_into().unwrap();
            (element::read(&words).unwrap().0, words)
        };
        let next = (0..3).filter(|k| pending & (1 << k) != 0);
        let Some(k) = next.min_by_key(|k| frame(*k).0.id().arbitration()) else {
            return;
        };
        let (frame, words) = frame(k);
        self.registers[TXBRP] &= !(1 << k);
        self.registers[IR] |= TRANSMITTED;
        if words[1] & 1 << 23 != 0 {
            self.registers[TXEFS] = 1;
            self.memory[SENT] = words[0];
            self.memory[SENT + 1] = u32::from(stamp);
        }
        self.wire.push(frame);
    }
}

#[derive(Debug)]
pub(crate) struct Window {
    model: Rc<RefCell<Model>>,
    memory: bool,
}

impl Words for Window {
    fn read(&self, word: usize) -> u32 {
        let model = self.model.borrow();
        if self.memory {
            model.memory[word]
        } else {
            model.registers[word]
        }
    }
    fn write(&mut self, word: usize, value: u32) {
        let mut model = self.model.borrow_mut();
        if self.memory {
            model.memory[word] = value;
        } else {
            model.write(word, value);
        }
    }
}

fn windows(model: &Rc<RefCell<Model>>) -> [Window; 2] {
    [false, true].map(|memory| Window {
        model: Rc::clone(model),
        memory,
    })
}

const SYNC: Id = Id::Standard(0x80);

pub(crate) fn started(timing: &BitTiming) -> (Rc<RefCell<Model>>, MCan<Window>) {
    let model = Model::new();
    let [registers, memory] = windows(&model);
    let can = MCan::start(registers, memory, timing, Some(SYNC)).unwrap();
    (model, can)
}

pub(crate) fn drives() -> BitTiming {
    classic(CLOCK, Rate::canopen(1_000_000), &M_CAN).unwrap()
}

pub(crate) fn frame(id: u16, number: u8) -> Frame {
    Frame::classic(Id::Standard(id), &[number]).unwrap()
}

#[test]
fn the_registers_of_both_buses_are_these() {
    let (model, _) = started(&drives());
    let registers = model.borrow().registers;
    // one less each: 21 (jump), 1, 148 before, 21 after
    assert_eq!(
        registers[NBTP],
        [20, 0, 147, 20]
            .into_iter()
            .zip([25, 16, 8, 0])
            .map(|(v, at)| v << at)
            .sum::<u32>()
    );
    assert_eq!((registers[CCCR], registers[DBTP]), (0, 0));
    let (model, _) = started(&fd(CLOCK, Rate::MP_NOMINAL, Rate::MP_DATA, &M_CAN).unwrap());
    let registers = model.borrow().registers;
    assert_eq!(
        registers[NBTP],
        [33, 0, 134, 33]
            .into_iter()
            .zip([25, 16, 8, 0])
            .map(|(v, at)| v << at)
            .sum::<u32>()
    );
    assert_eq!(registers[DBTP], 1 << 23 | 24 << 8 | 7 << 4 | 7);
    assert_eq!(registers[TDCR], 26 << 8);
    assert_eq!(registers[CCCR], FD_ON | SWITCH_ON);
    // the start of a frame by TIM3; queues as filtered; the lowest identifier first; interrupts on line 0
    assert_eq!((registers[TSCC], registers[RXGFC]), (2, 0x1_0003));
    assert_eq!((registers[TXBC], registers[ILE]), (1 << 24, 1));
}

#[test]
fn a_controller_that_does_not_answer_is_told() {
    let model = Model::new();
    model.borrow_mut().dead = true;
    let [registers, memory] = windows(&model);
    let silent = MCan::start(registers, memory, &drives(), None).unwrap_err();
    assert_eq!(silent, Silent);
}

#[test]
fn six_frames_of_drives_wait_and_the_seventh_is_counted() {
    let (model, mut can) = started(&drives());
    for turn in 0..4_u8 {
        for axis in 1..=6_u16 {
            let stamp = u16::from(turn) * 10 + axis;
            assert!(
                model
                    .borrow_mut()
                    .receive(&frame(0x180 + axis, turn), stamp)
            );
        }
        assert!(!model.borrow_mut().receive(&frame(0x187, turn), 0));
        can.acknowledge();
        assert_eq!(can.counts().overrun, u32::from(turn) + 1);
        let mut got: Vec<_> = core::iter::from_fn(|| can.receive()).collect();
        // odd ones and even ones keep their order
        let odd: Vec<_> = got
            .iter()
            .filter(|(_, s)| s % 2 == 1)
            .map(|(_, s)| s % 10)
            .collect();
        assert_eq!(odd, [1, 3, 5]);
        got.sort_by_key(|(_, stamp)| *stamp);
        for ((got, stamp), axis) in got.iter().zip(1..=6) {
            assert_eq!(
                (got, *stamp),
                (&frame(0x180 + axis, turn), u16::from(turn) * 10 + axis)
            );
        }
        assert_eq!(got.len(), 6);
    }
}

#[test]
fn an_fd_frame_comes_as_it_was() {
    let (model, mut can) = started(&fd(CLOCK, Rate::MP_NOMINAL, Rate::MP_DATA, &M_CAN).unwrap());
    let bytes: Vec<u8> = (0..64).collect();
    let frame = Frame::fd(Id::Extended(0x0123_4567), &bytes).unwrap();
    assert!(model.borrow_mut().receive(&frame, 0xFFFE));
    assert_eq!(can.receive(), Some((frame, 0xFFFE)));
    assert_eq!(can.receive(), None);
}

#[test]
fn sync_overtakes_and_frames_of_one_identifier_do_not() {
    let (model, mut can) = started(&drives());
    let mut outbox = Outbox::<16>::new();
    for number in 0..5 {
        outbox.push(frame(0x601, number));
    }
    outbox.push(frame(0x201, 9));
    can.transmit(&mut outbox);
    outbox.push(frame(0x80, 0));
    for stamp in 0..12 {
        can.transmit(&mut outbox);
        model.borrow_mut().send(stamp);
    }
    let sent: Vec<_> = model
        .borrow()
        .wire
        .iter()
        .map(|f| (f.id(), f.data()[0]))
        .collect();
    let wanted = [
        (0x80, 0),
        (0x201, 9),
        (0x601, 0),
        (0x601, 1),
        (0x601, 2),
        (0x601, 3),
        (0x601, 4),
    ];
    assert_eq!(sent, wanted.map(|(id, number)| (Id::Standard(id), number)));
}

#[test]
fn it_is_told_when_sync_was_sent_and_nothing_else() {
    let (model, mut can) = started(&drives());
    let mut outbox = Outbox::<16>::new();
    outbox.push(frame(0x201, 0));
    outbox.push(frame(0x80, 0));
    can.transmit(&mut outbox);
    model.borrow_mut().send(1234);
    assert_eq!(
        can.sent(),
        Some(Sent {
            id: SYNC,
            stamp: 1234
        })
    );
    model.borrow_mut().send(2000);
    assert_eq!(can.sent(), None);
}

#[test]
fn bus_off_is_counted_once_and_left_with_empty_buffers() {
    let (model, mut can) = started(&drives());
    let mut outbox = Outbox::<16>::new();
    outbox.push(frame(0x201, 0));
    can.transmit(&mut outbox);
    model.borrow_mut().go_off();
    can.acknowledge();
    can.acknowledge();
    assert!(can.is_bus_off());
    assert_eq!(can.counts().bus_off, 1);
    can.rejoin();
    let model = model.borrow();
    assert_eq!(
        (model.registers[CCCR] & INIT, model.registers[TXBRP]),
        (0, 0)
    );
}
