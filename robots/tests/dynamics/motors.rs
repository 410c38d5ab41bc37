//! What the motors see of the joints' dynamics: the IRp-6's parallelograms, screws and bevel.

use nalgebra::{SMatrix, SVector, Vector3};
use proptest::prelude::*;
use robots::dynamics::{IRP6_POSTUMENT, IRP6_TRACK, STANDARD_GRAVITY, Wrench, joints_by_motors};
use robots::{
    Irp6Postument, Irp6Track, Joints, KinematicError, MotorMotion, Quantity, Rnt, Robot, RobotKind,
    RobotVisitor, TrackRule,
};

use super::{apart, numbers};

/// Inside the range of the joints, by numbers in −1 … 1; upper arm by its angle in the plane.
fn posture(unit: &[f64; 7]) -> Joints<7> {
    let [a, b, c, d, e, f, g] = *unit;
    let (lower, upper) = (-1.57 + 0.6 * c, 0.1 + 0.5 * d);
    let relative = upper - lower - std::f64::consts::FRAC_PI_2;
    Joints([
        0.6 + 0.5 * a,
        2.0 * b,
        lower,
        relative,
        1.5 * e,
        2.0 * f,
        2.0 * g,
    ])
}

const WRENCH: Wrench = Wrench {
    force: Vector3::new(10.0, -20.0, 5.0),
    moment: Vector3::new(1.0, 2.0, -3.0),
};

proptest! {
    #[test]
    fn the_transmission_is_the_derivative_of_the_joints(unit in numbers::<7>(1.0), dm in numbers::<7>(200.0), ddm in numbers::<7>(900.0)) {
        let q = posture(&unit);
        let transmission = Irp6Track::KEEP.transmission(&q).unwrap();
        let motors = Irp6Track::KEEP.motors(&q).unwrap();
        let motion = Irp6Track::KEEP
            .joint_motion(&MotorMotion { position: motors, velocity: dm, acceleration: ddm })
            .unwrap();
        // the same chain rule from positions that went through the motors and back, to 1e-13
        prop_assert!(apart(&transmission.joint_velocity(&dm), &motion.velocity) < 1e-11);
        prop_assert!(apart(&transmission.joint_acceleration(&dm, &ddm), &motion.acceleration) < 1e-10);
        let dense = joints_by_motors(&Irp6Track::KEEP, &motors).unwrap();
        let torques = Irp6Track::KEEP.description().axes.map(|axis| axis.planning_limits.velocity * unit[0]);
        let reflected = dense.transpose() * SVector::from(torques);
        prop_assert!(apart(&transmission.motor_torques(&torques), reflected.as_slice()) < 1e-11);
        let m = IRP6_TRACK.at(&q).mass_matrix();
        let rotors = SVector::from(Irp6Track::KEEP.description().axes.map(|axis| axis.motor.rotor_kg_m2 + axis.motor.gear_kg_m2));
        let expected = dense.transpose() * m * dense + SMatrix::from_diagonal(&rotors);
        // entries of 1e-4 kg·m²
        prop_assert!((transmission.mass_matrix(&m) - expected).amax() < 1e-16);
    }

    #[test]
    fn motors_and_joints_give_the_same_power(unit in numbers::<7>(1.0), dm in numbers::<7>(200.0), torques in numbers::<7>(500.0)) {
        let transmission = Irp6Track::KEEP.transmission(&posture(&unit)).unwrap();
        let at_joints = SVector::from(torques).dot(&SVector::from(transmission.joint_velocity(&dm)));
        let at_motors = SVector::from(transmission.motor_torques(&torques)).dot(&SVector::from(dm));
        // sums of 7 products up to 1 kW
        prop_assert!((at_joints - at_motors).abs() < 1e-11, "{at_joints} {at_motors}");
    }

    #[test]
    fn the_power_of_the_motors_is_the_change_of_the_energy(unit in numbers::<7>(1.0), dm in numbers::<7>(100.0), ddm in numbers::<7>(500.0)) {
        let q = posture(&unit);
        let motors = Irp6Track::KEEP.motors(&q).unwrap();
        let transmission = Irp6Track::KEEP.transmission(&q).unwrap();
        let torques = IRP6_TRACK.at(&q).motor_inverse_dynamics(
            &transmission, &dm, &ddm, &STANDARD_GRAVITY, &Wrench::NONE,
        );
        let power = SVector::from(torques).dot(&SVector::from(dm));
        let energy = |t: f64| {
            let mut position = motors;
            let mut velocity = dm;
            for (((m, v), dm), ddm) in position.0.iter_mut().zip(&mut velocity).zip(dm).zip(ddm) {
                *m += t * dm + 0.5 * t * t * ddm;
                *v += t * ddm;
            }
            let motion = MotorMotion { position, velocity, acceleration: ddm };
            let joints = Irp6Track::KEEP.joint_motion(&motion).unwrap();
            let posture = IRP6_TRACK.at(&joints.position);
            let rotors: f64 = Irp6Track::KEEP.description().axes.iter().zip(velocity)
                .map(|(axis, v)| 0.5 * (axis.motor.rotor_kg_m2 + axis.motor.gear_kg_m2) * v * v).sum();
            rotors + posture.kinetic_energy(&joints.velocity) + posture.potential_energy(&STANDARD_GRAVITY)
        };
        let h = 1e-4;
        let change = (energy(h) - energy(-h)) / (2.0 * h);
        // h² of the third derivative and 1 kJ · 1e-16/h
        prop_assert!((change - power).abs() < 1e-4 * (1.0 + power.abs()), "{change} {power}");
    }

    #[test]
    fn acceleration_of_the_torques_of_motors_is_their_acceleration(unit in numbers::<7>(1.0), dm in numbers::<7>(200.0), ddm in numbers::<7>(900.0)) {
        let q = posture(&unit);
        let [_, arm @ ..] = q.0;
        let arm = Joints(arm);
        let transmission = Irp6Postument.transmission(&arm).unwrap();
        let (dm, ddm) = (*dm.first_chunk().unwrap(), *ddm.first_chunk().unwrap());
        let posture = IRP6_POSTUMENT.at(&arm);
        let torques = posture.motor_inverse_dynamics(&transmission, &dm, &ddm, &STANDARD_GRAVITY, &WRENCH);
        let found = posture.motor_forward_dynamics(&transmission, &dm, &torques, &STANDARD_GRAVITY, &WRENCH);
        // torques of up to 10 N·m to 1e-14, inertias of 1.5e-5 kg·m² at least
        prop_assert!(apart(&found, &ddm) < 1e-8, "{:e}", apart(&found, &ddm));
    }
}

/// A screw at constant speed turns its link at a changing one.
#[test]
fn the_curvature_of_the_screws_is_felt() {
    let q = posture(&[0.0; 7]);
    let transmission = Irp6Track::KEEP.transmission(&q).unwrap();
    let mut dm = [0.0; 7];
    dm[2] = 100.0;
    let acceleration = transmission.joint_acceleration(&dm, &[0.0; 7]);
    assert!(acceleration[2].abs() > 0.01, "{acceleration:?}");
    // the upper arm stands still in the plane: its joint turns back
    assert!((acceleration[2] + acceleration[3]).abs() < 1e-15);
}

/// The hand's own drive holds it level: the lower arm's motor does not carry the hand's moment.
#[test]
fn the_parallelogram_keeps_moments_apart() {
    let q = posture(&[0.0; 7]);
    let transmission = Irp6Track::KEEP.transmission(&q).unwrap();
    // a pure moment about T's axis is felt by the joints of lower arm, upper arm and T alike
    let motors = transmission.motor_torques(&[0.0, 0.0, 10.0, 10.0, 10.0, 0.0, 0.0]);
    assert_eq!([motors[2], motors[3]].map(f64::to_bits), [0; 2]);
    assert!((motors[4] - 10.0 / -128.0).abs() < 1e-15);
}

#[test]
fn beyond_a_dead_centre_there_is_no_transmission() {
    let mut q = posture(&[0.0; 7]);
    q.0[2] = 3.0;
    let refused = Irp6Track::KEEP.transmission(&q).unwrap_err();
    assert!(
        matches!(
            refused,
            KinematicError::Limit {
                axis: 2,
                quantity: Quantity::ScrewAngle,
                ..
            }
        ),
        "{refused}"
    );
    for wrong in [f64::NAN, f64::INFINITY] {
        q.0[2] = wrong;
        let refused = Irp6Track::KEEP.transmission(&q);
        assert_eq!(refused, Err(KinematicError::NotFinite));
    }
}

/// The transmission of any robot is the derivative of its joints: every motor unit vector by
/// [`Robot::joint_motion`], which the RNT computes through its legs.
struct Derivative {
    share: [f64; 8],
    rates: [f64; 8],
}

impl RobotVisitor for Derivative {
    type Output = Result<(), TestCaseError>;

    fn visit<R: Robot<N>, const N: usize>(self, robot: R) -> Self::Output {
        let axes = robot.description().axes;
        let q = Joints(core::array::from_fn(|k| {
            let range = axes[k].joint_position;
            let (low, high) = if range.lower.is_finite() {
                (range.lower, range.upper)
            } else {
                (-4.0, 4.0)
            };
            low + (0.2 + 0.6 * self.share[k]) * (high - low)
        }));
        // tilts and reach may ask for legs the tripod does not have
        let Ok(motors) = robot.motors(&q) else {
            return Ok(());
        };
        let transmission = robot.transmission(&q).unwrap();
        let velocity = core::array::from_fn(|k| 0.3 * axes[k].hard_limits.velocity * self.rates[k]);
        let acceleration =
            core::array::from_fn(|k| axes[k].hard_limits.acceleration * self.rates[(k + 3) % 8]);
        let motion = robot
            .joint_motion(&MotorMotion {
                position: motors,
                velocity,
                acceleration,
            })
            .unwrap();
        let size = 1.0
            + motion
                .velocity
                .iter()
                .chain(&motion.acceleration)
                .fold(0.0, |a, b| a + b.abs());
        // positions go through the motors and back, where the tripod is solved to 1e-12 m
        prop_assert!(
            apart(&transmission.joint_velocity(&velocity), &motion.velocity) < 1e-10 * size
        );
        let accelerations = transmission.joint_acceleration(&velocity, &acceleration);
        prop_assert!(apart(&accelerations, &motion.acceleration) < 1e-9 * size);
        let torques: [f64; N] = core::array::from_fn(|k| 100.0 * self.rates[k]);
        let dense = joints_by_motors(&robot, &motors).unwrap();
        let reflected = dense.transpose() * SVector::from(torques);
        prop_assert!(apart(&transmission.motor_torques(&torques), reflected.as_slice()) < 1e-9);
        if let Some(chain) = robot.chain() {
            let m = chain.at(&q).mass_matrix();
            let rotors =
                SVector::from(axes.map(|axis| axis.motor.rotor_kg_m2 + axis.motor.gear_kg_m2));
            let expected = dense.transpose() * m * dense + SMatrix::from_diagonal(&rotors);
            // entries of up to 2 kg·m² on direct drives
            prop_assert!((transmission.mass_matrix(&m) - expected).amax() < 1e-12);
        }
        Ok(())
    }
}

proptest! {
    #[test]
    fn the_transmission_of_every_robot_is_the_derivative_of_its_joints(
        share in prop::array::uniform8(0.0..1.0f64),
        rates in prop::array::uniform8(-1.0..1.0f64),
    ) {
        for kind in RobotKind::ALL {
            kind.visit(TrackRule::Keep, Derivative { share, rates })?;
        }
    }
}

/// A vertical push at the middle of the RNT's platform is shared by the three screws: Σ F·∂r/∂L.
#[test]
fn the_legs_of_the_rnt_share_the_weight() {
    let transmission = Rnt
        .transmission(&Joints([0.0, 0.0, 1.1, 0.0, 1.0, 0.0]))
        .unwrap();
    let motors = transmission.motor_torques(&[0.0, 0.0, 90.0, 0.0, 0.0, 0.0]);
    // a third each, by 10 mm a turn, along a leg that slants by 0.25 m on 1.1 m
    let slant = 1.1 / libm::sqrt(1.1 * 1.1 + 0.25 * 0.25);
    let expected = 30.0 / slant * 0.010 / std::f64::consts::TAU;
    for motor in &motors[..3] {
        assert!((motor - expected).abs() < 1e-12, "{motors:?} {expected}");
    }
    assert_eq!(motors[3..], [0.0; 3]);
}
