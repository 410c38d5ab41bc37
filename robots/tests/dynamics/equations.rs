//! The equations of motion against each other and against Lagrange's, by differences of the energy.

use nalgebra::{SVector, Vector3, Vector6};
use proptest::prelude::*;
use robots::Joints;
use robots::dynamics::{Body, Chain, Inertia, POLYCRANK, STANDARD_GRAVITY, Wrench};

use super::{State, apart, numbers, on_every_chain, state};

const WEIGHTLESS: Vector3<f64> = Vector3::new(0.0, 0.0, 0.0);

/// Gravity along no axis.
const SKEW: Vector3<f64> = Vector3::new(1.0, -2.0, -9.0);

fn unit<const N: usize>(k: usize) -> [f64; N] {
    let mut unit = [0.0; N];
    unit[k] = 1.0;
    unit
}

fn moved<const N: usize>(q: &Joints<N>, by: f64, along: &[f64; N]) -> Joints<N> {
    let mut q = *q;
    for (q, along) in q.0.iter_mut().zip(along) {
        *q += by * along;
    }
    q
}

fn mass_matrix<const N: usize>(chain: &Chain<N>, state: &State) -> Result<(), TestCaseError> {
    let posture = chain.at(&state.joints());
    let m = posture.mass_matrix();
    // rounding of sums of some 30 terms
    let tolerance = 1e-13 * m.amax();
    for i in 0..N {
        let column = posture.inverse_dynamics(&[0.0; N], &unit(i), &WEIGHTLESS, &Wrench::NONE);
        prop_assert!(apart(&column, m.column(i).as_slice()) < tolerance, "{i}");
        for j in 0..N {
            let mut both = unit::<N>(i);
            both[j] += 1.0;
            let energy = |dq: &[f64; N]| posture.kinetic_energy(dq);
            let entry = energy(&both) - energy(&unit(i)) - energy(&unit(j));
            prop_assert!((entry - m[(i, j)]).abs() < 2.0 * tolerance, "{i} {j}");
            prop_assert_eq!(m[(i, j)].to_bits(), m[(j, i)].to_bits());
        }
    }
    prop_assert!(m.cholesky().is_some(), "not positive definite: {m}");
    Ok(())
}

/// τ = d/dt(∂T/∂q̇) − ∂T/∂q + ∂V/∂q = M·q̈ + Ṁ·q̇ − ∂T/∂q + ∂V/∂q.
fn lagrange<const N: usize>(chain: &Chain<N>, state: &State) -> Result<(), TestCaseError> {
    let (q, dq, ddq) = (state.joints::<N>(), state.velocity(), state.acceleration());
    let h = 1e-5;
    let here = chain.at(&q);
    let m = here.mass_matrix();
    let (plus, minus) = (moved(&q, h, &dq), moved(&q, -h, &dq));
    let m_rate = (chain.at(&plus).mass_matrix() - chain.at(&minus).mass_matrix()) / (2.0 * h);
    let mut expected = m * SVector::from(ddq) + m_rate * SVector::from(dq);
    for k in 0..N {
        let lagrangian = |by: f64| {
            let posture = chain.at(&moved(&q, by, &unit(k)));
            posture.kinetic_energy(&dq) - posture.potential_energy(&SKEW)
        };
        expected[k] -= (lagrangian(h) - lagrangian(-h)) / (2.0 * h);
    }
    let torques = here.inverse_dynamics(&dq, &ddq, &SKEW, &Wrench::NONE);
    // energies of up to 3 kJ: rounding 4e-13 J / h; the third derivatives times h²/6 are below
    let error = apart(&torques, expected.as_slice());
    prop_assert!(error < 2e-6, "{error}: {torques:?} {expected}");
    Ok(())
}

fn forward_undoes_inverse<const N: usize>(
    chain: &Chain<N>,
    state: &State,
) -> Result<(), TestCaseError> {
    let (dq, ddq) = (state.velocity::<N>(), state.acceleration::<N>());
    let posture = chain.at(&state.joints());
    let wrench = Wrench {
        force: Vector3::new(10.0, -20.0, 5.0),
        moment: Vector3::new(1.0, 2.0, -3.0),
    };
    let torques = posture.inverse_dynamics(&dq, &ddq, &SKEW, &wrench);
    let found = posture.forward_dynamics(&dq, &torques, &SKEW, &wrench);
    // torques are right to about 1e-14 of the largest; the least inertia, of the last link, divides
    let m = posture.mass_matrix();
    let inverse = m.cholesky().unwrap().inverse().amax();
    let size = torques.iter().fold(m.amax(), |most, t| most + t.abs());
    let error = apart(&found, &ddq);
    prop_assert!(
        error < 1e-13 * size * inverse,
        "{error:e} of {size} · {inverse}"
    );
    // and the torques of what was found are the torques given
    let back = posture.inverse_dynamics(&dq, &found, &SKEW, &wrench);
    prop_assert!(apart(&back, &torques) < 1e-14 * size * 5.0);
    Ok(())
}

fn a_wrench_is_felt<const N: usize>(chain: &Chain<N>, state: &State) -> Result<(), TestCaseError> {
    let (dq, ddq) = (state.velocity::<N>(), state.acceleration());
    let posture = chain.at(&state.joints());
    let wrench = Wrench {
        force: Vector3::new(10.0, -20.0, 5.0),
        moment: Vector3::new(1.0, 2.0, -3.0),
    };
    let loaded = posture.inverse_dynamics(&dq, &ddq, &SKEW, &wrench);
    let free = posture.inverse_dynamics(&dq, &ddq, &SKEW, &Wrench::NONE);
    let to_base = posture.flange().rotation;
    let (force, moment) = (to_base * wrench.force, to_base * wrench.moment);
    let in_base = Vector6::new(force.x, force.y, force.z, moment.x, moment.y, moment.z);
    let expected = SVector::from(free) - posture.jacobian().transpose() * in_base;
    // torques up to 2 kN·m
    prop_assert!(apart(&loaded, expected.as_slice()) < 1e-11);
    Ok(())
}

/// A body on the flange: energy and weight by the flange's Jacobian.
fn a_payload_is_carried<const N: usize>(
    chain: &Chain<N>,
    state: &State,
) -> Result<(), TestCaseError> {
    let centre = Vector3::new(0.05, -0.1, 0.2);
    let body = Body {
        mass_kg: 2.5,
        centre_m: centre.into(),
        inertia: Inertia {
            xx: 0.02,
            yy: 0.03,
            zz: 0.04,
            xy: 0.001,
            xz: -0.002,
            yz: 0.003,
        },
    };
    let i = body.inertia;
    let inertia = nalgebra::Matrix3::new(i.xx, i.xy, i.xz, i.xy, i.yy, i.yz, i.xz, i.yz, i.zz);
    let loaded_chain = chain.with_payload(&body);
    let (q, dq) = (state.joints::<N>(), state.velocity::<N>());
    let (free, loaded) = (chain.at(&q), loaded_chain.at(&q));
    let twist = free.jacobian() * SVector::from(dq);
    let flange = free.flange();
    let (v, w) = (twist.fixed_rows::<3>(0), twist.fixed_rows::<3>(3));
    let at_centre = v + w.cross(&(flange.rotation * centre));
    let w = flange.rotation.transpose() * w;
    let energy = 0.5 * 2.5 * at_centre.dot(&at_centre) + 0.5 * w.dot(&(inertia * w));
    let more = loaded.kinetic_energy(&dq) - free.kinetic_energy(&dq);
    prop_assert!(
        (more - energy).abs() < 1e-12 * loaded.kinetic_energy(&dq),
        "{more} {energy}"
    );
    let height = flange.position + flange.rotation * centre;
    let more = loaded.potential_energy(&SKEW) - free.potential_energy(&SKEW);
    prop_assert!((more + 2.5 * SKEW.dot(&height)).abs() < 1e-11);
    // what `body` says of the last link is what the equations use
    let last = loaded_chain.links[N - 1].body();
    let unloaded = chain.links[N - 1].body();
    prop_assert!((last.mass_kg - unloaded.mass_kg - 2.5).abs() < 1e-14);
    let same = Chain {
        links: loaded_chain.links,
        flange: loaded_chain.flange,
    }
    .with_payload(&Body {
        mass_kg: 0.0,
        centre_m: [0.3, 0.1, 0.2],
        inertia: Inertia {
            xx: 0.0,
            yy: 0.0,
            zz: 0.0,
            xy: 0.0,
            xz: 0.0,
            yz: 0.0,
        },
    });
    let again = same.links[N - 1].body();
    prop_assert!(apart(&again.centre_m, &last.centre_m) < 1e-15);
    Ok(())
}

fn a_jacobian_is_the_derivative<const N: usize>(
    chain: &Chain<N>,
    state: &State,
) -> Result<(), TestCaseError> {
    let q = state.joints::<N>();
    let jacobian = chain.at(&q).jacobian();
    let h = 1e-6;
    for k in 0..N {
        let flange = |by: f64| chain.at(&moved(&q, by, &unit(k))).flange();
        let (plus, minus) = (flange(h), flange(-h));
        let linear = (plus.position - minus.position) / (2.0 * h);
        let turn = motion::pose::log(&(plus.rotation * minus.rotation.transpose()));
        let angular = turn / (2.0 * h);
        // rounding 4e-16/h and h² of differences
        let column = jacobian.column(k);
        prop_assert!((column.fixed_rows::<3>(0) - linear).amax() < 2e-9);
        prop_assert!((column.fixed_rows::<3>(3) - angular).amax() < 2e-9);
    }
    Ok(())
}

proptest! {
    #[test]
    fn the_mass_matrix_is_that_of_the_kinetic_energy(state in state()) {
        on_every_chain!(mass_matrix, state);
    }

    #[test]
    fn torques_are_those_of_lagrange(state in state()) {
        on_every_chain!(lagrange, state);
    }

    #[test]
    fn acceleration_of_the_torques_of_an_acceleration_is_the_acceleration(state in state()) {
        on_every_chain!(forward_undoes_inverse, state);
    }

    #[test]
    fn a_wrench_at_the_flange_is_felt_by_the_jacobian(state in state()) {
        on_every_chain!(a_wrench_is_felt, state);
    }

    #[test]
    fn a_payload_adds_its_own_energy_and_weight(state in state()) {
        on_every_chain!(a_payload_is_carried, state);
    }

    #[test]
    fn the_jacobian_is_the_derivative_of_the_flange(state in state()) {
        on_every_chain!(a_jacobian_is_the_derivative, state);
    }

    #[test]
    fn gravity_and_bias_are_parts_of_the_torque(q in numbers::<7>(3.0), dq in numbers::<7>(2.0)) {
        let posture = POLYCRANK.at(&Joints(q));
        let hold = posture.gravity_torques(&STANDARD_GRAVITY);
        let bias = posture.bias_torques(&dq, &STANDARD_GRAVITY, &Wrench::NONE);
        let swing = posture.bias_torques(&dq, &WEIGHTLESS, &Wrench::NONE);
        let sum: Vec<f64> = hold.iter().zip(swing).map(|(a, b)| a + b).collect();
        // torques up to 1 kN·m
        prop_assert!(apart(&bias, &sum) < 1e-11);
        // the first three axes are vertical
        prop_assert!(hold[..3].iter().all(|torque| torque.abs() < 1e-12), "{hold:?}");
        let turning_back = posture.bias_torques(&dq.map(|v| -v), &WEIGHTLESS, &Wrench::NONE);
        prop_assert!(apart(&turning_back, &swing) < 1e-11, "even in the velocity");
    }
}

#[test]
fn what_is_not_a_number_goes_through() {
    let posture = POLYCRANK.at(&Joints([0.0, f64::NAN, 0.0, 0.0, 0.0, 0.0, 0.0]));
    assert!(posture.gravity_torques(&STANDARD_GRAVITY)[4].is_nan());
    assert!(posture.mass_matrix()[(0, 0)].is_nan());
    let posture = POLYCRANK.at(&Joints([0.1; 7]));
    let found = posture.forward_dynamics(
        &[0.0; 7],
        &[f64::INFINITY; 7],
        &STANDARD_GRAVITY,
        &Wrench::NONE,
    );
    assert!(found.iter().all(|a| !a.is_finite()));
}
