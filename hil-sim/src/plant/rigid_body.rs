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
//! # Gears that give
//!
//! An axis with a [`Gear`] is two: its rotor, moved by the motor, rubbed and braked as any axis, and the links' side
//! of the shaft, which is the coordinate of the equations above, without the rotor's inertia. Stops are on the links'
//! side, the encoder is on the rotor's. The spring's torque is that of the angles half a substep on (drift, kick,
//! drift: symplectic), so are the forces of contact (`surroundings`); friction of contact is implicit.
//!
//! Where the motors stand where no posture of the links belongs to them (a screw beyond its dead centre,
//! legs that no platform joins; stops are before it), the last posture's M and h stay.

mod smooth;
mod surroundings;

use super::axis::{AxisPlant, Drive, Effort};
use super::contact::{Obstacle, Tip};
use super::friction::{Contact, Factors, Restraint, System};
use super::gear::{Gear, GearError};
use super::mechanics::{Mechanics, Wrist};
use nalgebra::Vector3;
use robots::dynamics::{Body, Chain, STANDARD_GRAVITY, Wrench};
use robots::{AxisDescription, KinematicError, Motors, Robot};
use smooth::Smooth;
use surroundings::Surroundings;

/// M and h are taken anew every so many substeps: every 1 ms with the default substep.
const REFRESH_GEARED: u32 = 4;
/// The same where a motor turns a joint without a gear, and joints turn by tens of rad/s: every 0.75 ms.
const REFRESH_DIRECT: u32 = 3;

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
    shafts: [Option<Shaft>; N],
    surroundings: Option<Surroundings>,
}

/// An axis whose gear gives.
#[derive(Clone, Copy, Debug)]
struct Shaft {
    gear: Gear,
    /// kg·m².
    rotor_kg_m2: f64,
    /// The links' side, as the motor angle that belongs to it, rad and rad/s; none before the first substep.
    links: Option<[f64; 2]>,
}

impl Shaft {
    /// Moves the rotor under what drives it, N·m, against what it hands on; friction as in `friction`, of one axis.
    fn turn(&self, plant: &mut AxisPlant, effort: &Effort, load_nm: f64, dt_s: f64) {
        let before = plant.velocity_rad_s();
        let pushed = self.rotor_kg_m2 * before + dt_s * (effort.torque_nm - load_nm);
        let dry = dt_s * effort.dry_nm;
        let sliding = if pushed > dry {
            pushed - dry
        } else if pushed < -dry {
            pushed + dry
        } else {
            0.0
        };
        let after = sliding / (self.rotor_kg_m2 + dt_s * plant.parameters().viscous_nms_rad);
        let angle = plant.angle_rad() + 0.5 * dt_s * (before + after);
        plant.moved(angle, after);
    }
}

impl<R: Robot<N>, const N: usize> RigidBody<R, N> {
    /// Of a robot; `None` if it has no chain.
    #[must_use]
    pub fn new(robot: R) -> Option<Self> {
        let chain = robot.chain()?;
        let axes = &robot.description().axes;
        let direct = axes.iter().any(AxisDescription::is_direct);
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
            shafts: [None; N],
            surroundings: None,
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
        let mut mass = transmission.mass_matrix(&posture.mass_matrix()).data.0;
        for (k, shaft) in self.shafts.iter().enumerate() {
            if let Some(shaft) = shaft {
                mass[k][k] -= shaft.rotor_kg_m2;
            }
        }
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
        let (motors, rates) = self.links(plants);
        let Ok((mass, bias)) = self.equations(&Motors(motors), &rates) else {
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
            if self.shafts[k].is_none() {
                a[k][k] += dt_s * plants[k].parameters().viscous_nms_rad;
            }
        }
        self.mass = mass;
        self.system = Some(System::new(a));
    }

    /// Angles, rad, and rates, rad/s, of the links as motors see them.
    fn links(&self, plants: &[AxisPlant; N]) -> ([f64; N], [f64; N]) {
        let mut angles = plants.each_ref().map(AxisPlant::angle_rad);
        let mut rates = plants.each_ref().map(AxisPlant::velocity_rad_s);
        for (k, shaft) in self.shafts.iter().enumerate() {
            if let Some([angle, rate]) = shaft.and_then(|shaft| shaft.links) {
                (angles[k], rates[k]) = (angle, rate);
            }
        }
        (angles, rates)
    }

    /// Moves all axes through the next substep of the window.
    fn move_all(&mut self, plants: &mut [AxisPlant; N], efforts: &[Effort; N], dt_s: f64) {
        let (angles, before) = self.links(plants);
        let Some(system) = &mut self.system else {
            // no posture was ever known: nothing moves
            for plant in plants {
                plant.moved(plant.angle_rad(), 0.0);
            }
            return;
        };
        let (gain, advance) = self.smooth.gains(self.substep);
        let (mut free, mut push) = ([0.0; N], [0.0; N]);
        let mut handed_on = [0.0; N];
        let mut restraints = [Restraint::NONE; N];
        let rate = 1.0 / dt_s;
        for k in 0..N {
            let p = plants[k].parameters();
            free[k] = before[k] + gain[k];
            let [low, high] = p.stop_rad;
            restraints[k].low = (low - angles[k]) * rate;
            restraints[k].high = (high - angles[k]) * rate;
            if let Some(shaft) = &self.shafts[k] {
                let twisting = plants[k].velocity_rad_s() - before[k];
                let twist = plants[k].angle_rad() - angles[k] + 0.5 * dt_s * twisting;
                handed_on[k] = shaft.gear.torque_nm(twist, twisting);
                push[k] = dt_s * handed_on[k];
            } else {
                restraints[k].dry = dt_s * efforts[k].dry_nm;
                push[k] = dt_s * (efforts[k].torque_nm - p.viscous_nms_rad * free[k]);
            }
        }
        let felt = self.surroundings.as_ref().and_then(|surroundings| {
            let middle = core::array::from_fn(|k| angles[k] + 0.5 * dt_s * before[k]);
            let felt = surroundings.feel(&self.robot, &self.loaded, &Motors(middle), &before);
            felt.ok().flatten()
        });
        let after = if let Some(felt) = &felt {
            let mut dragged = system.clone();
            dragged.resist(&felt.drag, dt_s);
            for ((push, felt_push), drag) in push.iter_mut().zip(felt.push).zip(&felt.drag) {
                let held: f64 = drag.iter().zip(&free).map(|(d, v)| d * v).sum();
                *push += dt_s * (felt_push - held);
            }
            dragged.velocities(&free, &push, &restraints, &mut self.contacts)
        } else {
            system.velocities(&free, &push, &restraints, &mut self.contacts)
        };
        if let Some(surroundings) = &mut self.surroundings {
            surroundings.felt = felt.map(|felt| felt.force(&after));
        }
        for k in 0..N {
            let [low, high] = plants[k].parameters().stop_rad;
            let mean = 0.5 * dt_s * (before[k] + after[k]);
            let moved = if self.contacts[k].is_held() {
                mean
            } else {
                mean + advance[k] - 0.5 * dt_s * gain[k]
            };
            let angle = (angles[k] + moved).clamp(low, high);
            if let Some(shaft) = &mut self.shafts[k] {
                shaft.links = Some([angle, after[k]]);
                shaft.turn(&mut plants[k], &efforts[k], handed_on[k], dt_s);
            } else {
                plants[k].moved(angle, after[k]);
            }
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

    fn set_gear(&mut self, axis: usize, gear: Option<Gear>) -> Result<(), GearError> {
        let motors = &self.robot.description().axes;
        let (Some(shaft), Some(description)) = (self.shafts.get_mut(axis), motors.get(axis)) else {
            return Err(GearError::Axis);
        };
        let rotor_kg_m2 = description.motor.rotor_kg_m2 + description.motor.gear_kg_m2;
        if let Some(gear) = &gear {
            gear.check(rotor_kg_m2)?;
        }
        *shaft = gear.map(|gear| Shaft {
            gear,
            rotor_kg_m2,
            links: None,
        });
        self.smooth.forget();
        self.substep = 0;
        Ok(())
    }

    fn links_rad(&self, axis: usize) -> Option<f64> {
        let shaft = self.shafts.get(axis)?.as_ref()?;
        shaft.links.map(|[angle, _]| angle)
    }

    fn surround(&mut self, obstacles: Vec<Obstacle>, tip: Tip) -> bool {
        self.surroundings = Some(Surroundings {
            obstacles,
            tip,
            felt: None,
        });
        true
    }

    fn wrist(&self, plants: &[AxisPlant]) -> Option<Wrist> {
        let (motors, _) = self.links(plants.first_chunk::<N>()?);
        let joints = self.robot.joints(&Motors(motors)).ok()?;
        let touch = self.surroundings.as_ref().and_then(|around| around.felt);
        Some(Wrist {
            flange: self.robot.forward(&joints),
            gravity: self.gravity,
            touch,
        })
    }
}

#[cfg(test)]
mod tests;
