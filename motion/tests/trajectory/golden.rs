//! Durations against those of another planner.
use super::data::{Case, cases};
use motion::profile::{Request, Trajectory};

/// Why a duration may differ.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Reason {
    /// The target is nearer than the error of position that Ruckig accepts at its end (up to 1e-8), so its
    /// duration is that of another problem.
    WithinItsEndError,
}

/// The cases whose durations differ by more than 1e-9 s: class, axes, number.
const EXCEPTIONS: [(&str, usize, u32, Reason); 3] = [
    ("N", 1, 29, Reason::WithinItsEndError),
    ("N", 1, 41, Reason::WithinItsEndError),
    ("N", 1, 52, Reason::WithinItsEndError),
];

/// A difference of rounding only: durations here are below 1e4 s, and both planners solve for them to some
/// units in the last place (2e-12 s); the measured worst is 4e-15 relative. A shorter time is as suspect as a
/// longer one: either the other planner is not optimal there, or we cheat in a way that the checker allows.
const TOLERANCE: f64 = 1e-9;

fn compare<const N: usize>(case: &Case<'_>) -> Result<(), String> {
    let request: Request<N> = case.request();
    let trajectory = Trajectory::new(&request).map_err(|e| e.to_string())?;
    trajectory
        .check(&request)
        .map_err(|(axis, violation)| format!("axis {axis}: {violation}"))?;
    let theirs = case.duration.expect("every case has a duration");
    let differs = trajectory.duration() - theirs;
    let exception = EXCEPTIONS
        .iter()
        .find(|e| (e.0, e.1, e.2) == (case.label, N, case.number));
    let justified = match exception.map(|e| e.3) {
        None => differs.abs() <= TOLERANCE,
        Some(Reason::WithinItsEndError) => {
            let near = |i: usize| (request.end[i].p - request.start[i].p).abs() < 1e-8;
            (0..N).all(near) && differs.abs() > TOLERANCE
        }
    };
    justified
        .then_some(())
        .ok_or_else(|| format!("{differs:e} s of {theirs} ({exception:?})"))
}

#[test]
fn durations_are_those_of_ruckig_on_its_own_distributions() {
    let cases = cases(include_str!("../data/durations.txt"));
    assert_eq!(cases.len(), 6 * (60 + 40 + 24));
    let mut failures = Vec::new();
    for case in &cases {
        let result = match case.axes() {
            1 => compare::<1>(case),
            3 => compare::<3>(case),
            7 => compare::<7>(case),
            other => Err(format!("{other} axes")),
        };
        if let Err(why) = result {
            let (label, axes, number) = (case.label, case.axes(), case.number);
            failures.push(format!("(\"{label}\", {axes}, {number}): {why}"));
        }
    }
    assert!(failures.is_empty(), "{failures:#?}");
}
