//! Frames in and out: NMT, SYNC, SDO, PDO, heartbeats.

use protocol::canopen::cia402::Event;
use protocol::canopen::emcy::ErrorCode;
use protocol::canopen::lss;
use protocol::canopen::nmt::{
    self, ErrorBehaviour, Heard, HeartbeatConsumer, HeartbeatProducer, State,
};
use protocol::canopen::node::{Function, NodeId, frame};
use protocol::canopen::objects::{self, index};
use protocol::canopen::pdo::{
    Communication, Entry, Mapping, Payload, Received, Rpdo, Tpdo, Transmission,
};
use protocol::canopen::sdo::Address;
use protocol::canopen::sync::{self, Consumed, Sync};
use protocol::frame::Frame;
use protocol::time::Micros;

use super::parameters::MS;
use super::quirk::Quirk;
use super::{SimDrive, slots};

/// Nanoseconds as bus time.
pub(super) const fn micros(ns: u64) -> Micros {
    Micros(ns / 1000)
}

impl SimDrive {
    /// A frame this drive listens to.
    pub(super) fn take(&mut self, cob: u16, frame: &Frame) {
        if cob == self.sync_cob {
            let overflow = u8::try_from(self.od.get(slots::SYNC_OVERFLOW)).unwrap_or(0);
            match sync::consume(cob, overflow, frame) {
                Some(Consumed::Sync(sync)) if self.nmt == State::Operational => self.on_sync(sync),
                Some(Consumed::Length) => self.report(ErrorCode::SYNC_LENGTH),
                Some(Consumed::Sync(_)) | None => {}
            }
            return;
        }
        if cob == nmt::COB {
            if let Some((command, target)) = nmt::decode_command(frame)
                && target.includes(self.node)
            {
                self.on_nmt(command);
            }
            return;
        }
        if cob == lss::MASTER_COB {
            self.on_lss(frame.data());
            return;
        }
        if cob == self.node.cob(Function::SdoRequest) {
            self.on_sdo(frame.data());
            return;
        }
        if let Some(consumer) = &mut self.consumer
            && let Some(heard) = consumer.on_frame(micros(self.now_ns), frame)
        {
            // A master that restarts has forgotten us: as good as lost.
            if heard == Heard::BootUp {
                self.connection_lost(ErrorCode::HEARTBEAT);
            }
            return;
        }
        if self.nmt == State::Operational {
            self.on_rpdo(cob, frame.data());
        }
    }

    fn on_nmt(&mut self, command: nmt::Command) {
        let before = self.nmt;
        self.nmt = before.on(command);
        match self.nmt {
            State::Initialising => {
                match command {
                    nmt::Command::ResetNode => self.lss.restart(),
                    nmt::Command::ResetCommunication
                    | nmt::Command::Start
                    | nmt::Command::Stop
                    | nmt::Command::EnterPreOperational => self.lss.reset(),
                }
                self.restart();
            }
            State::Stopped | State::PreOperational if before == State::Operational => {
                self.connection_lost(ErrorCode::NONE);
                self.rest_pdos();
            }
            State::Operational if before != State::Operational => self.rest_pdos(),
            State::Stopped | State::PreOperational | State::Operational => {}
        }
    }

    fn rest_pdos(&mut self) {
        self.fast.forget();
        self.rpdo.iter_mut().for_each(Rpdo::reset);
        self.tpdo.iter_mut().for_each(Tpdo::reset);
        self.last_sync_ns = None;
        self.missed = 0;
        self.poll_at_ns = 0;
    }

    fn on_sdo(&mut self, data: &[u8]) {
        match self.nmt {
            State::PreOperational | State::Operational => {}
            State::Initialising | State::Stopped => return,
        }
        self.publish();
        let answer = self
            .server
            .on_request(micros(self.now_ns), data, &mut self.od);
        if let Some(at) = self.od.take_written() {
            self.on_written(at);
        }
        if let Some(answer) = answer {
            if self.answer_ns() == 0 {
                self.send(self.node.cob(Function::SdoAnswer), answer);
            } else {
                self.answer = Some((self.now_ns + self.answer_ns(), answer));
            }
        }
    }

    pub(super) fn send(&mut self, cob: u16, bytes: [u8; 8]) {
        self.outbox.push(frame(cob, bytes));
    }

    fn on_written(&mut self, at: Address) {
        match at.index {
            index::ERROR_HISTORY => {
                self.history.clear();
                self.publish_history();
            }
            0x1000..=0x1FFF | index::FAST_SLOT => self.configure(),
            index::CONTROLWORD => self.on_controlword(),
            index::TOUCH_PROBE => self.on_probe_function(),
            _ => {
                self.configure_motion();
            }
        }
    }

    fn on_rpdo(&mut self, cob: u16, data: &[u8]) {
        // object 1007: a synchronous PDO that comes too late after SYNC does not count
        let window_ns = u64::from(self.od.get(slots::SYNC_WINDOW)) * 1000;
        let late = window_ns > 0
            && self
                .last_sync_ns
                .is_some_and(|sync| self.now_ns - sync > window_ns);
        for number in 0..self.rpdo.len() {
            let communication = self.rpdo[number].communication();
            if communication.cob != cob || late && communication.transmission.is_synchronous() {
                continue;
            }
            match self.rpdo[number].on_data(micros(self.now_ns), data) {
                Received::Latched | Received::Disabled => {}
                Received::Now(payload) => self.accept_pdo(number, payload),
                Received::WrongLength => self.report(ErrorCode::PDO_LENGTH),
            }
        }
    }

    /// Puts a PDO's values into the dictionary.
    fn accept_pdo(&mut self, number: usize, payload: Payload) {
        let od = &mut self.od;
        // The length was checked on arrival.
        let _ = self.rpdo[number]
            .mapping()
            .unpack(payload.data(), |entry, value| {
                if let Some(place) = objects::find(entry.address()) {
                    od.write_mapped(place, value);
                }
            });
        if self.rpdo[number]
            .communication()
            .transmission
            .is_synchronous()
        {
            return;
        }
        self.on_controlword();
    }

    /// Latches the targets, samples the actual values, sends the synchronous PDOs.
    fn on_sync(&mut self, sync: Sync) {
        self.last_sync_ns = Some(self.now_ns);
        let mut fresh = self.latch_group();
        for number in 0..self.rpdo.len() {
            if let Some(payload) = self.rpdo[number].on_sync() {
                self.accept_pdo(number, payload);
                fresh = true;
            }
        }
        self.publish();
        if fresh {
            self.missed = 0;
            self.on_probe_function();
            self.on_controlword();
        } else {
            self.missed = self.missed.saturating_add(1);
        }
        self.follow(fresh);
        self.whims.flicker = !self.whims.flicker;
        self.od
            .set(slots::STATUSWORD, u32::from(self.statusword().0));
        let short = self.p.quirks.has(Quirk::ShortPdo);
        let instead_of_tpdo1 = self.send_feedback();
        for number in usize::from(instead_of_tpdo1)..self.tpdo.len() {
            let tpdo = &mut self.tpdo[number];
            if !tpdo.communication().enabled || tpdo.is_event_driven() {
                continue;
            }
            let payload = pack(&self.od, tpdo.mapping());
            if tpdo.on_sync(micros(self.now_ns), sync, payload) {
                let cob = tpdo.communication().cob;
                let payload = if short { payload.shortened() } else { payload };
                self.outbox.push(payload.frame(cob));
            }
        }
    }

    /// What is due without a frame from outside.
    pub(super) fn work(&mut self) {
        let now = micros(self.now_ns);
        // On whole milliseconds, so that times do not depend on when the first poll came.
        self.poll_at_ns = (self.now_ns / MS + 1) * MS;
        self.answer_late();
        if self.nmt == State::Initialising {
            if self.now_ns < self.boot_at_ns {
                return;
            }
            self.nmt = State::PreOperational;
            self.before_boot_up();
            self.outbox
                .push(nmt::heartbeat_frame(self.node, State::Initialising));
            self.transition(Event::Booted);
            self.configure();
        }
        if self.producer.due(now) {
            self.outbox.push(nmt::heartbeat_frame(self.node, self.nmt));
        }
        if let Some(Heard::Lost | Heard::NeverHeard) = self
            .consumer
            .as_mut()
            .and_then(|consumer| consumer.poll(now))
        {
            self.communication_failed(ErrorCode::HEARTBEAT);
        }
        self.send_emergencies();
        // A segment of a block in a millisecond: its process data are more urgent to a drive.
        if let Some(segment) = self.server.next_segment() {
            self.send(self.node.cob(Function::SdoAnswer), segment);
        }
        if let Some(abort) = self.server.poll(now) {
            self.send(self.node.cob(Function::SdoAnswer), abort);
        }
        if let Some((due, answer)) = self.answer
            && self.now_ns >= due
        {
            self.answer = None;
            self.send(self.node.cob(Function::SdoAnswer), answer);
        }
        if self.nmt == State::Operational {
            self.send_events(now);
        }
    }

    /// A communication error of CiA 301: the axis stops by 6007, the NMT state follows 1029.
    pub(super) fn communication_failed(&mut self, code: ErrorCode) {
        self.connection_lost(code);
        let behaviour = u8::try_from(self.od.get(slots::ERROR_BEHAVIOUR)).ok();
        let behaviour = behaviour.and_then(ErrorBehaviour::from_code);
        self.nmt = behaviour.unwrap_or_default().after(self.nmt);
    }

    fn send_events(&mut self, now: Micros) {
        if self.rpdo.iter_mut().any(|rpdo| rpdo.timed_out(now)) {
            self.communication_failed(ErrorCode::RPDO_TIMEOUT);
        }
        if !self.tpdo.iter().any(Tpdo::is_event_driven) {
            return;
        }
        self.publish();
        for tpdo in &mut self.tpdo {
            if !tpdo.is_event_driven() {
                continue;
            }
            let payload = pack(&self.od, tpdo.mapping());
            if tpdo.poll(now, payload) {
                self.outbox.push(payload.frame(tpdo.communication().cob));
            }
        }
    }

    /// Reads the communication objects again.
    pub(super) fn configure(&mut self) {
        let now = micros(self.now_ns);
        for (number, i) in (0..).zip(0..4_u16) {
            let receive = (index::RPDO_COMMUNICATION + i, index::RPDO_MAPPING + i);
            let (communication, mapping) = self.pdo(receive);
            let rpdo = &self.rpdo[number];
            if rpdo.communication() != communication || *rpdo.mapping() != mapping {
                self.rpdo[number] = Rpdo::new(communication, mapping);
            }
            let transmit = (index::TPDO_COMMUNICATION + i, index::TPDO_MAPPING + i);
            let (communication, mapping) = self.pdo(transmit);
            let tpdo = &self.tpdo[number];
            if tpdo.communication() != communication || *tpdo.mapping() != mapping {
                self.tpdo[number] = Tpdo::new(communication, mapping);
            }
        }
        let period = Micros::from_millis(u64::from(self.od.get(slots::PRODUCER_HEARTBEAT)));
        self.producer = HeartbeatProducer::new(now, period);
        let [low, high, node, _] = self.od.get(slots::CONSUMER_HEARTBEAT).to_le_bytes();
        let window = Micros::from_millis(u64::from(u16::from_le_bytes([low, high])));
        let watched = NodeId::new(node).filter(|_| window != Micros(0));
        if self.consumer.map(|consumer| consumer.node()) != watched {
            self.consumer = watched.map(|node| HeartbeatConsumer::new(now, node, window));
        }
        let [low, high, ..] = self.od.get(slots::SYNC_COB).to_le_bytes();
        self.sync_cob = u16::from_le_bytes([low, high]) & 0x7FF;
        self.emergencies
            .set_inhibit(u16::try_from(self.od.get(slots::EMERGENCY_INHIBIT)).unwrap_or(0));
        self.configure_fast();
        self.configure_motion();
        self.listen();
        self.poll_at_ns = 0;
    }

    fn pdo(&self, (communication, mapping): (u16, u16)) -> (Communication, Mapping) {
        let half = |sub| u16::try_from(self.od.at(communication, sub)).unwrap_or(0);
        let cob = self.od.at(communication, 1);
        let [low, high, ..] = cob.to_le_bytes();
        let transmission = u8::try_from(self.od.at(communication, 2)).ok();
        let parameters = Communication {
            cob: u16::from_le_bytes([low, high]) & 0x7FF,
            enabled: cob >> 31 == 0,
            transmission: transmission
                .and_then(Transmission::from_code)
                .unwrap_or(Transmission::SyncAcyclic),
            inhibit_100us: half(3),
            event_ms: half(5),
            sync_start: u8::try_from(self.od.at(communication, 6)).unwrap_or(0),
        };
        let count = self.od.at(mapping, 0);
        let entries: Vec<Entry> = (1..=8)
            .zip(0..count)
            .map(|(sub, _)| Entry(self.od.at(mapping, sub)))
            .collect();
        (parameters, Mapping::new(&entries).unwrap_or_default())
    }

    /// Which identifiers concern this drive.
    fn listen(&mut self) {
        self.accept = [0; 32];
        let rpdos = self.rpdo.each_ref().map(Rpdo::communication);
        let rpdos = rpdos
            .into_iter()
            .filter(|rpdo| rpdo.enabled)
            .map(|rpdo| rpdo.cob);
        let watched = self
            .consumer
            .map(|consumer| consumer.node().cob(Function::Heartbeat));
        let own = [nmt::COB, self.sync_cob, self.node.cob(Function::SdoRequest)];
        let configured = own
            .into_iter()
            .chain(rpdos)
            .chain(watched)
            .chain(self.fast.cobs(self.sync_cob));
        let alone = self.lss.active().is_none();
        for cob in configured
            .filter(|_| !alone)
            .chain([lss::MASTER_COB, nmt::COB])
        {
            self.accept[usize::from(cob >> 6) & 31] |= 1 << (cob & 63);
        }
    }
}

/// The payload of a mapping, from the dictionary's present values.
fn pack(od: &super::dictionary::Dictionary, mapping: &Mapping) -> Payload {
    mapping.pack(|entry| objects::find(entry.address()).map_or(0, |place| u64::from(od.get(place))))
}
