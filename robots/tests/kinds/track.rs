//! Where the inverse puts the track.

use proptest::prelude::*;
use robots::irp6::BEND_M;
use robots::{Irp6Track, Joints, Robot, TrackRule};

use crate::{apart, spread};

/// Joints whose flange is before the column, where the rule can face it.
fn forward_facing(unit: &[f64; 7]) -> Joints<7> {
    let mut q = spread(&Irp6Track::KEEP, unit);
    q.0[1] *= 0.3;
    q
}

proptest! {
    #[test]
    fn in_front_the_column_looks_ahead_within_the_track(unit in prop::array::uniform7(0.05..0.95f64)) {
        let q = forward_facing(&unit);
        let mut pose = Irp6Track::KEEP.forward(&q);
        // behind 0.3 m the column could look the other way: the same hand, further ahead
        pose.position.x = pose.position.x.clamp(0.3, f64::INFINITY);
        if let Ok(found) = Irp6Track::IN_FRONT.inverse(&pose, &q) {
            let range = Irp6Track::KEEP.description().axes[0].joint_position;
            let y = pose.position.y;
            for branch in found.branches() {
                prop_assert!(apart(&Irp6Track::KEEP.forward(branch), &pose) < 1e-7);
                prop_assert!(range.contains(branch.0[0]));
                if range.lower + BEND_M < y && y < range.upper - BEND_M {
                    prop_assert!((branch.0[0] - y).abs() < 1e-12);
                    let q1 = branch.0[1];
                    prop_assert!(q1.abs() < 1e-9, "{q1}");
                }
            }
            // the pose alone says where: from wherever the track stands
            let mut elsewhere = q;
            elsewhere.0[0] = range.centre();
            let again = Irp6Track::IN_FRONT.inverse(&pose, &elsewhere).unwrap();
            prop_assert_eq!(again.branches(), found.branches());
        }
    }
}

#[test]
fn towards_its_ends_the_track_follows_smoothly() {
    let front = Joints([0.0, 0.0, -1.57, 0.0, 1.56, 1.57, -1.57]);
    let along = |y: f64| {
        let mut pose = Irp6Track::KEEP.forward(&front);
        pose.position.y = y;
        let found = Irp6Track::IN_FRONT.inverse_near(&pose, &front).unwrap();
        found.0[0]
    };
    let range = Irp6Track::KEEP.description().axes[0].joint_position;
    for (end, sign) in [(range.upper, 1.0), (range.lower, -1.0)] {
        let h = 1e-4;
        let mut last: Option<(f64, f64)> = None;
        for k in -800..=800 {
            let y = end + sign * 1e-4 * f64::from(k);
            let d = along(y);
            assert!(range.contains(d), "{d}");
            let slope = (along(y + h) - along(y - h)) / (2.0 * h);
            assert!((-1e-9..=1.0 + 1e-9).contains(&slope), "{slope} at {y}");
            let bend = (along(y + h) - 2.0 * d + along(y - h)) / (h * h);
            // 3·v·(1 − v)·2/(2·BEND) at its most: 1.5/(2·BEND) = 15 per m
            assert!(bend.abs() < 15.1, "{bend}");
            if let Some((slope_before, bend_before)) = last {
                assert!((slope - slope_before).abs() < 2e-3);
                // curvature goes on: its slope is 6/(2·BEND)² = 600 per m²
                assert!(
                    (bend - bend_before).abs() < 0.1,
                    "{bend} after {bend_before}"
                );
            }
            last = Some((slope, bend));
        }
        assert!((along(end + sign * 0.08) - end).abs() < 1e-12);
    }
}

#[test]
fn the_default_is_to_keep() {
    assert_eq!(Irp6Track::default(), Irp6Track::KEEP);
    assert_eq!(TrackRule::ALL.map(TrackRule::name), ["keep", "in-front"]);
}
