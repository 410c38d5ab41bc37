//! What the drives of an arm without gears are tuned for.
//!
//! Behind a gear a motor feels mostly itself. Without one it feels the arm: the least inertia where the other axes
//! give way, 1/(M⁻¹)ₖₖ, the most where they are held and the arm carries its payload, Mₖₖ. Loops of one axis are tuned
//! for the geometric mean of the two, which leaves the same margin to either side.

use super::random::SplitMix64;
use core::f64::consts::PI;
use robots::dynamics::{Body, Chain, Shape};
use robots::{Joints, RobotDescription};

/// Postures looked at.
const POSTURES: u32 = 400;

/// ASSUMED: the greatest payload of an arm without gears, kg, and the edge of the cube it is, m.
pub(crate) const PAYLOAD_KG: f64 = 2.0;
const PAYLOAD_M: f64 = 0.1;

/// The inertia a motor may feel, kg·m².
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Inertia {
    pub(crate) least: f64,
    pub(crate) most: f64,
}

impl Inertia {
    /// What its loops are tuned for, kg·m².
    pub(crate) fn tuned(self) -> f64 {
        (self.least * self.most).sqrt()
    }
}

/// A payload at the flange.
pub(crate) fn payload() -> Body {
    let shape = Shape::Box {
        centre: [0.0, 0.0, 0.048 + 0.5 * PAYLOAD_M],
        size: [PAYLOAD_M; 3],
    };
    Body::homogeneous(PAYLOAD_KG, &shape)
}

/// What the motors of a chain without gears feel over its postures.
pub(crate) fn inertias<const N: usize>(
    description: &RobotDescription<N>,
    chain: &Chain<N>,
) -> [Inertia; N] {
    let loaded = chain.with_payload(&payload());
    let mut random = SplitMix64::stream(0, "commissioning", 0);
    let mut out = [Inertia {
        least: f64::INFINITY,
        most: 0.0,
    }; N];
    for _ in 0..POSTURES {
        let joints = Joints(core::array::from_fn(|_| random.between(-PI, PI)));
        let mut empty = chain.at(&joints).mass_matrix();
        let full = loaded.at(&joints).mass_matrix();
        for (k, axis) in description.axes.iter().enumerate() {
            empty[(k, k)] += axis.motor.rotor_kg_m2;
        }
        let Some(inverse) = empty.try_inverse() else {
            continue; // not of a chain with rotors: M is positive definite
        };
        for (k, (inertia, axis)) in out.iter_mut().zip(&description.axes).enumerate() {
            inertia.least = inertia.least.min(1.0 / inverse[(k, k)]);
            inertia.most = inertia.most.max(full[(k, k)] + axis.motor.rotor_kg_m2);
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drive::parameters::DriveParameters;
    use crate::drive::servo::{Offset, Servo};
    use crate::plant::parameters::{AxisSetup, robot};
    use core::f64::consts::TAU;
    use robots::{Polycrank, Robot, RobotKind};

    /// A tenth of the peak torque comes upon a standing axis: the greatest error, and what is left of it after a
    /// second, rad.
    fn response(setup: &AxisSetup, inertia_kg_m2: f64) -> [f64; 2] {
        const DT_S: f64 = 0.000_25;
        let plant = setup.plant;
        let peak_nm = plant.torque_constant_nm_a * plant.current_limit_a / 1.25;
        let lag = 1.0 - libm::exp(-DT_S / plant.current_time_s);
        let increment = TAU / f64::from(plant.increments_per_turn);
        let mut servo = Servo::new(setup.drive, DT_S);
        servo.rest_at(0.0);
        servo.jog(0.0, 1.0);
        let (mut angle, mut rate, mut torque) = (0.0_f64, 0.0, 0.0);
        let (mut most, mut late) = (0.0_f64, 0.0_f64);
        for step in 0..6000 {
            let measured = libm::floor(angle / increment) * increment;
            let wanted = servo.step(measured, Offset::default(), peak_nm);
            torque += (wanted - torque) * lag;
            let acceleration = (torque - 0.1 * peak_nm) / inertia_kg_m2;
            angle += DT_S * (rate + 0.5 * DT_S * acceleration);
            rate += DT_S * acceleration;
            most = most.max(angle.abs());
            if step > 4000 {
                late = late.max(angle.abs());
            }
        }
        [most, late / increment]
    }

    #[test]
    fn the_loops_of_direct_drives_bear_every_inertia_they_meet() {
        let description = Polycrank.description();
        let inertias = inertias(description, &Polycrank.chain().unwrap());
        for (setup, met) in robot(RobotKind::Polycrank, 1).axes.iter().zip(inertias) {
            // and half as much again to either side
            for inertia in [
                met.least / 1.5,
                met.least,
                met.tuned(),
                met.most,
                1.5 * met.most,
            ] {
                let [most, left] = response(setup, inertia);
                // τ/(J·v·(p + i)) as long as position and integral give way together: 0.01·τ/J
                let stiffness = setup.drive.inertia_kg_m2 * 200.0 * 50.0;
                let peak_nm = setup.plant.torque_constant_nm_a * setup.plant.current_limit_a / 1.25;
                let share = most * stiffness / (0.1 * peak_nm);
                assert!((0.5..2.0).contains(&share), "{}: {share}", setup.name);
                // a limit cycle of the encoder's increments, and nothing else
                assert!(left <= 5.0, "{} with {inertia} kg·m²: {left}", setup.name);
            }
        }
    }

    #[test]
    fn the_spread_of_inertias_is_that_of_the_arm() {
        let found = inertias(Polycrank.description(), &Polycrank.chain().unwrap());
        // crank 6 turns 1.5 kg near its axis, or 2 kg more 0.15 m away; a payload beyond crank 1 counts most
        let ratio = found.map(|inertia| inertia.most / inertia.least);
        assert!(
            ratio[..3].iter().all(|r| (10.0..35.0).contains(r)),
            "{ratio:?}"
        );
        assert!(
            (8.0..14.0).contains(&ratio[5]) && (1.5..4.0).contains(&ratio[6]),
            "{ratio:?}"
        );
        let unloaded: &DriveParameters = &robot(RobotKind::Polycrank, 1).axes[0].drive;
        assert!(unloaded.inertia_kg_m2 > found[0].least && unloaded.inertia_kg_m2 < found[0].most);
    }

    #[test]
    fn peak_torques_hold_the_payload_and_accelerate() {
        let (description, chain) = (Polycrank.description(), Polycrank.chain().unwrap());
        let loaded = chain.with_payload(&payload());
        let mut random = SplitMix64::stream(1, "postures", 0);
        let mut used = [0.0_f64; 7];
        for _ in 0..2000 {
            let joints = Joints(core::array::from_fn(|_| random.between(-PI, PI)));
            let posture = loaded.at(&joints);
            let weight = posture.gravity_torques(&robots::dynamics::STANDARD_GRAVITY);
            let mass = posture.mass_matrix();
            for (k, axis) in description.axes.iter().enumerate() {
                let inertia = mass[(k, k)] + axis.motor.rotor_kg_m2;
                let torque = weight[k].abs() + inertia * axis.planning_limits.acceleration;
                let peak = axis.current_regulator.limit_ma * 1e-3 * axis.motor.torque_constant_nm_a;
                used[k] = used[k].max(torque / peak);
            }
        }
        // all but the roll, which is light, are chosen by this
        assert!(used.iter().all(|part| *part < 0.95), "{used:?}");
        assert!(used[..6].iter().all(|part| *part > 0.3), "{used:?}");
    }
}
