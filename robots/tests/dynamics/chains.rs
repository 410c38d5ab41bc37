//! The chains are the robots they say: same flange, same Jacobian, published poses, listed masses.

use motion::Pose;
use motion::pose::exp;
use nalgebra::{Matrix3, Vector3};
use proptest::prelude::*;
use robots::dynamics::{
    ASSUMED, Chain, IRP6_ARM, IRP6_POSTUMENT, IRP6_TRACK, POLYCRANK, rnt_chain,
};
use robots::{Irp6Postument, Irp6Track, Joints, Robot};

use super::{numbers, rnt};

/// The same pose, within what rounding of angles up to 10 rad (2e-15 an ulp) makes of 2 m.
fn same(a: &Pose, b: &Pose) -> Result<(), TestCaseError> {
    prop_assert!((a.position - b.position).amax() < 1e-14, "{a:?} {b:?}");
    prop_assert!((a.rotation - b.rotation).amax() < 1e-14, "{a:?} {b:?}");
    Ok(())
}

proptest! {
    #[test]
    fn a_chain_ends_where_its_robot_does(q in numbers::<7>(3.1), along in 0.0..1.5f64) {
        let [_, a, b, c, d, e, f] = q;
        let (track, arm) = (Joints([along, a, b, c, d, e, f]), Joints([a, b, c, d, e, f]));
        same(&IRP6_TRACK.at(&track).flange(), &Irp6Track::KEEP.forward(&track))?;
        same(&IRP6_POSTUMENT.at(&arm).flange(), &Irp6Postument.forward(&arm))?;
        let five = IRP6_ARM.at(&Joints([a, b, c, d, e])).flange();
        same(&five, &Irp6Postument.forward(&Joints([a, b, c, d, e, 0.0])))?;
        let jacobian = IRP6_TRACK.at(&track).jacobian() - Irp6Track::KEEP.jacobian(&track);
        prop_assert!(jacobian.amax() < 1e-14, "{jacobian}");
        let jacobian = IRP6_POSTUMENT.at(&arm).jacobian() - Irp6Postument.jacobian(&arm);
        prop_assert!(jacobian.amax() < 1e-14, "{jacobian}");
    }

    #[test]
    fn the_rnt_is_a_tilted_leg_with_an_inclined_wrist(q in numbers::<6>(3.0), inclination in -2.0..2.0f64) {
        let about = |axis: Vector3<f64>, angle: f64| exp(axis * angle);
        let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
        let platform = about(y, q[0]) * about(x, q[1]);
        let wrist = about(y, inclination) * about(z, q[3]) * about(y, q[4]) * about(z, q[5]);
        let expected = Pose { position: platform * z * -(q[2] + 0.12), rotation: platform * wrist };
        same(&rnt_chain(inclination).at(&Joints(q)).flange(), &expected)?;
    }
}

/// Six digits are published.
#[test]
fn the_polycrank_takes_its_published_poses() {
    let cases = [
        (
            [0.0; 7],
            Vector3::new(0.183, -0.296, 1.589),
            Matrix3::from_diagonal(&Vector3::new(1.0, -1.0, -1.0)),
        ),
        (
            [0.5, -0.4, 0.3, -0.2, 0.6, 0.7, -0.8],
            Vector3::new(0.331_677, -0.271_299, 1.641_298),
            Matrix3::new(
                0.011_725, 0.571_014, 0.820_856, 0.783_794, -0.514_997, 0.347_052, 0.620_91,
                0.639_313, -0.453_596,
            ),
        ),
    ];
    for (q, position, rotation) in cases {
        let flange = POLYCRANK.at(&Joints(q)).flange();
        assert!((flange.position - position).amax() < 6e-7, "{flange:?}");
        assert!((flange.rotation - rotation).amax() < 6e-7, "{flange:?}");
    }
}

#[test]
fn the_platform_hangs_where_the_tilts_say() {
    let q = Joints([-10f64.to_radians(), 20f64.to_radians(), 1.0, 0.0, 0.0, 0.0]);
    let [_, _, platform, ..] = rnt().at(&q).link_poses();
    let expected = Vector3::new(0.163_176, 0.342_020, -0.925_417);
    // six digits
    assert!((platform.position - expected).amax() < 6e-7);
    assert!((platform.rotation.column(2) - platform.position).amax() < 1e-15);
}

#[test]
fn every_mass_is_listed_as_assumed() {
    fn total<const N: usize>(chain: &Chain<N>) -> f64 {
        chain.links.iter().map(|link| link.body().mass_kg).sum()
    }
    let listed = |part: &str| -> f64 {
        let of_robot = ASSUMED.iter().filter(|mass| mass.item.contains(part));
        of_robot.map(|mass| mass.value).sum()
    };
    assert!((total(&IRP6_TRACK) - listed("IRp-6")).abs() < 1e-12);
    let on_track = listed("carriage");
    assert!((total(&IRP6_POSTUMENT) - listed("IRp-6") + on_track).abs() < 1e-12);
    assert!((total(&IRP6_ARM) - total(&IRP6_POSTUMENT)).abs() < 1e-12);
    assert!((total(&POLYCRANK) - listed("Polycrank")).abs() < 1e-12);
    // of three driven legs one half each is on the platform
    assert!((total(&rnt()) - listed("RNT") - 0.5 * listed("driven leg")).abs() < 1e-12);
    assert!(
        ASSUMED
            .iter()
            .all(|mass| mass.unit == "kg" && mass.value > 0.0)
    );
}
