//! What mechanics says of any arm, and of arms that are simple enough to solve.

use super::*;

/// Brakes, but neither friction nor stops.
fn braked(p: &mut PlantParameters) {
    (p.viscous_nms_rad, p.coulomb_nm) = (0.0, 0.0);
    p.stop_rad = [f64::NEG_INFINITY, f64::INFINITY];
}

/// Seconds of a period of a pendulum of the small-angle rate `omega` that swings by ±`most` rad: 2π/(ω·agm(1, cos(most/2))),
/// the complete elliptic integral by Gauss' mean.
fn period(omega: f64, most: f64) -> f64 {
    let (mut a, mut b) = (1.0, libm::cos(0.5 * most));
    for _ in 0..8 {
        (a, b) = (0.5 * (a + b), libm::sqrt(a * b));
    }
    core::f64::consts::TAU / (omega * a)
}

#[test]
fn one_free_crank_is_a_pendulum() {
    let posture = |q4: f64| Joints([0.0, 0.0, 0.0, q4, 0.5, -0.3, 0.0]);
    let chain = Polycrank.chain().unwrap();
    let hold = |q4: f64| chain.at(&posture(q4)).gravity_torques(&STANDARD_GRAVITY)[3];
    // the potential is −A·cos(q − φ), the torque that holds its derivative
    let (at_zero, at_quarter) = (hold(0.0), hold(core::f64::consts::FRAC_PI_2));
    let (most, down) = (
        libm::hypot(at_zero, at_quarter),
        libm::atan2(-at_zero, at_quarter),
    );
    let start = posture(down + 1.0);
    let transmission = Polycrank.transmission(&start).unwrap();
    let mass = transmission.mass_matrix(&chain.at(&start).mass_matrix())[(3, 3)];
    let expected = period(libm::sqrt(most / mass), 1.0);
    let mut arm = Arm::new(Polycrank, RobotKind::Polycrank, &start, DT, braked);
    let mut commands = [Drive::default(); 7];
    commands[3] = OPEN;
    let (mut before, mut crossings) = (1.0, Vec::new());
    for step in 0..20_000_u32 {
        arm.run(DT, &commands);
        let now = Polycrank.joints(&arm.motion().position).unwrap().0[3] - down;
        if before > 0.0 && now <= 0.0 {
            crossings.push(DT * (f64::from(step) + before / (before - now)));
        }
        before = now;
    }
    let count = crossings.len() - 1;
    #[expect(clippy::cast_precision_loss, reason = "small")]
    let measured = (crossings[count] - crossings[0]) / count as f64;
    println!("period {measured} s, expected {expected} s");
    // the first window after the brake opens is of first order: a ten-thousandth of its 0.5 ms
    assert!(count >= 3 && (measured / expected - 1.0).abs() < 1e-6);
}

/// Nothing turns the arm about the vertical through its base: the momentum about it stays, however the cranks fly.
#[test]
fn the_momentum_about_the_vertical_stays() {
    let mut arm = hanging(DT, REFRESH_DIRECT);
    for (k, plant) in arm.plants.iter_mut().enumerate() {
        plant.moved(plant.angle_rad(), [1.0, -2.0, 1.5, 0.0, 0.0, 0.0, 0.0][k]);
    }
    let momentum = |arm: &Arm<Polycrank, 7>| {
        let (mass, _) = arm
            .body
            .equations(&arm.motion().position, &arm.motion().velocity)
            .unwrap();
        let v = arm.motion().velocity;
        mass[0].iter().zip(v).map(|(m, v)| m * v).sum::<f64>()
    };
    let begin = momentum(&arm);
    let mut turned: f64 = 0.0;
    for _ in 0..300 {
        arm.run(0.01, &[OPEN; 7]);
        let change = (arm.motion().velocity[0] - 1.0).abs();
        turned = if change > turned { change } else { turned };
    }
    let end = momentum(&arm);
    println!("momentum {begin} and {end}, the base axis by {turned} rad/s");
    // started at speed, the first windows are of low order: measured 1e-6
    assert!(turned > 0.5 && begin.abs() > 0.1);
    assert!((end / begin - 1.0).abs() < 1e-5, "{begin} {end}");
}

/// Full torque to and fro at random, with and without friction: faster than any arm could bear, and still numbers.
#[test]
fn no_torque_makes_an_arm_leave_the_numbers() {
    for seed in 0..6 {
        let mut random = SplitMix64::stream(seed, "torque", 0);
        let mut arm = Arm::new(Polycrank, RobotKind::Polycrank, &SWING, DT, |p| {
            if seed % 2 == 0 {
                frictionless(p);
            }
        });
        for _ in 0..400 {
            let commands = [(); 7].map(|()| Drive {
                torque_nm: if random.coin() { 1e9 } else { -1e9 },
                release_brake: true,
            });
            arm.run(0.01, &commands);
        }
        let motion = arm.motion();
        let fastest = motion
            .velocity
            .iter()
            .fold(0.0, |a: f64, v| if v.abs() > a { v.abs() } else { a });
        println!("{seed}: {fastest} rad/s, order {}", arm.body.smooth.order());
        assert!(fastest.is_finite() && arm.energy()[0].is_finite());
    }
}
