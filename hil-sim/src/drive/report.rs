//! What the objects tell: statusword, actual values, inputs.

use protocol::canopen::cia402::{Mode, PowerState, Statusword, input};
use protocol::canopen::nmt::State;

use super::homing::Homing;
use super::servo::Setpoint;
use super::{SimDrive, slots, to_i32};
use protocol::units::modulo;

impl SimDrive {
    /// The statusword now.
    pub(super) fn statusword(&self) -> Statusword {
        let mut word = Statusword::of(self.power.state()).0 | Statusword::VOLTAGE;
        let mut set = |bit, on| word |= if on { bit } else { 0 };
        set(Statusword::REMOTE, self.nmt == State::Operational);
        set(Statusword::IN_SYNC, self.last_sync_ns.is_some());
        set(Statusword::LIMIT, self.cut || self.servo.limited);
        let enabled = self.power.state() == PowerState::OperationEnabled;
        match self.mode {
            Mode::Csp | Mode::Csv | Mode::Cst => {
                set(Statusword::FOLLOWS, self.follows());
                set(Statusword::DEVIATION, self.following_since_ns.is_some());
            }
            Mode::Homing if enabled => {
                set(
                    Statusword::TARGET_REACHED,
                    !self.homing.is_running() && !self.homing_waits() && self.servo.stands(),
                );
                set(Statusword::FOLLOWS, self.homing == Homing::Done);
                set(Statusword::DEVIATION, self.homing == Homing::Failed);
            }
            Mode::Pp if enabled => {
                set(Statusword::TARGET_REACHED, self.has_reached());
                set(Statusword::FOLLOWS, self.way.acknowledges());
                set(Statusword::DEVIATION, self.following_since_ns.is_some());
            }
            Mode::Pv if enabled => {
                set(Statusword::TARGET_REACHED, self.has_reached());
                set(Statusword::FOLLOWS, self.is_slow());
            }
            Mode::Pp | Mode::Pv | Mode::Homing | Mode::None => {}
        }
        if self.halted && enabled {
            word |= if self.servo.stands() {
                Statusword::TARGET_REACHED
            } else {
                0
            };
        }
        self.spoilt(Statusword(word))
    }

    /// Writes the values the drive measures into the dictionary.
    pub(super) fn publish(&mut self) {
        let scale = self.scale;
        let actual = scale.units(self.sensed.count);
        let torque = to_i32(self.sensed.current_a * self.torque_per_current() / scale.nm_per_mille);
        self.od.set_signed(slots::POSITION_ACTUAL, modulo(actual));
        self.od.set_signed(slots::TORQUE_ACTUAL, torque);
        let demand = to_i32(self.servo.demand_rad_s() * scale.units_per_rad);
        self.od.set_signed(slots::VELOCITY_DEMAND, demand);
        let velocity = to_i32(self.servo.velocity_rad_s() * scale.units_per_rad);
        self.od.set_signed(slots::VELOCITY_ACTUAL, velocity);
        self.od
            .set(slots::STATUSWORD, u32::from(self.statusword().0));
        self.od
            .set_signed(slots::MODE_DISPLAY, i32::from(self.mode.code()));
        self.od.set(slots::DIGITAL_INPUTS, self.inputs());
        self.publish_probes();
        self.od
            .set(slots::ERROR_REGISTER, u32::from(self.errors.register.0));
        self.od
            .set(slots::ERROR_CODE, u32::from(self.errors.code.0));
        let amperes = f64::from(self.od.get(slots::RATED_CURRENT)) * 1e-6;
        self.od.set_signed(
            slots::CURRENT_ACTUAL,
            to_i32(self.sensed.current_a / amperes),
        );
        let demand = self.demand_rad();
        let units = scale.units_of_rad(demand);
        self.od.set_signed(slots::POSITION_DEMAND, modulo(units));
        let error = (demand - scale.rad(self.sensed.count)) * scale.units_per_rad;
        self.od.set_signed(slots::FOLLOWING_ERROR, to_i32(error));
        let increments = to_i32(demand / scale.rad_per_increment);
        self.od
            .set_signed(slots::POSITION_DEMAND_INCREMENTS, increments);
    }

    /// Torque per current of the motor, from its rated values, N·m/A.
    fn torque_per_current(&self) -> f64 {
        self.scale.nm_per_mille * 1e6 / f64::from(self.od.get(slots::RATED_CURRENT))
    }

    /// The position reference, or the position where there is none.
    pub(super) fn demand_rad(&self) -> f64 {
        match self.servo.setpoint() {
            Setpoint::Line { .. } | Setpoint::Jog { .. } | Setpoint::Profile(_) => {
                self.servo.reference_rad
            }
            Setpoint::Free
            | Setpoint::Speed { .. }
            | Setpoint::Torque { .. }
            | Setpoint::Brake { .. } => self.scale.rad(self.sensed.count),
        }
    }

    pub(super) fn inputs(&self) -> u32 {
        let bit = |on, bit| if on { bit } else { 0 };
        bit(self.sensed.negative_limit, input::NEGATIVE_LIMIT)
            | bit(self.sensed.positive_limit, input::POSITIVE_LIMIT)
            | bit(self.sensed.home, input::HOME)
            | (u32::from(self.external) * input::FIRST_FREE)
    }
}
