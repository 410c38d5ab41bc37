//! A conveyor with its node, its keeper, what survives a reset, and a bus that can be bad.

use bus::wire::Kind;
use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash,
};
use firmware::maintenance::black_box::{self, BlackBox, Memory};
use firmware::maintenance::{Keeper, Kept, Start};
use firmware::update::Updater;
use firmware::update::image::{self, CRC};
use firmware::update::slots::{Layout, Slots};
use firmware::{Node, Station};
use hil_sim::cell::Cell;
use host::error::Error;
use host::maintenance::{Client, Wire};
use protocol::frame::Frame;
use protocol::id::NodeId;
use protocol::maintenance::{ImageHeader, ResetCause};
use protocol::message::{NodeState, ServoLaw};
use protocol::time::Micros;
use protocol::transfer::Mtu;
use robots::{Conveyor, RobotKind, TrackRule};
use std::sync::{Arc, Mutex};

/// A page, bytes.
const P: u32 = 2048;
const PAGE: usize = P as usize;
pub(super) const LAYOUT: Layout = Layout {
    slot_a: 0,
    slot_b: 7 * P,
    slot: 5 * P,
    log: [5 * P, 6 * P],
};

/// What survives a reset of the node.
pub(super) type Shared = Arc<Mutex<Vec<u8>>>;

#[derive(Clone, Debug)]
pub(super) struct Flash(pub(super) Shared);

#[derive(Debug)]
pub(super) struct Beyond;

impl NorFlashError for Beyond {
    fn kind(&self) -> NorFlashErrorKind {
        NorFlashErrorKind::OutOfBounds
    }
}

impl ErrorType for Flash {
    type Error = Beyond;
}

impl ReadNorFlash for Flash {
    const READ_SIZE: usize = 1;
    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Beyond> {
        let all = self.0.lock().unwrap();
        let from = all
            .get(offset as usize..)
            .and_then(|rest| rest.get(..bytes.len()));
        bytes.copy_from_slice(from.ok_or(Beyond)?);
        Ok(())
    }
    fn capacity(&self) -> usize {
        self.0.lock().unwrap().len()
    }
}

impl NorFlash for Flash {
    const WRITE_SIZE: usize = 8;
    const ERASE_SIZE: usize = PAGE;
    fn erase(&mut self, from: u32, to: u32) -> Result<(), Beyond> {
        self.0.lock().unwrap()[from as usize..to as usize].fill(0xFF);
        Ok(())
    }
    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Beyond> {
        let mut all = self.0.lock().unwrap();
        for (place, byte) in all[offset as usize..].iter_mut().zip(bytes) {
            assert_eq!(*place, 0xFF, "written without being erased");
            *place = *byte;
        }
        Ok(())
    }
}

#[derive(Debug)]
pub(super) struct BoxMemory {
    pub(super) bytes: Vec<u8>,
    pub(super) kept: Shared,
}

impl Memory for BoxMemory {
    fn bytes(&self) -> &[u8] {
        &self.bytes
    }
    fn bytes_mut(&mut self) -> &mut [u8] {
        &mut self.bytes
    }
    fn keep(&mut self) {
        self.kept.lock().unwrap().clone_from(&self.bytes);
    }
}

pub(super) const ROBOT: RobotKind = RobotKind::Conveyor;
pub(super) const TARGET: &str = "bench";

pub(super) fn me(number: u8) -> NodeId {
    NodeId::new(number).unwrap()
}

pub(super) fn node_id() -> NodeId {
    NodeId::effector(ROBOT.effector()).unwrap()
}

pub(super) fn image_of(bytes: &[u8], version: (u8, u8, u8)) -> ImageHeader {
    ImageHeader {
        robot: ROBOT.name().try_into().unwrap(),
        target: TARGET.try_into().unwrap(),
        version,
        schema_hash: 1,
        length: bytes.len().try_into().unwrap(),
        crc: CRC.checksum(bytes),
    }
}

pub(super) fn program(length: usize) -> Vec<u8> {
    (0..length)
        .map(|k| (k * 7 % 251).to_le_bytes()[0])
        .collect()
}

/// A conveyor with its node, its keeper, and a bus that can be bad.
pub(super) struct Bench {
    pub(super) cell: Cell,
    pub(super) flash: Shared,
    pub(super) memory: Shared,
    pub(super) boots: u32,
    pub(super) sent: u64,
    pub(super) heard: u64,
    /// Every so-manieth frame is lost, either way.
    pub(super) loss: Option<u64>,
    /// Every frame comes twice.
    pub(super) twice: bool,
    /// After so many frames the bus is away for so long.
    pub(super) away: Option<(u64, Micros)>,
    pub(super) back_at: Micros,
}

impl Bench {
    pub(super) fn new() -> Self {
        let mut flash = vec![0xFF; 12 * PAGE];
        let old = program(100);
        flash[..image::HEADER].copy_from_slice(&image::write(&image_of(&old, (0, 1, 0))));
        flash[PAGE..PAGE + 100].copy_from_slice(&old);
        let mut bench = Self {
            cell: Cell::new(Kind::Classic),
            flash: Arc::new(Mutex::new(flash)),
            memory: Arc::new(Mutex::new(vec![0x5A; black_box::bytes(1)])),
            boots: 0,
            sent: 0,
            heard: 0,
            loss: None,
            twice: false,
            away: None,
            back_at: Micros(0),
        };
        bench.reset();
        bench
    }

    /// Everything is new but what survives a reset.
    pub(super) fn reset(&mut self) {
        self.boots += 1;
        let station = Station {
            effector: ROBOT.effector(),
            unique_id: u64::from(self.boots),
            mtu: Mtu::Classic,
            law: ServoLaw::DrivePosition,
            velocity_factor: 0.5,
            one_wire: false,
            track: TrackRule::Keep,
        };
        let config = station.config([0]).unwrap();
        let node = Node::new(Micros(0), Conveyor, config).unwrap();
        let start = Start {
            target: TARGET.try_into().unwrap(),
            cause: if self.boots == 1 {
                ResetCause::PowerOn
            } else {
                ResetCause::Watchdog
            },
            boots: self.boots,
        };
        let memory = BoxMemory {
            bytes: self.memory.lock().unwrap().clone(),
            kept: Arc::clone(&self.memory),
        };
        let black_box = BlackBox::open(memory, 1).unwrap();
        let mut slots = Slots::new(Flash(Arc::clone(&self.flash)), LAYOUT).unwrap();
        let choice = slots.start().unwrap();
        let keeper = Keeper::new(start, black_box, Updater::new(slots, choice));
        self.cell = Cell::new(Kind::Classic);
        let kept = Box::new(Kept::new(node, keeper));
        self.cell.add_node(ROBOT, kept, &config.drives, 1).unwrap();
        self.back_at = Micros(0);
        self.run(2500);
        assert_eq!(self.state(), NodeState::Disabled);
    }

    pub(super) fn state(&self) -> NodeState {
        self.cell.node(0).unwrap().state()
    }

    pub(super) fn run(&mut self, ms: u64) {
        let until = self.cell.now() + Micros::from_millis(ms);
        self.cell.advance(until, &mut ());
        drop(self.cell.receive());
    }

    pub(super) fn client(&mut self, number: u8) -> Client<'_, Self> {
        Client::new(self, me(number), node_id(), ROBOT.name().into())
    }

    pub(super) fn lost(&mut self, count: u64) -> bool {
        self.cell.now() < self.back_at || self.loss.is_some_and(|every| count % every == every - 1)
    }
}

impl Wire for Bench {
    fn mtu(&self) -> Mtu {
        Mtu::Classic
    }
    fn now(&self) -> Micros {
        self.cell.now()
    }
    fn send(&mut self, frame: &Frame) -> Result<(), Error> {
        self.sent += 1;
        if let Some((after, long)) = self.away
            && self.sent == after
        {
            self.back_at = self.cell.now() + long;
        }
        if !self.lost(self.sent) {
            for _ in 0..=u8::from(self.twice) {
                self.cell.send(*frame);
            }
        }
        Ok(())
    }
    fn pass(&mut self, until: Micros, rx: &mut Vec<(Micros, Frame)>) -> Result<(), Error> {
        self.cell.advance(until, &mut ());
        let arrived: Vec<_> = self.cell.receive().collect();
        for received in arrived {
            self.heard += 1;
            if !self.lost(self.heard) {
                rx.push(received);
            }
        }
        Ok(())
    }
}
