use super::*;
use crate::plant::axis::PlantParameters;
use crate::plant::parameters::robot as setup_of;
use crate::plant::random::SplitMix64;
use robots::dynamics::Shape;
use robots::{Irp6Postument, Joints, MotorMotion, Polycrank, RobotKind};

mod contact;
mod gear;
mod laws;

const DT: f64 = 0.000_25;

/// An arm without drives.
struct Arm<R, const N: usize> {
    body: RigidBody<R, N>,
    plants: [AxisPlant; N],
    gravity: Vector3<f64>,
    dt_s: f64,
}

impl<R: Robot<N> + Copy + Send, const N: usize> Arm<R, N> {
    fn new(
        robot: R,
        kind: RobotKind,
        joints: &Joints<N>,
        dt_s: f64,
        change: impl Fn(&mut PlantParameters),
    ) -> Self {
        let motors = robot.motors(joints).unwrap().0;
        let setup = setup_of(kind, 1);
        let plants = core::array::from_fn(|k| {
            let mut parameters = setup.axes[k].plant;
            change(&mut parameters);
            AxisPlant::new(parameters, motors[k], dt_s, SplitMix64::new(1))
        });
        Self {
            body: RigidBody::new(robot).unwrap(),
            plants,
            gravity: STANDARD_GRAVITY,
            dt_s,
        }
    }

    fn run(&mut self, seconds: f64, commands: &[Drive; N]) {
        let steps = 0.5 + seconds / self.dt_s;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "small"
        )]
        for _ in 0..steps as u32 {
            self.body.step(&mut self.plants, commands, self.dt_s);
        }
    }

    fn motion(&self) -> MotorMotion<N> {
        MotorMotion {
            position: Motors(self.plants.each_ref().map(AxisPlant::angle_rad)),
            velocity: self.plants.each_ref().map(AxisPlant::velocity_rad_s),
            acceleration: [0.0; N],
        }
    }

    /// Kinetic energy of links and rotors, and potential energy, J.
    fn energy(&self) -> [f64; 2] {
        let motion = self.motion();
        let joints = self.body.robot.joint_motion(&motion).unwrap();
        let axes = &self.body.robot.description().axes;
        let rotors: f64 = axes
            .iter()
            .zip(motion.velocity)
            .map(|(axis, v)| 0.5 * (axis.motor.rotor_kg_m2 + axis.motor.gear_kg_m2) * v * v)
            .sum();
        let posture = self.body.loaded.at(&joints.position);
        [
            rotors + posture.kinetic_energy(&joints.velocity),
            posture.potential_energy(&self.gravity),
        ]
    }
}

/// Neither friction nor brake nor stop.
fn frictionless(p: &mut PlantParameters) {
    (p.viscous_nms_rad, p.coulomb_nm, p.brake_nm) = (0.0, 0.0, 0.0);
    p.stop_rad = [f64::NEG_INFINITY, f64::INFINITY];
}

const OPEN: Drive = Drive {
    torque_nm: 0.0,
    release_brake: true,
};

const SWING: Joints<7> = Joints([0.3, -0.8, 0.5, 0.2, -0.4, 0.3, 0.0]);

/// Greatest change of the energy in `seconds` of a motion, over the greatest kinetic energy in it.
fn drift<R: Robot<N> + Copy + Send, const N: usize>(
    arm: &mut Arm<R, N>,
    commands: &[Drive; N],
    seconds: u32,
) -> [f64; 2] {
    let begin: f64 = arm.energy().iter().sum();
    let (mut worst, mut kinetic) = (0.0_f64, 0.0_f64);
    for _ in 0..100 * seconds {
        arm.run(0.01, commands);
        let [moving, potential] = arm.energy();
        let off = (moving + potential - begin).abs();
        worst = if off > worst { off } else { worst };
        kinetic = if moving > kinetic { moving } else { kinetic };
    }
    [worst / kinetic, kinetic]
}

/// A frictionless Polycrank with its second three cranks 1 rad off hanging down, windows of `refresh`.
fn hanging(dt_s: f64, refresh: u32) -> Arm<Polycrank, 7> {
    let hang = core::f64::consts::FRAC_PI_2;
    let start = Joints([0.0, 0.0, 0.0, 1.0 - hang, 0.0, 0.0, 0.0]);
    let mut arm = Arm::new(Polycrank, RobotKind::Polycrank, &start, dt_s, frictionless);
    arm.body.refresh_substeps = refresh;
    arm.body.smooth = Smooth::new(refresh);
    arm
}

/// A frictionless IRp-6 on a wall, so that both arms can hang within the dead centres of their screws: free
/// fall is along the direction in which both arms hang, 12° from the base's x in its x-z plane. T starts 1 rad
/// off it, the column 0.7 rad, the arms 0.1 rad: with more they swing beyond a dead centre.
fn on_the_wall() -> Arm<Irp6Postument, 6> {
    let (down, g) = (-0.209, -STANDARD_GRAVITY.z);
    let [lower, upper, t] = [down + 0.1, down - 0.1, down + 1.0];
    let start = Joints([
        0.7,
        lower,
        upper - lower - core::f64::consts::FRAC_PI_2,
        t - upper,
        0.5,
        0.0,
    ]);
    let mut arm = Arm::new(
        Irp6Postument,
        RobotKind::Irp6Postument,
        &start,
        DT,
        frictionless,
    );
    let (s, c) = libm::sincos(down);
    arm.gravity = Vector3::new(g * c, 0.0, -g * s);
    arm.body = arm.body.under(arm.gravity);
    arm
}

#[test]
fn without_friction_the_energy_stays() {
    let [polycrank, exchanged] = drift(&mut hanging(DT, REFRESH_DIRECT), &[OPEN; 7], 10);
    println!("Polycrank: energy drift {polycrank:e} of {exchanged} J");
    // it turns by 20 rad/s; measured 1.8e-7 of 5.5 J
    assert!(exchanged > 5.0 && polycrank > 1e-10 && polycrank < 1e-6);
    let [irp6, exchanged] = drift(&mut on_the_wall(), &[OPEN; 6], 10);
    println!("IRp-6: energy drift {irp6:e} of {exchanged} J");
    assert!(exchanged > 20.0 && irp6 > 1e-13 && irp6 < 1e-6);
}

#[test]
fn the_smooth_part_is_of_high_order() {
    let drifts = [4, 2, 1].map(|refresh| drift(&mut hanging(DT, refresh), &[OPEN; 7], 2)[0]);
    println!("energy drift, windows of 1, 0.5 and 0.25 ms: {drifts:?}");
    let [coarse, used, fine] = drifts;
    // order 6 is a factor of 64 for half the window; measured 50 and 111
    assert!(
        used < coarse / 30.0 && fine < used / 30.0 && fine > 1e-12,
        "{drifts:?}"
    );
}

#[test]
fn friction_only_takes_energy() {
    let mut arm = Arm::new(Polycrank, RobotKind::Polycrank, &SWING, DT, |p| {
        p.brake_nm = 0.0;
    });
    let mut before: f64 = arm.energy().iter().sum();
    for _ in 0..400 {
        arm.run(0.01, &[OPEN; 7]);
        let now: f64 = arm.energy().iter().sum();
        // what the integration is off by in 10 ms, of some 10 J
        assert!(now < before + 1e-3, "{before} {now}");
        before = now;
    }
    let [kinetic, _] = arm.energy();
    assert!(kinetic < 5.0, "it comes to rest: {kinetic}");
}

const WORK: Joints<6> = Joints([0.3, -1.2, 0.2, 0.9, 0.4, 0.0]);

fn postument(change: impl Fn(&mut PlantParameters)) -> Arm<Irp6Postument, 6> {
    Arm::new(Irp6Postument, RobotKind::Irp6Postument, &WORK, DT, change)
}

/// Torques, N·m, that hold the motors in this posture against gravity.
fn holding(arm: &Arm<Irp6Postument, 6>) -> [f64; 6] {
    let transmission = Irp6Postument.transmission(&WORK).unwrap();
    let posture = arm.body.loaded.at(&WORK);
    transmission.motor_torques(&posture.gravity_torques(&STANDARD_GRAVITY))
}

#[test]
fn an_arm_is_held_by_the_torque_of_gravity_and_by_nothing_less() {
    // the friction of the real axes could hold some of them alone
    let mut arm = postument(frictionless);
    let hold = holding(&arm).map(|torque_nm| Drive { torque_nm, ..OPEN });
    assert!(hold[1].torque_nm.abs() > 0.05, "{hold:?}");
    let start = arm.motion().position.0;
    let fallen = |arm: &Arm<Irp6Postument, 6>| {
        let now = arm.motion().position.0;
        core::array::from_fn::<f64, 6, _>(|k| now[k] - start[k])
    };
    arm.run(0.2, &hold);
    // the current rises in 0.3 ms: 0.3 N·m · 0.3 ms / 3e-4 kg·m² leaves 0.3 rad/s for 0.2 s
    for moved in fallen(&arm) {
        assert!(moved.abs() < 0.15, "{:?}", fallen(&arm));
    }
    let held = fallen(&arm);
    let mut arm = postument(frictionless);
    arm.run(
        0.2,
        &hold.map(|drive| Drive {
            torque_nm: 0.9 * drive.torque_nm,
            ..drive
        }),
    );
    let (less, enough) = (fallen(&arm)[1], held[1]);
    assert!(
        less.abs() > 3.0 * enough.abs() && less * hold[1].torque_nm < 0.0,
        "{less} {enough}"
    );
}

#[test]
fn a_brake_that_opens_before_there_is_torque_lets_the_arm_droop() {
    let mut arm = postument(|p| p.coulomb_nm = 0.0);
    let start = arm.motion().position.0;
    arm.run(0.5, &[Drive::default(); 6]);
    let held = arm.motion().position.0.map(f64::to_bits);
    assert_eq!(held, start.map(f64::to_bits), "the brakes hold");
    // 20 ms to open, 30 ms without torque
    arm.run(0.05, &[OPEN; 6]);
    let fallen: [f64; 6] = core::array::from_fn(|k| arm.motion().position.0[k] - start[k]);
    // ½·a·t² with the acceleration of no torque; viscous friction of 67 1/s takes its part
    let transmission = Irp6Postument.transmission(&WORK).unwrap();
    let a = arm.body.loaded.at(&WORK).motor_forward_dynamics(
        &transmission,
        &[0.0; 6],
        &[0.0; 6],
        &STANDARD_GRAVITY,
        &Wrench::NONE,
    );
    for k in 1..3 {
        let free = 0.5 * a[k] * 0.03 * 0.03;
        assert!(
            fallen[k] / free > 0.4 && fallen[k] / free < 1.0,
            "{k}: {} {free}",
            fallen[k]
        );
    }
}

/// A torque on the lower arm's motor moves the others as the mass matrix says.
#[test]
fn axes_disturb_each_other_as_inverse_dynamics_says() {
    let mut arm = Arm::new(Polycrank, RobotKind::Polycrank, &SWING, DT, frictionless);
    // all but the fourth are braked: they hold, and what they hold with is the coupling
    let transmission = Polycrank.transmission(&SWING).unwrap();
    let posture = arm.body.loaded.at(&SWING);
    let bias = posture.motor_inverse_dynamics(
        &transmission,
        &[0.0; 7],
        &[0.0; 7],
        &STANDARD_GRAVITY,
        &Wrench::NONE,
    );
    let mut acceleration = [0.0; 7];
    acceleration[3] = 20.0;
    let torques = posture.motor_inverse_dynamics(
        &transmission,
        &[0.0; 7],
        &acceleration,
        &STANDARD_GRAVITY,
        &Wrench::NONE,
    );
    // with exactly these torques the fourth accelerates and the others keep still, unbraked
    let v = velocity_after(&mut arm, &torques);
    for (k, v) in v.iter().enumerate() {
        let expected = acceleration[k] * DT;
        // the posture is that of the middle of the refresh, at rest: the same
        assert!((v - expected).abs() < 1e-12, "{k}: {v} {expected}");
    }
    // without the coupling's share the fifth turns back
    let mut arm = Arm::new(Polycrank, RobotKind::Polycrank, &SWING, DT, frictionless);
    let mut alone = bias;
    alone[3] = torques[3];
    let v = velocity_after(&mut arm, &alone);
    assert!(v[4] < -0.3 * v[3] && v[3] > 20.0 * DT, "{v:?}");
}

/// Velocities after one substep in which the currents are at once what they should be.
fn velocity_after(arm: &mut Arm<Polycrank, 7>, torques: &[f64; 7]) -> [f64; 7] {
    arm.body.refresh(&arm.plants, DT);
    let efforts = torques.map(|torque_nm| Effort {
        torque_nm,
        dry_nm: 0.0,
    });
    arm.body.move_all(&mut arm.plants, &efforts, DT);
    arm.motion().velocity
}

#[test]
fn a_closed_brake_keeps_its_axis_while_another_moves_and_slips_when_overloaded() {
    let mut arm = Arm::new(Polycrank, RobotKind::Polycrank, &SWING, DT, |p| {
        p.stop_rad = [f64::NEG_INFINITY, f64::INFINITY];
    });
    let start = arm.motion().position.0;
    let mut commands = [Drive::default(); 7];
    commands[3] = Drive {
        torque_nm: 15.0,
        ..OPEN
    };
    arm.run(0.2, &commands);
    let now = arm.motion().position.0;
    for k in [0, 1, 2, 4, 5, 6] {
        assert!((now[k] - start[k]).abs() < 1e-12, "{k}");
    }
    assert!((now[3] - start[3]).abs() > 0.1, "{now:?}");
    // a brake of a tenth of what the weight needs does not hold
    let mut arm = Arm::new(Polycrank, RobotKind::Polycrank, &SWING, DT, |p| {
        (p.brake_nm, p.coulomb_nm) = (0.1, 0.0);
    });
    arm.run(0.2, &[Drive::default(); 7]);
    assert!((arm.motion().position.0[3] - start[3]).abs() > 0.05);
}

#[test]
fn a_stop_ends_the_travel_of_an_arm() {
    let mut arm = postument(|p| {
        (p.coulomb_nm, p.brake_nm) = (0.0, 0.0);
    });
    let mut commands = [OPEN; 6];
    commands[1].torque_nm = -2.0;
    arm.run(3.0, &commands);
    let stop = arm.plants[1].parameters().stop_rad[0];
    let motion = arm.motion();
    assert!(
        (motion.position.0[1] - stop).abs() < 1e-12,
        "{} {stop}",
        motion.position.0[1]
    );
    assert_eq!(motion.velocity[1].to_bits() << 1, 0);
}

#[test]
fn a_command_that_is_no_number_moves_nothing_and_leaves_numbers() {
    let mut arm = Arm::new(Polycrank, RobotKind::Polycrank, &SWING, DT, |_| ());
    for torque_nm in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        arm.run(0.5, &[Drive { torque_nm, ..OPEN }; 7]);
        let motion = arm.motion();
        assert!(
            motion
                .position
                .0
                .iter()
                .chain(&motion.velocity)
                .all(|x| x.is_finite())
        );
        // the greatest currents through viscous friction: 3 kW a kg·m² would be 1e5 J
        assert!(arm.energy()[0] < 1e6);
    }
}

#[test]
fn a_payload_weighs() {
    let weight = |payload: Option<&Body>| {
        let mut arm = postument(frictionless);
        assert!(arm.body.carry(payload));
        holding(&arm)
    };
    let shape = Shape::Box {
        centre: [0.0; 3],
        size: [0.1; 3],
    };
    let (empty, loaded) = (weight(None), weight(Some(&Body::homogeneous(2.0, &shape))));
    assert!(
        loaded[1].abs() > 1.05 * empty[1].abs(),
        "{empty:?} {loaded:?}"
    );
}
