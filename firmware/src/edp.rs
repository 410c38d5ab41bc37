//! The Effector Driver Process: synchronisation, fixed-step interpolation, servo loops, limits,
//! drives.
//!
//! Once per servo step: take what the drives sampled at SYNC, watch it, interpolate the next
//! set-point, let the [`limits::Gate`] pass it, close the loops, send the drives their targets
//! before the next SYNC. The state machine is [`mode::Mode`].

pub mod axis;
pub mod computed;
pub mod drives;
mod encoder_watch;
pub(crate) mod envelopes;
mod holder;
pub mod homing;
pub mod limits;
pub mod mode;
mod queue;
pub mod servo;
mod setup;
mod supervise;
mod synchronise;

pub use setup::{Constants, EdpSetup};

use crate::ecp::EffectorAtMotors;
use crate::io::Port;
use axis::{Axis, Reference};
use computed::ComputedTorque;
use drives::{DriveLink, Drives, Task};
use encoder_watch::EncoderWatch;
use envelopes::{UNBOUNDED, bounds};
use holder::Holder;
use limits::Gate;
use mode::{Event, Mode};
use motion::Angle;
use motion::interpolator::{Status, StopCause};
use protocol::canopen::cia402::{Goal, Mode as DriveMode};
use protocol::fault::{Cause, Fault, Reaction, Refusal};
use protocol::frame::Frame;
use protocol::message::{Event as NodeEvent, HomingPhase, NodeState, ServoLaw};
use protocol::time::Micros;
use robots::{JointGuard, Motors, Robot};
use synchronise::HomingRun;

/// What homing reports to the outside.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HomingProgress {
    /// The axis, from 0.
    pub axis: u8,
    /// The phase it has entered.
    pub phase: HomingPhase,
}

/// The EDP of one robot.
#[derive(Debug)]
pub struct Edp<R, const N: usize> {
    robot: R,
    setup: Constants<N>,
    mode: Mode,
    drives: Drives<N>,
    axes: [Axis; N],
    /// The law of the robot as a whole, of one that has a chain.
    computed: Option<ComputedTorque<N>>,
    /// The part of the model's torque that csp has as an offset, 0 to 1.
    offset_share: f32,
    interpolator: Holder<N>,
    gate: Gate<N>,
    /// Gate and interpolator have the ranges of a homed robot.
    ranges_homed: bool,
    guard: JointGuard<N>,
    homing: Option<HomingRun>,
    homing_report: Option<HomingProgress>,
    queue_end: Motors<N>,
    overcurrent: [u8; N],
    encoders: [EncoderWatch; N],
    enabling_since: Micros,
    quick_stop_taken: bool,
    /// A feed hold ends the path: nothing of what is left of it will be run.
    coming_to_rest: bool,
    new_fault: Option<Fault>,
    violations: u32,
    acceleration_step: f32,
    step: u32,
    configured: u8,
}

impl<R: Robot<N> + Copy, const N: usize> Edp<R, N> {
    /// Nothing known of the drives yet.
    pub fn new(now: Micros, robot: R, setup: EdpSetup<N>) -> Self {
        let EdpSetup {
            constants,
            addresses,
            scripts,
            sync_cob,
            master,
            axes,
            braking,
            velocity_factor,
        } = setup;
        let axes = axes.map(|each| Axis::new(each, constants.law));
        let bounds = bounds(robot.description(), velocity_factor, false);
        Self {
            computed: ComputedTorque::new(&robot, constants.servo_step_s),
            offset_share: 0.0,
            robot,
            mode: Mode::Boot,
            drives: Drives::new(now, &addresses, &scripts, sync_cob, master),
            axes,
            interpolator: Holder::new(braking),
            gate: Gate::at_rest(&[Angle::ZERO; N], &bounds, constants.servo_step_s),
            ranges_homed: false,
            guard: JointGuard::new(robot.description()),
            homing: None,
            homing_report: None,
            queue_end: Motors([0.0; N]),
            overcurrent: [0; N],
            encoders: [EncoderWatch::default(); N],
            enabling_since: now,
            quick_stop_taken: false,
            coming_to_rest: false,
            new_fault: None,
            violations: 0,
            acceleration_step: 0.0,
            step: 0,
            configured: 0,
            setup: constants,
        }
    }

    /// The state.
    pub const fn mode(&self) -> Mode {
        self.mode
    }

    /// Servo steps since boot.
    pub const fn servo_step(&self) -> u32 {
        self.step
    }

    /// Set-points that were stopped at the gate.
    pub const fn violations(&self) -> u32 {
        self.violations
    }

    /// The axes.
    pub const fn axes(&self) -> &[Axis; N] {
        &self.axes
    }

    /// The drives.
    pub const fn drives(&self) -> &Drives<N> {
        &self.drives
    }

    /// Drive the outputs at the tool, which are those of the last axis' drive.
    pub fn drive_outputs(&mut self, levels: u16) {
        if let Some(link) = self.drives.link_mut(N.saturating_sub(1)) {
            link.set_outputs(levels);
        }
    }

    /// Greatest following error of each axis since the last call, drive units.
    pub fn take_following_errors(&mut self) -> [u32; N] {
        let mut out = [0; N];
        for (out, axis) in out.iter_mut().zip(&mut self.axes) {
            *out = axis.take_following_error();
        }
        out
    }

    /// Greatest step of acceleration where a cubic segment began, since the last call, rad/s².
    pub const fn take_acceleration_step(&mut self) -> f32 {
        core::mem::replace(&mut self.acceleration_step, 0.0)
    }

    /// Are all axes homed?
    pub fn homed(&self) -> bool {
        self.axes.iter().all(|axis| axis.homed)
    }

    /// Path time left in the queue, µs.
    pub fn horizon_us(&self, now: Micros) -> u64 {
        self.interpolator.get().map_or(0, |i| i.horizon_us(now.0))
    }

    /// A drive that has become ready since the last call.
    pub fn take_configured(&mut self) -> Option<u8> {
        for (axis, link) in (0_u8..8).zip(self.drives.links()) {
            let bit = 1 << (axis & 7);
            if link.is_ready() && self.configured & bit == 0 {
                self.configured |= bit;
                return Some(axis);
            }
        }
        None
    }

    /// What was found out about who a drive is, since the last call.
    pub fn take_drive_news(&mut self) -> Option<NodeEvent> {
        self.drives.take_news()
    }

    /// What homing has to report since the last call.
    pub const fn take_homing_progress(&mut self) -> Option<HomingProgress> {
        self.homing_report.take()
    }

    /// A frame from a drive bus.
    pub fn on_frame(&mut self, now: Micros, bus: u8, frame: &Frame) {
        self.drives.on_frame(now, bus, frame);
    }

    /// Send SYNC: the beginning of a servo step.
    pub fn sync(&mut self, tx: &mut impl FnMut(Port, Frame)) {
        self.step = self.step.wrapping_add(1);
        self.drives.sync(tx);
    }

    /// Current of an axis, mA.
    fn current_ma(&self, k: usize) -> f32 {
        let (Some(link), Some(axis)) = (self.drives.links().get(k), self.axes.get(k)) else {
            return 0.0;
        };
        current_ma(f32::from(link.actual().torque), link, axis)
    }

    /// Current that has held an axis in the last steps, mA.
    fn holding_ma(&self, k: usize) -> f32 {
        let (Some(link), Some(axis)) = (self.drives.links().get(k), self.axes.get(k)) else {
            return 0.0;
        };
        current_ma(axis.mean_torque(), link, axis)
    }

    /// Motor currents, mA.
    pub fn currents_ma(&self) -> [f32; N] {
        core::array::from_fn(|k| self.current_ma(k))
    }

    /// The image for the ECP.
    pub fn image(&self) -> EffectorAtMotors<N> {
        EffectorAtMotors {
            motors: Motors(self.axes.each_ref().map(Axis::actual_rad)),
            demanded_motors: self.queue_end,
            following_error: self.axes.each_ref().map(Axis::following_error_rad),
            homed: self.homed(),
        }
    }

    fn fault(&self, cause: Cause, axis: Option<usize>) -> Fault {
        Fault {
            cause,
            axis: axis.and_then(|k| u8::try_from(k).ok()),
            step: self.step,
            during: NodeState::from(self.mode),
        }
    }

    /// An event for the state machine, with what follows from it.
    ///
    /// # Errors
    /// [`Refusal::WrongState`] if it is not allowed now.
    pub fn on(&mut self, now: Micros, event: Event) -> Result<(), Refusal> {
        let before = self.mode;
        let Some(after) = before.on(event) else {
            return Err(Refusal::WrongState {
                state: before.into(),
            });
        };
        self.mode = after;
        match event {
            Event::Enable { .. } => {
                self.enabling_since = now;
                for (k, axis) in (0..N).zip(&mut self.axes) {
                    axis.settle(0.0);
                    axis.master.reset_fault();
                    if let Some(count) = self.overcurrent.get_mut(k) {
                        *count = 0;
                    }
                }
                if let Some(computed) = &mut self.computed {
                    computed.begin();
                }
                // nothing has held the arm: a model that is known is to do it at once
                self.offset_share = 1.0;
                self.hold_here();
            }
            Event::Synchronise => self.home_next(0),
            Event::Acknowledge if after == Mode::Configuring => {
                self.interpolator.leave();
                self.homing = None;
                self.configured = 0;
                for (axis, link) in self.axes.iter_mut().zip(self.drives.links()) {
                    axis.master.reset_fault();
                    if link.has_restarted() {
                        axis.homed = false;
                    }
                }
                self.drives.restart(now);
            }
            Event::Acknowledge => self.hold_setpoint(),
            Event::Stop(_) | Event::Fault(..) => self.begin_stop(),
            _ => {}
        }
        Ok(())
    }

    /// Raise a fault; every state accepts one.
    pub fn raise(&mut self, now: Micros, cause: Cause, axis: Option<usize>) {
        self.raise_with(now, cause, axis, cause.reaction());
    }

    /// Raise a fault with a reaction of its own.
    pub fn raise_with(
        &mut self,
        now: Micros,
        cause: Cause,
        axis: Option<usize>,
        reaction: Reaction,
    ) {
        let fault = self.fault(cause, axis);
        if self.mode.fault().is_none() {
            self.new_fault = Some(fault);
        }
        // `on` refuses no fault: tested over every state
        let _ = self.on(now, Event::Fault(fault, reaction));
    }

    /// The first fault that latched since the last call.
    pub const fn take_new_fault(&mut self) -> Option<Fault> {
        self.new_fault.take()
    }

    /// Is what is wrong with the hardware still wrong? Then a fault cannot be acknowledged.
    pub fn cause_present(&self) -> bool {
        // A drive's own fault is reset by the acknowledgement; a silent one must speak first.
        matches!(self.drives.fault(), Some((_, Cause::DriveSilent)))
    }

    /// The set-points as they stand now.
    fn setpoint(&self) -> [Angle; N] {
        match self.interpolator.get() {
            Some(interpolator) => interpolator.setpoint().position,
            None => self.axes.each_ref().map(Axis::actual_angle),
        }
    }

    /// Hold where the axes stand.
    fn hold_here(&mut self) {
        let here = self.axes.each_ref().map(Axis::actual_angle);
        self.hold_at(here);
    }

    /// Hold where the set-points stand.
    fn hold_setpoint(&mut self) {
        self.hold_at(self.setpoint());
    }

    // a frame of its own: what else its caller does must not lie below it on the stack
    #[inline(never)]
    fn hold_at(&mut self, positions: [Angle; N]) {
        self.ranges_homed = self.homed();
        let unbounded = [UNBOUNDED; N];
        let ranges = if self.ranges_homed {
            &self.setup.homed_ranges
        } else {
            &unbounded
        };
        self.interpolator.hold(ranges, positions);
        self.gate.set_ranges(ranges);
        self.gate.hold(&positions);
        self.queue_end = Motors(positions.map(Angle::to_f64));
        self.quick_stop_taken = false;
        self.coming_to_rest = false;
    }

    /// A stop has begun or become stronger.
    fn begin_stop(&mut self) {
        let Mode::Stopping { reaction, .. } = self.mode else {
            return;
        };
        if let Some(homing) = &mut self.homing {
            homing.run.abort();
        }
        if let Some(interpolator) = self.interpolator.get_mut() {
            match reaction {
                Reaction::PathStop => interpolator.feed_hold(),
                Reaction::QuickStop | Reaction::TorqueOff => {
                    if !self.quick_stop_taken {
                        self.quick_stop_taken = true;
                        interpolator.quick_stop();
                    }
                }
            }
        }
    }

    /// Choose the servo law; allowed with torque off or at rest.
    ///
    /// # Errors
    /// [`Refusal::WrongState`], or [`Refusal::UnknownServoLaw`] for computed torque of a robot without a
    /// chain.
    pub fn select(&mut self, law: ServoLaw) -> Result<(), Refusal> {
        if !matches!(self.mode, Mode::Disabled | Mode::Resting(_)) {
            return Err(Refusal::WrongState {
                state: self.mode.into(),
            });
        }
        if !self.has(law) {
            return Err(Refusal::UnknownServoLaw);
        }
        self.setup.law = law;
        if let Some(computed) = &mut self.computed {
            computed.leave();
        }
        for k in 0..N {
            let current = self.holding_ma(k);
            let Some(axis) = self.axes.get_mut(k) else {
                continue;
            };
            if drive_mode(axis.law()) == drive_mode(law) {
                axis.select(law, current);
            } else {
                // the law changes when the drive confirms its mode
                axis.hand_over();
            }
        }
        Ok(())
    }

    /// A drive that has latched its first target of the other kind is asked for the mode that goes with it;
    /// once it has confirmed that, it gets nothing else.
    fn follow_modes(&mut self) {
        let wanted = self.setup.law;
        let code = drive_mode(wanted).code();
        if self.axes.iter().all(|axis| axis.law() == wanted) {
            return;
        }
        for k in 0..N {
            let current = self.holding_ma(k);
            let (Some(axis), Some(link)) = (self.axes.get_mut(k), self.drives.link_mut(k)) else {
                continue;
            };
            if axis.law() == wanted || !link.is_ready() {
                continue;
            }
            if link.mode() == code {
                axis.select(wanted, current);
                if let Some(computed) = &mut self.computed {
                    computed.leave();
                }
            } else if !axis.is_handing_over() && !link.busy() {
                link.request(Task::SetMode(code));
            }
        }
    }

    /// The servo step: after the drives' answers to SYNC have come, before the next SYNC. `currents_ma` are
    /// those of [`Self::currents_ma`] since then.
    // a frame of its own: what else its caller does must not lie below it on the stack
    #[inline(never)]
    pub fn servo(&mut self, now: Micros, currents_ma: &[f32; N], tx: &mut impl FnMut(Port, Frame)) {
        if self.mode == Mode::Boot {
            let _ = self.on(now, Event::Started);
        }
        self.measure(now);
        self.supervise(now, currents_ma);
        self.follow_modes();
        let setpoint = self.next_setpoint(now);
        self.command(&setpoint, tx);
        self.drives.poll(now, tx);
    }

    // a frame of its own: what else its caller does must not lie below it on the stack
    #[inline(never)]
    fn next_setpoint(&mut self, now: Micros) -> motion::Setpoint<N> {
        let rest = |positions| motion::Setpoint::at_rest(positions);
        if !self.mode.torque() {
            // nobody follows it
            return rest(self.gate.positions());
        }
        if self.homing.is_some() {
            return self.homing_setpoint(now);
        }
        let Some(interpolator) = self.interpolator.get_mut() else {
            return rest(self.setpoint());
        };
        let mut output = interpolator.step(now.0);
        let passed = self.gate.pass(&output.setpoint.position);
        let passed = passed.map_err(|violation| (violation.cause(), violation.axis));
        let passed = passed.and_then(|()| self.joints_inside(&output.setpoint.position));
        if let Err((cause, axis)) = passed {
            self.violations = self.violations.saturating_add(1);
            self.raise(now, cause, Some(axis));
            // the set-point is not sent: every axis stops from where the last one was
            output.setpoint = rest(self.gate.positions());
            self.hold_at(output.setpoint.position);
        }
        self.follow_status(now, output.status);
        output.setpoint
    }

    fn follow_status(&mut self, now: Micros, status: Status) {
        let stopping = matches!(self.mode, Mode::Stopping { .. });
        match status {
            Status::Stopping {
                cause: StopCause::Underrun,
            }
            | Status::Stopped {
                cause: StopCause::Underrun,
            } if !stopping
                && !self.coming_to_rest
                && !matches!(self.mode, Mode::Faulted { .. }) =>
            {
                self.raise(now, Cause::Underrun, None);
            }
            _ => {}
        }
        if stopping && self.at_rest_after_stop() {
            self.flush();
            let _ = self.on(now, Event::AtRest);
        }
    }

    fn at_rest_after_stop(&self) -> bool {
        match (&self.homing, self.interpolator.get()) {
            (Some(homing), _) => homing.run.at_rest(),
            (None, Some(interpolator)) => interpolator.is_at_rest(),
            (None, None) => true,
        }
    }

    /// Close the loops and send the drives their targets.
    // a frame of its own: what else its caller does must not lie below it on the stack
    #[inline(never)]
    fn command(&mut self, setpoint: &motion::Setpoint<N>, tx: &mut impl FnMut(Port, Frame)) {
        let torque = self.mode.torque();
        let goal = if torque {
            Goal::Enabled
        } else {
            Goal::Disabled
        };
        let ts = servo::narrow(self.setup.servo_step_s);
        let computed = self.computed_currents(setpoint);
        let offsets = self.torque_offsets(setpoint);
        for (k, axis) in (0..N).zip(&mut self.axes) {
            let Some(link) = self.drives.link_mut(k) else {
                continue;
            };
            if !link.is_ready() {
                continue;
            }
            let state = link.state();
            let (Some(p), Some(v), Some(a)) = (
                setpoint.position.get(k),
                setpoint.velocity.get(k),
                setpoint.acceleration.get(k),
            ) else {
                continue;
            };
            let demand = Reference {
                position: *p,
                velocity: *v,
                acceleration: *a,
            };
            let offset = offsets.get(k).copied().flatten();
            let target = if torque {
                let computed_ma = computed.as_ref().and_then(|ma| ma.get(k)).copied();
                let rated_mnm = link.rated_torque_mnm();
                axis.servo(demand, computed_ma, offset, state, rated_mnm, ts)
            } else {
                axis.idle()
            };
            let controlword = axis.controlword(goal, link.statusword());
            link.command(controlword, target, offset, tx);
        }
        self.drives.send_groups(tx);
    }
}

/// The current, mA, of a torque in ‰ of the drive's rated torque.
fn current_ma(torque: f32, link: &DriveLink, axis: &Axis) -> f32 {
    torque * 1e-3 * axis::whole(link.rated_torque_mnm()) / axis.constants().torque_constant
}

/// The CiA 402 mode in which a law is run.
const fn drive_mode(law: ServoLaw) -> DriveMode {
    match law {
        ServoLaw::DrivePosition => DriveMode::Csp,
        ServoLaw::Original | ServoLaw::FeedForward | ServoLaw::ComputedTorque => DriveMode::Cst,
    }
}
