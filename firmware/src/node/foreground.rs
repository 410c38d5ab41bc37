//! What of a node has the servo period as its deadline: link, lease, EDP, and the orders to the ECP.

use super::NodeSetup;
use super::work::Work;
use crate::capacity::{EVENTS, LINK_SESSIONS};
use crate::config::NodeConfig;
use crate::ecp::agenda::Agenda;
use crate::ecp::condition::ForceAbove;
use crate::ecp::{Ecp, Programs, Sensors};
use crate::edp::Edp;
use crate::edp::mode::{Event as ModeEvent, Mode, Rest};
use crate::io::{Port, Received};
use crate::maintenance::Asked;
use crate::session::Session;
use crate::vsp::{EffortSensor, Wrist};
use agent::Vsp;
use protocol::clock::{Clock, Quality};
use protocol::cyphal::NodeInfo;
use protocol::fault::{Cause, Reaction, Refusal};
use protocol::frame::Frame;
use protocol::id::NodeId;
use protocol::link::{Endpoint, Incoming, Message, Role};
use protocol::message::{
    Command, Event, Identity, Instruction, NodeState, Reply, Request, StopKind, TimeSync,
};
use protocol::schema::{PROTOCOL, SCHEMA_HASH};
use protocol::time::Micros;
use protocol::transfer::TransferId;
use robots::Robot;

/// With torque on, at rest and nobody in command, torque goes off after this time.
const HOLD_TIMEOUT: Micros = Micros::from_millis(30_000);
/// A start time may lie this far ahead at most.
const START_HORIZON: Micros = Micros::from_millis(10_000);

/// The part of a node that is done in every servo period, whatever its ECP is busy with.
#[derive(Debug)]
pub struct Foreground<R, const N: usize> {
    config: NodeConfig<N>,
    robot: R,
    pub(super) link: Endpoint<LINK_SESSIONS>,
    pub(super) clock: Clock,
    pub(super) session: Session,
    pub(super) agenda: Agenda,
    pub(super) work: Work,
    pub(super) edp: Edp<R, N>,
    effort: Vsp<EffortSensor<N>>,
    pub(super) sensors: Sensors<N>,
    pub(super) wrist: Wrist,
    /// The force at which the running motion is to end.
    guard: Option<ForceAbove>,
    period: Micros,
    next_sync: Micros,
    next_servo: Option<Micros>,
    pub(super) sampled_at: Micros,
    pub(super) ending: bool,
    alone_since: Option<Micros>,
    /// Levels of the outputs at the tool.
    outputs: u16,
    pub(super) trace_every: u16,
    pub(super) announced: bool,
    pub(super) events: heapless::Deque<Event, EVENTS>,
    /// The maintenance request that waits for the keeper.
    pub(super) asked: Option<Asked>,
}

impl<R: Robot<N> + Copy, const N: usize> Foreground<R, N> {
    /// The foreground of a node, at `now`.
    pub(super) fn new(now: Micros, setup: NodeSetup<R, N>) -> Self {
        let NodeSetup {
            robot,
            config,
            edp: setup,
        } = setup;
        let macrostep = robot.description().macrostep;
        let period = Micros(u64::from(robot.description().servo_step_us));
        let effort = Vsp::new(
            EffortSensor::new(setup.constants.overcurrent_ma, macrostep),
            (),
        );
        let seed = (config.unique_id ^ config.unique_id >> 32) & 0xFFFF_FFFF;
        Self {
            link: Endpoint::new(config.node, Role::Node, config.mtu),
            clock: Clock::default(),
            session: Session::new(u32::try_from(seed).unwrap_or(0)),
            agenda: Agenda::new(),
            work: Work::new(macrostep),
            edp: Edp::new(now, robot, setup),
            effort,
            sensors: Sensors::NONE,
            wrist: Wrist::new(config.force),
            guard: None,
            period,
            next_sync: now,
            next_servo: None,
            sampled_at: now,
            ending: false,
            alone_since: None,
            outputs: 0,
            trace_every: 0,
            announced: false,
            events: heapless::Deque::new(),
            asked: None,
            config,
            robot,
        }
    }

    /// The state as seen from outside.
    pub fn state(&self) -> NodeState {
        self.edp.mode().into()
    }

    /// The EDP, to look at.
    pub const fn edp(&self) -> &Edp<R, N> {
        &self.edp
    }

    /// Who it is.
    pub fn identity(&self) -> Identity {
        let description = self.robot.description();
        let mut robot = heapless::String::new();
        // names are shorter than MAX_NAME: tested in `robots`
        let _ = robot.push_str(description.name);
        Identity {
            robot,
            unique_id: self.config.unique_id,
            protocol: PROTOCOL,
            schema_hash: SCHEMA_HASH,
            config_crc: self.config.crc(description.name),
            firmware: FIRMWARE_VERSION,
            axes: u8::try_from(N).unwrap_or(u8::MAX),
            servo_step_us: description.servo_step_us,
            macrostep: u16::try_from(description.macrostep).unwrap_or(u16::MAX),
        }
    }

    /// When [`Self::step`] must be called next, local time.
    pub fn next_wake(&self) -> Micros {
        match self.next_servo {
            Some(at) if at < self.next_sync => at,
            _ => self.next_sync,
        }
    }

    /// Take what has arrived and do what is due. Bounded work; no clock, no bus. `ecp` is the node's other half,
    /// unless it is still at work.
    pub fn step<P: Programs<N>, const W: usize>(
        &mut self,
        now: Micros,
        rx: &[Received],
        mut ecp: Option<&mut Ecp<R, N, P, W>>,
        tx: &mut impl FnMut(Port, Frame),
    ) {
        for received in rx {
            match received.port {
                Port::Mp => self.listen(now, received, ecp.as_deref_mut(), tx),
                Port::Drives(bus) => {
                    self.wrist.on_frame(received.at, bus, &received.frame);
                    self.edp.on_frame(received.at, bus, &received.frame);
                }
            }
        }
        if now >= self.next_sync {
            self.edp.sync(tx);
            self.sampled_at = now;
            let half = Micros(self.period.0 / 2);
            self.next_servo = Some(self.next_sync + half);
            self.next_sync = self.next_sync + self.period;
            if self.next_sync <= now {
                // overrun: take up the beat again instead of catching up in a burst
                self.next_sync = now + self.period;
                self.next_servo = Some(now + half);
            }
        }
        if self.next_servo.is_some_and(|at| now >= at) {
            self.next_servo = None;
            self.servo(now, ecp, tx);
        }
    }

    // a frame of its own: what else its caller does must not lie below it on the stack
    #[inline(never)]
    fn servo<P: Programs<N>, const W: usize>(
        &mut self,
        now: Micros,
        ecp: Option<&mut Ecp<R, N, P, W>>,
        tx: &mut impl FnMut(Port, Frame),
    ) {
        self.watch_lease(now);
        let currents_ma = self.edp.currents_ma();
        if let Some(reading) = self.effort.step(&(), &currents_ma) {
            self.sensors = reading;
        }
        self.sensors.force_n = self.wrist.change_n(now);
        self.end_at_force(now);
        self.coordinate(now, ecp);
        self.watch_force(now);
        self.edp.servo(now, &currents_ma, tx);
        self.after_fault();
        self.drive_outputs();
        self.report(now, tx);
    }

    /// The outputs are off without torque, with a latched fault, and at rest without a master.
    fn drive_outputs(&mut self) {
        let on = match self.edp.mode() {
            Mode::Resting(_) => self.session.epoch() != 0,
            Mode::Moving { .. } | Mode::Stopping { .. } | Mode::Synchronising => true,
            _ => false,
        };
        if !on {
            self.outputs = 0;
        }
        self.edp.drive_outputs(self.outputs);
    }

    /// A motion that is to end at a force ends in this servo step: every axis stops, and what is left of path and plan is
    /// of no use any more.
    fn end_at_force(&mut self, now: Micros) {
        let felt = self.guard.is_some_and(|at| at.exceeded(&self.sensors));
        if felt && self.agenda.due(self.clock.to_bus(now)) {
            self.agenda.end();
            self.ending = true;
            self.edp.stop_here();
        }
    }

    /// A robot that has a force sensor does not move without it.
    fn watch_force(&mut self, now: Micros) {
        if matches!(self.edp.mode(), Mode::Moving { .. }) && self.wrist.is_blind(now) {
            let reaction = if self.guard.is_some() {
                Reaction::QuickStop
            } else {
                Cause::ForceSensor.reaction()
            };
            self.edp.raise_with(now, Cause::ForceSensor, None, reaction);
        }
    }

    /// A stop or fault ends the running instruction.
    fn after_fault(&mut self) {
        let running = matches!(self.edp.mode(), Mode::Resting(_) | Mode::Moving { .. });
        if !running && self.agenda.busy() {
            self.agenda.abort();
            self.ending = false;
        }
    }

    fn watch_lease(&mut self, now: Micros) {
        if self.session.expired(now) {
            self.link.set_lease(0);
            self.trace_every = 0;
            match self.edp.mode() {
                Mode::Moving { .. } | Mode::Synchronising => {
                    self.edp.raise(now, Cause::LeaseExpired, None);
                }
                _ => self.agenda.abort(),
            }
        }
        let alone = self.session.epoch() == 0 && matches!(self.edp.mode(), Mode::Resting(_));
        if !alone {
            self.alone_since = None;
        } else if let Some(since) = self.alone_since {
            if now.since(since) > HOLD_TIMEOUT {
                let _ = self.edp.on(now, ModeEvent::Disable);
            }
        } else {
            self.alone_since = Some(now);
        }
    }

    /// A frame from the MP's bus.
    // a frame of its own: what else its caller does must not lie below it on the stack
    #[inline(never)]
    fn listen<P: Programs<N>, const W: usize>(
        &mut self,
        now: Micros,
        received: &Received,
        ecp: Option<&mut Ecp<R, N, P, W>>,
        tx: &mut impl FnMut(Port, Frame),
    ) {
        if let Some(incoming) = self.link.receive_at_node(&received.frame, received.at) {
            self.hear(now, &incoming, ecp, tx);
        }
    }

    // a frame of its own: what is received must not lie beside it on the stack
    #[inline(never)]
    fn hear<P: Programs<N>, const W: usize>(
        &mut self,
        now: Micros,
        incoming: &Incoming,
        ecp: Option<&mut Ecp<R, N, P, W>>,
        tx: &mut impl FnMut(Port, Frame),
    ) {
        let from = incoming.from;
        match &incoming.message {
            Message::Command(command) => self.command(now, from, command),
            Message::StopAll(stop) => self.stop(now, stop.kind),
            Message::TimeSync(sync) => self.time(now, incoming.received_at, sync),
            Message::Request {
                transfer_id,
                request,
            } => {
                let reply = self
                    .request(now, from, request, ecp)
                    .unwrap_or_else(Reply::Refused);
                // a reply that cannot be encoded is lost like any other frame: the MP asks again
                let _ = self
                    .link
                    .send_reply(from, *transfer_id, &reply, &mut mp(tx));
            }
            Message::Maintenance {
                transfer_id,
                request,
            } => self.wait_for_keeper(from, *transfer_id, request),
            Message::GetInfo { transfer_id } => self.send_info(from, *transfer_id, tx),
            _ => {}
        }
    }

    /// Time steps only for a new master, while nobody commands and nothing moves.
    fn time(&mut self, now: Micros, received_at: Micros, sync: &TimeSync) {
        self.clock.receive(received_at, sync);
        let disagrees = self.clock.quality(now) == Quality::Disagrees;
        if disagrees && self.session.epoch() == 0 && self.standing() {
            self.clock.reset();
        }
    }

    /// No set-point moves: not even one of homing or of a stop.
    fn standing(&self) -> bool {
        !matches!(
            self.edp.mode(),
            Mode::Moving { .. } | Mode::Stopping { .. } | Mode::Synchronising
        )
    }

    // a frame of its own: what else its caller does must not lie below it on the stack
    #[inline(never)]
    fn send_info(&mut self, to: NodeId, transfer: TransferId, tx: &mut impl FnMut(Port, Frame)) {
        let identity = self.identity();
        self.link
            .send_node_info(to, transfer, &NodeInfo::of(&identity), &mut mp(tx));
    }

    fn command(&mut self, now: Micros, from: NodeId, command: &Command) {
        let bus_now = self.clock.to_bus(now);
        if self
            .session
            .renew(bus_now, now, from.get(), command)
            .is_err()
        {
            return;
        }
        // a full inbox is told by the knots that are missing: the queue runs dry and says so
        let _ = self.agenda.coordinate(&command.coordination);
    }

    fn stop(&mut self, now: Micros, kind: StopKind) {
        self.agenda.abort();
        self.ending = false;
        match kind {
            StopKind::Path => {
                // allowed in every state that has something to stop
                let _ = self.edp.on(now, ModeEvent::Stop(Reaction::PathStop));
            }
            StopKind::Quick => self.edp.raise(now, Cause::EmergencyStop, None),
            StopKind::TorqueOff => {
                self.edp
                    .raise_with(now, Cause::EmergencyStop, None, Reaction::TorqueOff);
            }
        }
    }

    #[expect(clippy::too_many_lines, reason = "one arm per request")]
    fn request<P: Programs<N>, const W: usize>(
        &mut self,
        now: Micros,
        from: NodeId,
        request: &Request,
        ecp: Option<&mut Ecp<R, N, P, W>>,
    ) -> Result<Reply, Refusal> {
        let holder = |session: &Session, epoch: u32| session.authorise(from.get(), epoch);
        match request {
            Request::Identify => return Ok(Reply::Identity(self.identity())),
            Request::Acquire {
                lease_ms, takeover, ..
            } => {
                let at_rest = self.standing();
                let epoch = self
                    .session
                    .acquire(now, from.get(), *lease_ms, *takeover, at_rest)?;
                self.link.set_lease(epoch);
                if at_rest && !matches!(self.clock.quality(now), Quality::Synchronised { .. }) {
                    // a master that has gone: the next pair may be another one's
                    self.clock.reset();
                }
                self.agenda.forget();
                return Ok(Reply::Lease { epoch });
            }
            Request::Stop { kind } => self.stop(now, *kind),
            Request::Release { epoch } => {
                holder(&self.session, *epoch)?;
                self.session.release();
                self.link.set_lease(0);
                self.trace_every = 0;
                self.stop(now, StopKind::Path);
            }
            Request::Enable { epoch } => {
                holder(&self.session, *epoch)?;
                self.unlatched()?;
                let homed = self.edp.homed();
                self.edp.on(now, ModeEvent::Enable { homed })?;
            }
            Request::Disable { epoch } => {
                holder(&self.session, *epoch)?;
                self.edp.on(now, ModeEvent::Disable)?;
            }
            Request::Synchronise { epoch } => {
                holder(&self.session, *epoch)?;
                self.unlatched()?;
                self.edp.on(now, ModeEvent::Synchronise)?;
            }
            Request::Execute {
                epoch,
                id,
                start_at,
                instruction,
            } => {
                holder(&self.session, *epoch)?;
                self.unlatched()?;
                let Mode::Resting(rest) = self.edp.mode() else {
                    return Err(Refusal::WrongState {
                        state: self.state(),
                    });
                };
                let ecp = self.ecp_at_hand(ecp, NodeState::Moving)?;
                let bus_now = self.clock.to_bus(now);
                let timed = *start_at != Micros(0);
                if timed && *start_at < bus_now {
                    return Err(Refusal::Late);
                }
                if timed && start_at.since(bus_now) > START_HORIZON {
                    return Err(Refusal::Late);
                }
                let mut guard = None;
                if let Instruction::MoveUntilForce { newtons, .. } = instruction {
                    let newtons = f64::from(*newtons);
                    guard = Some(ForceAbove { newtons });
                }
                if guard.is_some() && self.wrist.force_n(now).is_none() {
                    return Err(Refusal::NoForce);
                }
                self.session.fresh(*id)?;
                self.ending = false;
                ecp.accept(instruction, rest == Rest::Holding)?;
                self.guard = guard;
                self.wrist.begin();
                self.agenda.begin(*id, *start_at, instruction);
            }
            Request::EndMotion { epoch } => {
                holder(&self.session, *epoch)?;
                self.agenda.end_motion();
            }
            Request::Acknowledge { epoch } => {
                holder(&self.session, *epoch)?;
                let Some(fault) = self.edp.mode().fault() else {
                    return Err(Refusal::WrongState {
                        state: self.state(),
                    });
                };
                if self.edp.cause_present() {
                    return Err(Refusal::CausePresent { cause: fault.cause });
                }
                self.edp.on(now, ModeEvent::Acknowledge)?;
            }
            Request::SelectServo { epoch, law } => {
                holder(&self.session, *epoch)?;
                self.edp.select(*law)?;
            }
            Request::SetTool {
                epoch,
                t_flange_tool,
            } => {
                holder(&self.session, *epoch)?;
                self.ecp_at_hand(ecp, self.state())?
                    .set_tool(t_flange_tool)?;
            }
            Request::Path {
                epoch,
                first,
                elements,
            } => {
                holder(&self.session, *epoch)?;
                let (next, room) = self.agenda.extend_path(*first, elements)?;
                return Ok(Reply::Path { next, room });
            }
            Request::FeedOverride { epoch, share } => {
                holder(&self.session, *epoch)?;
                self.agenda.override_feed(*share)?;
            }
            Request::Outputs { epoch, mask, on } => {
                holder(&self.session, *epoch)?;
                self.unlatched()?;
                let Mode::Resting(_) = self.edp.mode() else {
                    return Err(Refusal::WrongState {
                        state: self.state(),
                    });
                };
                self.outputs = self.outputs & !mask | on & mask;
            }
            Request::Trace { epoch, every } => {
                holder(&self.session, *epoch)?;
                self.trace_every = *every;
            }
        }
        Ok(Reply::Accepted)
    }

    /// The ECP, if it has nothing to do. For the time of a hand-over after an instruction was aborted it may still be at
    /// work on its last step.
    fn ecp_at_hand<'a, P, const W: usize>(
        &self,
        ecp: Option<&'a mut Ecp<R, N, P, W>>,
        state: NodeState,
    ) -> Result<&'a mut Ecp<R, N, P, W>, Refusal> {
        let idle = !self.agenda.busy() && self.work.is_at_hand();
        let ecp = ecp.filter(|_| idle);
        ecp.ok_or(Refusal::WrongState { state })
    }

    fn unlatched(&self) -> Result<(), Refusal> {
        match self.edp.mode().fault() {
            Some(fault) => Err(Refusal::FaultLatched { cause: fault.cause }),
            None => Ok(()),
        }
    }
}

/// Firmware version: major, minor, patch.
pub const FIRMWARE_VERSION: (u8, u8, u8) = (0, 1, 0);

/// Only the MP's port.
pub(super) fn mp(tx: &mut impl FnMut(Port, Frame)) -> impl FnMut(Frame) {
    move |frame| tx(Port::Mp, frame)
}
