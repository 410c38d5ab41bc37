use super::*;
use robots::{Conveyor, Irp6Postument, Joints, Polycrank, Rnt};

const TS: f64 = 0.002;
/// Drive units of these tests in a rad.
const UNITS: f64 = 1e6;

fn at_rest(angles: [f64; 7]) -> Setpoint<7> {
    Setpoint::at_rest(angles.map(Angle::bound))
}

/// Axes without current that are so far behind a demand.
fn behind(demand: &Setpoint<7>, errors: [f64; 7]) -> [Measured; 7] {
    core::array::from_fn(|k| {
        let actual = demand.position[k].to_f64() - errors[k];
        #[expect(clippy::cast_possible_truncation, reason = "some 10^6")]
        let units = libm::round(actual * UNITS) as i64;
        Measured {
            error: narrow(errors[k]),
            units,
            rad_per_unit: narrow(1.0 / UNITS),
            current_ma: 0.0,
            follows: true,
        }
    })
}

fn demand() -> Setpoint<7> {
    Setpoint {
        position: [0.3, -0.8, 0.5, 0.2, -0.4, 0.3, 0.0].map(Angle::bound),
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
fn only_a_robot_with_legs_has_its_model_in_f64() {
    let model = |law: Option<ComputedTorque<6>>| law.unwrap().model.is_some();
    assert!(model(ComputedTorque::new(&Irp6Postument, TS)));
    assert!(!model(ComputedTorque::new(&Rnt, TS)));
    let demand = Setpoint::at_rest([Angle::ZERO; 6]);
    let torques = ComputedTorque::new(&Rnt, TS)
        .unwrap()
        .model(&Rnt, &demand)
        .unwrap();
    assert!(
        torques.iter().any(|torque| torque.abs() > 1e-3),
        "{torques:?}"
    );
}

#[test]
fn without_errors_it_gives_the_torques_of_the_equation_of_motion() {
    let mut law = ComputedTorque::new(&Polycrank, TS).unwrap();
    law.begin();
    let d = demand();
    // where the encoders were a step ago, so that the measured velocities are those demanded
    let velocity = d.velocity.map(f64::from);
    let before: [f64; 7] = core::array::from_fn(|k| d.position[k].to_f64() - TS * velocity[k]);
    let standing = at_rest(before);
    law.step(&Polycrank, &standing, &behind(&standing, [0.0; 7]))
        .unwrap();
    let currents = law.step(&Polycrank, &d, &behind(&d, [0.0; 7])).unwrap();
    let q = Joints(d.position.map(Angle::to_f64));
    let transmission = Polycrank.transmission(&q).unwrap();
    let chain = Polycrank.chain().unwrap();
    let torques = chain.at(&q).motor_inverse_dynamics(
        &transmission,
        &velocity,
        &d.acceleration.map(f64::from),
        &STANDARD_GRAVITY,
        &Wrench::NONE,
    );
    let mass = transmission.mass_matrix(&chain.at(&q).mass_matrix());
    for (k, axis) in Polycrank.description().axes.iter().enumerate() {
        let m = axis.motor;
        let friction = m.viscous_nms_rad * velocity[k] + m.coulomb_nm * velocity[k].signum();
        let torque = f64::from(currents[k]) * 1e-3 * m.torque_constant_nm_a;
        // dry friction is blended: at 0.5 rad/s of 6.3 to 97 %; the velocity measured is off by one unit in a
        // step, which the law takes for an error on every axis; and f32
        let rate = 2.0 * DIRECT_BANDWIDTH_STEPS / TS / UNITS / TS;
        let unit: f64 = (0..7).map(|i| mass[(k, i)].abs() * rate).sum();
        let tolerance = 0.04 * m.coulomb_nm + unit + 1e-5 * torques[k].abs() + 1e-4;
        assert!(
            (torque - torques[k] - friction).abs() < tolerance,
            "{k}: {torque}"
        );
    }
}

#[test]
fn an_error_of_one_axis_is_answered_on_all_as_the_mass_matrix_says() {
    let d = at_rest(demand().position.map(Angle::to_f64));
    let mut currents = [[0.0; 7]; 2];
    for (currents, error) in currents.iter_mut().zip([0.0, 1e-2]) {
        let mut law = ComputedTorque::new(&Polycrank, TS).unwrap();
        law.begin();
        let errors = [0.0, error, 0.0, 0.0, 0.0, 0.0, 0.0];
        *currents = law.step(&Polycrank, &d, &behind(&d, errors)).unwrap();
    }
    let q = Joints(d.position.map(Angle::to_f64));
    let matrix = Polycrank.chain().unwrap().at(&q).mass_matrix();
    let matrix = Polycrank.transmission(&q).unwrap().mass_matrix(&matrix);
    for (k, axis) in Polycrank.description().axes.iter().enumerate() {
        let constant = axis.motor.torque_constant_nm_a;
        let answered = f64::from(currents[1][k] - currents[0][k]) * 1e-3 * constant;
        let expected = matrix[(k, 1)] * 1600.0 * 1e-2;
        // f32 of torques of up to 100 N·m, by some twenty roundings
        assert!(
            (answered - expected).abs() < 1e-4,
            "{k}: {answered} {expected}"
        );
    }
}

#[test]
fn taking_over_goes_on_with_the_currents_there_are() {
    let mut law = ComputedTorque::new(&Polycrank, TS).unwrap();
    let d = at_rest(demand().position.map(Angle::to_f64));
    let mut measured = behind(&d, [-1e-5; 7]);
    for (k, axis) in measured.iter_mut().enumerate() {
        axis.current_ma = [3000.0, -2000.0, 100.0, 5000.0, 1500.0, -40.0, 9.0][k];
    }
    let currents = law.step(&Polycrank, &d, &measured).unwrap();
    for (current, axis) in currents.iter().zip(measured) {
        // f32 of torques of up to 100 N·m, of which a few are added: of 5 A
        assert!((current - axis.current_ma).abs() < 0.01, "{current}");
    }
    // and an error is answered from there on, as it is without
    for axis in &mut measured {
        axis.error = 0.0;
    }
    let before = law.step(&Polycrank, &d, &measured).unwrap();
    let mut alone = ComputedTorque::new(&Polycrank, TS).unwrap();
    alone.begin();
    alone.step(&Polycrank, &d, &measured).unwrap();
    let alone = alone.step(&Polycrank, &d, &measured).unwrap();
    for ((before, alone), (now, held)) in
        before.iter().zip(alone).zip(currents.iter().zip(law.held))
    {
        let held = held / (before - alone);
        assert!(held > 0.0 && held.is_finite(), "{held} {now}");
    }
}

#[test]
fn saturated_axes_do_not_wind_up_and_all_stay_within_their_current() {
    let mut law = ComputedTorque::new(&Polycrank, TS).unwrap();
    law.begin();
    let d = at_rest(demand().position.map(Angle::to_f64));
    for _ in 0..1000 {
        let currents = law.step(&Polycrank, &d, &behind(&d, [1.0; 7])).unwrap();
        for (current, axis) in currents.iter().zip(&Polycrank.description().axes) {
            let limit = axis.current_regulator.limit_ma * (1.0 + 1e-6);
            assert!(f64::from(current.abs()) <= limit);
        }
    }
    assert!(
        law.integral.iter().all(|i| i.abs() < 0.5),
        "{:?}",
        law.integral
    );
    // nor while a drive does not follow yet
    law.begin();
    let mut waiting = behind(&d, [1e-3; 7]);
    for axis in &mut waiting {
        axis.follows = false;
    }
    for _ in 0..100 {
        law.step(&Polycrank, &d, &waiting).unwrap();
    }
    assert_eq!(law.integral.map(f32::to_bits), [0; 7]);
}

#[test]
fn a_demand_without_a_posture_gives_no_torques() {
    let mut law = ComputedTorque::new(&Irp6Postument, TS).unwrap();
    law.begin();
    let mut d = Setpoint::at_rest([Angle::ZERO; 6]);
    let measured = [Measured::NOTHING; 6];
    assert!(law.step(&Irp6Postument, &d, &measured).is_ok());
    // beyond the end of a screw
    d.position[1] = Angle::bound(1000.0);
    assert!(law.step(&Irp6Postument, &d, &measured).is_err());
}
