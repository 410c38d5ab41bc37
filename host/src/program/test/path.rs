//! Paths from text to rest.

use super::{finish, plan, task, world};
use crate::mp::test::peer::{Script, path::PathScript};
use crate::path::{Streamed, pose};
use crate::program::plan::Work;
use crate::program::{Progress, RunStatus, Segment};
use protocol::message::{Instruction, NodeState, PathElement};
use std::path::Path;
use std::sync::Arc;

/// The postument at a pose with room around it, then a path of these elements.
fn steps(path: &str) -> String {
    format!(
        r#"
[[step]]
home = ["irp6-postument"]
[[step]]
move = {{ robot = "irp6-postument", joints = [0.0, -1.57, 0.0, 1.56, 1.57, -1.57] }}
[[step]]
path = {{ robot = "irp6-postument", relative_to = "start", {path} }}
"#
    )
}

const FRAME: &str = r"feed_m_s = 0.1, overrides = [[0.2, 0.0], [0.4, 1.0]], elements = [
  { line = { position_m = [-0.05, 0, 0] } },
  { line = { position_m = [-0.05, 0.05, 0] }, corner_m = 0.005 },
  { through = { position_m = [-0.03, 0.06, 0] } },
  { through = { position_m = [-0.01, 0.05, 0] } },
  { arc = { via_m = [0, 0.03, 0.01], to = { position_m = [0.01, 0, 0] } } },
]";

fn streamed(work: &Work) -> &Arc<Streamed> {
    match work {
        Work::Path { streamed, .. } => streamed,
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_path_runs_to_its_end() {
    let slow = Script {
        path: PathScript {
            element_ms: 200,
            ..PathScript::default()
        },
        ..Script::default()
    };
    let mut world = world(task(&steps(FRAME)), [Script::default(), slow]);
    let mut on_path = false;
    assert!(world.until(60_000, |w| {
        on_path |= matches!(w.driver.run.segment(1), Segment::Path(_));
        w.driver.status != RunStatus::Running
    }));
    assert_eq!(world.driver.status, RunStatus::Done);
    assert!(on_path);
    let plan = world.driver.run.plan().unwrap();
    let elements = &streamed(&plan.steps[2].work).elements;
    let peer = &world.peers[1];
    assert_eq!(peer.path.elements, elements.to_vec());
    assert_eq!((elements.len(), elements[5]), (6, PathElement::End));
    assert!(matches!(
        peer.started.last().unwrap().1,
        Instruction::FollowPath { .. }
    ));
    assert_eq!(peer.state, NodeState::Holding);
    // where the plan said it would be: units of the feedback
    for (motor, planned) in peer.motors.iter().zip(&plan.end[1].motors) {
        assert!((motor - planned).abs() < 1e-4, "{motor} {planned}");
    }
    let tenths: Vec<u32> = world
        .driver
        .progress
        .iter()
        .filter_map(|p| match p {
            Progress::Path {
                robot: 1, tenths, ..
            } => Some(*tenths),
            _ => None,
        })
        .collect();
    assert!(
        tenths.is_sorted() && tenths.last() == Some(&10),
        "{tenths:?}"
    );
    assert_eq!(peer.path.overrides.len(), 2);
}

#[test]
fn a_path_begins_where_the_robot_will_be() {
    let plan = plan(&steps(FRAME), None).unwrap();
    let streamed = streamed(&plan.steps[2].work);
    let PathElement::Line { to, .. } = streamed.elements[0] else {
        panic!("{:?}", streamed.elements[0]);
    };
    let start = streamed.course.at(0.0).unwrap().pose;
    let way = pose(&to).position - start.position;
    assert!((way.x + 0.05).abs() < 1e-12 && way.yz().norm() < 1e-12);
}

#[test]
fn a_point_that_cannot_be_is_told_with_its_number_and_line() {
    let path = Path::new("job.toml");
    for (elements, message) in [
        (
            "{ line = { position_m = [-0.05, 0, 0] } },\n { line = { position_m = [2, 0, 0] } }",
            "job.toml:11: error: irp6-postument: to point 2 of the path: ",
        ),
        (
            "{ line = { position_m = [-0.05, 0, 0] } },\n { through = { position_m = [-0.05, 0.01, 0], rotation_rad = [0, 0, 1.5] } }",
            "job.toml:11: error: irp6-postument: point 2 of the path: it turns the tool by more than a radian from the point before",
        ),
        (
            "{ line = { position_m = [0, 0, 0] } }",
            "job.toml:10: error: irp6-postument: point 1 of the path: it goes nowhere",
        ),
    ] {
        let error = plan(&steps(&format!("elements = [{elements}]")), Some(path)).unwrap_err();
        assert!(error.starts_with(message), "{error}");
        assert!(!error.contains('\n'));
    }
    let unhomed = "[[step]]\npath = { robot = \"irp6-track\", elements = [{ line = { position_m = [0, 0, 0] } }] }\n";
    assert!(
        plan(unhomed, Some(path))
            .unwrap_err()
            .starts_with("job.toml:4: error: irp6-track is not homed")
    );
}

#[test]
fn a_path_that_cannot_be_moves_nothing() {
    let far = "elements = [{ line = { position_m = [5, 0, 0] } }]";
    let mut world = world(task(&steps(far)), [Script::default(), Script::default()]);
    match finish(&mut world) {
        RunStatus::Failed(error) => assert_eq!(error.exit_code(), 11),
        other => panic!("{other:?}"),
    }
    assert!(world.peers.iter().all(|peer| peer.started.is_empty()));
}
