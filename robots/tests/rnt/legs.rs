//! From leg lengths to the platform: everywhere in the workspace, and never to another assembly.

use core::f64::consts::FRAC_PI_4;

use proptest::prelude::*;
use robots::{KinematicError, Quantity, Rnt, Robot};

use super::{Numbers, apart, distances};

const MOST_STEPS: u32 = 4;

/// The platform found for its own legs, and the steps it took.
fn returns(ty: f64, tx: f64, reach: f64) -> u32 {
    let lengths = distances(ty, tx, reach);
    let (found, steps) = Rnt
        .assembled(lengths)
        .unwrap_or_else(|error| panic!("{ty} {tx} {reach}: {error}"));
    // legs good to 1e-12 m determine tilts to 1e-12 m over the least slope, 0.1 m/rad
    assert!(
        apart(&found, &[ty, tx, reach]) < 1e-11,
        "{found:?} {ty} {tx} {reach}"
    );
    let back = distances(found[0], found[1], found[2]);
    assert!(apart(&back, &lengths) < 1e-12, "{back:?} {lengths:?}");
    steps
}

#[test]
fn legs_are_those_of_the_published_check() {
    let legs = Rnt
        .legs(&robots::Joints([
            (-10.0_f64).to_radians(),
            20.0_f64.to_radians(),
            1.0,
            0.0,
            0.0,
            0.0,
        ]))
        .unwrap();
    // six printed digits
    assert!(
        apart(&legs, &[0.892_256, 1.148_313, 1.042_280]) < 5e-7,
        "{legs:?}"
    );
}

#[test]
fn every_platform_of_a_dense_grid_is_found_from_its_legs_in_few_steps() {
    let mut most = 0;
    for i in 0..=70 {
        for j in 0..=70 {
            for k in 0..=30 {
                let (ty, tx) = (f64::from(i - 35), f64::from(j - 35));
                let reach = 0.8 + 0.02 * f64::from(k);
                let steps = returns(ty.to_radians(), tx.to_radians(), reach);
                most = if steps > most { steps } else { most };
            }
        }
    }
    assert_eq!(most, MOST_STEPS);
}

#[test]
fn a_hundred_thousand_random_platforms_are_found_from_their_legs_in_few_steps() {
    let mut numbers = Numbers(1);
    let mut most = 0;
    let mut found = 0;
    while found < 100_000 {
        // up to the ends of what is known: 45°, 0.5 m to 1.7 m
        let [ty, tx, r] = [(); 3].map(|()| numbers.unit());
        let (ty, tx) = ((2.0 * ty - 1.0) * 0.785, (2.0 * tx - 1.0) * 0.785);
        let reach = 0.501 + 1.1 * r;
        if distances(ty, tx, reach)
            .iter()
            .all(|l| (0.50..=1.70).contains(l))
        {
            let steps = returns(ty, tx, reach);
            most = if steps > most { steps } else { most };
            found += 1;
        }
    }
    assert!(most <= MOST_STEPS, "{most}");
}

/// F(ty, tx) of the crate's documentation, by other means: what the legs lack in length if the platform
/// has these tilts and the reach that the sum of their squares asks for, weighted by cos φ and sin φ.
fn lack(lengths: &[f64; 3], ty: f64, tx: f64) -> Option<[f64; 2]> {
    let square: f64 = lengths.iter().map(|l| l * l).sum();
    let at_1: f64 = distances(ty, tx, 1.0).iter().map(|l| l * l).sum();
    let reach2 = (square - at_1) / 3.0 + 1.0;
    if reach2 < 0.25 {
        return None;
    }
    let mut sums = [0.0; 2];
    for ((have, want), degrees) in distances(ty, tx, libm::sqrt(reach2))
        .iter()
        .zip(lengths)
        .zip([90.0_f64, 210.0, 330.0])
    {
        let (s, c) = libm::sincos(degrees.to_radians());
        let weight = (have * have - want * want) * 2.0 / 3.0 / 0.40;
        sums[0] += weight * c;
        sums[1] += weight * s;
    }
    Some(sums)
}

/// Whether the legs can be joined within 45°, by a slow way: F (with its second part negated) is strongly
/// monotone, so p ← p − γF(p), brought back into the square of tilts, goes to the only point where F is
/// zero or pushes out of the square.
fn joined(lengths: &[f64; 3]) -> bool {
    let within = |t: f64| t.clamp(-FRAC_PI_4, FRAC_PI_4);
    let (mut ty, mut tx) = (0.0, 0.0);
    for _ in 0..4000 {
        let Some([a, b]) = lack(lengths, ty, tx) else {
            return false; // a reach short of 0.5 m
        };
        let (y, x) = (within(ty - 0.1 * a), within(tx + 0.1 * b));
        if (y - ty).abs() < 1e-13 && (x - tx).abs() < 1e-13 {
            return a.abs() < 1e-9 && b.abs() < 1e-9;
        }
        (ty, tx) = (y, x);
    }
    panic!("{lengths:?}: no rest at {ty} {tx}");
}

#[test]
fn refused_lengths_join_nowhere_within_the_tilts_and_others_do() {
    let mut numbers = Numbers(2);
    let (mut accepted, mut refused, mut most) = (0, 0, 0);
    for trial in 0..100_000 {
        let lengths = [(); 3].map(|()| 0.60 + numbers.unit());
        match Rnt.assembled(lengths) {
            Ok(([ty, tx, reach], steps)) => {
                assert!(ty.abs() <= FRAC_PI_4 && tx.abs() <= FRAC_PI_4);
                assert!(
                    (0.5..=1.7).contains(&reach) && steps <= MOST_STEPS + 2,
                    "{steps}"
                );
                assert!(apart(&distances(ty, tx, reach), &lengths) < 1e-12);
                most = if steps > most { steps } else { most };
                accepted += 1;
            }
            Err(error) => {
                assert_eq!(error, KinematicError::Unreachable);
                refused += 1;
                if trial < 3000 {
                    assert!(!joined(&lengths), "{lengths:?} can be joined");
                }
            }
        }
    }
    assert!(most <= MOST_STEPS, "{most}");
    // half of the cube of lengths tilts too far or is too short
    assert!(
        accepted > 45_000 && refused > 45_000,
        "{accepted} {refused}"
    );
}

/// The lesser eigenvalue of the symmetric part of F', by differences of [`lack`].
fn least_eigenvalue(lengths: &[f64; 3], ty: f64, tx: f64) -> Option<f64> {
    let h = 1e-6;
    let (yp, ym) = (lack(lengths, ty + h, tx)?, lack(lengths, ty - h, tx)?);
    let (xp, xm) = (lack(lengths, ty, tx + h)?, lack(lengths, ty, tx - h)?);
    // rows F1 and −F2
    let d = |p: f64, m: f64| (p - m) / (2.0 * h);
    let [a, b, c, e] = [
        d(yp[0], ym[0]),
        d(xp[0], xm[0]),
        -d(yp[1], ym[1]),
        -d(xp[1], xm[1]),
    ];
    let (mean, half) = (0.5 * (a + e), 0.5 * (a - e));
    let skew = 0.5 * (b + c);
    Some(mean - libm::sqrt(half * half + skew * skew))
}

#[test]
fn the_equations_of_the_tilts_are_monotone_over_all_tilts() {
    let mut least = f64::INFINITY;
    for k in 0..=48 {
        // only the sum of squares counts for F'
        let length = 0.50 + 0.025 * f64::from(k);
        for i in -45..=45 {
            for j in -45..=45 {
                let (ty, tx) = (f64::from(i).to_radians(), f64::from(j).to_radians());
                if let Some(value) = least_eigenvalue(&[length; 3], ty, tx) {
                    least = if value < least { value } else { least };
                }
            }
        }
    }
    // the claim of the documentation; differences are good to 1e-9
    assert!((0.12..0.2).contains(&least), "{least}");
}

proptest! {
    #[test]
    fn a_platform_tilted_too_far_is_refused_or_taken_for_one_of_the_same_legs(
        ty in -1.5..1.5f64, tx in -1.5..1.5f64, reach in 0.5..1.7f64,
    ) {
        let lengths = distances(ty, tx, reach);
        match Rnt.assembled(lengths) {
            Ok(([y, x, r], _)) => {
                prop_assert!(y.abs() <= FRAC_PI_4 && x.abs() <= FRAC_PI_4);
                prop_assert!(apart(&distances(y, x, r), &lengths) < 1e-12);
            }
            Err(KinematicError::Limit { quantity, value, lower, upper, .. }) => {
                prop_assert_eq!(quantity, Quantity::ScrewLength);
                prop_assert!(value < lower || value > upper);
            }
            Err(error) => {
                prop_assert_eq!(error, KinematicError::Unreachable);
                prop_assert!(ty.abs() > 0.785 || tx.abs() > 0.785);
            }
        }
    }
}

#[test]
fn a_platform_just_beyond_the_tilts_is_not_moved_onto_them() {
    for beyond in [1e-5, 3e-8, 1e-9] {
        let lengths = distances(FRAC_PI_4 + beyond, 0.1, 1.1);
        assert_eq!(
            Rnt.assembled(lengths),
            Err(KinematicError::Unreachable),
            "{beyond}"
        );
    }
    // the tilts' bounds themselves are inside, but for rounding
    Rnt.assembled(distances(FRAC_PI_4 - 1e-13, 0.1, 1.1))
        .unwrap();
}

#[test]
fn impossible_lengths_are_explained() {
    // one leg long, two short
    assert_eq!(
        Rnt.assembled([1.6, 0.6, 0.6]),
        Err(KinematicError::Unreachable)
    );
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert_eq!(
            Rnt.assembled([1.0, bad, 1.0]),
            Err(KinematicError::NotFinite)
        );
    }
    for bad in [-1.0, 0.0, 0.499, 1.701, 1e300] {
        let error = Rnt.assembled([1.0, 1.0, bad]).unwrap_err();
        assert!(
            matches!(
                error,
                KinematicError::Limit {
                    axis: 2,
                    name: "reach/leg 3",
                    quantity: Quantity::ScrewLength,
                    lower: 500.0,
                    upper: 1700.0,
                    ..
                }
            ),
            "{error:?}"
        );
    }
    // a reach too short although every leg is long enough
    assert_eq!(Rnt.assembled([0.55; 3]), Err(KinematicError::Unreachable));
}

#[test]
fn platforms_beyond_what_is_known_have_no_motors() {
    let good = robots::rnt::HOME;
    Rnt.motors(&good).unwrap();
    for (axis, value) in [(0, 0.79), (1, -0.79), (2, 0.49), (2, 1.71)] {
        let mut bad = good;
        bad.0[axis] = value;
        let error = Rnt.motors(&bad).unwrap_err();
        assert!(
            matches!(error, KinematicError::Limit { axis: k, quantity: Quantity::Joint, .. } if k == axis),
            "{error:?}"
        );
        assert_eq!(Rnt.legs(&bad), Err(error));
        assert_eq!(Rnt.leg_jacobian(&bad), Err(error));
    }
}
