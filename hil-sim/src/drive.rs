//! A simulated servo drive: a conformant CiA 301 / CiA 402 slave for one axis.
//!
//! It speaks CANopen on one side and torque on the other, and knows nothing of the plant but what
//! its receptors tell. Its monitoring is on from power-up: a missing SYNC or set-point, a lost
//! heartbeat, too much current or too great a following error stop the axis without the node.
//!
//! ```text
//!           frames                               substeps
//! node ──▶ on_frame ──▶ NMT, SDO, RPDO, SYNC ──▶ torque_command ──▶ plant
//!      ◀── poll     ◀── EMCY, TPDO, heartbeat ◀── Sensed        ◀──
//! ```
//!
//! | module | one line |
//! |---|---|
//! | [`parameters`] | what a drive is commissioned with |
//! | `dictionary` | the object dictionary and the checks on writing it |
//! | `layer` | node identifiers (LSS) and resets |
//! | `network` | frames in and out: NMT, SYNC, SDO, PDO, heartbeats |
//! | `operation` | power states, modes, brake, following the set-points |
//! | `report` | what the objects tell |
//! | `monitor` | what stops the axis without the node |
//! | `controller` | how its CAN controller is, and what follows from it |
//! | `scale` | drive units, increments, radians |
//! | `servo` | set-point generation, observer, position and velocity control |
//! | `homing`, `probe` | homing inside the drive; the position at an edge |
//! | [`quirk`] | what drives in the field do otherwise |
//! | `fast` | the fast profile on CAN FD |
//! | `profile` | the modes in which the drive makes its way itself: pp, pv |

mod controller;
mod dictionary;
mod fast;
mod homing;
mod layer;
mod monitor;
mod network;
mod operation;
pub mod parameters;
mod probe;
mod profile;
pub mod quirk;
mod report;
mod scale;
pub(crate) mod servo;
mod slots;

use bus::wire::confinement::State;
use protocol::canopen::cia402::{
    AbortConnection, Controlword, Mode, Options, Power, PowerState, output,
};
use protocol::canopen::emcy::{ErrorCode, ErrorRegister, History, Producer};
use protocol::canopen::lss;
use protocol::canopen::nmt::{self, HeartbeatConsumer, HeartbeatProducer};
use protocol::canopen::node::NodeId;
use protocol::canopen::objects::{Object, eds};
use protocol::canopen::pdo::{Communication, Mapping, Rpdo, Tpdo, Transmission};
use protocol::canopen::sdo::Server;
use protocol::frame::Frame;
use protocol::time::Micros;

use crate::plant::axis::{Drive, EncoderFault, Sensed};
use dictionary::Dictionary;
pub use dictionary::program::{CAPACITY as PROGRAM_CAPACITY, flash};
use homing::Homing;
use parameters::DriveParameters;
use probe::Probes;
use profile::Way;
use scale::{Scale, to_i32};
use servo::Servo;

/// A fault put into a drive or its axis from outside, as data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DriveFault {
    /// The drive trips with this error code; it cannot be reset while injected.
    Trip(ErrorCode),
    /// The drive neither sends nor receives; its axis goes on by the last set-point until the
    /// drive's own monitoring stops it.
    Silent,
    /// The encoder tells something else.
    Encoder(EncoderFault),
    /// The home switch is stuck at this level.
    SwitchStuck(bool),
    /// The encoder gives no index pulse.
    IndexMissing,
    /// The drive starts anew and has lost its node id, the stored one too; it works when it is given one.
    Blank,
}

impl DriveFault {
    /// Those that have a name on a command line.
    pub const NAMED: [(&'static str, Self); 11] = [
        ("silent", Self::Silent),
        ("trip", Self::Trip(ErrorCode::HARDWARE)),
        (
            EncoderFault::Frozen.name(),
            Self::Encoder(EncoderFault::Frozen),
        ),
        (
            EncoderFault::Jumping.name(),
            Self::Encoder(EncoderFault::Jumping),
        ),
        (
            EncoderFault::Reversed.name(),
            Self::Encoder(EncoderFault::Reversed),
        ),
        (
            EncoderFault::Drifting.name(),
            Self::Encoder(EncoderFault::Drifting),
        ),
        (
            EncoderFault::Garbage.name(),
            Self::Encoder(EncoderFault::Garbage),
        ),
        ("switch-on", Self::SwitchStuck(true)),
        ("switch-off", Self::SwitchStuck(false)),
        ("no-index", Self::IndexMissing),
        ("blank", Self::Blank),
    ];

    /// The fault of a name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        let named = Self::NAMED.into_iter().find(|(known, _)| *known == name);
        named.map(|(_, fault)| fault)
    }

    /// Its name on a command line; of any other trip than of the hardware too.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Silent => "silent",
            Self::Trip(_) => "trip",
            Self::Encoder(wrong) => wrong.name(),
            Self::SwitchStuck(true) => "switch-on",
            Self::SwitchStuck(false) => "switch-off",
            Self::IndexMissing => "no-index",
            Self::Blank => "blank",
        }
    }
}

/// The power stage and the brake.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    /// No torque, brake closed.
    Off,
    /// Torque holds the axis while the brake opens, until this time, ns.
    Opening(u64),
    /// Torque, brake open.
    On,
    /// Torque holds the axis while the brake closes, until this time, ns.
    Closing(u64),
}

/// A simulated drive.
#[derive(Clone, Debug)]
pub struct SimDrive {
    node: NodeId,
    p: DriveParameters,
    od: Dictionary,
    scale: Scale,
    // Network
    lss: lss::Slave,
    nmt: nmt::State,
    boot_at_ns: u64,
    producer: HeartbeatProducer,
    consumer: Option<HeartbeatConsumer>,
    server: Box<Server<PROGRAM_CAPACITY>>,
    answer: Option<(u64, [u8; 8])>,
    rpdo: [Rpdo; 4],
    tpdo: [Tpdo; 4],
    accept: [u64; 32],
    fast: fast::Fast,
    sync_cob: u16,
    outbox: Vec<Frame>,
    poll_at_ns: u64,
    silent: bool,
    layer: layer::Layer,
    can: State,
    // Operation
    power: Power,
    options: Options,
    controlword: Controlword,
    mode: Mode,
    stage: Stage,
    servo: Servo,
    homing: Homing,
    way: Way,
    probes: Probes,
    /// Digital inputs for whoever needs them: probe inputs 1 and 2 are the first.
    external: u16,
    offset: servo::Offset,
    limit_nm: f64,
    period_ns: u64,
    halted: bool,
    cut: bool,
    // Monitoring
    sensed: Sensed,
    home: Debounced,
    whims: quirk::Whims,
    last_sync_ns: Option<u64>,
    missed: u8,
    /// Where the first index was since power-up, counts modulo a turn.
    index: Option<i64>,
    /// When a ramp that leads to torque off has taken too long, ns.
    ramp_ends_ns: u64,
    /// How fast the axis was when it began, rad/s.
    ramp_began_rad_s: f64,
    over_current_since_ns: Option<u64>,
    following_since_ns: Option<u64>,
    abort_connection: AbortConnection,
    injected: Option<ErrorCode>,
    errors: Errors,
    history: History<4>,
    emergencies: Producer<8>,
    following_window: (f64, u64),
    now_ns: u64,
}

/// A switch that counts only after it rested.
#[derive(Clone, Copy, Debug, Default)]
struct Debounced {
    level: bool,
    differs_since_ns: Option<u64>,
}

/// What object 1001, 603F and 1003 tell.
#[derive(Clone, Copy, Debug, Default)]
struct Errors {
    register: ErrorRegister,
    code: ErrorCode,
}

impl SimDrive {
    /// A drive that is switched on at `now_ns`, with the inner loop closed every `dt_s`.
    #[must_use]
    pub fn new(node: NodeId, p: DriveParameters, now_ns: u64, dt_s: f64) -> Self {
        let od = Dictionary::new(node, &p);
        let unused = Communication::new(0, Transmission::SyncAcyclic);
        let unused = Communication {
            enabled: false,
            ..unused
        };
        let mut drive = Self {
            node,
            p,
            scale: Scale::read(&od),
            lss: lss::Slave::new(identity(&od), Some(node)),
            od,
            nmt: nmt::State::Initialising,
            boot_at_ns: now_ns,
            producer: HeartbeatProducer::new(Micros(0), Micros(0)),
            consumer: None,
            server: Box::default(),
            answer: None,
            rpdo: [(); 4].map(|()| Rpdo::new(unused, Mapping::default())),
            tpdo: [(); 4].map(|()| Tpdo::new(unused, Mapping::default())),
            accept: [0; 32],
            fast: fast::Fast::default(),
            sync_cob: 0,
            outbox: Vec::with_capacity(8),
            poll_at_ns: 0,
            silent: false,
            layer: layer::Layer::default(),
            can: State::Active,
            power: Power::NotReady,
            options: Options::default(),
            controlword: Controlword::default(),
            mode: Mode::None,
            stage: Stage::Off,
            servo: Servo::new(p, dt_s),
            homing: Homing::Idle,
            way: Way::default(),
            probes: Probes::default(),
            external: 0,
            offset: servo::Offset::default(),
            limit_nm: 0.0,
            period_ns: 2 * parameters::MS,
            halted: false,
            cut: false,
            sensed: Sensed::default(),
            home: Debounced::default(),
            whims: quirk::Whims::default(),
            last_sync_ns: None,
            missed: 0,
            index: None,
            ramp_ends_ns: 0,
            ramp_began_rad_s: 0.0,
            over_current_since_ns: None,
            following_since_ns: None,
            abort_connection: AbortConnection::QuickStop,
            injected: None,
            errors: Errors::default(),
            history: History::new(),
            emergencies: Producer::new(0),
            following_window: (f64::INFINITY, 0),
            now_ns,
        };
        drive.boot_at_ns = now_ns + drive.boot_ns();
        drive.servo.rest_at(0.0);
        drive.configure();
        drive
    }

    /// The CANopen node identifier.
    #[must_use]
    pub const fn node(&self) -> NodeId {
        self.node
    }

    /// Transmit mailboxes of its CAN controller.
    #[must_use]
    pub const fn mailboxes(&self) -> usize {
        self.p.mailboxes
    }

    /// The NMT state.
    #[must_use]
    pub const fn nmt_state(&self) -> nmt::State {
        self.nmt
    }

    /// The last error since the last reset (object 603F).
    #[must_use]
    pub const fn error_code(&self) -> ErrorCode {
        self.errors.code
    }

    /// The power state.
    #[must_use]
    pub const fn power_state(&self) -> PowerState {
        self.power.state()
    }

    /// The position, drive units; object 6064 is this modulo 2³².
    #[must_use]
    pub const fn position_units(&self) -> i64 {
        self.scale.units(self.sensed.count)
    }

    /// The levels of the tool's outputs (object 60FE).
    #[must_use]
    pub fn outputs(&self) -> u16 {
        let driven = self.od.get(slots::DIGITAL_OUTPUTS) & self.od.get(slots::DIGITAL_OUTPUT_MASK);
        output::tool(driven)
    }

    /// Levels of the 16 digital inputs for whoever needs them (object 60FD from bit 16 on); the first two are probe
    /// inputs 1 and 2.
    pub const fn set_inputs(&mut self, levels: u16) {
        self.external = levels;
    }

    /// Puts a fault in, or takes all faults out. Faults of receptors are the plant's.
    pub fn set_fault(&mut self, fault: Option<DriveFault>) {
        self.silent = fault == Some(DriveFault::Silent);
        self.injected = match fault {
            Some(DriveFault::Trip(code)) => Some(code),
            Some(
                DriveFault::Silent
                | DriveFault::Encoder(_)
                | DriveFault::SwitchStuck(_)
                | DriveFault::IndexMissing
                | DriveFault::Blank,
            )
            | None => None,
        };
        self.set_blank(fault == Some(DriveFault::Blank));
    }

    /// Takes a frame from the bus; answers go to `out`. Foreign frames cost one table look-up.
    #[inline]
    pub fn on_frame(&mut self, now_ns: u64, frame: &Frame, out: &mut impl FnMut(Frame)) {
        let protocol::frame::Id::Standard(cob) = frame.id() else {
            return;
        };
        let word = self.accept[usize::from(cob >> 6) & 31];
        if word >> (cob & 63) & 1 == 0 || self.silent {
            return;
        }
        self.now_ns = now_ns;
        if frame.is_fd() {
            self.take_group(cob, frame);
            return;
        }
        self.take(cob, frame);
        self.flush(out);
    }

    /// Sends what is due: boot-up, heartbeat, event-driven PDOs, emergencies, late SDO answers.
    #[inline]
    pub fn poll(&mut self, now_ns: u64, out: &mut impl FnMut(Frame)) {
        if now_ns < self.poll_at_ns && self.outbox.is_empty() {
            return;
        }
        self.now_ns = now_ns;
        self.work();
        self.flush(out);
    }

    fn flush(&mut self, out: &mut impl FnMut(Frame)) {
        for frame in self.outbox.drain(..) {
            if !self.silent && self.can != State::BusOff {
                out(frame);
            }
        }
    }

    /// One substep of the inner loop: what the plant is to do, given what it senses.
    #[inline]
    pub fn torque_command(&mut self, now_ns: u64, sensed: &Sensed) -> Drive {
        self.now_ns = now_ns;
        self.sense(sensed);
        if self.stage == Stage::Off {
            self.servo.step(
                self.scale.rad(self.sensed.count),
                servo::Offset::default(),
                0.0,
            );
            return Drive::default();
        }
        self.watch();
        self.operate();
        let release_brake = match self.stage {
            Stage::Opening(_) | Stage::On => true,
            Stage::Off | Stage::Closing(_) => false,
        };
        let measured = self.scale.rad(self.sensed.count);
        let torque_nm = self.servo.step(measured, self.offset, self.greatest_nm());
        Drive {
            torque_nm,
            release_brake,
        }
    }
}

/// Who the drive is, for LSS.
fn identity(od: &Dictionary) -> lss::Identity {
    let part = |sub| od.at(protocol::canopen::objects::index::IDENTITY, sub);
    lss::Identity::from_parts([part(1), part(2), part(3), part(4)])
}

/// The data sheet (EDS, CiA 306) of a drive with these parameters.
#[must_use]
pub fn data_sheet(p: &DriveParameters, file_name: &str, description: &str) -> String {
    let od = Dictionary::new(NodeId::FIRST, p);
    let order_code = format!("serial {}", p.serial);
    let sheet = eds::Sheet {
        file_name,
        description,
        order_code: &order_code,
    };
    let mut text = String::new();
    // a string takes everything
    let _ = eds::write(&mut text, &sheet, &|object: &Object| od.default_of(object));
    text
}

#[cfg(test)]
mod tests;
