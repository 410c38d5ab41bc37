//! Inputs that failed in other planners and were reported.
use super::cases::{larger, missed};
use super::data::{Case, cases};
use motion::profile::{Request, Trajectory};

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
