use super::*;
use crate::plot::{Picture, png, svg};
use ::motion::profile::{AxisLimits, Profile};

const LIMITS: AxisLimits = AxisLimits {
    v: 0.5,
    a: 1.0,
    j: 10.0,
};

fn axis(distance: f64, limits: AxisLimits) -> AxisMotion {
    AxisMotion {
        name: "axis <1>".into(),
        phases: Profile::new(distance, &limits).unwrap().phases().to_vec(),
        bounds: limits.into(),
    }
}

fn picture(axes: Vec<AxisMotion>) -> String {
    let data = MotionPlot {
        title: "t".into(),
        unit: "m".into(),
        axes,
    };
    svg(&Picture::from(&data))
}

fn count_thin(picture: &str) -> usize {
    picture
        .matches("stroke-width=\"0.9\" stroke-dasharray")
        .count()
}

#[test]
fn a_curve_is_the_motion_at_both_ends_of_every_phase() {
    let axis = axis(1.0, LIMITS);
    let curve = curve(&axis);
    let mut begin = 0.0;
    for phase in &axis.phases {
        assert!(curve.contains(&(begin, phase.at(0.0))));
        assert!(curve.contains(&(begin + phase.t, phase.at(phase.t))));
        begin += phase.t;
    }
    assert!(curve.windows(2).all(|pair| pair[0].0 <= pair[1].0));
    // velocity and acceleration of the peak are among the points
    let reached = Range::of(curve.iter().map(|(_, state)| state.v));
    assert!((reached.upper - 0.5).abs() < 1e-12);
}

#[test]
fn limits_are_drawn_once_and_where_the_motion_comes_near_them() {
    // velocity, acceleration and jerk both ways, and the legend; positions have no limit
    assert_eq!(count_thin(&picture(vec![axis(1.0, LIMITS)])), 6 + 1);
    assert_eq!(count_thin(&picture(vec![axis(1.0, LIMITS); 3])), 6 + 1);
    let faster = AxisLimits { v: 0.6, ..LIMITS };
    let two = vec![axis(1.0, LIMITS), axis(1.0, faster)];
    assert_eq!(count_thin(&picture(two)), 8 + 1);
    // 10 mm: a fifth of the velocity limit is reached, less than half of the acceleration's is not
    let far = AxisLimits { v: 50.0, ..LIMITS };
    assert_eq!(count_thin(&picture(vec![axis(0.01, far)])), 4 + 1);
}

#[test]
fn a_picture_has_four_diagrams_one_time_and_every_name() {
    let picture = picture(vec![axis(1.0, LIMITS), axis(-0.0, LIMITS)]);
    for words in [
        "position [m]",
        "velocity [m/s]",
        "acceleration [m/s²]",
        "jerk [m/s³]",
        "time [s]",
        "limit",
    ] {
        assert_eq!(
            picture.matches(&format!(">{words}</text>")).count(),
            1,
            "{words}"
        );
    }
    assert_eq!(picture.matches("axis &lt;1&gt;").count(), 2);
}

#[test]
fn nothing_and_nonsense_make_a_picture_too() {
    let still = AxisMotion {
        name: String::new(),
        phases: Vec::new(),
        bounds: LIMITS.into(),
    };
    let mut wrong = axis(1.0, LIMITS);
    wrong.phases[3].t = f64::NAN;
    wrong.phases[4].p0 = f64::INFINITY;
    wrong.bounds.v_max = f64::NAN;
    for axes in [
        vec![],
        vec![still],
        vec![wrong],
        vec![axis(1.0, LIMITS); 40],
    ] {
        let data = MotionPlot {
            axes,
            ..MotionPlot::default()
        };
        let text = svg(&Picture::from(&data));
        assert!(text.starts_with("<svg ") && text.ends_with("</svg>\n"));
        assert!(!text.contains("NaN") && !text.contains("inf"));
        assert!(png(&Picture::from(&data)).is_ok());
    }
}
