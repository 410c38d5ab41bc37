//! Limits along a path: kept when sampled, and close to the best.
use motion::line::Twist;
use motion::path_profile::{PathError, PathScan, ToolLimits};
use motion::profile::{AxisLimits, Profile, rest_time};
use nalgebra::Vector3;
use proptest::prelude::*;

/// Joint path: q = c1·s + c2·sin(w·s + phase), with its three derivatives.
fn joint([c1, c2, w, phase]: [f64; 4], s: f64) -> [f64; 4] {
    let (sin, cos) = libm::sincos(w * s + phase);
    [
        c1 * s + c2 * sin,
        c1 + c2 * w * cos,
        -c2 * w * w * sin,
        -c2 * w * w * w * cos,
    ]
}

const SAMPLES: u32 = 400;

fn scan(paths: &[[f64; 4]; 2]) -> PathScan<2> {
    let mut scan = PathScan::new();
    for i in 0..=SAMPLES {
        let s = f64::from(i) / f64::from(SAMPLES);
        let q = paths.map(|path| joint(path, s));
        scan.add(&q.map(|q| q[1]), &q.map(|q| q[2]), &q.map(|q| q[3]));
    }
    scan
}

fn path() -> impl Strategy<Value = [f64; 4]> {
    [-2.0..2.0f64, -1.0..1.0f64, 0.0..6.0f64, 0.0..3.0f64]
}

fn limits() -> impl Strategy<Value = AxisLimits> {
    (0.2..3.0f64, 0.5..30.0f64, 5.0..900.0f64).prop_map(|(v, a, j)| AxisLimits { v, a, j })
}

proptest! {
    #[test]
    fn joints_keep_their_limits_along_the_path(paths in [path(), path()], joints in [limits(), limits()]) {
        let scan = scan(&paths);
        let s = scan.limits(&joints, None, 1.0).unwrap();
        let profile = Profile::new(1.0, &s).unwrap();
        for i in 0..=1000u32 {
            let x = profile.at(profile.duration() * f64::from(i) / 1000.0);
            for (path, limit) in paths.iter().zip(&joints) {
                let [_, q1, q2, q3] = joint(*path, x.p);
                let v = q1 * x.v;
                let a = q2 * x.v * x.v + q1 * x.a;
                let j = q3 * x.v * x.v * x.v + 3.0 * q2 * x.v * x.a + q1 * x.j;
                // between samples of the scan a maximum is missed by at most |c2|·w⁵·h²/8 < 7e-3
                for (x, limit) in [(v, limit.v), (a, limit.a), (j, limit.j)] {
                    prop_assert!(x.abs() <= limit * 1.01);
                }
            }
        }
    }

    #[test]
    fn the_quick_search_keeps_the_limits_and_loses_little(
        paths in [path(), path()], joints in [limits(), limits()],
    ) {
        let scan = scan(&paths);
        let Ok(thorough) = scan.limits(&joints, None, 1.0) else { return Ok(()) };
        let thorough = rest_time(1.0, &thorough);
        let quick = scan.quick_limits(&joints, None, 1.0).unwrap();
        let ratio = rest_time(1.0, &quick) / thorough;
        prop_assert!((0.99..1.2).contains(&ratio), "{ratio}");
        for (path, limit) in paths.iter().zip(&joints) {
            let most = (0..=SAMPLES)
                .map(|i| joint(*path, f64::from(i) / f64::from(SAMPLES)))
                .fold([0.0f64; 3], |m, q| [
                    if q[1].abs() > m[0] { q[1].abs() } else { m[0] },
                    if q[2].abs() > m[1] { q[2].abs() } else { m[1] },
                    if q[3].abs() > m[2] { q[3].abs() } else { m[2] },
                ]);
            let AxisLimits { v, a, j } = quick;
            prop_assert!(most[0] * v <= limit.v);
            prop_assert!(most[1] * v * v + most[0] * a <= limit.a);
            prop_assert!(most[2] * v * v * v + 3.0 * most[1] * v * a + most[0] * j <= limit.j);
        }
    }

    #[test]
    fn no_other_split_is_much_faster(
        paths in [path(), path()], joints in [limits(), limits()],
        tries in prop::collection::vec((0.0..1.0f64, 0.0..1.0f64), 200),
    ) {
        let scan = scan(&paths);
        let found = scan.limits(&joints, None, 1.0).unwrap();
        let best = rest_time(1.0, &found);
        let mut most = [[0.0f64; 3]; 2];
        for i in 0..=SAMPLES {
            for (most, path) in most.iter_mut().zip(&paths) {
                let q = joint(*path, f64::from(i) / f64::from(SAMPLES));
                for (m, x) in most.iter_mut().zip(&q[1..]) {
                    if x.abs() > *m { *m = x.abs(); }
                }
            }
        }
        for (m, l) in most.iter().zip(&joints) {
            let AxisLimits { v, a, j } = found;
            prop_assert!(m[0] * v <= l.v && m[1] * v * v + m[0] * a <= l.a);
            prop_assert!(m[2] * v * v * v + 3.0 * m[1] * v * a + m[0] * j <= l.j);
        }
        let least = |f: &dyn Fn(&[f64; 3], &AxisLimits) -> f64| {
            most.iter().zip(&joints).map(|(m, l)| f(m, l)).fold(f64::INFINITY, |x, y| if y < x { y } else { x })
        };
        for (v_share, a_share) in tries {
            let v = v_share * least(&|m, l| l.v / m[0]);
            let a = a_share * least(&|m, l| (l.a - m[1] * v * v) / m[0]);
            let j = least(&|m, l| (l.j - m[2] * v * v * v - 3.0 * m[1] * v * a) / m[0]);
            if v > 0.0 && a > 0.0 && j > 0.0 {
                let other = rest_time(1.0, &AxisLimits { v, a, j });
                prop_assert!(best <= 1.01 * other);
            }
        }
    }

    #[test]
    fn the_tool_keeps_its_speed(linear in 0.01..5.0f64, angular in 0.0..5.0f64, v in 0.01..2.0f64, w in 0.01..2.0f64) {
        let mut scan = PathScan::<1>::new();
        scan.add(&[0.1], &[0.0], &[0.0]);
        scan.add_twist(&Twist { linear: Vector3::x() * linear, angular: Vector3::y() * angular });
        let tool = ToolLimits { linear_m_s: v, angular_rad_s: w };
        let s = scan.limits(&[AxisLimits { v: 9.0, a: 9.0, j: 9.0 }], Some(tool), 1.0).unwrap();
        prop_assert!(s.v * linear <= v && s.v * angular <= w);
    }
}

#[test]
fn refusals_are_typed() {
    let unit = AxisLimits {
        v: 1.0,
        a: 1.0,
        j: 1.0,
    };
    let mut scan = PathScan::<1>::new();
    assert_eq!(scan.limits(&[unit], None, 1.0), Err(PathError::Still));
    scan.add(&[1.0], &[0.0], &[0.0]);
    assert_eq!(scan.limits(&[unit], None, 0.0), Err(PathError::NotPositive));
    let none = AxisLimits { a: 0.0, ..unit };
    assert_eq!(scan.limits(&[none], None, 1.0), Err(PathError::NotPositive));
    let tool = ToolLimits {
        linear_m_s: -1.0,
        angular_rad_s: 1.0,
    };
    assert_eq!(
        scan.limits(&[unit], Some(tool), 1.0),
        Err(PathError::NotPositive)
    );
    scan.add(&[f64::NAN], &[0.0], &[0.0]);
    assert_eq!(scan.limits(&[unit], None, 1.0), Err(PathError::NotFinite));
}
