//! Inputs that failed in other planners and were reported.
use super::cases::{larger, missed, symmetric};
use super::data::{Case, cases};
use motion::profile::{AxisBounds, Boundary, Request, Synchronisation, Trajectory};

fn solve<const N: usize>(case: &Case<'_>) {
    let request: Request<N> = case.request();
    let label = case.label;
    let trajectory = Trajectory::new(&request).unwrap_or_else(|e| panic!("{label}: {e}"));
    assert_eq!(trajectory.check(&request), Ok(()), "{label}");
    for axis in 0..N {
        // positions up to 1000: some units in the last place of them
        let [p, v, a] = missed(&trajectory, &request, axis);
        assert!(
            p <= 1e-12 * 1e3 && v <= 1e-9 && a <= 1e-8,
            "{label}: {p} {v} {a}"
        );
    }
    if let Some(theirs) = case.duration {
        let ours = trajectory.duration();
        // #68 and #69 start on the way of a motion that need only be finished: there Ruckig's end misses the
        // target by the rounding δ of a position, and a motion that does not must dip by it: x³·j/32 = δ
        let dip = (0..N).fold(0.0, |dip, i| {
            let spare = f64::EPSILON * larger(request.start[i].p.abs(), request.end[i].p.abs());
            larger(dip, libm::cbrt(32.0 * spare / request.bounds[i].j_max))
        });
        assert!(
            ours <= theirs + 1e-9 + 2.0 * dip,
            "{label}: {ours} instead of {theirs}"
        );
    }
}

#[test]
fn reported_failures_are_planned() {
    let cases = cases(include_str!("../data/issues.txt"));
    assert_eq!(cases.len(), 24);
    for case in &cases {
        match case.axes() {
            1 => solve::<1>(case),
            2 => solve::<2>(case),
            3 => solve::<3>(case),
            4 => solve::<4>(case),
            6 => solve::<6>(case),
            7 => solve::<7>(case),
            other => panic!("{other} axes"),
        }
    }
}

/// States of reports whose limits cannot be read in full, axis by axis: p v a of the start, p of the rest they go to.
#[expect(
    clippy::unreadable_literal,
    reason = "the digits as they were reported"
)]
const STATES: [(&str, &[[f64; 4]]); 3] = [
    (
        "ruckig#19",
        &[
            [
                -0.843763019702056,
                -0.0303436943534115,
                0.0941203950600968,
                -0.847254234340315,
            ],
            [
                -1.26164314329262,
                0.0371785718477563,
                -0.152313813731685,
                -1.25777615061367,
            ],
            [
                1.62592703780797,
                -0.0294029319779939,
                0.134100351460333,
                1.62279392916203,
            ],
            [
                -1.26322670514057,
                -0.0129669308625882,
                0.0630571844324987,
                -1.26518389118862,
            ],
            [
                -0.900133529360832,
                -0.030242580748223,
                0.0116214644247746,
                -0.90368278625599,
            ],
            [
                1.09819107359504,
                0.00636710830722948,
                -0.0622068786789912,
                1.09921788488865,
            ],
        ],
    ),
    (
        "ruckig#160, the second",
        &[
            [
                0.03839900283757711,
                1.466391486711824e-18,
                0.0,
                0.0383990028375771,
            ],
            [
                0.2093483656756634,
                1.924174584908152e-18,
                -3.608224830031759e-16,
                0.2093483656756634,
            ],
            [
                0.03189466728432298,
                -1.542564246001646e-20,
                0.0,
                0.03189466728432298,
            ],
        ],
    ),
    (
        "rsruckig#9",
        &[
            [3.0017279999860462, 0.0, 0.0, 1.0954848240358788],
            [0.891077, 0.0, 0.0, 1.3018323350364962],
            [-90.0, 0.0, 0.0, -90.0],
            [0.212, 0.0, 0.0, 0.217],
        ],
    ),
];

#[test]
fn reported_states_are_planned_whatever_the_limits() {
    for (label, states) in STATES {
        for v in [0.05, 0.5, 5.0, 50.0] {
            for a in [0.2, 1.0, 10.0, 1000.0] {
                for j in [1.0, 100.0, 1e4] {
                    for state in states {
                        together::<1>(label, &[*state], symmetric(v, a, j));
                    }
                    match states.len() {
                        3 => together::<3>(label, states, symmetric(v, a, j)),
                        4 => together::<4>(label, states, symmetric(v, a, j)),
                        _ => together::<6>(label, states, symmetric(v, a, j)),
                    }
                }
            }
        }
    }
}

fn together<const N: usize>(label: &str, states: &[[f64; 4]], bounds: AxisBounds) {
    let request = Request::<N> {
        start: core::array::from_fn(|i| {
            let [p, v, a, _] = states[i];
            Boundary { p, v, a }
        }),
        end: core::array::from_fn(|i| Boundary {
            p: states[i][3],
            v: 0.0,
            a: 0.0,
        }),
        bounds: [bounds; N],
        synchronisation: Synchronisation::Time,
        minimum_duration: 0.0,
    };
    let trajectory =
        Trajectory::new(&request).unwrap_or_else(|e| panic!("{label}: {e} {bounds:?}"));
    assert_eq!(trajectory.check(&request), Ok(()), "{label} {bounds:?}");
    for axis in 0..N {
        let [p, v, a] = missed(&trajectory, &request, axis);
        assert!(
            p <= 1e-10 && v <= 1e-10 && a <= 1e-10,
            "{label} {bounds:?}: {p} {v} {a}"
        );
    }
}
