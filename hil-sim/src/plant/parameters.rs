//! The numbers of the IRp-6 robots, referred to the motor shafts.
//!
//! Sources: *MRROC++* is the public mirror of the original controller (`irp6ot_m`, `irp6p_m`);
//! *IRP* is its OROCOS successor of the same laboratory (`irp6_robot`, launch files of 2017).
//! ASSUMED numbers are invented and plausible: nobody published them.

use core::f64::consts::TAU;

use super::axis::PlantParameters;
use super::gravity::{GravityModel, Irp6Arm, Masses};
use super::random::SplitMix64;
use crate::drive::parameters::DriveParameters;

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
    /// What weighs on them.
    pub gravity: Box<dyn GravityModel + Send>,
}

impl core::fmt::Debug for RobotSetup {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("RobotSetup")
            .field("axes", &self.axes)
            .finish_non_exhaustive()
    }
}

/// What differs between the axes.
#[derive(Clone, Copy, Debug)]
struct Axis {
    name: &'static str,
    /// Rotor inertia, kg·m² (IRP `hw_model`).
    rotor: f64,
    /// Reflected load, kg·m²: ASSUMED, from the ASSUMED masses over the squared gear.
    load: f64,
    /// Viscous friction, N·m·s/rad (IRP `hw_model`).
    viscous: f64,
    /// Coulomb friction, N·m: ASSUMED.
    coulomb: f64,
    /// Greatest current of the regulator, A (IRP launch files); the drive's peak current.
    peak_a: f64,
    /// Encoder increments per motor turn (MRROC++).
    increments: u32,
    /// Motor limits, rad (MRROC++).
    limits: [f64; 2],
}

/// Torque per current of every motor, N·m/A (IRP).
pub const TORQUE_CONSTANT_NM_A: f64 = 0.105;

const TRACK: Axis = Axis {
    name: "track",
    rotor: 1.5e-4,
    load: 1.0e-4,
    viscous: 0.02,
    coulomb: 0.02,
    peak_a: 20.0,
    increments: 4000,
    limits: [-200.0, 1900.0],
};
const COLUMN: Axis = Axis {
    name: "column",
    load: 2.0e-4,
    limits: [-470.0, 450.0],
    ..TRACK
};
const LOWER: Axis = Axis {
    name: "lower arm",
    load: 1.4e-4,
    peak_a: 15.0,
    limits: [-110.0, 100.0],
    ..TRACK
};
const UPPER: Axis = Axis {
    name: "upper arm",
    load: 1.0e-4,
    limits: [-80.0, 100.0],
    ..LOWER
};
const PITCH: Axis = Axis {
    name: "wrist T",
    load: 1.0e-5,
    limits: [-70.0, 380.0],
    ..LOWER
};
const ROLL: Axis = Axis {
    name: "wrist V",
    rotor: 1.5e-5,
    // Hand, gripper and work-piece, 0.18 kg·m² about the wrist. With half of it MRROC++'s gain for
    // this axis would oscillate behind the bus: a test shows both.
    load: 3.0e-5,
    viscous: 2.0e-4,
    coulomb: 0.01,
    peak_a: 8.0,
    increments: 4000,
    limits: [-80.0, 490.0],
};
const HAND: Axis = Axis {
    name: "wrist N",
    load: 2.0e-7,
    coulomb: 0.005,
    peak_a: 1.0,
    increments: 2000,
    limits: [-1000.0, 3000.0],
    ..ROLL
};

/// Motor angle below which the home switch is active, rad. ASSUMED: MRROC++ says only that the
/// index at 0 follows when the axis backs off in positive direction, less than a turn away.
const SWITCH_RAD: f64 = -2.0;

/// The range of motor angles at power-up, rad. ASSUMED.
const START_RAD: [f64; 2] = [5.0, 40.0];

impl Axis {
    fn setup(self, bus: u8, node: u8, seed: u64) -> AxisSetup {
        let inertia = self.rotor + self.load;
        let [low, high] = self.limits;
        let mut start = SplitMix64::stream(seed, "start angle", u64::from(node));
        let plant = PlantParameters {
            torque_constant_nm_a: TORQUE_CONSTANT_NM_A,
            inertia_kg_m2: inertia,
            viscous_nms_rad: self.viscous,
            coulomb_nm: self.coulomb,
            // ASSUMED: a holding brake is chosen for the motor's peak torque.
            brake_nm: 1.5 * self.peak_a * TORQUE_CONSTANT_NM_A,
            // ASSUMED: a quarter above the regulator's clamp.
            current_limit_a: 1.25 * self.peak_a,
            // ASSUMED: a 500 Hz current loop.
            current_time_s: 0.000_3,
            increments_per_turn: self.increments,
            switch_rad: SWITCH_RAD,
            // ASSUMED: a cam and a micro-switch.
            switch_hysteresis_rad: 0.05,
            bounce_s: 0.0015,
            // ASSUMED: limit switches two, stops ten motor rad beyond the software limits.
            limit_rad: [low - 2.0, high + 2.0],
            stop_rad: [low - 10.0, high + 10.0],
            brake_open_s: 0.020,
            brake_close_s: 0.030,
        };
        let drive = DriveParameters::new(
            self.increments,
            self.peak_a,
            TORQUE_CONSTANT_NM_A,
            inertia,
            u32::from(node),
        );
        let [first, last] = START_RAD;
        let start_rad = start.between(first, last);
        AxisSetup {
            name: self.name,
            bus,
            node,
            plant,
            drive,
            start_rad,
        }
    }
}

/// The IRp-6 on the track: drives 1 to 4 on bus 0, 5 to 7 on bus 1.
///
/// Seven axes at 500 Hz do not fit one classical 1 Mbit/s bus.
#[must_use]
pub fn irp6_track(seed: u64) -> RobotSetup {
    let axes = [TRACK, COLUMN, LOWER, UPPER, PITCH, ROLL, HAND];
    let places = [(0, 1), (0, 2), (0, 3), (0, 4), (1, 5), (1, 6), (1, 7)];
    let axes = axes.into_iter().zip(places);
    RobotSetup {
        axes: axes
            .map(|(axis, (bus, node))| axis.setup(bus, node, seed))
            .collect(),
        gravity: Box::new(Irp6Arm::track(Masses::ASSUMED)),
    }
}

/// The IRp-6 on the postument: drives 1 to 6 on bus 0.
#[must_use]
pub fn irp6_postument(seed: u64) -> RobotSetup {
    let axes = [COLUMN, LOWER, UPPER, PITCH, ROLL, HAND];
    let axes = axes.into_iter().zip(1..);
    RobotSetup {
        axes: axes.map(|(axis, node)| axis.setup(0, node, seed)).collect(),
        gravity: Box::new(Irp6Arm::postument(Masses::ASSUMED)),
    }
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
        assert_eq!(
            names,
            [
                "column",
                "lower arm",
                "upper arm",
                "wrist T",
                "wrist V",
                "wrist N"
            ]
        );
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
