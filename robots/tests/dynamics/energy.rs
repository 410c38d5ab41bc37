//! Free motion keeps the energy.

use nalgebra::{SVector, Vector3};
use robots::Joints;
use robots::dynamics::{
    Chain, IRP6_ARM, IRP6_POSTUMENT, IRP6_TRACK, POLYCRANK, STANDARD_GRAVITY, Wrench,
};

use super::rnt;

const STEP_S: f64 = 1e-4;
const STEPS: u32 = 100_000;

/// The greatest change of the energy over 10 s of free motion, by Runge and Kutta's
/// fourth-order method, relative to the greatest kinetic energy.
fn drift<const N: usize>(
    chain: &Chain<N>,
    start: [f64; N],
    velocity: [f64; N],
    gravity: &Vector3<f64>,
) -> f64 {
    let acceleration = |q: &SVector<f64, N>, v: &SVector<f64, N>| {
        let found = chain.at(&Joints(q.data.0[0])).forward_dynamics(
            &v.data.0[0],
            &[0.0; N],
            gravity,
            &Wrench::NONE,
        );
        SVector::from(found)
    };
    let energies = |q: &SVector<f64, N>, v: &SVector<f64, N>| {
        let posture = chain.at(&Joints(q.data.0[0]));
        let kinetic = posture.kinetic_energy(&v.data.0[0]);
        (kinetic, kinetic + posture.potential_energy(gravity))
    };
    let (mut q, mut v) = (SVector::from(start), SVector::from(velocity));
    let (_, total) = energies(&q, &v);
    let (mut worst, mut most_kinetic) = (0.0_f64, 0.0_f64);
    let h = STEP_S;
    for step in 1..=STEPS {
        let a1 = acceleration(&q, &v);
        let v2 = v + a1 * (0.5 * h);
        let a2 = acceleration(&(q + v * (0.5 * h)), &v2);
        let v3 = v + a2 * (0.5 * h);
        let a3 = acceleration(&(q + v2 * (0.5 * h)), &v3);
        let v4 = v + a3 * h;
        let a4 = acceleration(&(q + v3 * h), &v4);
        q += (v + (v2 + v3) * 2.0 + v4) * (h / 6.0);
        v += (a1 + (a2 + a3) * 2.0 + a4) * (h / 6.0);
        if step % 20 == 0 {
            let (kinetic, now) = energies(&q, &v);
            let off = (now - total).abs();
            assert!(off.is_finite());
            worst = if off > worst { off } else { worst };
            most_kinetic = if kinetic > most_kinetic {
                kinetic
            } else {
                most_kinetic
            };
        }
    }
    assert!(most_kinetic > 1.0, "it moved: {most_kinetic} J");
    worst / most_kinetic
}

/// Ten seconds, 0.1 ms a step: the bound is the method's error, far above rounding.
#[test]
fn ten_seconds_of_free_motion_keep_the_energy() {
    let falling = &STANDARD_GRAVITY;
    let drifts = [
        (
            "IRp-6 arm",
            drift(&IRP6_ARM, [0.3, -1.2, 0.2, 0.5, 0.7], [0.0; 5], falling),
        ),
        (
            "IRp-6 on its postument",
            drift(
                &IRP6_POSTUMENT,
                [0.3, -1.2, 0.2, 0.5, 0.7, 0.1],
                [0.0; 6],
                falling,
            ),
        ),
        (
            "IRp-6 on its track",
            drift(
                &IRP6_TRACK,
                [0.0, 0.3, -1.2, 0.2, 0.5, 0.7, 0.1],
                [0.0; 7],
                falling,
            ),
        ),
        (
            "Polycrank",
            drift(
                &POLYCRANK,
                [0.3, -1.2, 0.2, 0.5, 0.7, 0.1, 0.4],
                [0.0; 7],
                falling,
            ),
        ),
        // its leg would slide out without end, and its fall would hide every error
        (
            "RNT, weightless",
            drift(
                &rnt(),
                [0.1, 0.2, 1.1, 0.3, 0.4, 0.5],
                [1.0, -0.5, 0.2, 3.0, 2.0, 4.0],
                &Vector3::zeros(),
            ),
        ),
    ];
    for (name, drift) in drifts {
        println!("{name}: {drift:.1e}");
        assert!(drift < 1e-6, "{name}: {drift}");
    }
}
