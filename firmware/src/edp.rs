//! The Effector Driver Process: synchronisation, fixed-step interpolation, servo loops, limits,
//! drives.
//!
//! Once per servo step: take what the drives sampled at SYNC, watch it, interpolate the next
//! set-point, let the [`limits::Gate`] pass it, close the loops, send the drives their targets
//! before the next SYNC. The state machine is [`mode::Mode`].

pub mod axis;
pub mod drives;
pub mod homing;
pub mod limits;
pub mod mode;
pub mod servo;
mod setup;

pub use setup::EdpSetup;

use crate::capacity::KNOT_QUEUE;
use crate::ecp::{Demand, EffectorImage, refusal};
use crate::io::Port;
use axis::Axis;
use drives::{AxisActual, Drives, Task};
use homing::{Action, AxisHoming, Inputs};
use limits::Gate;
use mode::{Event, Mode};
use motion::interpolator::{PushError, Status, StopCause};
use motion::{Interpolator, Knot};
use protocol::canopen::cia402::{Goal, Mode as DriveMode, PowerState};
use protocol::fault::{Cause, Fault, Quantity, Reaction, Refusal};
use protocol::frame::Frame;
use protocol::message::{HomingPhase, NodeState, ServoLaw};
use protocol::time::Micros;
use robots::{Joints, MotorMotion, Motors, Robot};

/// Overcurrent must last so many servo steps: 20 ms at 2 ms.
const OVERCURRENT_STEPS: u8 = 10;
/// Drives that do not follow within this time after "enable" have a fault, µs.
const ENABLE_TIMEOUT: Micros = Micros::from_millis(3000);

/// What homing reports to the outside.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HomingProgress {
    /// The axis, from 0.
    pub axis: u8,
    /// The phase it has entered.
    pub phase: HomingPhase,
}

/// Homing in progress.
#[derive(Debug)]
struct HomingRun {
    /// Position in the robot's homing order.
    turn: usize,
    axis: usize,
    run: AxisHoming,
    reported: Option<HomingPhase>,
    /// The other axes' switches when this axis began: they must not change.
    switches: u8,
}

/// The EDP of one robot.
#[derive(Debug)]
pub struct Edp<R, const N: usize> {
    robot: R,
    setup: EdpSetup<N>,
    mode: Mode,
    drives: Drives<N>,
    axes: [Axis; N],
    interpolator: Option<Interpolator<N, KNOT_QUEUE>>,
    gate: Gate<N>,
    homing: Option<HomingRun>,
    homing_report: Option<HomingProgress>,
    last_knot_at: Micros,
    queue_end: Motors<N>,
    overcurrent: [u8; N],
    enabling_since: Micros,
    quick_stop_taken: bool,
    /// A feed hold ends the path: nothing of what is left of it will be run.
    coming_to_rest: bool,
    new_fault: Option<Fault>,
    violations: u32,
    step: u32,
    configured: u8,
}

impl<R: Robot<N> + Copy, const N: usize> Edp<R, N> {
    /// Nothing known of the drives yet.
    pub fn new(now: Micros, robot: R, setup: EdpSetup<N>) -> Self {
        let axes = setup.axes.map(|constants| Axis::new(constants, setup.law));
        Self {
            robot,
            mode: Mode::Boot,
            drives: Drives::new(
                now,
                &setup.addresses,
                &setup.scripts,
                setup.sync_cob,
                setup.master,
            ),
            axes,
            interpolator: None,
            gate: Gate::at_rest(&[0.0; N], setup.servo_step_s),
            homing: None,
            homing_report: None,
            last_knot_at: Micros(0),
            queue_end: Motors([0.0; N]),
            overcurrent: [0; N],
            enabling_since: now,
            quick_stop_taken: false,
            coming_to_rest: false,
            new_fault: None,
            violations: 0,
            step: 0,
            configured: 0,
            setup,
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

    /// Greatest following error of each axis since the last call, drive units.
    pub fn take_following_errors(&mut self) -> [u32; N] {
        let mut out = [0; N];
        for (out, axis) in out.iter_mut().zip(&mut self.axes) {
            *out = axis.take_following_error();
        }
        out
    }

    /// Are all axes homed?
    pub fn homed(&self) -> bool {
        self.axes.iter().all(|axis| axis.homed)
    }

    /// Path time left in the queue, µs.
    pub fn horizon_us(&self, now: Micros) -> u64 {
        self.interpolator
            .as_ref()
            .map_or(0, |i| i.horizon_us(now.0))
    }

    /// A drive that has become ready since the last call.
    pub fn take_configured(&mut self) -> Option<u8> {
        let links = self.drives.links().iter().enumerate();
        for (k, link) in links {
            let axis = u8::try_from(k).ok()?;
            if link.is_ready() && self.configured & (1 << axis) == 0 {
                self.configured |= 1 << axis;
                return Some(axis);
            }
        }
        None
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
    fn current_ma(&self, k: usize) -> f64 {
        let (Some(link), Some(axis)) = (self.drives.links().get(k), self.axes.get(k)) else {
            return 0.0;
        };
        let torque_mnm =
            f64::from(link.actual().torque) * 1e-3 * f64::from(link.rated_torque_mnm());
        torque_mnm / axis.constants().torque_constant
    }

    /// Motor currents, mA.
    pub fn currents_ma(&self) -> [f64; N] {
        core::array::from_fn(|k| self.current_ma(k))
    }

    /// The image for the ECP.
    pub fn image(&self) -> EffectorImage<N> {
        let motors = Motors(self.axes.each_ref().map(Axis::actual_rad));
        let homed = self.homed();
        let joints = |m: &Motors<N>| homed.then(|| self.robot.joints(m).ok()).flatten();
        EffectorImage {
            motors,
            joints: joints(&motors),
            demanded_motors: self.queue_end,
            demanded_joints: joints(&self.queue_end),
            following_error: self.axes.each_ref().map(Axis::following_error_rad),
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
                for (k, axis) in self.axes.iter_mut().enumerate() {
                    axis.settle(0.0);
                    axis.master.reset_fault();
                    if let Some(count) = self.overcurrent.get_mut(k) {
                        *count = 0;
                    }
                }
                self.hold_here();
            }
            Event::Synchronise => self.home_next(0),
            Event::Acknowledge if after == Mode::Configuring => {
                self.interpolator = None;
                self.homing = None;
                self.configured = 0;
                for axis in &mut self.axes {
                    axis.master.reset_fault();
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

    /// The set-points as they stand now, rad.
    fn setpoint(&self) -> [f64; N] {
        match &self.interpolator {
            Some(interpolator) => interpolator.setpoint().position,
            None => self.axes.each_ref().map(Axis::actual_rad),
        }
    }

    /// Hold where the axes stand.
    fn hold_here(&mut self) {
        let here = self
            .axes
            .each_ref()
            .map(|axis| axis.rad(axis.units(axis.actual_rad())));
        self.hold_at(here);
    }

    /// Hold where the set-points stand.
    fn hold_setpoint(&mut self) {
        self.hold_at(self.setpoint());
    }

    fn hold_at(&mut self, positions: [f64; N]) {
        let envelopes = self.setup.envelopes(self.homed());
        self.interpolator = Interpolator::new(envelopes, positions).ok();
        self.gate = Gate::at_rest(&positions, self.setup.servo_step_s);
        self.queue_end = Motors(positions);
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
        if let Some(interpolator) = &mut self.interpolator {
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

    /// The demand of one macrostep becomes a knot of the set-point queue.
    ///
    /// # Errors
    /// Why the knot was refused; nothing changed then.
    pub fn demand(&mut self, now: Micros, demand: &Demand<N>) -> Result<(), Refusal> {
        let (motion, at, has_acceleration) = match demand {
            Demand::Stay => return Ok(()),
            Demand::Refuse(refusal) => return Err(*refusal),
            Demand::Motors(motion) => (*motion, None, true),
            Demand::At {
                at,
                motion,
                has_acceleration,
            } => (*motion, Some(*at), *has_acceleration),
            Demand::Joints(motion) => (self.motor_motion(motion)?, None, true),
            Demand::JointsAt {
                at,
                motion,
                has_acceleration,
            } => (self.motor_motion(motion)?, Some(*at), *has_acceleration),
        };
        let macrostep = self.setup.macrostep;
        let Some(interpolator) = &mut self.interpolator else {
            return Err(Refusal::WrongState {
                state: self.mode.into(),
            });
        };
        let at = if interpolator.is_idle() {
            // one macrostep of lead, so that the queue never runs dry between two of them
            let start = match at {
                Some(at) if at.since(now) > macrostep => Micros(at.0.saturating_sub(macrostep.0)),
                Some(_) => now,
                None => now + macrostep,
            };
            interpolator
                .start(start.0)
                .map_err(|_| Refusal::WrongState {
                    state: self.mode.into(),
                })?;
            at.unwrap_or(start + macrostep)
        } else {
            at.unwrap_or(self.last_knot_at + macrostep)
        };
        let knot = Knot {
            at_us: at.0,
            position: motion.position.0,
            velocity: motion.velocity,
            acceleration: has_acceleration.then_some(motion.acceleration),
        };
        interpolator
            .push(knot, now.0)
            .map_err(|e| from_push(&e, self.mode.into()))?;
        self.last_knot_at = at;
        self.queue_end = motion.position;
        Ok(())
    }

    fn motor_motion(&self, motion: &robots::JointMotion<N>) -> Result<MotorMotion<N>, Refusal> {
        self.robot
            .check_joints(&motion.position)
            .map_err(|e| refusal::from_kinematics(&e))?;
        self.robot
            .motor_motion(motion)
            .map_err(|e| refusal::from_kinematics(&e))
    }

    /// The instruction has ended, perhaps in the middle of a motion: come to rest on the path.
    pub fn come_to_rest(&mut self) {
        if let Some(interpolator) = &mut self.interpolator
            && !interpolator.ends_at_rest()
        {
            interpolator.feed_hold();
            self.coming_to_rest = true;
        }
    }

    /// Have the set-points come to rest, with nothing left to do?
    pub fn at_rest(&self, now: Micros) -> bool {
        self.interpolator.as_ref().is_none_or(|interpolator| {
            interpolator.is_at_rest()
                && (self.coming_to_rest || interpolator.horizon_us(now.0) == 0)
        })
    }

    /// Drop what is left of a path that was held or stopped.
    pub fn flush(&mut self) {
        if let Some(interpolator) = &mut self.interpolator
            && interpolator.flush().is_ok()
        {
            interpolator.resume();
            self.coming_to_rest = false;
            self.queue_end = Motors(interpolator.setpoint().position);
        }
    }

    /// Choose the servo law; allowed with torque off or at rest.
    ///
    /// # Errors
    /// [`Refusal::WrongState`]
    pub fn select(&mut self, law: ServoLaw) -> Result<(), Refusal> {
        if !matches!(self.mode, Mode::Disabled | Mode::Resting(_)) {
            return Err(Refusal::WrongState {
                state: self.mode.into(),
            });
        }
        let code = drive_mode(law).code();
        self.setup.law = law;
        for k in 0..N {
            let current = self.current_ma(k);
            let Some(axis) = self.axes.get_mut(k) else {
                continue;
            };
            if drive_mode(axis.law()) == drive_mode(law) {
                axis.select(law, current);
            } else if let Some(link) = self.drives.link_mut(k) {
                // the law changes when the drive confirms its mode
                link.request(Task::SetMode(code));
            }
        }
        Ok(())
    }

    /// A drive has confirmed its mode: from now on it gets the other kind of target.
    fn follow_modes(&mut self) {
        let wanted = self.setup.law;
        for k in 0..N {
            let confirmed = self.drives.links().get(k).map(drives::DriveLink::mode);
            let current = self.current_ma(k);
            if let Some(axis) = self.axes.get_mut(k)
                && axis.law() != wanted
                && confirmed == Some(drive_mode(wanted).code())
            {
                axis.select(wanted, current);
            }
        }
    }

    /// The servo step: after the drives' answers to SYNC have come, before the next SYNC.
    pub fn servo(&mut self, now: Micros, tx: &mut impl FnMut(Port, Frame)) {
        if self.mode == Mode::Boot {
            let _ = self.on(now, Event::Started);
        }
        self.measure(now);
        self.supervise(now);
        self.follow_modes();
        let setpoint = self.next_setpoint(now);
        self.command(&setpoint, tx);
        self.drives.poll(now, tx);
    }

    fn measure(&mut self, now: Micros) {
        let mut jump = None;
        let links = self
            .drives
            .links()
            .iter()
            .map(|link| (link.is_ready(), link.actual()));
        for (k, (axis, (ready, actual))) in self.axes.iter_mut().zip(links).enumerate() {
            let AxisActual {
                position, fresh, ..
            } = actual;
            if ready && fresh && !axis.measure(position) {
                jump = Some(k);
            }
        }
        if let Some(axis) = jump {
            self.raise(now, Cause::EncoderJump, Some(axis));
        }
    }

    /// Faults of the drives and of the loops.
    fn supervise(&mut self, now: Micros) {
        match self.mode {
            Mode::Configuring if self.drives.ready() => {
                let _ = self.on(now, Event::DrivesConfigured);
            }
            Mode::Enabling { .. } => {
                let states = self.drives.links().iter().map(drives::DriveLink::state);
                if states
                    .clone()
                    .all(|s| s == Some(PowerState::OperationEnabled))
                {
                    let _ = self.on(now, Event::Enabled);
                } else if now.since(self.enabling_since) > ENABLE_TIMEOUT {
                    let late = states
                        .enumerate()
                        .find(|(_, s)| *s != Some(PowerState::OperationEnabled))
                        .map(|(k, _)| k);
                    self.raise(now, Cause::DriveDisabled, late);
                }
            }
            _ => {}
        }
        let latched = matches!(self.mode, Mode::Faulted { .. });
        // While enabling, the drives' old faults are being reset.
        let resetting = matches!(self.mode, Mode::Enabling { .. } | Mode::Disabled)
            && now.since(self.enabling_since) < ENABLE_TIMEOUT;
        if let Some((axis, cause)) = self.drives.fault()
            && !latched
            && !(resetting && cause == Cause::DriveFault)
        {
            self.raise(now, cause, Some(axis));
            return;
        }
        if !self.mode.torque() || matches!(self.mode, Mode::Enabling { .. }) {
            return;
        }
        let velocity = self
            .interpolator
            .as_ref()
            .map_or([0.0; N], |i| i.setpoint().velocity);
        let mut found = None;
        for (k, link) in self.drives.links().iter().enumerate() {
            let over = libm::fabs(self.current_ma(k))
                > self.setup.overcurrent_ma.get(k).copied().unwrap_or(0.0);
            let (Some(axis), Some(count), Some(v)) = (
                self.axes.get(k),
                self.overcurrent.get_mut(k),
                velocity.get(k),
            ) else {
                continue;
            };
            *count = if over { count.saturating_add(1) } else { 0 };
            let cause = if link.state() != Some(PowerState::OperationEnabled) {
                Cause::DriveDisabled
            } else if *count >= OVERCURRENT_STEPS {
                Cause::OverCurrent
            } else if axis.beyond_window(*v) {
                Cause::FollowingError
            } else {
                continue;
            };
            found = Some((cause, k));
            break;
        }
        if let Some((cause, axis)) = found
            && !latched
        {
            self.raise(now, cause, Some(axis));
        }
    }

    fn next_setpoint(&mut self, now: Micros) -> motion::Setpoint<N> {
        let rest = |positions| motion::Setpoint::at_rest(positions);
        if !self.mode.torque() {
            return rest(self.axes.each_ref().map(Axis::actual_rad));
        }
        if self.homing.is_some() {
            return self.homing_setpoint(now);
        }
        let Some(interpolator) = &mut self.interpolator else {
            return rest(self.setpoint());
        };
        let mut output = interpolator.step(now.0);
        let bounds = self.setup.bounds(self.homed());
        let passed = self.gate.pass(&output.setpoint.position, &bounds);
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

    /// Joint limits, once homed.
    fn joints_inside(&self, positions: &[f64; N]) -> Result<(), (Cause, usize)> {
        if !self.homed() {
            return Ok(());
        }
        let checked = self.robot.joints(&Motors(*positions)).and_then(|q| {
            // what stands outside already may come back
            let inside = self.robot.check_joints(&q);
            inside.or_else(|e| if self.closer(&q) { Ok(()) } else { Err(e) })
        });
        checked.map_err(|e| match e {
            robots::KinematicError::Limit { axis, .. } => (Cause::PositionLimit, axis),
            _ => (Cause::Unreachable, 0),
        })
    }

    /// Is every joint that is outside its range no farther outside than where the axis stands?
    fn closer(&self, q: &Joints<N>) -> bool {
        let here = Motors(self.axes.each_ref().map(Axis::actual_rad));
        let Ok(here) = self.robot.joints(&here) else {
            return false;
        };
        let ranges = self
            .robot
            .description()
            .axes
            .iter()
            .map(|a| a.joint_position);
        q.0.iter()
            .zip(&here.0)
            .zip(ranges)
            .all(|((q, here), range)| {
                range.contains(*q)
                    || (*q > range.upper && *q <= *here + JOINT_TOLERANCE)
                    || (*q < range.lower && *q >= *here - JOINT_TOLERANCE)
            })
    }

    fn follow_status(&mut self, now: Micros, status: Status) {
        let stopping = matches!(self.mode, Mode::Stopping { .. });
        match status {
            Status::Stopping {
                cause: StopCause::Underrun,
            }
            | Status::Stopped {
                cause: StopCause::Underrun,
            } if !stopping && !matches!(self.mode, Mode::Faulted { .. }) => {
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
        match (&self.homing, &self.interpolator) {
            (Some(homing), _) => homing.run.at_rest(),
            (None, Some(interpolator)) => interpolator.is_at_rest(),
            (None, None) => true,
        }
    }

    /// Begin homing the next axis in the robot's order, from `turn` on.
    fn home_next(&mut self, turn: usize) {
        let order = self.robot.description().homing.order;
        let next = order
            .iter()
            .enumerate()
            .skip(turn)
            .find(|(_, k)| self.axes.get(**k).is_some_and(|axis| !axis.homed));
        let Some((turn, axis)) = next else {
            self.homing = None;
            return;
        };
        let (Some(parameters), Some(position), Some(link)) = (
            self.setup.homing.get(*axis).copied(),
            self.setpoint().get(*axis).copied(),
            self.drives.links().get(*axis),
        ) else {
            return;
        };
        let switches = self.switches();
        let run = AxisHoming::new(parameters, position, link.home_switch());
        self.homing = Some(HomingRun {
            turn,
            axis: *axis,
            run,
            reported: None,
            switches,
        });
    }

    /// One bit per axis.
    fn switches(&self) -> u8 {
        let links = self.drives.links().iter();
        links.enumerate().fold(0, |bits, (k, link)| {
            bits | u8::from(link.home_switch()) << (k & 7)
        })
    }

    fn homing_setpoint(&mut self, now: Micros) -> motion::Setpoint<N> {
        let mut setpoint = motion::Setpoint::at_rest(self.gate.positions());
        let switches = self.switches();
        let Some(homing) = &mut self.homing else {
            return setpoint;
        };
        let k = homing.axis;
        let (Some(axis), Some(link)) = (self.axes.get(k), self.drives.links().get(k)) else {
            return setpoint;
        };
        let foreign = (switches ^ homing.switches) & !(1_u8 << (k & 7)) != 0;
        let inputs = Inputs {
            switch: link.home_switch(),
            index_rad: link.index().map(|units| axis.rad(i64::from(units))),
        };
        let result = if foreign && self.mode == Mode::Synchronising {
            Err(Cause::HomingForeignSwitch)
        } else {
            homing.run.step(inputs, self.setup.servo_step_s)
        };
        if homing.reported != Some(homing.run.phase()) {
            homing.reported = Some(homing.run.phase());
            self.homing_report = Some(HomingProgress {
                axis: u8::try_from(k).unwrap_or(u8::MAX),
                phase: homing.run.phase(),
            });
        }
        let out = match result {
            Ok(out) => out,
            Err(cause) => {
                // `raise` makes the axis slow down; this step it goes on as it was
                self.raise(now, cause, Some(k));
                let Some(homing) = &mut self.homing else {
                    return setpoint;
                };
                match homing.run.step(Inputs::default(), self.setup.servo_step_s) {
                    Ok(out) => out,
                    Err(_) => return setpoint,
                }
            }
        };
        let (Some(axis), Some(link)) = (self.axes.get_mut(k), self.drives.link_mut(k)) else {
            return setpoint;
        };
        let mut finished = false;
        match out.action {
            Action::None => {}
            Action::ArmIndex => link.request(Task::ArmIndex),
            Action::SetZero { index_rad } => {
                let zero = axis.units(index_rad);
                let shift = axis.rad(zero);
                axis.set_zero(zero);
                self.gate.shift(k, -shift);
                for (p, past) in setpoint.position.iter_mut().zip(self.gate.positions()) {
                    *p = past;
                }
            }
            Action::Finished => finished = true,
        }
        let axes = setpoint.position.iter_mut().zip(&mut setpoint.velocity);
        if let Some(((p, v), a)) = axes.zip(&mut setpoint.acceleration).nth(k) {
            (*p, *v, *a) = (out.position, out.velocity, out.acceleration);
        }
        let bounds = self.setup.bounds(false);
        if let Err(violation) = self.gate.pass(&setpoint.position, &bounds) {
            self.violations = self.violations.saturating_add(1);
            self.raise(now, violation.cause(), Some(violation.axis));
            setpoint = motion::Setpoint::at_rest(self.gate.positions());
        }
        if matches!(self.mode, Mode::Stopping { .. }) && self.at_rest_after_stop() {
            self.homing = None;
            self.hold_at(setpoint.position);
            let _ = self.on(now, Event::AtRest);
        } else if finished {
            let turn = self.homing.as_ref().map_or(0, |h| h.turn);
            self.hold_at(setpoint.position);
            self.home_next(turn.saturating_add(1));
            if self.homing.is_none() {
                let _ = self.on(now, Event::Synchronised);
                self.hold_at(setpoint.position);
            }
        }
        setpoint
    }

    /// Close the loops and send the drives their targets.
    fn command(&mut self, setpoint: &motion::Setpoint<N>, tx: &mut impl FnMut(Port, Frame)) {
        let torque = self.mode.torque();
        let goal = if torque {
            Goal::Enabled
        } else {
            Goal::Disabled
        };
        let ts = self.setup.servo_step_s;
        for (k, axis) in self.axes.iter_mut().enumerate() {
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
            let demand = servo::Demand {
                position: *p,
                velocity: *v,
                acceleration: *a,
            };
            let target = if torque {
                axis.servo(demand, state, link.rated_torque_mnm(), ts)
            } else {
                axis.idle()
            };
            let controlword = axis.controlword(goal, link.statusword());
            link.command(controlword, target, tx);
        }
    }
}

/// What stands outside a joint limit may waver by encoder noise while it comes back, rad or m.
const JOINT_TOLERANCE: f64 = 1e-4;

/// The CiA 402 mode in which a law is run.
const fn drive_mode(law: ServoLaw) -> DriveMode {
    match law {
        ServoLaw::DrivePosition => DriveMode::Csp,
        ServoLaw::Original | ServoLaw::FeedForward => DriveMode::Cst,
    }
}

fn from_push(error: &PushError, state: NodeState) -> Refusal {
    let axis_of = |axis: usize| u8::try_from(axis).unwrap_or(u8::MAX);
    match *error {
        PushError::NotStarted | PushError::Stopped { .. } => Refusal::WrongState { state },
        PushError::Full => Refusal::QueueFull,
        PushError::NotMonotone { .. } => Refusal::NotMonotone,
        PushError::Late { .. } => Refusal::Late,
        PushError::NotFinite { axis } => Refusal::NotFinite {
            index: axis_of(axis),
        },
        PushError::Limit {
            axis,
            quantity,
            value,
            limit,
        } => Refusal::Limit {
            axis: axis_of(axis),
            quantity: match quantity {
                motion::knot::Quantity::Position => Quantity::MotorPosition,
                motion::knot::Quantity::Velocity => Quantity::Velocity,
                motion::knot::Quantity::Acceleration => Quantity::Acceleration,
                motion::knot::Quantity::Jerk => Quantity::Jerk,
            },
            value,
            limit,
        },
        PushError::NoRoomToStop { axis, value, limit } => Refusal::Limit {
            axis: axis_of(axis),
            quantity: Quantity::MotorPosition,
            value,
            limit,
        },
        PushError::AccelerationStep { axis, value, limit } => Refusal::Limit {
            axis: axis_of(axis),
            quantity: Quantity::Acceleration,
            value,
            limit,
        },
    }
}
