//! What the drives of an arm without gears are tuned for.
//!
//! Behind a gear a motor feels mostly itself. Without one it feels the arm: the least inertia where the other axes
//! give way, 1/(M⁻¹)ₖₖ, the most where they are held and the arm carries its payload, Mₖₖ. Loops of one axis are tuned
//! for the geometric mean of the two, Jₖ, which leaves the same margin to either side.
//!
//! All together they are as stable as one axis that is λ times as easy to turn as what it is tuned for, for every
//! eigenvalue λ of D·M⁻¹·D, D² = diag(J), since the loops are the same but for Jₖ: over the postures and up to the
//! payload λ goes from 1/18 to 10.

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
        libm::sqrt(self.least * self.most)
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
            let free = 1.0 / inverse[(k, k)];
            let held = full[(k, k)] + axis.motor.rotor_kg_m2;
            if free < inertia.least {
                inertia.least = free;
            }
            if held > inertia.most {
                inertia.most = held;
            }
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

    fn larger(a: f64, b: f64) -> f64 {
        if b > a { b } else { a }
    }

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
            most = larger(most, angle.abs());
            if step > 4000 {
                late = larger(late, angle.abs());
            }
        }
        [most, late / increment]
    }

    /// The least and the greatest λ of a chain over its postures.
    fn eigenvalues(chain: &Chain<7>, tuned: &[f64; 7]) -> [f64; 2] {
        let mut random = SplitMix64::stream(2, "postures", 0);
        let mut range = [f64::INFINITY, 0.0];
        for _ in 0..3000 {
            let joints = Joints(core::array::from_fn(|_| random.between(-PI, PI)));
            let mut mass = chain.at(&joints).mass_matrix();
            for (k, axis) in Polycrank.description().axes.iter().enumerate() {
                mass[(k, k)] += axis.motor.rotor_kg_m2;
            }
            for row in 0..7 {
                for column in 0..7 {
                    mass[(row, column)] /= libm::sqrt(tuned[row] * tuned[column]);
                }
            }
            for inertia in &mass.symmetric_eigenvalues() {
                let [least, most] = range;
                range = [-larger(-least, -1.0 / inertia), larger(most, 1.0 / inertia)];
            }
        }
        range
    }

    #[test]
    fn the_loops_of_direct_drives_bear_the_arm_in_every_posture() {
        let chain = Polycrank.chain().unwrap();
        let tuned = inertias(Polycrank.description(), &chain).map(Inertia::tuned);
        let [_, most] = eigenvalues(&chain, &tuned);
        let [least, _] = eigenvalues(&chain.with_payload(&payload()), &tuned);
        assert!(
            (0.05..0.07).contains(&least) && (8.0..10.5).contains(&most),
            "{least} {most}"
        );
        let robot = robot(RobotKind::Polycrank, 1);
        for (setup, tuned) in robot.axes.iter().zip(tuned) {
            assert!((setup.drive.inertia_kg_m2 / tuned - 1.0).abs() < 1e-12);
            // a third more to the light side, where the delays are; the heavy side decays slowly
            for (times, left_most) in [
                (1.35 * most, 3.0),
                (1.0, 3.0),
                (0.1, 6.0),
                (0.9 * least, 200.0),
            ] {
                let [most, left] = response(setup, tuned / times);
                // position and integral give way together: torque/(J·v·(p + i)), twice that where it swings
                let p = setup.drive;
                let stiffness =
                    tuned * p.velocity_bandwidth * (p.position_bandwidth + p.velocity_integral);
                let peak_nm = setup.plant.torque_constant_nm_a * setup.plant.current_limit_a / 1.25;
                let share = most * stiffness / (0.1 * peak_nm);
                assert!(
                    (0.5..2.5).contains(&share),
                    "{} at {times}: {share}",
                    setup.name
                );
                // a limit cycle of an increment or two, and nothing else
                assert!(left <= left_most, "{} at {times}: {left}", setup.name);
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
                used[k] = larger(used[k], torque / peak);
            }
        }
        // all but the roll, which is light, are chosen by this
        assert!(used.iter().all(|part| *part < 0.95), "{used:?}");
        assert!(used[..6].iter().all(|part| *part > 0.3), "{used:?}");
    }
}
