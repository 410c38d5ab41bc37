//! Computed torque for cst: the whole arm's equation of motion, turned into motor currents.
//!
//! With M and h of the motors ([`robots::dynamics`]), m the angles of the motors, d the demand, and e what is left,
//!
//! ```text
//!   torque = M(m_d)·(m̈_d + Kv·ė + Kp·e + Ki·∫e dt) + h(m_d, ṁ_d) + friction(ṁ_d)
//! ```
//!
//! with e = `m_d` − m. With a true model every error then obeys e''' + Kv·e'' + Kp·e' + Ki·e = 0, whatever the posture
//! and however the axes are coupled (Luh, Walker and Paul 1980; Craig, "Introduction to Robotics", ch. 10).
//! M·a + h is one pass of Newton and Euler: M itself is never formed.
//!
//! The model is taken at the set-point, not where the arm is measured to be: the set-point is smooth, known
//! to the last bit and two steps younger than a measurement; h of a differentiated encoder would put its
//! noise and the loop's delay into a term that is no part of the feedback the gains are designed for. What
//! is lost is of the order of the following error, which the law makes small.
//!
//! Gains: the poles −ω, −ω, −ω/8, roughly, as those of [`super::servo::FeedForwardGains`]; ω = 0.18/Ts, which
//! is 90 rad/s at servo steps of 2 ms and 180 rad/s at 1 ms: the loop's delay of one and a half steps then
//! costs 15° of phase on any robot. With direct drives ω = 0.08/Ts = 40 rad/s: there encoders are the limit.
//!
//! What another law gave beyond the model when this one takes over (payload, dry friction) is given on, and fades while the
//! integral takes its place: so currents do not jump, and in motion there is nothing of it left.
//!
//! Until all axes are homed no posture is known: then feed-forward closes the loops.
//!
//! In csp the drives close the loops; those without a gear are given the model's torque as an offset, brought in
//! within half a second where something else held the arm before.

use super::Edp;
use crate::edp::axis::{Axis, float, per_mille, whole};
use crate::edp::servo::narrow;
use motion::{Angle, Setpoint};
use protocol::canopen::cia402::PowerState;
use protocol::message::ServoLaw;
use robots::dynamics::{MotorModel, STANDARD_GRAVITY, Wrench};
use robots::{AxisDescription, KinematicError, MotorMotion, Motors, Robot};

/// ω·Ts.
const BANDWIDTH_STEPS: f64 = 0.18;
/// The same with direct drives: at 0.18 one increment of crank 1 of the Polycrank in one step would be
/// 2ω/Ts·2π/increments·M = 40 N·m; at 0.08 it is less than half of that.
const DIRECT_BANDWIDTH_STEPS: f64 = 0.08;
/// The integral's pole is so much slower than the bandwidth.
const INTEGRAL_RATIO: f64 = 8.0;
/// Part of an axis' greatest velocity below which the compensation of dry friction fades out.
const COULOMB_BLEND: f64 = 0.002;

/// The time in which the model takes over from the integrals of drives that hold an arm, s: five times what these
/// take to give way, at 10 1/s.
const OFFSET_RAMP_S: f64 = 0.5;

/// In which the torque of another law fades, s: about as slowly as the integral rises.
const HELD_S: f32 = 0.1;

/// What the law needs of one motor.
#[derive(Clone, Copy, Debug, PartialEq)]
struct MotorData {
    /// N·m/mA.
    torque_per_ma: f32,
    /// N·m·s/rad.
    viscous: f32,
    /// N·m.
    coulomb: f32,
    /// rad/s.
    blend: f32,
    /// N·m.
    limit: f32,
}

impl MotorData {
    /// Torque against friction at a velocity, N·m.
    fn friction(&self, velocity: f32) -> f32 {
        let direction = velocity / (libm::fabsf(velocity) + self.blend);
        self.viscous * velocity + self.coulomb * direction
    }
}

/// The law of a whole robot, and its state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ComputedTorque<const N: usize> {
    /// In f32, of a robot that can have it so; else the model is computed in f64.
    model: Option<MotorModel<N>>,
    motors: [MotorData; N],
    /// Kp, Kv, Ki: 1/s², 1/s, 1/s³.
    gains: [f32; 3],
    ts: f32,
    /// ∫e dt, rad·s.
    integral: [f32; N],
    /// What is left of what another law gave beyond the model when this one took over, N·m.
    held: [f32; N],
    last_actual: Option<[i64; N]>,
    /// It gave the torque of the last step.
    running: bool,
}

/// One axis in one step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// Demand less actual motor angle, rad.
    pub error: f32,
    /// Actual position, drive units.
    pub units: i64,
    /// Rad of the motor in a drive unit.
    pub rad_per_unit: f32,
    /// Motor current that has held the axis, mA.
    pub current_ma: f32,
    /// The drive follows: without that nothing is integrated.
    pub follows: bool,
}

impl Measured {
    /// Of an axis that does not exist.
    const NOTHING: Self = Self {
        error: 0.0,
        units: 0,
        rad_per_unit: 0.0,
        current_ma: 0.0,
        follows: false,
    };
}

impl<const N: usize> ComputedTorque<N> {
    /// For a robot whose servo step is `ts` seconds; `None` if it has no chain.
    pub fn new<R: Robot<N>>(robot: &R, ts: f64) -> Option<Self> {
        let description = robot.description();
        let direct = description.axes.iter().any(AxisDescription::is_direct);
        let steps = if direct {
            DIRECT_BANDWIDTH_STEPS
        } else {
            BANDWIDTH_STEPS
        };
        let w = steps / ts;
        Some(Self {
            model: MotorModel::new(description, &robot.chain()?),
            motors: description.axes.each_ref().map(|axis| MotorData {
                torque_per_ma: narrow(1e-3 * axis.motor.torque_constant_nm_a),
                viscous: narrow(axis.motor.viscous_nms_rad),
                coulomb: narrow(axis.motor.coulomb_nm),
                blend: narrow(COULOMB_BLEND * axis.hard_limits.velocity),
                limit: narrow(
                    axis.current_regulator.limit_ma * 1e-3 * axis.motor.torque_constant_nm_a,
                ),
            }),
            gains: [w * w, 2.0 * w, w * w * w / INTEGRAL_RATIO].map(narrow),
            ts: narrow(ts),
            integral: [0.0; N],
            held: [0.0; N],
            last_actual: None,
            running: false,
        })
    }

    /// Torque comes on: the model alone is to hold the arm.
    pub const fn begin(&mut self) {
        self.integral = [0.0; N];
        self.held = [0.0; N];
        self.last_actual = None;
        self.running = true;
    }

    /// Another law closes the loops; what it gave last is where this one will go on.
    pub const fn leave(&mut self) {
        self.running = false;
    }

    /// One servo step: the motors' currents, mA. The integral of an axis stops while its current is
    /// saturated. The first step after another law, which is to be at rest, gives the currents measured.
    ///
    /// # Errors
    /// As [`Robot::joints`] and [`Robot::transmission`] of the demand: nothing inside its limits.
    pub fn step<R: Robot<N>>(
        &mut self,
        robot: &R,
        demand: &Setpoint<N>,
        measured: &[Measured; N],
    ) -> Result<[f32; N], KinematicError> {
        let [kp, kv, ki] = self.gains;
        let actual = measured.each_ref().map(|axis| axis.units);
        let takes_over = !self.running;
        if takes_over {
            self.begin();
        }
        let last = self.last_actual.replace(actual).unwrap_or(actual);
        let mut wanted = demand.acceleration;
        let rates = demand.velocity.iter().zip(last);
        for (((wanted, (demanded, last)), axis), integral) in wanted
            .iter_mut()
            .zip(rates)
            .zip(measured)
            .zip(self.integral)
        {
            let moved = float(axis.units.wrapping_sub(last)) * axis.rad_per_unit;
            let rate = demanded - moved / self.ts;
            *wanted += kv * rate + kp * axis.error + ki * integral;
        }
        let mut currents = self.torques(robot, demand, &wanted)?;
        if takes_over {
            let axes = self.held.iter_mut().zip(&self.motors).zip(measured);
            for (((held, motor), axis), torque) in axes.zip(&currents) {
                *held = motor.torque_per_ma * axis.current_ma - torque;
            }
        }
        let states = self.integral.iter_mut().zip(measured);
        for (((current, held), motor), (integral, measured)) in currents
            .iter_mut()
            .zip(&mut self.held)
            .zip(&self.motors)
            .zip(states)
        {
            let torque = *current + *held;
            *held -= *held * self.ts / HELD_S;
            let bounded = if torque > motor.limit {
                motor.limit
            } else if torque < -motor.limit {
                -motor.limit
            } else {
                if measured.follows {
                    *integral += measured.error * self.ts;
                }
                torque
            };
            *current = bounded / motor.torque_per_ma;
        }
        Ok(currents)
    }

    /// The torques of the motors that the demand takes, N·m, by the model alone.
    ///
    /// # Errors
    /// As [`Self::step`].
    pub fn model<R: Robot<N>>(
        &self,
        robot: &R,
        demand: &Setpoint<N>,
    ) -> Result<[f32; N], KinematicError> {
        self.torques(robot, demand, &demand.acceleration)
    }

    /// Torques of the motors, N·m, friction included, at the demand but with this acceleration, rad/s².
    fn torques<R: Robot<N>>(
        &self,
        robot: &R,
        demand: &Setpoint<N>,
        acceleration: &[f32; N],
    ) -> Result<[f32; N], KinematicError> {
        let quick = self
            .model
            .as_ref()
            .and_then(|model| model.torques(&demand.position, &demand.velocity, acceleration));
        let mut torques = match quick {
            Some(torques) => torques,
            None => exact_torques(robot, demand, acceleration)?,
        };
        for ((torque, motor), velocity) in torques.iter_mut().zip(&self.motors).zip(demand.velocity)
        {
            *torque += motor.friction(velocity);
        }
        Ok(torques)
    }
}

/// The same torques without friction in f64, of a robot that has legs, or near a dead centre.
#[inline(never)]
fn exact_torques<R: Robot<N>, const N: usize>(
    robot: &R,
    demand: &Setpoint<N>,
    acceleration: &[f32; N],
) -> Result<[f32; N], KinematicError> {
    let demand = exact(demand);
    let joints = robot.joints(&demand.position)?;
    let transmission = robot.transmission(&joints)?;
    let chain = robot.chain().ok_or(KinematicError::Unreachable)?;
    let torques = chain.at(&joints).motor_inverse_dynamics(
        &transmission,
        &demand.velocity,
        &acceleration.map(f64::from),
        &STANDARD_GRAVITY,
        &Wrench::NONE,
    );
    Ok(torques.map(narrow))
}

/// A set-point as the model in f64 takes it.
fn exact<const N: usize>(setpoint: &Setpoint<N>) -> MotorMotion<N> {
    MotorMotion {
        position: Motors(setpoint.position.map(Angle::to_f64)),
        velocity: setpoint.velocity.map(f64::from),
        acceleration: setpoint.acceleration.map(f64::from),
    }
}

impl<R: Robot<N> + Copy, const N: usize> Edp<R, N> {
    /// Is this law one this robot has?
    pub(super) const fn has(&self, law: ServoLaw) -> bool {
        match law {
            ServoLaw::ComputedTorque => self.computed.is_some(),
            ServoLaw::DrivePosition | ServoLaw::Original | ServoLaw::FeedForward => true,
        }
    }

    /// Currents, mA, of the robot's computed torques, where that law is in force and can be.
    pub(super) fn computed_currents(&mut self, demand: &Setpoint<N>) -> Option<[f32; N]> {
        let in_force = |axis: &Axis| axis.law() == ServoLaw::ComputedTorque;
        if !(self.axes.iter().any(in_force) && self.mode.torque() && self.homed()) {
            if let Some(computed) = &mut self.computed {
                computed.leave();
            }
            return None;
        }
        let measured = core::array::from_fn(|k| {
            let (Some(axis), Some(link), Some(angle)) = (
                self.axes.get(k),
                self.drives.links().get(k),
                demand.position.get(k),
            ) else {
                return Measured::NOTHING;
            };
            let rad_per_unit = axis.constants().rad_per_unit;
            Measured {
                error: float(axis.units(*angle).wrapping_sub(axis.actual())) * rad_per_unit,
                units: axis.actual(),
                rad_per_unit,
                current_ma: self.holding_ma(k),
                follows: link.state() == Some(PowerState::OperationEnabled),
            }
        });
        let computed = self.computed.as_mut()?;
        let currents = computed.step(&self.robot, demand, &measured).ok();
        if currents.is_none() {
            computed.leave();
        }
        currents
    }

    /// Torque offsets of the drives that have them mapped, ‰ of rated: in csp what the demand takes.
    pub(super) fn torque_offsets(&mut self, demand: &Setpoint<N>) -> [Option<i16>; N] {
        let in_csp = |axis: &Axis| axis.law() == ServoLaw::DrivePosition;
        let mapped = self.setup.torque_offset.iter().any(|mapped| *mapped);
        // drives confirm a change of mode one after the other
        if !mapped {
            return [None; N];
        }
        let wanted = self.mode.torque() && self.homed() && self.axes.iter().any(in_csp);
        let model = match &self.computed {
            Some(computed) if wanted => computed.model(&self.robot, demand).ok(),
            _ => None,
        };
        self.offset_share = match model {
            Some(_) if self.offset_share < 1.0 => {
                self.offset_share + narrow(self.setup.servo_step_s / OFFSET_RAMP_S)
            }
            Some(_) => 1.0,
            None => 0.0,
        };
        let torques = model.unwrap_or([0.0; N]);
        core::array::from_fn(|k| {
            let (axis, mapped) = (self.axes.get(k)?, *self.setup.torque_offset.get(k)?);
            let rated_mnm = whole(self.drives.links().get(k)?.rated_torque_mnm());
            let torque = if in_csp(axis) { *torques.get(k)? } else { 0.0 };
            mapped.then(|| per_mille(1e6 * self.offset_share * torque / rated_mnm))
        })
    }
}

#[cfg(test)]
mod test;
