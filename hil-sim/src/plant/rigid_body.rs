//! The rigid bodies of an arm, moved by its motors.
//!
//! In motor angles m, with the robot's chain and transmission ([`robots::dynamics`]):
//!
//! ```text
//!   M(m)·m̈ + h(m, ṁ) = torque of the motors − viscous·ṁ − dry friction and brakes − stops
//! ```
//!
//! # Integration
//!
//! Geometry is taken anew every `REFRESH_SUBSTEPS` substeps (1 ms): M and h, in the middle of the time
//! they are used for, where position and velocity are foretold from those at its beginning and the mean
//! acceleration before: the explicit midpoint rule. In a substep the velocity comes from
//!
//! ```text
//!   M·(v⁺ − v) = dt·(torque − h − viscous·v⁺) − friction and stops
//! ```
//!
//! all friction implicit (`plant::friction`), and the angle from the mean of v and v⁺. Without friction
//! this is of second order; `tests.rs` measures the drift of the energy, and the error of the refresh.
//!
//! Where the motors stand where no posture of the links belongs to them (a screw beyond its dead centre,
//! legs that no platform joins; stops are before it), the last posture's M and h stay.

use super::axis::{AxisPlant, Drive, Effort};
use super::friction::{Contact, Restraint, velocities};
use super::mechanics::Mechanics;
use robots::dynamics::{Body, Chain, STANDARD_GRAVITY, Wrench};
use robots::{KinematicError, Motors, Robot};

/// M and h are taken anew every so many substeps: every 1 ms with the default substep.
const REFRESH_SUBSTEPS: u32 = 4;

/// The links of a robot with a chain.
#[derive(Clone, Debug)]
pub struct RigidBody<R, const N: usize> {
    robot: R,
    chain: Chain<N>,
    loaded: Chain<N>,
    refresh_substeps: u32,
    to_refresh: u32,
    equations: Option<Equations<N>>,
    /// Velocities where M and h were last taken, rad/s.
    since: [f64; N],
    contacts: [Contact; N],
}

/// M and h at one posture and velocity.
#[derive(Clone, Copy, Debug)]
struct Equations<const N: usize> {
    /// kg·m² at the motor shafts.
    mass: [[f64; N]; N],
    /// N·m on the motor shafts: weight, centrifugal and Coriolis torques.
    bias: [f64; N],
}

impl<R: Robot<N>, const N: usize> RigidBody<R, N> {
    /// Of a robot; `None` if it has no chain.
    #[must_use]
    pub fn new(robot: R) -> Option<Self> {
        let chain = robot.chain()?;
        Some(Self {
            robot,
            chain,
            loaded: chain,
            refresh_substeps: REFRESH_SUBSTEPS,
            to_refresh: 0,
            equations: None,
            since: [0.0; N],
            contacts: [Contact::Stuck; N],
        })
    }

    fn equations(
        &self,
        motors: &Motors<N>,
        velocity: &[f64; N],
    ) -> Result<Equations<N>, KinematicError> {
        let joints = self.robot.joints(motors)?;
        let transmission = self.robot.transmission(&joints)?;
        let posture = self.loaded.at(&joints);
        Ok(Equations {
            mass: transmission.mass_matrix(&posture.mass_matrix()).data.0,
            bias: posture.motor_inverse_dynamics(
                &transmission,
                velocity,
                &[0.0; N],
                &STANDARD_GRAVITY,
                &Wrench::NONE,
            ),
        })
    }

    /// M and h for the next `ahead_s` seconds.
    fn refresh(&mut self, plants: &[AxisPlant; N], ahead_s: f64) {
        let mut motors = [0.0; N];
        let mut rates = [0.0; N];
        for k in 0..N {
            let v = plants[k].velocity_rad_s();
            motors[k] = plants[k].angle_rad() + 0.5 * ahead_s * v;
            rates[k] = v + 0.5 * (v - self.since[k]);
            self.since[k] = v;
        }
        if let Ok(equations) = self.equations(&Motors(motors), &rates) {
            self.equations = Some(equations);
        }
    }

    fn move_all(&mut self, plants: &mut [AxisPlant; N], efforts: &[Effort; N], dt_s: f64) {
        let Some(Equations { mass, bias }) = self.equations else {
            // no posture was ever known: nothing moves
            for plant in plants {
                plant.moved(plant.angle_rad(), 0.0);
            }
            return;
        };
        let before = plants.each_ref().map(AxisPlant::velocity_rad_s);
        let mut a = mass;
        let mut b = [0.0; N];
        for k in 0..N {
            let momentum: f64 = mass[k].iter().zip(before).map(|(m, v)| m * v).sum();
            b[k] = momentum + dt_s * (efforts[k].torque_nm - bias[k]);
            a[k][k] += dt_s * plants[k].parameters().viscous_nms_rad;
        }
        let restraints = core::array::from_fn(|k| {
            let [low, high] = plants[k].parameters().stop_rad;
            let angle = plants[k].angle_rad();
            Restraint {
                dry: dt_s * efforts[k].dry_nm,
                low: (low - angle) / dt_s,
                high: (high - angle) / dt_s,
            }
        });
        let after = velocities(&a, &b, &restraints, &mut self.contacts);
        for k in 0..N {
            let [low, high] = plants[k].parameters().stop_rad;
            let angle = plants[k].angle_rad() + 0.5 * dt_s * (before[k] + after[k]);
            plants[k].moved(angle.clamp(low, high), after[k]);
        }
    }
}

impl<R: Robot<N> + Send, const N: usize> Mechanics for RigidBody<R, N> {
    fn axes(&self) -> Option<usize> {
        Some(N)
    }

    fn step(&mut self, plants: &mut [AxisPlant], commands: &[Drive], dt_s: f64) {
        let (Some(plants), Some(commands)) =
            (plants.first_chunk_mut::<N>(), commands.first_chunk::<N>())
        else {
            return;
        };
        if self.to_refresh == 0 {
            self.to_refresh = self.refresh_substeps;
            self.refresh(plants, dt_s * f64::from(self.refresh_substeps));
        }
        self.to_refresh -= 1;
        let mut commands = commands.iter();
        let efforts = plants
            .each_mut()
            .map(|plant| plant.actuate(commands.next().copied().unwrap_or_default()));
        self.move_all(plants, &efforts, dt_s);
    }

    fn carry(&mut self, body: Option<&Body>) -> bool {
        self.loaded = match body {
            Some(body) => self.chain.with_payload(body),
            None => self.chain,
        };
        true
    }
}

#[cfg(test)]
mod tests;
