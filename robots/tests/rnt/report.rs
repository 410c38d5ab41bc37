//! Singular values against nalgebra's, and reports where the answer is known.

use core::f64::consts::FRAC_PI_3;

use nalgebra::SMatrix;
use proptest::prelude::*;
use robots::report::{posture, singular_values};
use robots::rnt::HOME;
use robots::{Irp6Postument, Irp6Track, Joints, KinematicError, Rnt, Robot};

use super::{apart, within_limits};

proptest! {
    #[test]
    fn singular_values_are_those_of_another_library(
        rows in prop::array::uniform6(prop::array::uniform6(-2.0..2.0f64)),
    ) {
        let matrix = SMatrix::<f64, 6, 6>::from_fn(|i, j| rows[i][j]);
        let mut theirs: [f64; 6] = matrix.singular_values().into();
        theirs.sort_unstable_by(|a, b| b.total_cmp(a));
        let ours = singular_values(rows);
        // both keep 1e-15 of the greatest, at most 12
        prop_assert!(apart(&ours, &theirs) < 1e-13, "{ours:?} {theirs:?}");
    }

    #[test]
    fn the_product_is_the_determinant(
        unit in prop::array::uniform6(0.0..1.0f64), length in 0.5..2.0f64,
    ) {
        let q = within_limits(&unit);
        let report = posture(&Rnt, &q, length);
        // legs may be off their screws at the corners of the joints' ranges
        let Ok(report) = report else {
            prop_assert!(matches!(report, Err(KinematicError::Limit { .. })), "{report:?}");
            return Ok(());
        };
        let determinant = Rnt.jacobian(&q).determinant().abs();
        // three rows in units of the length; 1e-15 of singular values up to 4, five others up to 4
        let product = report.manipulability() * length * length * length;
        prop_assert!((product - determinant).abs() < 1e-11, "{report:?}");
        // in closed form: (r + d)²·cos tx from the central leg, sin w2 from the wrist
        let known = (q.0[2] + 0.12) * (q.0[2] + 0.12) * libm::cos(q.0[1]) * libm::sin(q.0[4]).abs();
        prop_assert!((determinant - known).abs() < 1e-13, "{determinant} {known}");
    }
}

#[test]
fn a_diagonal_is_its_own_answer_and_missing_columns_are_zero() {
    let diagonal = [[0.0, -3.0, 0.0], [0.5, 0.0, 0.0], [0.0, 0.0, 2.0]];
    assert!(apart(&singular_values(diagonal), &[3.0, 2.0, 0.5]) < 1e-15);
    let tall = [[3.0], [4.0], [0.0]];
    assert!(apart(&singular_values(tall), &[5.0, 0.0, 0.0]) < 1e-15);
    assert!(apart(&singular_values([[0.0; 4]; 3]), &[0.0; 3]) < 1e-300);
    // two equal rows
    let twins = [[1.0, 1.0], [1.0, 1.0]];
    assert!(apart(&singular_values(twins), &[2.0, 0.0]) < 1e-15);
    assert!(
        singular_values([[f64::NAN, 1.0], [0.0, 1.0]])
            .iter()
            .any(|v| v.is_nan())
    );
}

#[test]
fn a_singular_wrist_shows() {
    let mut q = HOME;
    let good = posture(&Rnt, &q, 0.15).unwrap();
    assert!(
        good.dexterity() > 0.3 && good.condition() < 40.0,
        "{good:?}"
    );
    q.0[4] = 0.0;
    let singular = posture(&Rnt, &q, 0.15).unwrap();
    assert!(
        singular.dexterity() < 1e-15 && singular.condition() > 1e14,
        "{singular:?}"
    );
    q.0[4] = 1e-3;
    let near = posture(&Rnt, &q, 0.15).unwrap();
    // two axes w2 apart cannot turn across both by more than w2/√2; the tilts, with their long levers,
    // take part a little
    let share = near.dexterity() / (1e-3 / libm::sqrt(2.0));
    assert!((0.99..1.0).contains(&share), "{near:?}");
}

#[test]
fn margins_name_the_axis_nearest_to_a_limit() {
    let mut q = HOME;
    q.0[4] = FRAC_PI_3 + 0.6;
    let report = posture(&Rnt, &q, 0.15).unwrap();
    let margin = report.joints.unwrap();
    assert_eq!(margin.axis, 4);
    let share = 1.0 - (FRAC_PI_3 + 0.6) / 110.0_f64.to_radians();
    assert!((margin.share - share).abs() < 1e-12, "{margin:?}");
    assert_eq!(report.motors.unwrap().axis, 4);
    q.0[2] = 1.45;
    let report = posture(&Rnt, &q, 0.15).unwrap();
    let margin = report.joints.unwrap();
    assert!(
        margin.axis == 2 && (margin.share + 0.05 / 0.3).abs() < 1e-12,
        "{margin:?}"
    );
    q.0[2] = f64::NAN;
    assert_eq!(posture(&Rnt, &q, 0.15), Err(KinematicError::NotFinite));
}

#[test]
fn other_robots_have_postures_too() {
    // sin t5 = 0 is the singularity of the IRp-6's wrist
    let mut q = Joints([0.0, -1.57, 0.0, 1.56, 1.57, -1.57]);
    assert!(posture(&Irp6Postument, &q, 0.25).unwrap().dexterity() > 0.1);
    q.0[4] = 0.0;
    assert!(posture(&Irp6Postument, &q, 0.25).unwrap().dexterity() < 1e-15);
    // with the track the column can turn the flange without moving it, though slowly
    let q = Joints([0.0, 0.0, -1.57, 0.0, 1.56, 0.0, -1.57]);
    let report = posture(&Irp6Track::KEEP, &q, 0.25).unwrap();
    assert!((1e-3..1e-2).contains(&report.dexterity()), "{report:?}");
    assert!(report.singular_values[0] > 1.0);
}
