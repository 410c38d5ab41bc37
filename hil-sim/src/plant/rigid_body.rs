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
//! The accelerations −M⁻¹·h are evaluated every few substeps and continued in between by a
//! polynomial (`smooth`), which gives w, the velocity that weight and inertia alone would leave at the end of a
//! substep, and their part of the angle. All else is done in each substep, with M foretold for the middle of its
//! window by a straight line:
//!
//! ```text
//!   M·(v⁺ − w) = dt·(torque − viscous·v⁺) − friction and stops
//! ```
//!
//! all friction implicit (`friction`), and its part of the angle as by a constant acceleration. So what
//! weight and inertia do is of the order of the polynomial, and what bends the velocity of the second; `tests`
//! measures the drift of the energy and both orders.
//!
//! Where the motors stand where no posture of the links belongs to them (a screw beyond its dead centre,
//! legs that no platform joins; stops are before it), the last posture's M and h stay.

mod smooth;

use super::axis::{AxisPlant, Drive, Effort};
use super::friction::{Contact, Factors, Restraint, System};
use super::mechanics::Mechanics;
use nalgebra::Vector3;
use robots::dynamics::{Body, Chain, STANDARD_GRAVITY, Wrench};
use robots::{KinematicError, Motors, Robot};
use smooth::Smooth;

/// M and h are taken anew every so many substeps: every 1 ms with the default substep.
const REFRESH_GEARED: u32 = 4;
/// The same where a motor turns a joint without a gear, and joints turn by tens of rad/s: every 0.5 ms.
const REFRESH_DIRECT: u32 = 2;

/// The links of a robot with a chain.
#[derive(Clone, Debug)]
pub struct RigidBody<R, const N: usize> {
    robot: R,
    chain: Chain<N>,
    loaded: Chain<N>,
    gravity: Vector3<f64>,
    refresh_substeps: u32,
    /// Substeps of the window that are done.
    substep: u32,
    smooth: Smooth<N>,
    /// M at the last evaluation, kg·m² at the motor shafts.
    mass: [[f64; N]; N],
    /// M + dt·viscous for this window; none before the first posture is known.
    system: Option<System<N>>,
    contacts: [Contact; N],
}

impl<R: Robot<N>, const N: usize> RigidBody<R, N> {
    /// Of a robot; `None` if it has no chain.
    #[must_use]
    pub fn new(robot: R) -> Option<Self> {
        let chain = robot.chain()?;
        let direct = robot.description().axes.iter().any(|axis| axis.is_direct());
        let refresh_substeps = if direct {
            REFRESH_DIRECT
        } else {
            REFRESH_GEARED
        };
        Some(Self {
            robot,
            chain,
            loaded: chain,
            gravity: STANDARD_GRAVITY,
            refresh_substeps,
            substep: 0,
            smooth: Smooth::new(refresh_substeps),
            mass: [[0.0; N]; N],
            system: None,
            contacts: [Contact::Stuck; N],
        })
    }

    /// The same robot on a wall, a ceiling or another planet: `gravity` is the acceleration of free fall in its
    /// base frame, m/s².
    #[must_use]
    pub fn under(self, gravity: Vector3<f64>) -> Self {
        Self { gravity, ..self }
    }

    /// M, kg·m², and h, N·m, at the motor shafts.
    fn equations(
        &self,
        motors: &Motors<N>,
        velocity: &[f64; N],
    ) -> Result<([[f64; N]; N], [f64; N]), KinematicError> {
        let joints = self.robot.joints(motors)?;
        let transmission = self.robot.transmission(&joints)?;
        let posture = self.loaded.at(&joints);
        let mass = transmission.mass_matrix(&posture.mass_matrix()).data.0;
        let bias = posture.motor_inverse_dynamics(
            &transmission,
            velocity,
            &[0.0; N],
            &self.gravity,
            &Wrench::NONE,
        );
        Ok((mass, bias))
    }

    /// Begins a window of substeps of `dt_s`.
    fn refresh(&mut self, plants: &[AxisPlant; N], dt_s: f64) {
        self.smooth.pace(dt_s);
        let motors = Motors(plants.each_ref().map(AxisPlant::angle_rad));
        let rates = plants.each_ref().map(AxisPlant::velocity_rad_s);
        let Ok((mass, bias)) = self.equations(&motors, &rates) else {
            self.smooth.hold();
            return;
        };
        let weight = Factors::new(&mass, [false; N]).solve(bias.map(|h| -h));
        self.smooth.evaluated(&weight);
        let mut a = mass;
        for k in 0..N {
            if self.smooth.order() > 1 {
                for i in 0..N {
                    a[k][i] += 0.5 * (mass[k][i] - self.mass[k][i]);
                }
            }
            a[k][k] += dt_s * plants[k].parameters().viscous_nms_rad;
        }
        self.mass = mass;
        self.system = Some(System::new(a));
    }

    /// Moves all axes through the next substep of the window.
    fn move_all(&mut self, plants: &mut [AxisPlant; N], efforts: &[Effort; N], dt_s: f64) {
        let Some(system) = &mut self.system else {
            // no posture was ever known: nothing moves
            for plant in plants {
                plant.moved(plant.angle_rad(), 0.0);
            }
            return;
        };
        let (gain, advance) = self.smooth.gains(self.substep);
        let before = plants.each_ref().map(AxisPlant::velocity_rad_s);
        let (mut free, mut push) = ([0.0; N], [0.0; N]);
        let mut restraints = [Restraint::NONE; N];
        for k in 0..N {
            let p = plants[k].parameters();
            let angle = plants[k].angle_rad();
            free[k] = before[k] + gain[k];
            push[k] = dt_s * (efforts[k].torque_nm - p.viscous_nms_rad * free[k]);
            let [low, high] = p.stop_rad;
            restraints[k] = Restraint {
                dry: dt_s * efforts[k].dry_nm,
                low: (low - angle) / dt_s,
                high: (high - angle) / dt_s,
            };
        }
        let after = system.velocities(&free, &push, &restraints, &mut self.contacts);
        for k in 0..N {
            let [low, high] = plants[k].parameters().stop_rad;
            let mean = 0.5 * dt_s * (before[k] + after[k]);
            let moved = if self.contacts[k].is_held() {
                mean
            } else {
                mean + advance[k] - 0.5 * dt_s * gain[k]
            };
            let angle = plants[k].angle_rad() + moved;
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
        if self.substep == 0 {
            self.refresh(plants, dt_s);
        }
        let mut commands = commands.iter();
        let efforts = plants
            .each_mut()
            .map(|plant| plant.actuate(commands.next().copied().unwrap_or_default()));
        self.move_all(plants, &efforts, dt_s);
        self.substep = (self.substep + 1) % self.refresh_substeps;
    }

    fn carry(&mut self, body: Option<&Body>) -> bool {
        self.loaded = match body {
            Some(body) => self.chain.with_payload(body),
            None => self.chain,
        };
        self.smooth.forget();
        self.substep = 0;
        true
    }
}

#[cfg(test)]
mod tests;
