//! One drive.

mod who;

use super::script::{AxisSetup, DRIVE_HEARTBEAT_MS, Script};
use super::{AxisActual, BOOT_TIMEOUT};
use crate::config::DriveAddress;
use crate::io::Port;
use protocol::canopen::axis::{self, Actual, Inputs, Target};
use protocol::canopen::cia402::{self, PowerState, Statusword};
use protocol::canopen::emcy::Emergency;
use protocol::canopen::fast::{Feedback, Group};
use protocol::canopen::nmt::{self, Heard, HeartbeatConsumer};
use protocol::canopen::node::{self, Function};
use protocol::canopen::objects::index;
use protocol::canopen::pdo::Value;
use protocol::canopen::sdo::{Address, Client, Outcome, Progress};
use protocol::fault::Cause;
use protocol::frame::Frame;
use protocol::message::DriveFinding;
use protocol::time::Micros;
use who::{Search, question};

/// The drive's heartbeat may be missing for three of its periods.
const HEARTBEAT_WINDOW: Micros = Micros::from_millis(3 * DRIVE_HEARTBEAT_MS as u64);
/// SYNCs in a row without an answer with which the drive counts as silent.
const SILENT_AFTER: u8 = 3;
/// For how long a drive may store its set-up: a few hundred objects, one after the other.
const STORE_TIMEOUT: Micros = Micros::from_millis(3000);
/// An acyclic task for a drive in operation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Task {
    /// Latch the next index pulse.
    ArmIndex,
    /// Change the mode of operation.
    SetMode(i8),
}

#[derive(Clone, Debug)]
enum Phase {
    /// Reset was sent; waiting for the boot-up message.
    Booting { reset_at: Option<Micros> },
    /// Reading what must be known.
    Identifying { step: u8 },
    /// Writing the script.
    Configuring { script: Script },
    /// In operation.
    Ready,
    /// Given up.
    Failed(Cause),
}

/// What the SDO channel is busy with in operation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Acyclic {
    Idle,
    DisarmIndex,
    ArmIndex,
    AwaitIndex,
    ReadIndex,
    SetMode(i8),
    SetOutputs(u16),
}

/// The node's view of one drive.
#[derive(Debug)]
pub struct DriveLink {
    address: DriveAddress,
    setup: AxisSetup,
    phase: Phase,
    sdo: Client<8>,
    outgoing: Option<[u8; 8]>,
    acyclic: Acyclic,
    task: Option<Task>,
    heartbeat: HeartbeatConsumer,
    heartbeat_lost: bool,
    emergency: Option<Emergency>,
    actual: AxisActual,
    missed: u8,
    inputs: u32,
    probe: u16,
    index: Option<i32>,
    rated_torque_mnm: u32,
    mode: i8,
    /// Levels of the digital outputs: wanted, and confirmed by the drive.
    outputs: [u16; 2],
    /// In the fast profile: what the next group carries.
    grouped: Option<(u16, Target, Option<i16>)>,
    search: Search,
    /// As far as is known, it has stored the set-up that it would be given.
    unchanged: bool,
}

impl DriveLink {
    /// Nothing known yet.
    #[must_use]
    pub fn new(now: Micros, address: DriveAddress, setup: AxisSetup) -> Self {
        Self {
            address,
            setup,
            phase: Phase::Booting { reset_at: None },
            sdo: Client::default(),
            outgoing: None,
            acyclic: Acyclic::Idle,
            task: None,
            heartbeat: HeartbeatConsumer::new(now, address.id, HEARTBEAT_WINDOW),
            heartbeat_lost: false,
            emergency: None,
            actual: AxisActual::default(),
            missed: 0,
            inputs: 0,
            probe: 0,
            index: None,
            rated_torque_mnm: 0,
            mode: setup.mode,
            outputs: [0; 2],
            grouped: None,
            search: Search::default(),
            unchanged: setup.stored,
        }
    }

    /// Where it is.
    #[must_use]
    pub const fn address(&self) -> DriveAddress {
        self.address
    }

    /// Configured and in operation.
    #[must_use]
    pub const fn is_ready(&self) -> bool {
        matches!(self.phase, Phase::Ready)
    }

    /// The latest process data.
    #[must_use]
    pub const fn actual(&self) -> AxisActual {
        self.actual
    }

    /// Its statusword.
    #[must_use]
    pub const fn statusword(&self) -> Statusword {
        Statusword(self.actual.statusword)
    }

    /// Its power state.
    #[must_use]
    pub const fn state(&self) -> Option<PowerState> {
        Statusword(self.actual.statusword).state()
    }

    /// The home switch.
    #[must_use]
    pub const fn home_switch(&self) -> bool {
        self.inputs & cia402::input::HOME != 0
    }

    /// The position latched at the index since it was armed, drive units.
    #[must_use]
    pub const fn index(&self) -> Option<i32> {
        self.index
    }

    /// Rated torque, mN·m.
    #[must_use]
    pub const fn rated_torque_mnm(&self) -> u32 {
        self.rated_torque_mnm
    }

    /// The mode of operation it has confirmed.
    #[must_use]
    pub const fn mode(&self) -> i8 {
        self.mode
    }

    /// The last emergency message, if one is active.
    #[must_use]
    pub const fn emergency(&self) -> Option<Emergency> {
        self.emergency
    }

    /// Is an acyclic task waiting or under way?
    #[must_use]
    pub fn busy(&self) -> bool {
        self.task.is_some() || !matches!(self.acyclic, Acyclic::Idle | Acyclic::AwaitIndex)
    }

    /// Ask for an acyclic task; a later one replaces one that has not begun.
    pub fn request(&mut self, task: Task) {
        if task == Task::ArmIndex {
            self.index = None;
        }
        self.task = Some(task);
    }

    /// Drive the digital outputs to these levels, as soon as the SDO channel is free.
    pub const fn set_outputs(&mut self, levels: u16) {
        let [wanted, _] = &mut self.outputs;
        *wanted = levels;
    }

    /// Did it restart by itself? Its position count is then worth nothing.
    #[must_use]
    pub const fn has_restarted(&self) -> bool {
        matches!(self.phase, Phase::Failed(Cause::DriveDisabled))
    }

    /// Reset and configure it again.
    pub fn restart(&mut self, now: Micros) {
        *self = Self::new(
            now,
            self.address,
            AxisSetup {
                mode: self.mode,
                // what was stored is in force after a reset of the whole device only, which would forget where it stands
                stored: false,
                ..self.setup
            },
        );
    }

    /// Does it give torque?
    pub(super) fn has_torque(&self) -> bool {
        self.is_ready() && self.state() == Some(PowerState::OperationEnabled)
    }

    /// SYNCs in a row without an answer, the last one too.
    const fn unanswered(&self) -> u8 {
        self.missed.saturating_add(!self.actual.fresh as u8)
    }

    /// What is wrong, if anything is; to be asked when the answers to the last SYNC should have come.
    #[must_use]
    pub fn fault(&self) -> Option<Cause> {
        match self.phase {
            Phase::Failed(cause) => Some(cause),
            Phase::Ready => {
                if self.emergency.is_some() || self.state() == Some(PowerState::Fault) {
                    Some(Cause::DriveFault)
                } else if self.heartbeat_lost {
                    Some(Cause::DriveHeartbeat)
                } else if self.unanswered() >= SILENT_AFTER {
                    Some(Cause::DriveSilent)
                } else {
                    None
                }
            }
            Phase::Booting { .. } | Phase::Identifying { .. } | Phase::Configuring { .. } => None,
        }
    }

    /// SYNC is going out.
    pub(super) fn on_sync(&mut self) {
        if self.actual.fresh {
            self.missed = 0;
        } else if self.is_ready() {
            self.missed = self.missed.saturating_add(1);
        }
        self.actual.fresh = false;
    }

    /// A frame of this drive; `function` is its COB-ID without the node id.
    pub(super) fn on_frame(&mut self, now: Micros, function: u16, frame: &Frame) {
        // of the fast profile only the actual values are FD
        let fast = self.setup.slot.is_some() && function == Function::Tpdo1 as u16;
        if frame.is_fd() != fast {
            return;
        }
        let data = frame.data();
        if function == Function::Tpdo1 as u16 {
            if let Some(Actual {
                statusword,
                position,
                torque,
            }) = self.decode(data)
            {
                self.actual = AxisActual {
                    position,
                    torque,
                    statusword,
                    fresh: true,
                };
            }
        } else if function == Function::Tpdo2 as u16 {
            if let Some(Inputs {
                inputs,
                touch_probe,
            }) = Inputs::decode(data)
            {
                self.inputs = inputs;
                self.probe = touch_probe;
            }
        } else if function == Function::SdoAnswer as u16 {
            let progress = self.sdo.on_answer(now, data);
            self.sdo_progress(progress);
        } else if function == Function::Emergency as u16 {
            if let Some((_, emergency)) = Emergency::decode(frame) {
                self.emergency = (emergency.code.0 != 0).then_some(emergency);
            }
        } else {
            match self.heartbeat.on_frame(now, frame) {
                Some(Heard::BootUp) => self.booted(),
                Some(Heard::Appeared(_)) => self.heartbeat_lost = false,
                _ => {}
            }
        }
    }

    /// Its actual values, in the profile it speaks.
    fn decode(&self, data: &[u8]) -> Option<Actual> {
        if self.setup.slot.is_none() {
            return Actual::decode(data);
        }
        Feedback::decode(data).map(|feedback| Actual {
            statusword: feedback.statusword,
            position: feedback.position,
            torque: feedback.torque,
        })
    }

    /// The drive (re)started: expected after a reset, a fault in operation.
    fn booted(&mut self) {
        match self.phase {
            Phase::Booting { reset_at: Some(_) } => {
                // what it told before is of the time before the reset; some tell it while they boot
                self.emergency = None;
                self.phase = Phase::Identifying { step: 0 };
            }
            Phase::Ready => self.phase = Phase::Failed(Cause::DriveDisabled),
            Phase::Booting { reset_at: None }
            | Phase::Identifying { .. }
            | Phase::Configuring { .. }
            | Phase::Failed(_) => {}
        }
    }

    fn sdo_progress(&mut self, progress: Progress) {
        match progress {
            Progress::Ignored => {}
            Progress::Send(data) => self.outgoing = Some(data),
            Progress::Done(outcome) => self.sdo_done(outcome),
            Progress::End(data, outcome) => {
                self.outgoing = Some(data);
                self.sdo_done(outcome);
            }
        }
    }

    fn sdo_done(&mut self, outcome: Outcome) {
        let ok = matches!(outcome, Outcome::Downloaded(_) | Outcome::Uploaded(_));
        match &mut self.phase {
            Phase::Identifying { step } => {
                let step = *step;
                self.identified(step, ok);
            }
            Phase::Configuring { script } if !ok && script.is_complete() => {
                *script = Script::End;
                self.search.news = Some(DriveFinding::SetupNotStored);
            }
            Phase::Configuring { .. } if !ok => {
                self.phase = Phase::Failed(Cause::DriveConfiguration);
            }
            Phase::Ready => self.acyclic_done(ok),
            Phase::Configuring { .. } | Phase::Booting { .. } | Phase::Failed(_) => {}
        }
    }

    fn acyclic_done(&mut self, ok: bool) {
        if !ok {
            self.phase = Phase::Failed(Cause::DriveConfiguration);
            return;
        }
        self.acyclic = match self.acyclic {
            Acyclic::DisarmIndex => Acyclic::ArmIndex,
            Acyclic::ArmIndex => Acyclic::AwaitIndex,
            Acyclic::ReadIndex => {
                let [a, b, c, d] = self.sdo.number().unwrap_or(0).to_le_bytes();
                self.index = Some(i32::from_le_bytes([a, b, c, d]));
                Acyclic::Idle
            }
            Acyclic::SetMode(mode) => {
                self.mode = mode;
                Acyclic::Idle
            }
            Acyclic::SetOutputs(levels) => {
                let [_, confirmed] = &mut self.outputs;
                *confirmed = levels;
                Acyclic::Idle
            }
            Acyclic::Idle | Acyclic::AwaitIndex => Acyclic::Idle,
        };
    }

    /// What is due: requests, time-outs.
    pub(super) fn poll(&mut self, now: Micros, tx: &mut impl FnMut(Port, Frame)) {
        let port = Port::Drives(self.address.bus);
        if let Some(Heard::Lost | Heard::NeverHeard) = self.heartbeat.poll(now)
            && self.is_ready()
        {
            self.heartbeat_lost = true;
        }
        if let Some(progress) = self.sdo.poll(now) {
            self.sdo_progress(progress);
        }
        if self.outgoing.is_none() && self.sdo.is_idle() {
            self.outgoing = self.next_request(now, port, tx);
        }
        if let Some(data) = self.outgoing.take() {
            tx(
                port,
                node::frame(self.address.id.cob(Function::SdoRequest), data),
            );
        }
    }

    fn next_request(
        &mut self,
        now: Micros,
        port: Port,
        tx: &mut impl FnMut(Port, Frame),
    ) -> Option<[u8; 8]> {
        let id = self.address.id;
        let target = nmt::Target::Node(id);
        match &mut self.phase {
            Phase::Booting {
                reset_at: Some(since),
            } => {
                // one that layer setting looks for is given up by it
                let looked_for = self.setup.find || self.setup.identity.is_some();
                if now.since(*since) > BOOT_TIMEOUT && !looked_for {
                    self.phase = Phase::Failed(Cause::DriveHeartbeat);
                }
                None
            }
            Phase::Booting { reset_at } => {
                *reset_at = Some(now);
                let command = if self.setup.stored {
                    nmt::Command::ResetNode
                } else {
                    nmt::Command::ResetCommunication
                };
                tx(port, nmt::command_frame(command, target));
                None
            }
            Phase::Identifying { step } => {
                let at = question(&self.setup, *step)?;
                self.sdo.upload(now, at).ok()
            }
            Phase::Configuring { script } => {
                if let Some(write) = script.next(id, &self.setup) {
                    if write.at.index == index::STORE {
                        self.sdo = Client::new(STORE_TIMEOUT);
                    }
                    self.sdo.download(now, write.at, write.value.data()).ok()
                } else {
                    tx(port, nmt::command_frame(nmt::Command::Start, target));
                    self.phase = Phase::Ready;
                    self.sdo = Client::default();
                    self.heartbeat = HeartbeatConsumer::new(now, id, HEARTBEAT_WINDOW);
                    None
                }
            }
            Phase::Ready => self.next_acyclic(now),
            Phase::Failed(_) => None,
        }
    }

    fn next_acyclic(&mut self, now: Micros) -> Option<[u8; 8]> {
        if let Acyclic::Idle | Acyclic::AwaitIndex = self.acyclic
            && let Some(task) = self.task.take()
        {
            self.acyclic = match task {
                Task::ArmIndex => Acyclic::DisarmIndex,
                Task::SetMode(mode) => Acyclic::SetMode(mode),
            };
        }
        let [wanted, confirmed] = self.outputs;
        if self.acyclic == Acyclic::Idle && wanted != confirmed {
            self.acyclic = Acyclic::SetOutputs(wanted);
        }
        if self.acyclic == Acyclic::AwaitIndex && self.probe & cia402::probe::POSITIVE_STORED != 0 {
            self.acyclic = Acyclic::ReadIndex;
        }
        let write = |sdo: &mut Client<8>, object, value: Value| {
            sdo.download(now, Address::new(object, 0), value.data())
                .ok()
        };
        match self.acyclic {
            Acyclic::Idle | Acyclic::AwaitIndex => None,
            Acyclic::DisarmIndex => {
                self.probe = 0;
                write(&mut self.sdo, index::TOUCH_PROBE, Value::half(0))
            }
            Acyclic::ArmIndex => {
                self.probe = 0;
                write(
                    &mut self.sdo,
                    index::TOUCH_PROBE,
                    Value::half(cia402::probe::INDEX_ONCE),
                )
            }
            Acyclic::ReadIndex => self
                .sdo
                .upload(now, Address::new(index::TOUCH_PROBE_POSITIVE, 0))
                .ok(),
            Acyclic::SetMode(mode) => {
                let [mode] = mode.to_le_bytes();
                write(&mut self.sdo, index::MODE, Value::byte(mode))
            }
            Acyclic::SetOutputs(levels) => {
                let value = Value::word(cia402::output::levels(levels));
                let at = Address::new(index::DIGITAL_OUTPUTS, 1);
                self.sdo.download(now, at, value.data()).ok()
            }
        }
    }

    /// Send the process data of one servo step.
    pub(crate) fn command(
        &mut self,
        controlword: u16,
        target: Target,
        offset: Option<i16>,
        tx: &mut impl FnMut(Port, Frame),
    ) {
        if !self.is_ready() {
            return;
        }
        if self.setup.slot.is_some() {
            self.grouped = Some((controlword, target, offset));
        } else {
            let frame = axis::command(self.address.id, controlword, target, offset);
            tx(Port::Drives(self.address.bus), frame);
        }
    }

    /// Joins a group of its bus, or begins one; others wait for a group of their own.
    pub(super) fn join(&mut self, bus: u8, group: &mut Option<Group>) {
        let (Some((controlword, target, offset)), Some(slot)) = (self.grouped, self.setup.slot)
        else {
            return;
        };
        if self.address.bus != bus {
            return;
        }
        let group = group.get_or_insert(Group::new(controlword, target, offset));
        if group.controlword() == controlword && group.put(slot, target, offset) {
            self.grouped = None;
        }
    }
}
