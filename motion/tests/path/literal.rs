//! Our moving segment against the paper's text taken literally, and against the spline through all points.

use crate::moving_segment::{joins, spans};
use crate::oracle::{Spline, chords};
use crate::support::at;
use motion::path::Curve;
use nalgebra::Vector3;

/// The paper's text taken literally: the middle span of the spline through each eight points.
fn literal(points: &[Vector3<f64>]) -> Vec<(Spline, f64, f64)> {
    let t = chords(points);
    (0..=points.len() - 8)
        .map(|i| {
            (
                Spline::new(&t[i..i + 8], &points[i..i + 8]),
                t[i + 3],
                t[i + 4],
            )
        })
        .collect()
}

#[derive(Default, Debug, Clone, Copy)]
struct Compared {
    /// Jumps of the literal reading: p', p'', p'''.
    literal: [f64; 3],
    /// Jumps of ours.
    ours: [f64; 3],
    /// Distance at equal parameter: from the global spline, ours and the literal one's; and from the literal one.
    global: [f64; 2],
    between: f64,
    /// |p'| of ours, least and greatest; of the global spline.
    speed: [f64; 2],
    speed_global: [f64; 2],
    third: f64,
}

fn compare(points: &[Vector3<f64>]) -> Compared {
    let mut seen = Compared {
        speed: [f64::INFINITY, 0.0],
        speed_global: [f64::INFINITY, 0.0],
        ..Compared::default()
    };
    let t = chords(points);
    let (global, literal) = (Spline::new(&t, points), literal(points));
    let ours = spans(points.iter().map(|p| at(p.x, p.y, p.z)));
    for pair in literal.windows(2) {
        let ((a, _, end), (b, ..)) = (&pair[0], &pair[1]);
        let (x, y) = (a.at(*end), b.at(*end));
        // a spline's third derivative is of the span before its knot
        let x3 = a.at(end - 1e-9)[3];
        for (k, jump) in [
            (x[1] - y[1]).norm(),
            (x[2] - y[2]).norm(),
            (x3 - y[3]).norm(),
        ]
        .into_iter()
        .enumerate()
        {
            seen.literal[k] = seen.literal[k].max(jump);
        }
    }
    for jump in joins(&ours[3..ours.len() - 3]) {
        for k in 0..3 {
            seen.ours[k] = seen.ours[k].max(jump[2 * k]);
        }
    }
    for (i, (spline, from, to)) in literal.iter().enumerate() {
        for k in 0..=20 {
            let s = (to - from) * f64::from(k) / 20.0;
            let x = ours[i + 3].at(s);
            let (a, b) = (spline.at(from + s), global.at(from + s));
            seen.global[0] = seen.global[0].max((x.pose.position - b[0]).norm());
            seen.global[1] = seen.global[1].max((a[0] - b[0]).norm());
            seen.between = seen.between.max((x.pose.position - a[0]).norm());
            for (speed, v) in [
                (&mut seen.speed, x.first.linear_norm()),
                (&mut seen.speed_global, b[1].norm()),
            ] {
                *speed = [speed[0].min(v), speed[1].max(v)];
            }
            seen.third = seen.third.max(b[3].norm());
        }
    }
    seen
}

#[test]
fn ours_has_no_jumps_where_the_literal_reading_has_and_is_as_near_to_a_global_spline() {
    let wave = |step: f64| -> Vec<Vector3<f64>> {
        let place = |i: i32| f64::from(i) * step;
        (0..40)
            .map(place)
            .map(|x| Vector3::new(x, 0.02 * (x * 40.0).sin(), 0.01 * (x * 23.0).cos()))
            .collect()
    };
    for step in [0.02, 0.01, 0.005] {
        let seen = compare(&wave(step));
        println!("wave, step {step}: {seen:?}");
        // the literal reading jumps by much more than rounding
        assert!(seen.literal[0] > 1e-6 && seen.literal[1] > 1e-3);
        assert!(seen.ours[0] < 1e-12 && seen.ours[1] < 1e-9);
        assert!(seen.global[0] < 2.0 * seen.global[1].max(1e-5), "{seen:?}");
    }
}

/// A fixed sequence of numbers in [−1, 1] (Numerical Recipes' linear congruence).
fn noise() -> impl FnMut() -> f64 {
    let mut state = 12_345_u32;
    move || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(state) / f64::from(u32::MAX) * 2.0 - 1.0
    }
}

#[test]
fn the_parameter_runs_like_that_of_a_global_spline_on_random_points() {
    for most_turn in [0.2, 0.5, 1.0] {
        let mut random = noise();
        let (mut here, mut heading) = (Vector3::zeros(), 0.0_f64);
        let mut points = Vec::new();
        for _ in 0..100 {
            heading += most_turn * random();
            let step = 0.01 * (1.0 + 0.8 * random());
            here += Vector3::new(heading.cos(), heading.sin(), 0.0) * step;
            points.push(here);
        }
        let seen = compare(&points);
        println!("random walk, turns up to {most_turn} rad: {seen:?}");
        assert!(seen.ours[0] < 1e-11 && seen.ours[1] < 1e-8);
        assert!(
            seen.speed[0] > seen.speed_global[0] - 0.1
                && seen.speed[1] < seen.speed_global[1] + 0.1
        );
    }
}
