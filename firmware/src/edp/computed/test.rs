use super::*;
use robots::{Conveyor, Irp6Postument, Polycrank};

const TS: f64 = 0.002;

fn at_rest(angles: [f64; 7]) -> MotorMotion<7> {
    MotorMotion {
        position: Motors(angles),
        velocity: [0.0; 7],
        acceleration: [0.0; 7],
    }
}

fn still(angles: &[f64; 7]) -> [Measured; 7] {
    angles.map(|angle| Measured {
        angle,
        current_ma: 0.0,
        follows: true,
    })
}

fn demand() -> MotorMotion<7> {
    MotorMotion {
        position: Motors([0.3, -0.8, 0.5, 0.2, -0.4, 0.3, 0.0]),
        velocity: [1.0, -2.0, 0.5, 1.5, 2.0, -1.0, 3.0],
        acceleration: [5.0, 4.0, -3.0, 2.0, -1.0, 6.0, 7.0],
    }
}

#[test]
fn a_robot_without_a_chain_does_not_have_the_law() {
    assert!(ComputedTorque::<1>::new(&Conveyor, TS).is_none());
    assert!(ComputedTorque::<6>::new(&Irp6Postument, TS).is_some());
}

#[test]
fn without_errors_it_gives_the_torques_of_the_equation_of_motion() {
    let mut law = ComputedTorque::new(&Polycrank, TS).unwrap();
    law.begin();
    let d = demand();
    // where the encoders were a step ago, so that the measured velocities are those demanded
    let before: [f64; 7] = core::array::from_fn(|k| d.position.0[k] - TS * d.velocity[k]);
    let standing = at_rest(before);
    law.step(&Polycrank, &standing, &still(&before)).unwrap();
    let currents = law.step(&Polycrank, &d, &still(&d.position.0)).unwrap();
    let q = Joints(d.position.0);
    let transmission = Polycrank.transmission(&q).unwrap();
    let chain = Polycrank.chain().unwrap();
    let torques = chain.at(&q).motor_inverse_dynamics(
        &transmission,
        &d.velocity,
        &d.acceleration,
        &STANDARD_GRAVITY,
        &Wrench::NONE,
    );
    for (k, axis) in Polycrank.description().axes.iter().enumerate() {
        let m = axis.motor;
        let friction = m.viscous_nms_rad * d.velocity[k] + m.coulomb_nm * d.velocity[k].signum();
        let torque = currents[k] * 1e-3 * m.torque_constant_nm_a;
        // dry friction is blended: at 0.5 rad/s of 6.3 to 97 %
        let tolerance = 0.04 * m.coulomb_nm + 1e-9;
        assert!(
            (torque - torques[k] - friction).abs() < tolerance,
            "{k}: {torque}"
        );
    }
}

#[test]
fn an_error_of_one_axis_is_answered_on_all_as_the_mass_matrix_says() {
    let d = at_rest(demand().position.0);
    let mut currents = [[0.0; 7]; 2];
    for (currents, error) in currents.iter_mut().zip([0.0, 1e-4]) {
        let mut law = ComputedTorque::new(&Polycrank, TS).unwrap();
        law.begin();
        let mut actual = d.position.0;
        actual[1] -= error;
        *currents = law.step(&Polycrank, &d, &still(&actual)).unwrap();
    }
    let q = Joints(d.position.0);
    let matrix = Polycrank.chain().unwrap().at(&q).mass_matrix();
    let matrix = Polycrank.transmission(&q).unwrap().mass_matrix(&matrix);
    for (k, axis) in Polycrank.description().axes.iter().enumerate() {
        let constant = axis.motor.torque_constant_nm_a;
        let answered = (currents[1][k] - currents[0][k]) * 1e-3 * constant;
        let expected = matrix[(k, 1)] * 1600.0 * 1e-4;
        assert!(
            (answered - expected).abs() < 1e-9,
            "{k}: {answered} {expected}"
        );
    }
}

#[test]
fn taking_over_goes_on_with_the_currents_there_are() {
    let mut law = ComputedTorque::new(&Polycrank, TS).unwrap();
    let d = at_rest(demand().position.0);
    let mut measured = still(&d.position.0);
    for (k, axis) in measured.iter_mut().enumerate() {
        axis.angle += 1e-5;
        axis.current_ma = [3000.0, -2000.0, 100.0, 5000.0, 1500.0, -40.0, 9.0][k];
    }
    let currents = law.step(&Polycrank, &d, &measured).unwrap();
    for (current, axis) in currents.iter().zip(measured) {
        // two solutions of a system of condition 1e4, of 10 A
        assert!((current - axis.current_ma).abs() < 1e-6, "{current}");
    }
}

#[test]
fn saturated_axes_do_not_wind_up_and_all_stay_within_their_current() {
    let mut law = ComputedTorque::new(&Polycrank, TS).unwrap();
    law.begin();
    let d = at_rest(demand().position.0);
    let far = d.position.0.map(|x| x - 1.0);
    for _ in 0..1000 {
        let currents = law.step(&Polycrank, &d, &still(&far)).unwrap();
        for (current, axis) in currents.iter().zip(&Polycrank.description().axes) {
            assert!(current.abs() <= axis.current_regulator.limit_ma * (1.0 + 1e-12));
        }
    }
    assert!(
        law.integral.iter().all(|i| i.abs() < 0.5),
        "{:?}",
        law.integral
    );
    // nor while a drive does not follow yet
    law.begin();
    let mut waiting = still(&d.position.0.map(|x| x - 1e-3));
    for axis in &mut waiting {
        axis.follows = false;
    }
    for _ in 0..100 {
        law.step(&Polycrank, &d, &waiting).unwrap();
    }
    assert_eq!(law.integral.map(f64::to_bits), [0; 7]);
}

#[test]
fn a_demand_without_a_posture_gives_no_torques() {
    let mut law = ComputedTorque::new(&Polycrank, TS).unwrap();
    let mut d = demand();
    d.position.0[2] = f64::NAN;
    assert!(law.step(&Polycrank, &d, &still(&[0.0; 7])).is_err());
}
