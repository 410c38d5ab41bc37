//! The simulated robots, referred to the motor shafts: what the robots' descriptions say, and
//! what the world adds to it.
//!
//! ASSUMED numbers are invented and plausible: nobody published them.

use core::f64::consts::TAU;

use super::axis::PlantParameters;
use super::commissioning::{Inertia, inertias};
use super::mechanics::{Apart, Mechanics};
use super::motor::Winding;
use super::random::SplitMix64;
use super::rigid_body::RigidBody;
use crate::drive::parameters::DriveParameters;
use robots::{AxisDescription, AxisHoming, Range, Robot, RobotKind, RobotVisitor, TrackRule};

/// One axis of a robot: where it hangs and what it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisSetup {
    /// Its name.
    pub name: &'static str,
    /// The robot's drive bus it hangs on, from 0.
    pub bus: u8,
    /// CANopen node identifier, 1 to 127.
    pub node: u8,
    /// Motor and load.
    pub plant: PlantParameters,
    /// Drive.
    pub drive: DriveParameters,
    /// True motor angle at power-up, rad: within the travel and above the home switch.
    pub start_rad: f64,
}

/// One robot.
pub struct RobotSetup {
    /// The axes, in the robot's order.
    pub axes: Vec<AxisSetup>,
    /// How they move together.
    pub mechanics: Box<dyn Mechanics>,
}

impl core::fmt::Debug for RobotSetup {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("RobotSetup")
            .field("axes", &self.axes)
            .finish_non_exhaustive()
    }
}

/// Motor angle below which the home switch is active, rad. ASSUMED: MRROC++ says only that the
/// index at 0 follows when the axis backs off in positive direction, less than a turn away.
const SWITCH_RAD: f64 = -2.0;

/// The range of motor angles at power-up, rad. ASSUMED.
const START_RAD: [f64; 2] = [5.0, 40.0];

/// An encoder of fewer increments a turn is coarse: at the usual bandwidths one increment would take
/// more torque than there is. ASSUMED: commissioning then takes a quarter of them.
const COARSE_INCREMENTS: u32 = 1000;
const COARSE: f64 = 0.25;

/// Bandwidths of position, velocity and observer and integral of a drive without a gear, 1/s. ASSUMED: with the inertia
/// r times the one the loop is tuned for, P and PI stay stable where r < velocity·(position + integral)/
/// (position·integral) = 21, and the delays allow a fifteenth of it: what an arm needs, see `plant::commissioning`.
const DIRECT_POSITION: f64 = 25.0;
const DIRECT_VELOCITY: f64 = 150.0;
const DIRECT_INTEGRAL: f64 = 10.0;
const DIRECT_OBSERVER: f64 = 1600.0;

/// Turns a minute of a velocity, rad/s, to the nearest.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "saturates, and the value is positive"
)]
fn rpm(rad_s: f64) -> u32 {
    (rad_s * 60.0 / TAU + 0.5) as u32
}

/// The peak current of a drive, A: that of the regulator's clamp.
fn peak_a(axis: &AxisDescription) -> f64 {
    axis.current_regulator.limit_ma * 1e-3
}

/// The windings of the arms' motors. MRROC++ (`hi_moxa.h`): 48 V. ASSUMED: 1 Ω, with which its regulators are stable
/// on every axis (2 Ω is not), an electrical time constant of 1 ms, and the heat of a servo motor of some
/// 200 W: 32 s for the winding and 22 min for the housing, which at rated current (a quarter of the peak) ends at
/// 95 K above the air; insulation of class F with 20 K in hand.
const ARM_WINDING: Winding = Winding {
    resistance_ohm: 1.0,
    inductance_h: 0.001,
    supply_v: 48.0,
    winding_j_k: 40.0,
    housing_j_k: 600.0,
    winding_housing_k_w: 0.8,
    housing_air_k_w: 2.2,
    air_c: 20.0,
    trip_c: 135.0,
};

/// What is known of a robot's windings: those of the others nobody published, and nothing about them can be
/// concluded from their regulators.
const fn winding(kind: RobotKind) -> Option<Winding> {
    match kind {
        RobotKind::Irp6Track | RobotKind::Irp6Postument | RobotKind::Irp6Arm => Some(ARM_WINDING),
        RobotKind::Polycrank
        | RobotKind::Conveyor
        | RobotKind::Irp6TrackGripper
        | RobotKind::Irp6PostumentGripper
        | RobotKind::Rnt => None,
    }
}

/// An axis whose drive is tuned for `tuned_kg_m2`, or for rotor and load.
fn axis(
    kind: RobotKind,
    description: &AxisDescription,
    tuned_kg_m2: Option<f64>,
    bus: u8,
    node: u8,
    seed: u64,
) -> AxisSetup {
    let motor = description.motor;
    let inertia = motor.rotor_kg_m2 + motor.load_kg_m2;
    let Range {
        lower: low,
        upper: high,
    } = description.motor_position;
    let peak_a = peak_a(description);
    let mut start = SplitMix64::stream(seed, "start angle", u64::from(node));
    let plant = PlantParameters {
        torque_constant_nm_a: motor.torque_constant_nm_a,
        inertia_kg_m2: inertia,
        viscous_nms_rad: motor.viscous_nms_rad,
        coulomb_nm: motor.coulomb_nm,
        // nobody knows more of their friction
        stiction_nm: 0.0,
        stribeck_rad_s: 1.0,
        // ASSUMED: a holding brake is chosen for the motor's peak torque.
        brake_nm: 1.5 * peak_a * motor.torque_constant_nm_a,
        // ASSUMED: a quarter above the regulator's clamp.
        current_limit_a: 1.25 * peak_a,
        // ASSUMED: a 500 Hz current loop.
        current_time_s: 0.000_3,
        winding: winding(kind),
        increments_per_turn: description.increments_per_turn,
        // ASSUMED: gated.
        index_increments: 1,
        absolute: description.homing == AxisHoming::Absolute,
        switch_rad: match description.homing {
            AxisHoming::Switch { .. } => SWITCH_RAD,
            AxisHoming::InPlace | AxisHoming::Absolute => f64::NEG_INFINITY,
        },
        // ASSUMED: a cam and a micro-switch.
        switch_hysteresis_rad: 0.05,
        bounce_s: 0.0015,
        // ASSUMED: limit switches two, stops ten motor rad beyond the software limits.
        limit_rad: [low - 2.0, high + 2.0],
        stop_rad: [low - 10.0, high + 10.0],
        brake_open_s: 0.020,
        brake_close_s: 0.030,
    };
    let drive = DriveParameters {
        max_speed_rpm: rpm(description.hard_limits.velocity),
        ..DriveParameters::new(
            description.increments_per_turn,
            peak_a,
            motor.torque_constant_nm_a,
            tuned_kg_m2.unwrap_or(inertia),
            u32::from(node),
        )
    };
    let drive = if description.increments_per_turn < COARSE_INCREMENTS {
        DriveParameters {
            position_bandwidth: COARSE * drive.position_bandwidth,
            velocity_bandwidth: COARSE * drive.velocity_bandwidth,
            velocity_integral: COARSE * drive.velocity_integral,
            observer_bandwidth: COARSE * drive.observer_bandwidth,
            ..drive
        }
    } else {
        drive
    };
    let drive = if description.is_direct() {
        DriveParameters {
            position_bandwidth: DIRECT_POSITION,
            velocity_bandwidth: DIRECT_VELOCITY,
            velocity_integral: DIRECT_INTEGRAL,
            observer_bandwidth: DIRECT_OBSERVER,
            ..drive
        }
    } else {
        drive
    };
    let [first, last] = START_RAD;
    let start_rad = start.between(first, last);
    AxisSetup {
        name: description.name,
        bus,
        node,
        plant,
        drive,
        start_rad,
    }
}

/// A robot of this kind; its drives are numbered from 1 in the order of the axes, on the buses of
/// [`firmware::process::drive_buses`]. A robot with a chain moves as its rigid bodies do, the others'
/// axes each on its own.
#[must_use]
pub fn robot(kind: RobotKind, seed: u64) -> RobotSetup {
    kind.visit(TrackRule::Keep, Setup { kind, seed })
}

struct Setup {
    kind: RobotKind,
    seed: u64,
}

impl RobotVisitor for Setup {
    type Output = RobotSetup;

    fn visit<R, const N: usize>(self, robot: R) -> RobotSetup
    where
        R: Robot<N> + Send + 'static,
    {
        let description = robot.description();
        let direct = description.axes.iter().any(AxisDescription::is_direct);
        let chain = robot.chain().filter(|_| direct);
        let tuned = chain.map(|chain| inertias(description, &chain).map(Inertia::tuned));
        let axes = description
            .axes
            .iter()
            .zip(description.drive_buses())
            .enumerate()
            .zip(1_u8..)
            .map(|((k, (description, bus)), node)| {
                axis(
                    self.kind,
                    description,
                    tuned.map(|tuned| tuned[k]),
                    bus,
                    node,
                    self.seed,
                )
            })
            .collect();
        let mechanics: Box<dyn Mechanics> = match RigidBody::new(robot) {
            Some(body) => Box::new(body),
            None => Box::new(Apart),
        };
        RobotSetup { axes, mechanics }
    }
}

/// The IRp-6 on the track: drives 1 to 4 on bus 0, 5 to 7 on bus 1.
#[must_use]
pub fn irp6_track(seed: u64) -> RobotSetup {
    robot(RobotKind::Irp6Track, seed)
}

/// The IRp-6 on the postument: drives 1 to 6 on bus 0.
#[must_use]
pub fn irp6_postument(seed: u64) -> RobotSetup {
    robot(RobotKind::Irp6Postument, seed)
}

/// Drive units per motor radian of an axis with `increments` a turn.
#[must_use]
pub fn units_per_rad(increments: u32) -> f64 {
    #[expect(clippy::cast_precision_loss, reason = "a small constant")]
    let units = protocol::units::UNITS_PER_INCREMENT as f64;
    f64::from(increments) * units / TAU
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn robots_have_their_axes_on_their_buses() {
        let track = irp6_track(1);
        let places: Vec<_> = track
            .axes
            .iter()
            .map(|axis| (axis.bus, axis.node))
            .collect();
        assert_eq!(
            places,
            [(0, 1), (0, 2), (0, 3), (0, 4), (1, 5), (1, 6), (1, 7)]
        );
        let names: Vec<_> = irp6_postument(1)
            .axes
            .iter()
            .map(|axis| axis.name)
            .collect();
        assert_eq!(names, ["column", "lower arm", "upper arm", "T", "V", "N"]);
    }

    #[test]
    fn axes_start_within_the_travel_above_the_switch_and_by_the_seed() {
        for seed in 0..20 {
            for axis in irp6_track(seed).axes {
                assert!((5.0..40.0).contains(&axis.start_rad));
                assert!(axis.start_rad < axis.plant.limit_rad[1]);
                assert!(axis.start_rad > axis.plant.switch_rad);
            }
        }
        let start = |seed| {
            irp6_track(seed)
                .axes
                .iter()
                .map(|a| a.start_rad)
                .collect::<Vec<_>>()
        };
        assert_eq!(start(3), start(3));
        assert_ne!(start(3), start(4));
    }
}
