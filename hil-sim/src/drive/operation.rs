//! Power states, modes, brake; following the set-points; what the objects tell.

use core::f64::consts::TAU;

use protocol::canopen::cia402::{
    AbortConnection, Action, Command, Controlword, Event, Halt, HomingMethod, Mode, Options, Power,
    Ramp,
};
use protocol::canopen::emcy::{Emergency, ErrorCode};
use protocol::canopen::nmt::State;
use protocol::units::{modulo, nearest};

use super::homing::{Homing, View, Want};
use super::profile::Way;
use super::servo::{Offset, Setpoint};
use super::{Errors, Scale, SimDrive, Stage, slots};

/// What the power stage can, beside the rated torque (see [`super::parameters::DriveParameters::new`]), ‰.
const PEAK_PER_MILLE: f64 = 4000.0;

/// The deceleration of stage changes that find the axis standing, rad/s².
const HOLD_RAMP: f64 = 1000.0;

/// An axis that becomes faster by this in a ramp down runs away: torque off at once, rad/s. ASSUMED.
const RUNAWAY_RAD_S: f64 = 5.0;
/// A ramp that takes longer than it should by this factor and time ends in torque off all the same: the encoder may be
/// what is wrong. ASSUMED.
const RAMP_FACTOR: f64 = 1.5;
const RAMP_GRACE_NS: u64 = 200 * super::parameters::MS;

impl SimDrive {
    /// Reads the objects of the profile again.
    pub(super) fn configure_motion(&mut self) {
        let offset = self.scale.offset;
        self.scale = Scale::read(&self.od);
        self.scale.offset = offset;
        let code = |slot| i16::try_from(self.od.signed(slot)).unwrap_or(0);
        self.options = Options::from_codes(
            code(slots::QUICK_STOP_OPTION),
            code(slots::SHUTDOWN_OPTION),
            code(slots::DISABLE_OPTION),
            code(slots::FAULT_OPTION),
        )
        .unwrap_or_default();
        self.abort_connection = AbortConnection::from_code(code(slots::ABORT_CONNECTION))
            .unwrap_or(AbortConnection::QuickStop);
        self.period_ns = u64::from(self.od.get(slots::CYCLE_PERIOD)) * 1000;
        let window = f64::from(self.od.get(slots::FOLLOWING_WINDOW)) / self.scale.units_per_rad;
        let timeout = u64::from(self.od.get(slots::FOLLOWING_TIMEOUT)) * super::parameters::MS;
        // all ones: not watched
        let watched = self.od.get(slots::FOLLOWING_WINDOW) != u32::MAX;
        let window = if watched { window } else { f64::INFINITY };
        self.following_window = (window, timeout);
        self.limit_nm = f64::from(self.od.get(slots::MAX_TORQUE)) * self.scale.nm_per_mille;
        self.choose_mode();
    }

    /// Takes the commanded mode over, at once: every mode starts from where the axis is.
    fn choose_mode(&mut self) {
        let code = i8::try_from(self.od.signed(slots::MODE)).unwrap_or(0);
        let mode = Mode::from_code(code).unwrap_or_default();
        if mode == self.mode {
            return;
        }
        self.mode = mode;
        self.homing = Homing::Idle;
        self.way = Way::default();
        self.missed = 0;
        self.cut = false;
        if self.power == Power::Enabled {
            self.stand(Ramp::SlowDown);
        }
    }

    /// The period of the interpolation (object 60C2), s.
    fn interpolation_s(&self) -> f64 {
        let mut period = f64::from(self.od.get(slots::INTERPOLATION_PERIOD));
        for _ in self.od.signed(slots::INTERPOLATION_INDEX)..0 {
            period *= 0.1;
        }
        period
    }

    /// The deceleration of a ramp, rad/s²; none where the torque limits it.
    fn ramp(&self, ramp: Ramp) -> Option<f64> {
        let slot = match ramp {
            Ramp::SlowDown => slots::PROFILE_DECELERATION,
            Ramp::QuickStop => slots::QUICK_STOP_DECELERATION,
            Ramp::CurrentLimit | Ramp::VoltageLimit => return None,
        };
        Some(f64::from(self.od.get(slot)) / self.scale.units_per_rad)
    }

    /// The greatest torque now, N·m: a stop at the voltage limit may use all that the power stage has.
    pub(super) fn greatest_nm(&self) -> f64 {
        if self.servo.setpoint() == (Setpoint::Brake { unlimited: true }) {
            PEAK_PER_MILLE * self.scale.nm_per_mille
        } else {
            self.limit_nm
        }
    }

    /// How long a ramp from the present velocity may take, ns.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "saturates, and is positive"
    )]
    fn ramp_ns(&self, ramp: Ramp) -> u64 {
        // at its torque limit an axis needs about what a slow-down takes, or there is something wrong with it
        let least = self.ramp(ramp).or(self.ramp(Ramp::SlowDown));
        let way = self.servo.velocity_rad_s().abs();
        least.map_or(0, |ramp| (RAMP_FACTOR * 1e9 * way / ramp) as u64)
    }

    fn stand(&mut self, ramp: Ramp) {
        match self.ramp(ramp) {
            Some(decelerate) => self.servo.jog(0.0, decelerate),
            None => self.servo.brake(ramp == Ramp::VoltageLimit),
        }
        self.offset = Offset::default();
    }

    /// Evaluates the controlword in the dictionary.
    pub(super) fn on_controlword(&mut self) {
        let [low, high, ..] = self.od.get(slots::CONTROLWORD).to_le_bytes();
        let word = Controlword(u16::from_le_bytes([low, high]));
        let before = core::mem::replace(&mut self.controlword, word);
        if word.rises(before, Controlword::FAULT_RESET) {
            self.reset_fault();
        }
        if self.may(word.command()) {
            self.transition(Event::Command(word.command()));
        }
        let halt = word.has(Controlword::HALT);
        if halt && !self.halted && self.power == Power::Enabled {
            let code = i16::try_from(self.od.signed(slots::HALT_OPTION)).unwrap_or(1);
            let Halt(ramp) = Halt::from_code(code).unwrap_or(Halt(Ramp::SlowDown));
            self.stand(ramp);
        }
        self.halted = halt;
        self.choose_mode();
        if let Stage::Opening(_) = self.stage {
            // what begins with this edge begins when the brake is open
            self.controlword.0 &= !Controlword::OPERATION_4;
        }
        match self.mode {
            Mode::Homing if self.follows() => self.home(word, before),
            Mode::Pp if self.follows() => self.ask(word, before),
            Mode::None | Mode::Pp | Mode::Pv | Mode::Homing | Mode::Csp | Mode::Csv | Mode::Cst => {
            }
        }
    }

    /// Torque is refused while the node's heartbeat is missing, and that is told once.
    fn may(&mut self, command: Command) -> bool {
        let missing = self.consumer.is_some_and(|consumer| consumer.is_missing());
        if !missing || command != Command::EnableOperation || self.power != Power::SwitchedOn {
            return true;
        }
        if self.errors.code != ErrorCode::HEARTBEAT {
            self.report(ErrorCode::HEARTBEAT);
        }
        false
    }

    fn home(&mut self, word: Controlword, before: Controlword) {
        if word.rises(before, Controlword::OPERATION_4) {
            let code = i8::try_from(self.od.signed(slots::HOMING_METHOD)).unwrap_or(0);
            let method = HomingMethod::from_code(code).unwrap_or(HomingMethod::PresentPosition);
            let (homing, want) = Homing::start(method, &self.view());
            self.homing = homing;
            self.obey(want);
        } else if !word.has(Controlword::OPERATION_4) && self.homing.is_running() {
            self.homing = Homing::Idle;
            self.stand(Ramp::SlowDown);
        }
    }

    fn view(&self) -> View {
        View {
            count: self.sensed.count,
            index: self.sensed.index,
            home: self.home.level,
            negative_limit: self.sensed.negative_limit,
            positive_limit: self.sensed.positive_limit,
            stands: self.servo.stands(),
            increments_per_turn: i64::from(self.p.increments_per_turn),
        }
    }

    fn obey(&mut self, want: Want) {
        let units = self.scale.units_per_rad;
        let ramp = f64::from(self.od.get(slots::HOMING_ACCELERATION)) / units;
        match want {
            Want::Nothing => {}
            Want::Move { fast, negative } => {
                let slot = if fast {
                    slots::HOMING_FAST
                } else {
                    slots::HOMING_SLOW
                };
                let speed = f64::from(self.od.get(slot)) / units;
                self.servo.jog(if negative { -speed } else { speed }, ramp);
            }
            Want::Stop => self.servo.jog(0.0, ramp),
            Want::Home(at) => {
                let home = i64::from(self.od.signed(slots::HOME_OFFSET));
                self.scale.offset = 0;
                self.scale.offset = home - self.scale.units(at);
            }
        }
    }

    /// Is the drive following set-points?
    pub(super) fn follows(&self) -> bool {
        self.power == Power::Enabled
            && self.stage == Stage::On
            && !self.halted
            && !self.homes_itself()
    }

    /// Runs an event through the power state machine and does what it says.
    pub(super) fn transition(&mut self, event: Event) {
        let (power, action) = self.power.on(event, self.options);
        self.power = power;
        match action {
            Action::None => {}
            Action::Energise => {
                self.clear_errors();
                self.stage = Stage::Opening(self.now_ns + self.p.enable_ns);
                self.servo.jog(0.0, HOLD_RAMP);
                self.way = Way::default();
                self.missed = 0;
                (self.over_current_since_ns, self.following_since_ns) = (None, None);
            }
            Action::Resume => self.missed = 0,
            Action::Ramp(ramp) => {
                self.way = Way::default();
                self.ramp_ends_ns = self.now_ns + RAMP_GRACE_NS + self.ramp_ns(ramp);
                self.ramp_began_rad_s = self.servo.velocity_rad_s().abs();
                self.stand(ramp);
            }
            Action::SwitchOff => {
                if self.stage != Stage::Off {
                    self.stage = Stage::Closing(self.now_ns + self.p.brake_close_ns);
                }
            }
            Action::Coast => self.coast(),
        }
        self.od.energised = self.stage != Stage::Off;
    }

    fn coast(&mut self) {
        self.stage = Stage::Off;
        self.end_by_itself();
        self.servo.free();
        self.offset = Offset::default();
    }

    /// Lets the axis go and forgets the power state: reset.
    pub(super) fn let_go(&mut self) {
        self.coast();
        self.power = Power::NotReady;
        self.controlword = Controlword::default();
        self.mode = Mode::None;
        self.homing = Homing::Idle;
        self.way = Way::default();
        self.halted = false;
        self.errors = Errors::default();
        self.last_sync_ns = None;
        self.scale.offset = 0;
        self.probes.set_function(0);
    }

    /// Between SYNCs: stage times, ramps that end, homing.
    #[inline]
    pub(super) fn operate(&mut self) {
        match self.stage {
            Stage::Opening(until) if self.now_ns >= until => {
                self.stage = Stage::On;
                self.begin_by_itself();
                if !self.mode.is_cyclic() {
                    self.on_controlword();
                }
            }
            Stage::Closing(until) if self.now_ns >= until => {
                self.coast();
                self.od.energised = false;
            }
            Stage::Off | Stage::Opening(_) | Stage::On | Stage::Closing(_) => {}
        }
        match self.power {
            Power::Leaving { .. } | Power::QuickStop { stand: false } | Power::FaultReaction => {
                let speed = self.servo.velocity_rad_s().abs();
                let runs_away = speed > self.ramp_began_rad_s + RUNAWAY_RAD_S;
                if self.servo.stands() || runs_away || self.now_ns >= self.ramp_ends_ns {
                    self.transition(Event::Standstill);
                }
            }
            Power::Enabled if self.homing.is_running() => {
                let (homing, want) = self.homing.step(&self.view());
                self.homing = homing;
                self.obey(want);
            }
            Power::Enabled if self.homes_itself() => {
                if self.sensed.index.is_some() {
                    self.end_by_itself();
                }
            }
            Power::Enabled if self.follows() => self.make_way(),
            Power::NotReady
            | Power::Disabled
            | Power::Ready
            | Power::SwitchedOn
            | Power::Enabled
            | Power::QuickStop { stand: true }
            | Power::Fault => {}
        }
    }

    /// At SYNC: the new set-point takes effect.
    pub(super) fn follow(&mut self, fresh: bool) {
        if !self.mode.is_cyclic() || !self.follows() {
            self.missed = 0;
            return;
        }
        if self.missed >= super::monitor::PATIENCE {
            self.connection_lost(ErrorCode::RPDO_TIMEOUT);
            return;
        }
        if !fresh {
            return;
        }
        let units = self.scale.units_per_rad;
        let per_mille = self.scale.nm_per_mille;
        self.offset = Offset {
            rad_s: f64::from(self.od.signed(slots::VELOCITY_OFFSET)) / units,
            nm: f64::from(self.od.signed(slots::TORQUE_OFFSET)) * per_mille,
        };
        let most = f64::from(self.od.get(slots::MAX_SPEED)) * TAU / 60.0;
        match self.mode {
            Mode::Csp => {
                let (target, cut) = self.target();
                let target = self.scale.rad_of_units(target);
                self.cut = self.servo.line(target, self.interpolation_s(), most) || cut;
            }
            Mode::Csv => {
                let wanted = f64::from(self.od.signed(slots::TARGET_VELOCITY)) / units;
                let over = self.runs_over(wanted);
                let speed = if over { 0.0 } else { wanted.clamp(-most, most) };
                self.cut = over || wanted.abs() > most;
                self.servo.speed(speed);
            }
            Mode::Cst => {
                let wanted = f64::from(self.od.signed(slots::TARGET_TORQUE)) * per_mille;
                // No torque that drives the axis beyond the greatest speed.
                let velocity = self.servo.velocity_rad_s();
                self.cut = velocity.abs() > most && velocity * wanted > 0.0;
                self.servo.torque(if self.cut { 0.0 } else { wanted });
            }
            Mode::None | Mode::Pp | Mode::Pv | Mode::Homing => {}
        }
    }

    /// The target position within the software limits, and whether they cut it.
    fn target(&self) -> (i64, bool) {
        let wanted = i64::from(self.od.signed(slots::TARGET_POSITION))
            + i64::from(self.od.signed(slots::POSITION_OFFSET));
        let low = self.od.signed(slots::SOFT_LIMIT_LOW);
        if low >= self.od.signed(slots::SOFT_LIMIT_HIGH) {
            // without limits the drive counts on, and its 32 bits are modulo
            let near = nearest(modulo(wanted), self.position_units());
            return (near, false);
        }
        self.within_soft_limits(wanted)
    }

    fn reset_fault(&mut self) {
        if self.power != Power::Fault || self.injected.is_some() {
            return;
        }
        self.transition(Event::FaultReset);
        self.clear_errors();
    }

    /// Forgets errors and says so, if there were any.
    fn clear_errors(&mut self) {
        if self.errors.register.0 == 0 {
            return;
        }
        self.errors = Errors::default();
        self.announce(Emergency::default());
    }

    /// Sends an emergency, unless object 1014 switches it off; not before the inhibit time (1015).
    pub(super) fn announce(&mut self, emergency: Emergency) {
        match self.nmt {
            State::PreOperational | State::Operational
                if self.od.get(slots::EMERGENCY_COB) >> 31 == 0 =>
            {
                self.emergencies.push(emergency);
                self.send_emergencies();
            }
            State::Initialising | State::Stopped | State::PreOperational | State::Operational => {}
        }
    }

    /// Sends the emergencies that may go.
    pub(super) fn send_emergencies(&mut self) {
        let [low, high, ..] = self.od.get(slots::EMERGENCY_COB).to_le_bytes();
        let cob = u16::from_le_bytes([low, high]) & 0x7FF;
        while let Some(emergency) = self.emergencies.due(super::network::micros(self.now_ns)) {
            self.outbox.push(emergency.frame_on(cob));
        }
    }

    /// A quick stop of the drive's own accord.
    pub(super) fn stop_quickly(&mut self) {
        self.transition(Event::Command(Command::QuickStop));
    }
}
