//! Between joints and motors: torques, masses, and the curvature of the screws.
//!
//! With m the motors' angles, q the joints' and J = ∂q/∂m,
//!
//! ```text
//!   q̇ = J·ṁ        q̈ = J·m̈ + γ,  γ = J̇·ṁ        τm = Jᵀ·τq   (the same power: τm·ṁ = τq·q̇)
//!
//!   (Jᵀ·M·J + I)·m̈ + Jᵀ·(M·γ + c + τg − Jₑᵀ·w) = τm
//! ```
//!
//! with I the inertia of the rotors and of what turns with them, M, c, τg of the joints and w at the flange. Joints → gear coordinates x →
//! motors are two maps with entries on the diagonal and next to it (see [`crate::gearing`]); so are their
//! transposes, and J is never formed. γ comes from the screws, ẍ = (m̈ − m''·ẋ²)/m', and from the legs of a
//! platform, a third map where there is one (`Legs`). A rotor's spin is not coupled to the turning of the
//! link that carries it: its mass is part of that link, the gyroscopic torque of the rotor is left out.

use nalgebra::{ArrayStorage, SMatrix, Vector3};

use super::chain::Posture;
use super::forward::solve;
use super::inverse::Wrench;
use super::legs::Legs;
use crate::description::{AxisDescription, Gearing, Reference, RobotDescription};
use crate::error::KinematicError;
use crate::gearing::{at_axis, finite, gear_positions};
use crate::robot::Robot;
use crate::space::{Joints, MotorMotion, Motors};

/// How one axis moves its motor, at one joint position.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Ratio {
    /// ∂x/∂m of its own motor: 1/m'.
    reduction: f64,
    /// m'', rad/rad².
    curvature: f64,
    /// 1 where the gear coordinate holds the previous one too, else 0.
    on_previous_link: f64,
    /// 1 where the motor's travel holds the previous one's too, else 0.
    on_previous_motor: f64,
}

/// The derivative of a robot's joints by its motors, at fixed joint positions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transmission<const N: usize> {
    ratios: [Ratio; N],
    legs: Option<Legs>,
    rotors: [f64; N],
}

impl<const N: usize> Transmission<N> {
    /// Of gears that are an axis' own, at joint positions; the rotors' inertias are those of the
    /// description.
    ///
    /// # Errors
    /// As [`Robot::motors`]; [`KinematicError::Unreachable`] where a gear drives the leg of a platform
    /// ([`Reference::Leg`]), of which the description does not say what it has to do with the joints.
    pub(crate) fn geared(
        robot: &RobotDescription<N>,
        joints: &Joints<N>,
    ) -> Result<Self, KinematicError> {
        let leg = |axis: &AxisDescription| matches!(axis.reference, Reference::Leg { .. });
        if robot.axes.iter().any(leg) {
            return Err(KinematicError::Unreachable);
        }
        Self::of_gears(robot, joints)
    }

    /// Of a robot whose first three gears drive `legs`; `gears` holds the legs' lengths, m, in the place
    /// of the joints, as everywhere in [`crate::gearing`].
    ///
    /// # Errors
    /// As [`Robot::motors`].
    pub(crate) fn of_legs(
        robot: &RobotDescription<N>,
        gears: &Joints<N>,
        legs: &Legs,
    ) -> Result<Self, KinematicError> {
        let transmission = Self::of_gears(robot, gears)?;
        Ok(Self {
            legs: Some(*legs),
            ..transmission
        })
    }

    fn of_gears(robot: &RobotDescription<N>, joints: &Joints<N>) -> Result<Self, KinematicError> {
        finite(&joints.0)?;
        let mut ratios = [Ratio {
            reduction: 1.0,
            curvature: 0.0,
            on_previous_link: 0.0,
            on_previous_motor: 0.0,
        }; N];
        let x = gear_positions(robot, &joints.0);
        for (k, ((ratio, axis), x)) in (0..N).zip(ratios.iter_mut().zip(&robot.axes).zip(x)) {
            if let Reference::ArmPlane { .. } = axis.reference {
                ratio.on_previous_link = 1.0;
            }
            match axis.gearing {
                Gearing::Linear { ratio: slope } => ratio.reduction = 1.0 / slope,
                Gearing::OnPrevious { ratio: slope } => {
                    ratio.reduction = 1.0 / slope;
                    ratio.on_previous_motor = 1.0;
                }
                Gearing::Screw(screw) => {
                    let travel = screw.travel(x).map_err(at_axis(k, axis))?;
                    ratio.reduction = 1.0 / travel.first;
                    ratio.curvature = travel.second;
                }
                Gearing::Quadratic(law) => {
                    let travel = law.travel(x).map_err(at_axis(k, axis))?;
                    ratio.reduction = 1.0 / travel.first;
                    ratio.curvature = travel.second;
                }
            }
        }
        Ok(Self {
            ratios,
            legs: None,
            rotors: robot
                .axes
                .each_ref()
                .map(|axis| axis.motor.rotor_kg_m2 + axis.motor.gear_kg_m2),
        })
    }

    /// J·m̈ + γ: accelerations of the joints, rad/s² or m/s², from those of the motors, rad/s², at
    /// motor velocities, rad/s.
    #[must_use]
    pub fn joint_acceleration(&self, velocity: &[f64; N], acceleration: &[f64; N]) -> [f64; N] {
        let dx = self.gear_rates(velocity);
        let mut ddx = self.gear_rates(acceleration);
        for ((ddx, dx), ratio) in ddx.iter_mut().zip(dx).zip(&self.ratios) {
            *ddx -= ratio.reduction * ratio.curvature * dx * dx;
        }
        let mut ddq = self.links_apart(&ddx);
        if let Some(legs) = &self.legs {
            legs.accelerations(&mut ddq, &self.joint_velocity(velocity));
        }
        ddq
    }

    /// J·ṁ: velocities of the joints, rad/s or m/s, from those of the motors, rad/s.
    #[must_use]
    pub fn joint_velocity(&self, velocity: &[f64; N]) -> [f64; N] {
        let mut dq = self.links_apart(&self.gear_rates(velocity));
        if let Some(legs) = &self.legs {
            legs.rates(&mut dq);
        }
        dq
    }

    fn gear_rates(&self, motor_rates: &[f64; N]) -> [f64; N] {
        let mut x = [0.0; N];
        let mut previous = 0.0;
        for ((x, m), ratio) in x.iter_mut().zip(motor_rates).zip(&self.ratios) {
            *x = ratio.reduction * (m - ratio.on_previous_motor * previous);
            previous = *m;
        }
        x
    }

    fn links_apart(&self, gear_rates: &[f64; N]) -> [f64; N] {
        let mut q = [0.0; N];
        let mut previous = 0.0;
        for ((q, x), ratio) in q.iter_mut().zip(gear_rates).zip(&self.ratios) {
            *q = x - ratio.on_previous_link * previous;
            previous = *x;
        }
        q
    }

    /// Jᵀ·τ: torques of the motors, N·m, from those of the joints, N·m or N.
    #[must_use]
    pub fn motor_torques(&self, joint_torques: &[f64; N]) -> [f64; N] {
        let mut of_links = *joint_torques;
        if let Some(legs) = &self.legs {
            legs.forces(&mut of_links);
        }
        let mut torques = [0.0; N];
        // what the axis after this one takes: of the joints, then of the motors
        let (mut link_after, mut motor_after) = (0.0, 0.0);
        for ((torque, joint), ratio) in torques.iter_mut().zip(&of_links).zip(&self.ratios).rev() {
            let own = ratio.reduction * (joint - link_after);
            *torque = own - motor_after;
            link_after = ratio.on_previous_link * joint;
            motor_after = ratio.on_previous_motor * own;
        }
        torques
    }

    /// Jᵀ·M·J + I: the mass matrix seen at the motors, kg·m², from that of the joints.
    #[must_use]
    pub fn mass_matrix(&self, joints: &SMatrix<f64, N, N>) -> SMatrix<f64, N, N> {
        // M is symmetric, so its columns are its rows; and so is the result
        let half = self.transposed_times(joints.data.0);
        let turned = SMatrix::from_array_storage(ArrayStorage(half)).transpose();
        let rows = self.transposed_times(turned.data.0);
        let mut matrix = SMatrix::from_array_storage(ArrayStorage(rows));
        for (k, rotor) in (0..N).zip(&self.rotors) {
            if let Some(entry) = matrix.get_mut((k, k)) {
                *entry += rotor;
            }
        }
        matrix
    }

    /// The rows of Jᵀ·A from those of A: [`Transmission::motor_torques`] of every column at once.
    fn transposed_times(&self, rows: [[f64; N]; N]) -> [[f64; N]; N] {
        let mut of_links = rows;
        if let Some(legs) = &self.legs {
            legs.forces_of_rows(&mut of_links);
        }
        let mut out = [[0.0; N]; N];
        let (mut link_after, mut motor_after) = ([0.0; N], [0.0; N]);
        for ((out, joint), ratio) in out.iter_mut().zip(&of_links).zip(&self.ratios).rev() {
            let columns = out.iter_mut().zip(joint);
            for ((out, joint), (link, motor)) in
                columns.zip(link_after.iter_mut().zip(&mut motor_after))
            {
                let own = ratio.reduction * (joint - *link);
                *out = own - *motor;
                *link = ratio.on_previous_link * joint;
                *motor = ratio.on_previous_motor * own;
            }
        }
        out
    }
}

impl<const N: usize> Posture<'_, N> {
    /// Torques of the motors, N·m, that give them `acceleration`, rad/s², while they turn at `velocity`,
    /// rad/s; without friction. `transmission` is to be at the same joint positions. Gravity and wrench
    /// as in [`Posture::inverse_dynamics`].
    #[must_use]
    pub fn motor_inverse_dynamics(
        &self,
        transmission: &Transmission<N>,
        velocity: &[f64; N],
        acceleration: &[f64; N],
        gravity: &Vector3<f64>,
        wrench: &Wrench,
    ) -> [f64; N] {
        let dq = transmission.joint_velocity(velocity);
        let ddq = transmission.joint_acceleration(velocity, acceleration);
        let joint_torques = self.inverse_dynamics(&dq, &ddq, gravity, wrench);
        let mut torques = transmission.motor_torques(&joint_torques);
        for ((torque, rotor), ddm) in torques
            .iter_mut()
            .zip(transmission.rotors)
            .zip(acceleration)
        {
            *torque += rotor * ddm;
        }
        torques
    }

    /// Accelerations of the motors, rad/s², under motor torques, N·m: the inverse of
    /// [`Posture::motor_inverse_dynamics`], with the same arguments.
    #[must_use]
    pub fn motor_forward_dynamics(
        &self,
        transmission: &Transmission<N>,
        velocity: &[f64; N],
        torques: &[f64; N],
        gravity: &Vector3<f64>,
        wrench: &Wrench,
    ) -> [f64; N] {
        let bias = self.motor_inverse_dynamics(transmission, velocity, &[0.0; N], gravity, wrench);
        let mut right = *torques;
        for (right, bias) in right.iter_mut().zip(bias) {
            *right -= bias;
        }
        let matrix = transmission.mass_matrix(&self.mass_matrix());
        solve(matrix.data.0, right)
    }
}

/// J = ∂q/∂m of any robot, dense, by one [`Robot::joint_motion`] a column: rad/rad or m/rad. Torques
/// follow by its transpose. [`Robot::transmission`] gives the same much faster.
///
/// # Errors
/// As [`Robot::joint_motion`].
pub fn joints_by_motors<const N: usize>(
    robot: &impl Robot<N>,
    motors: &Motors<N>,
) -> Result<SMatrix<f64, N, N>, KinematicError> {
    let mut columns = [[0.0; N]; N];
    for (k, column) in (0..N).zip(&mut columns) {
        let mut velocity = [0.0; N];
        if let Some(unit) = velocity.get_mut(k) {
            *unit = 1.0;
        }
        let motion = MotorMotion {
            position: *motors,
            velocity,
            acceleration: [0.0; N],
        };
        *column = robot.joint_motion(&motion)?.velocity;
    }
    Ok(SMatrix::from_array_storage(ArrayStorage(columns)))
}
