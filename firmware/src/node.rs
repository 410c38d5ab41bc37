//! The controller node: link, lease, ECP and EDP of one robot, as one pure step function.
//!
//! ```text
//!  t_k          SYNC out: drives latch the targets of cycle k−1 and sample their actual values
//!  t_k + Ts/2   answers are in: supervise, ECP (every macrostep), EDP; targets out for SYNC k+1
//! ```
//! The age of feedback is one cycle, constantly. [`Node::step`] is called whenever
//! [`Node::next_wake`] has come, or earlier with frames that have arrived; it decides what is due.

mod keep;
mod report;

pub use report::FEEDBACK_STEPS;

use crate::capacity::{EVENTS, KNOT_INBOX, LINK_SESSIONS, PATH_SAMPLES};
use crate::config::{ConfigError, NodeConfig};
use crate::ecp::{Ecp, NoPrograms, Outcome, Programs, Sensors};
use crate::edp::mode::{Event as ModeEvent, Mode, Rest};
use crate::edp::{Edp, EdpSetup};
use crate::io::{Port, Received};
use crate::maintenance::Asked;
use crate::session::Session;
use crate::vsp::EffortSensor;
use agent::Vsp;
use protocol::clock::{Clock, Quality};
use protocol::cyphal::NodeInfo;
use protocol::fault::{Cause, Reaction, Refusal};
use protocol::frame::Frame;
use protocol::id::NodeId;
use protocol::link::{Endpoint, Incoming, Message, Role};
use protocol::message::{
    Command, Event, Identity, NodeState, Reply, Request, ServoLaw, StopKind, TimeSync,
};
use protocol::schema::{PROTOCOL, SCHEMA_HASH};
use protocol::time::Micros;
use protocol::transfer::TransferId;
use robots::Robot;

/// With torque on, at rest and nobody in command, torque goes off after this time.
const HOLD_TIMEOUT: Micros = Micros::from_millis(30_000);
/// A start time may lie this far ahead at most.
const START_HORIZON: Micros = Micros::from_millis(10_000);

/// One robot's controller, which looks at W samples of a path: see [`PATH_SAMPLES`].
#[derive(Debug)]
pub struct Node<R, const N: usize, P = NoPrograms, const W: usize = PATH_SAMPLES> {
    config: NodeConfig<N>,
    robot: R,
    link: Endpoint<LINK_SESSIONS>,
    clock: Clock,
    session: Session,
    ecp: Ecp<R, N, P, W>,
    edp: Edp<R, N>,
    effort: Vsp<EffortSensor<N>>,
    sensors: Sensors<N>,
    period: Micros,
    macrostep: u32,
    next_sync: Micros,
    next_servo: Option<Micros>,
    sampled_at: Micros,
    ending: bool,
    alone_since: Option<Micros>,
    /// Levels of the outputs at the tool.
    outputs: u16,
    trace_every: u16,
    announced: bool,
    events: heapless::Deque<Event, EVENTS>,
    /// The maintenance request that waits for the keeper.
    asked: Option<Asked>,
}

/// A robot and a configuration that has been found good: all that can fail before there is a node.
#[derive(Clone, Debug)]
pub struct NodeSetup<R, const N: usize> {
    robot: R,
    config: NodeConfig<N>,
    edp: EdpSetup<N>,
}

impl<R: Robot<N> + Copy, const N: usize> NodeSetup<R, N> {
    /// # Errors
    /// [`ConfigError`]
    pub fn new(robot: R, config: NodeConfig<N>) -> Result<Self, ConfigError> {
        config.validate()?;
        if config.law == ServoLaw::ComputedTorque && robot.chain().is_none() {
            return Err(ConfigError::ServoLaw);
        }
        let edp = EdpSetup::new(&robot, &config);
        edp.validate()?;
        Ok(Self { robot, config, edp })
    }
}

impl<R: Robot<N> + Copy, const N: usize> Node<R, N> {
    /// A node with the built-in instructions only.
    ///
    /// # Errors
    /// [`ConfigError`]
    pub fn new(now: Micros, robot: R, config: NodeConfig<N>) -> Result<Self, ConfigError> {
        Self::with_programs(now, robot, config, NoPrograms)
    }
}

impl<R: Robot<N> + Copy, const N: usize, P: Programs<N>> Node<R, N, P> {
    /// A node into which the user's programs are linked.
    ///
    /// # Errors
    /// [`ConfigError`]
    pub fn with_programs(
        now: Micros,
        robot: R,
        config: NodeConfig<N>,
        programs: P,
    ) -> Result<Self, ConfigError> {
        Ok(Self::of(now, NodeSetup::new(robot, config)?, programs))
    }
}

impl<R: Robot<N> + Copy, const N: usize, P: Programs<N>, const W: usize> Node<R, N, P, W> {
    /// The node of a setup; it is large, so this comes last, where it is to stay.
    pub fn of(now: Micros, setup: NodeSetup<R, N>, programs: P) -> Self {
        let NodeSetup {
            robot,
            config,
            edp: setup,
        } = setup;
        let limits = EdpSetup::generator_limits(&robot, config.velocity_factor);
        let macrostep = robot.description().macrostep;
        let period = Micros(u64::from(robot.description().servo_step_us));
        let effort = Vsp::new(EffortSensor::new(setup.overcurrent_ma, macrostep), ());
        let seed = (config.unique_id ^ config.unique_id >> 32) & 0xFFFF_FFFF;
        Self {
            link: Endpoint::new(config.node, Role::Node, config.mtu),
            clock: Clock::default(),
            session: Session::new(u32::try_from(seed).unwrap_or(0)),
            ecp: Ecp::new(robot, limits, setup.macrostep.as_secs_f64(), programs),
            edp: Edp::new(now, robot, setup),
            effort,
            sensors: Sensors { effort: [0.0; N] },
            period,
            macrostep,
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
            macrostep: u16::try_from(self.macrostep).unwrap_or(u16::MAX),
        }
    }

    /// When [`Node::step`] must be called next, local time.
    pub fn next_wake(&self) -> Micros {
        match self.next_servo {
            Some(at) if at < self.next_sync => at,
            _ => self.next_sync,
        }
    }

    /// Take what has arrived and do what is due. Bounded work; no clock, no bus.
    pub fn step(&mut self, now: Micros, rx: &[Received], tx: &mut impl FnMut(Port, Frame)) {
        for received in rx {
            match received.port {
                Port::Mp => {
                    if let Some(incoming) = self.link.receive(&received.frame, received.at) {
                        self.hear(now, incoming, tx);
                    }
                }
                Port::Drives(bus) => self.edp.on_frame(received.at, bus, &received.frame),
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
            self.servo(now, tx);
        }
    }

    // a frame of its own: what else its caller does must not lie below it on the stack
    #[inline(never)]
    fn servo(&mut self, now: Micros, tx: &mut impl FnMut(Port, Frame)) {
        self.watch_lease(now);
        let currents_ma = self.edp.currents_ma();
        if let Some(reading) = self.effort.step(&(), &currents_ma) {
            self.sensors = reading;
        }
        if self.edp.servo_step().is_multiple_of(self.macrostep) {
            self.macrostep(now);
        }
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

    /// A stop or fault ends the running instruction.
    fn after_fault(&mut self) {
        let running = matches!(self.edp.mode(), Mode::Resting(_) | Mode::Moving { .. });
        if !running && self.ecp.busy() {
            self.ecp.abort();
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
                _ => self.ecp.abort(),
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

    /// One macrostep of the ECP: under tight coordination, one step for every knot that waits.
    // a frame of its own: what else its caller does must not lie below it on the stack
    #[inline(never)]
    fn macrostep(&mut self, now: Micros) {
        if !matches!(self.edp.mode(), Mode::Resting(_) | Mode::Moving { .. }) {
            return;
        }
        for _ in 0..KNOT_INBOX {
            if self.ending || !self.ecp.busy() {
                break;
            }
            let bus_now = self.clock.to_bus(now);
            match self.ecp.step(bus_now, self.edp.image(), self.sensors) {
                Outcome::Idle => break,
                Outcome::Demand(demand) => {
                    if matches!(self.edp.mode(), Mode::Resting(_)) {
                        let _ = self.edp.on(now, ModeEvent::Start);
                    }
                    let demand = demand.in_local_time(&self.clock);
                    if let Err(refusal) = self.edp.demand(now, &demand) {
                        self.ecp.fail(refusal);
                        self.refused(now, &refusal);
                    }
                }
                Outcome::Ended => {
                    self.ending = true;
                    self.edp.come_to_rest();
                }
                Outcome::Failed(refusal) => self.refused(now, &refusal),
                Outcome::Error => self.edp.raise(now, Cause::ErrorCondition, None),
            }
            if !(self.ecp.follows() && self.ecp.more()) {
                break;
            }
        }
        if (self.ending || !self.ecp.busy()) && self.edp.at_rest(now) {
            if self.ending {
                self.ending = false;
                self.ecp.complete();
            }
            self.edp.flush();
            if matches!(self.edp.mode(), Mode::Moving { .. }) {
                let _ = self.edp.on(now, ModeEvent::Ended);
            }
        }
    }

    /// What the instruction asked for cannot be: harmless at rest, a fault in motion.
    fn refused(&mut self, now: Micros, refusal: &Refusal) {
        self.ending = false;
        if self.edp.at_rest(now) {
            return;
        }
        let (cause, axis) = match refusal {
            Refusal::Limit { axis, .. } => (Cause::PositionLimit, Some(usize::from(*axis))),
            Refusal::NotFinite { index } => (Cause::NotFinite, Some(usize::from(*index))),
            _ => (Cause::Unreachable, None),
        };
        let fault = Cause::reaction(cause);
        let reaction = if fault > Reaction::PathStop {
            Reaction::PathStop
        } else {
            fault
        };
        // the path so far was checked: stopping on it is the safest thing to do
        self.edp.raise_with(now, cause, axis, reaction);
    }

    // a frame of its own: what else its caller does must not lie below it on the stack
    #[inline(never)]
    fn hear(&mut self, now: Micros, incoming: Incoming, tx: &mut impl FnMut(Port, Frame)) {
        let from = incoming.from;
        match incoming.message {
            Message::Command(command) => self.command(now, from, &command),
            Message::StopAll(stop) => self.stop(now, stop.kind),
            Message::TimeSync(sync) => self.time(now, incoming.received_at, &sync),
            Message::Request {
                transfer_id,
                request,
            } => {
                let reply = self
                    .request(now, from, &request)
                    .unwrap_or_else(Reply::Refused);
                // a reply that cannot be encoded is lost like any other frame: the MP asks again
                let _ = self.link.send_reply(from, transfer_id, &reply, &mut mp(tx));
            }
            Message::Maintenance {
                transfer_id,
                request,
            } => self.wait_for_keeper(from, transfer_id, request),
            Message::GetInfo { transfer_id } => self.send_info(from, transfer_id, tx),
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
        let _ = self.ecp.coordinate(&command.coordination);
    }

    fn stop(&mut self, now: Micros, kind: StopKind) {
        self.ecp.abort();
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
    fn request(&mut self, now: Micros, from: NodeId, request: &Request) -> Result<Reply, Refusal> {
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
                self.ecp.forget();
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
                if self.ecp.busy() {
                    return Err(Refusal::WrongState {
                        state: NodeState::Moving,
                    });
                }
                let bus_now = self.clock.to_bus(now);
                let timed = *start_at != Micros(0);
                if timed && *start_at < bus_now {
                    return Err(Refusal::Late);
                }
                if timed && start_at.since(bus_now) > START_HORIZON {
                    return Err(Refusal::Late);
                }
                self.session.fresh(*id)?;
                self.ending = false;
                self.ecp
                    .accept(*id, *start_at, instruction, rest == Rest::Holding)?;
            }
            Request::EndMotion { epoch } => {
                holder(&self.session, *epoch)?;
                self.ecp.end_motion();
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
                if self.ecp.busy() {
                    return Err(Refusal::WrongState {
                        state: self.state(),
                    });
                }
                self.ecp.set_tool(t_flange_tool)?;
            }
            Request::Path {
                epoch,
                first,
                elements,
            } => {
                holder(&self.session, *epoch)?;
                let (next, room) = self.ecp.extend_path(*first, elements)?;
                return Ok(Reply::Path { next, room });
            }
            Request::FeedOverride { epoch, share } => {
                holder(&self.session, *epoch)?;
                self.ecp.override_feed(*share)?;
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
fn mp(tx: &mut impl FnMut(Port, Frame)) -> impl FnMut(Frame) {
    move |frame| tx(Port::Mp, frame)
}
