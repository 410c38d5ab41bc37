//! Feeds that change along a path.

use super::*;

/// Lines and points 1 mm apart, 60 mm of each feed.
fn of_feeds(feeds: &[f32], curved: bool) -> Vec<PathElement> {
    let (start, mut at) = (start(), 0.0);
    let mut elements = Vec::new();
    for feed in feeds {
        elements.push(PathElement::Feed {
            metres_per_second: *feed,
        });
        for _ in 0..60 {
            at += 1e-3;
            let mut to = start;
            to.position.z -= at;
            let to = message(&to);
            let corner = exact();
            elements.push(if curved {
                PathElement::Through(to)
            } else {
                PathElement::Line { to, corner }
            });
        }
    }
    elements.push(PathElement::End);
    elements
}

#[test]
fn every_feed_holds_from_where_it_is_programmed_and_never_above_the_instructions() {
    for curved in [false, true] {
        let mut run = Run::new(&arm(0.06), of_feeds(&[0.02, 0.5, 0.03], curved));
        assert_eq!(run.steps(2000, |_| 1.0, |_| false), End::Done);
        let from = start().position.z;
        let ways: Vec<f64> = run
            .knots
            .iter()
            .map(|k| from - run.tool(&k.position).position.z)
            .collect();
        let mut fastest = [0.0f64; 3];
        for pair in ways.windows(2) {
            // a step that is in one of them alone
            for (k, range) in [(0.0, 0.06), (0.06, 0.12), (0.12, 0.18)]
                .into_iter()
                .enumerate()
            {
                if pair[0] >= range.0 && pair[1] <= range.1 {
                    fastest[k] = larger(fastest[k], (pair[1] - pair[0]) / (0.5 * H));
                }
            }
        }
        // the feed travels as f32 and forward kinematics rounds: 1e-6; it is reached, but for what the
        // smoothing takes
        for (got, feed) in fastest.into_iter().zip([0.02, 0.06, 0.03]) {
            assert!(
                (0.98 * feed..feed * (1.0 + 1e-6)).contains(&got),
                "{curved} {got} {feed}"
            );
        }
    }
}

#[test]
fn a_feed_that_is_none_is_refused() {
    for none in [0.0, -0.1, f32::NAN, f32::INFINITY] {
        let mut run = Run::new(&arm(0.06), of_feeds(&[0.05, none], true));
        let problem = PathProblem::Feed;
        let element = 61;
        let refusal = Refusal::Path { element, problem };
        assert_eq!(run.steps(2000, |_| 1.0, |_| false), End::Refused(refusal));
    }
}
