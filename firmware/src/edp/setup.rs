//! From a robot's description and a node's configuration to everything the EDP computes with.

use crate::capacity::DRIVE_BUSES;
use crate::config::{ConfigError, DriveAddress, NodeConfig};
use crate::ecp::Limits;
use crate::ecp::generator::axis_move::MotorShare;
use crate::edp::axis::{AxisConstants, whole};
use crate::edp::drives::AxisSetup;
use crate::edp::envelopes::{PLAN_VELOCITY, envelopes, ranges};
use crate::edp::homing::HomingParameters;
use crate::edp::servo::{FeedForwardGains, OriginalGains, narrow};
use motion::angle::Ratio;
use motion::interpolator::{Braking, PathLimits, Range};
use motion::knot::EnvelopeError;
use motion::profile::AxisLimits;
use motion::{Angle, AxisEnvelope};
use protocol::canopen::cia402::Mode;
use protocol::canopen::fast::{Layout, Slot};
use protocol::canopen::node::NodeId as DriveId;
use protocol::message::ServoLaw;
use protocol::time::Micros;
use protocol::units::UNITS_PER_INCREMENT;
use robots::{AxisDescription, Robot, VelocityFactor};

/// What a generator plans with, as a fraction of that: interpolation between knots overshoots by
/// 0.0221·j·h² = 0.03 rad/s at the planning jerk and macrosteps of 20 ms.
const GENERATOR_VELOCITY: f64 = 0.99;

/// What the EDP goes on computing with.
#[derive(Clone, Debug)]
pub struct Constants<const N: usize> {
    /// Servo step, s.
    pub servo_step_s: f64,
    /// The same.
    pub period: Micros,
    /// Macrostep.
    pub macrostep: Micros,
    /// Homing.
    pub homing: [HomingParameters; N],
    /// Trip currents, mA.
    pub overcurrent_ma: [f32; N],
    /// The drive has a torque offset mapped.
    pub torque_offset: [bool; N],
    /// The servo law in force.
    pub law: ServoLaw,
    /// Where the motors may be, once homed.
    pub homed_ranges: [Range; N],
}

/// Everything an EDP is made of.
#[derive(Clone, Debug)]
pub struct EdpSetup<const N: usize> {
    /// What stays with it.
    pub constants: Constants<N>,
    /// Where the drives are.
    pub addresses: [DriveAddress; N],
    /// How the drives are configured.
    pub scripts: [AxisSetup; N],
    /// COB-ID of SYNC.
    pub sync_cob: u16,
    /// CANopen id of the node.
    pub master: DriveId,
    /// Constants of the loops.
    pub axes: [AxisConstants; N],
    /// How fast paths may be held and resumed, and axes stopped.
    pub braking: Braking<N>,
    /// Share of the motors' hard velocity that may be used.
    pub velocity_factor: f64,
}

impl<const N: usize> EdpSetup<N> {
    /// For a robot and a configuration; the configuration has been validated.
    pub fn new<R: Robot<N>>(robot: &R, config: &NodeConfig<N>) -> Self {
        let description = robot.description();
        let period = Micros(u64::from(description.servo_step_us));
        let factor = config.velocity_factor;
        let axes = description
            .axes
            .each_ref()
            .map(|axis| constants(axis, factor));
        let mode = match config.law {
            ServoLaw::DrivePosition => Mode::Csp,
            ServoLaw::Original | ServoLaw::FeedForward | ServoLaw::ComputedTorque => Mode::Cst,
        };
        let has_chain = robot.chain().is_some();
        let offset = |axis: &AxisDescription| has_chain && axis.is_direct();
        let mut setup = Self {
            constants: Constants {
                servo_step_s: period.as_secs_f64(),
                period,
                macrostep: Micros(period.0 * u64::from(description.macrostep)),
                homing: description.axes.each_ref().map(|axis| HomingParameters {
                    way: axis.homing,
                    travel_rad: axis.motor_position.upper - axis.motor_position.lower,
                    limits: AxisLimits {
                        v: axis.hard_limits.velocity * factor * PLAN_VELOCITY,
                        a: axis.planning_limits.acceleration,
                        j: axis.planning_limits.jerk,
                    },
                }),
                overcurrent_ma: description
                    .axes
                    .each_ref()
                    .map(|axis| whole(axis.overcurrent_ma)),
                torque_offset: description.axes.each_ref().map(offset),
                law: config.law,
                homed_ranges: ranges(description),
            },
            addresses: config.drives,
            scripts: description.axes.each_ref().map(|axis| AxisSetup {
                sync_cob: config.sync_cob,
                period,
                master: config.master.get(),
                following_window: saturate(
                    i64::from(axis.following_error_increments) * UNITS_PER_INCREMENT,
                ),
                quick_stop_deceleration: saturate_f64(
                    axis.hard_limits.acceleration * units_per_rad(axis),
                ),
                max_torque: 0,
                mode: mode.code(),
                torque_offset: offset(axis),
                slot: None,
                identity: None,
                find: config.find_drives,
                stored: config.stored_setup,
            }),
            sync_cob: config.sync_cob,
            master: config.master,
            axes,
            braking: Braking::new(&envelopes(description, factor, true)),
            velocity_factor: factor,
        };
        for (script, identity) in setup.scripts.iter_mut().zip(config.identities) {
            script.identity = identity;
        }
        if config.fast_drives {
            setup.with_slots()
        } else {
            setup
        }
    }

    /// A slot of the fast profile for every drive: its number on its bus.
    fn with_slots(mut self) -> Self {
        let mut used = [0_u8; DRIVE_BUSES];
        for (script, address) in self.scripts.iter_mut().zip(&self.addresses) {
            if let Some(used) = used.get_mut(usize::from(address.bus)) {
                *used = used.saturating_add(1);
                script.slot = Slot::new(*used);
            }
        }
        self
    }

    /// Can every drive speak the fast profile, if some do?
    fn validate_slots(&self) -> Result<(), ConfigError> {
        if self.scripts.iter().all(|script| script.slot.is_none()) {
            return Ok(());
        }
        let unfit = |script: &AxisSetup| {
            let layout = if script.torque_offset {
                Layout::Offsets
            } else {
                Layout::Targets
            };
            let fits = |slot: Slot| usize::from(slot.get()) <= layout.slots();
            !script.slot.is_some_and(fits)
        };
        match self.scripts.iter().position(unfit) {
            Some(axis) => Err(ConfigError::FastDrive {
                axis: u8::try_from(axis).unwrap_or(u8::MAX),
            }),
            None => Ok(()),
        }
    }

    /// There can be paths within the envelopes.
    ///
    /// # Errors
    /// [`ConfigError::NoRoomToStop`], [`ConfigError::FastDrive`].
    pub fn validate(&self, envelopes: [AxisEnvelope; N]) -> Result<(), ConfigError> {
        self.validate_slots()?;
        let Err(error) = PathLimits::new(envelopes) else {
            return Ok(());
        };
        let (EnvelopeError::Senseless { axis } | EnvelopeError::NoRoomToStop { axis, .. }) = error;
        Err(ConfigError::NoRoomToStop {
            axis: u8::try_from(axis).unwrap_or(u8::MAX),
        })
    }

    /// What the ECP's generators may plan with.
    pub fn generator_limits<R: Robot<N>>(robot: &R, factor: f64) -> Limits<N> {
        let description = robot.description();
        let share = PLAN_VELOCITY * GENERATOR_VELOCITY;
        let motors = description.axes.each_ref().map(|axis| {
            let (hard, plan) = (axis.hard_limits.velocity * factor, axis.planning_limits);
            let v = if plan.velocity < hard {
                plan.velocity
            } else {
                hard
            };
            AxisLimits {
                v: v * share,
                a: plan.acceleration,
                j: plan.jerk,
            }
        });
        let factor = VelocityFactor::new(factor).unwrap_or_default();
        // what the robot's own planning share leaves of the hard velocity, brought down to ours
        let velocity = share / robots::VELOCITY_SHARE;
        let joints_anywhere = robot.joint_limits_for_planning(factor).map(|l| AxisLimits {
            v: l.v * velocity,
            a: l.a,
            j: l.j,
        });
        let joints = description.axes.each_ref().map(|axis| {
            let bend = axis.planning_limits.jerk / axis.planning_limits.acceleration;
            AxisLimits {
                v: axis.joint_velocity,
                a: axis.joint_acceleration,
                j: axis.joint_acceleration * bend,
            }
        });
        Limits {
            motors,
            joints,
            joints_anywhere,
            motor_share: MotorShare { factor, velocity },
            cartesian_velocity: description.cartesian_velocity,
            cartesian_acceleration: description.cartesian_acceleration,
        }
    }
}

fn units_per_rad(axis: &AxisDescription) -> f64 {
    #[expect(clippy::cast_precision_loss, reason = "1000")]
    let per_increment = UNITS_PER_INCREMENT as f64;
    f64::from(axis.increments_per_turn) * per_increment / core::f64::consts::TAU
}

fn constants(axis: &AxisDescription, factor: f64) -> AxisConstants {
    let (pwm, current) = (axis.pwm_regulator, axis.current_regulator);
    AxisConstants {
        units_per_rad: units_per_rad(axis),
        units_per_quantum: Ratio::nearest(units_per_rad(axis) * Angle::of_quanta(1).to_f64()),
        rad_per_unit: narrow(1.0 / units_per_rad(axis)),
        torque_constant: narrow(axis.motor.torque_constant_nm_a),
        original: OriginalGains {
            epsilon: narrow(pwm.epsilon),
            a: narrow(pwm.a),
            b0: narrow(pwm.b0),
            b1: narrow(pwm.b1),
            u_max: narrow(pwm.limit),
            ma_per_count: narrow(current.gain_ma),
        },
        feed_forward: FeedForwardGains::design(axis),
        following_window: whole(saturate(
            i64::from(axis.following_error_increments) * UNITS_PER_INCREMENT,
        )),
        window_at_rest: super::axis::at_rest(
            i64::from(axis.following_error_increments) * UNITS_PER_INCREMENT,
        ),
        full_speed: narrow(axis.hard_limits.velocity * factor),
        jump_units: i64::from(axis.max_increments_per_step) * UNITS_PER_INCREMENT,
    }
}

fn saturate(value: i64) -> u32 {
    u32::try_from(value).unwrap_or(u32::MAX)
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "saturates"
)]
fn saturate_f64(value: f64) -> u32 {
    value as u32
}

#[cfg(test)]
mod test {
    use super::*;
    use crate::process::Station;
    use protocol::transfer::Mtu;
    use robots::{Irp6Postument, Polycrank, TrackRule};

    fn setup<R: Robot<N>, const N: usize>(robot: &R) -> EdpSetup<N> {
        let station = Station {
            effector: 1,
            unique_id: 1,
            mtu: Mtu::Fd,
            law: ServoLaw::DrivePosition,
            velocity_factor: 0.2,
            one_wire: false,
            track: TrackRule::Keep,
        };
        let buses = robot.description().drive_buses();
        let mut config = station.config(buses).unwrap();
        config.fast_drives = true;
        EdpSetup::new(robot, &config)
    }

    /// What becomes of it with the third axis in this slot.
    fn slot<const N: usize>(mut setup: EdpSetup<N>, number: u8) -> Result<(), ConfigError> {
        setup.scripts[2].slot = Slot::new(number);
        setup.validate_slots()
    }

    #[test]
    fn the_fast_profile_has_fifteen_drives_a_bus_and_ten_with_an_offset() {
        let refused = Err(ConfigError::FastDrive { axis: 2 });
        let geared = setup(&Irp6Postument);
        assert!(geared.scripts.iter().all(|script| !script.torque_offset));
        let direct = setup(&Polycrank);
        assert!(direct.scripts.iter().any(|script| script.torque_offset));
        let results = [10, 11, 15, 16].map(|n| (slot(geared.clone(), n), slot(direct.clone(), n)));
        assert_eq!(
            results,
            [
                (Ok(()), Ok(())),
                (Ok(()), refused),
                (Ok(()), refused),
                (refused, refused)
            ]
        );
    }
}
