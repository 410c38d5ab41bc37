//! Tasks from text to rest, in virtual time, with scripted peers.

mod path;

use super::plan::{Place, Plan, Work};
use super::run::NEXT_NODE;
use super::{Progress, Run, RunError, RunStatus, Segment, config_of};
use crate::input::Files;
use crate::mp::config::Config;
use crate::mp::failure::Failure;
use crate::mp::test::peer::Script;
use crate::mp::test::world::{Driver, World};
use crate::task::Task;
use protocol::frame::Frame;
use protocol::message::{Instruction, NodeState, StopKind};
use protocol::time::Micros;
use std::path::Path;

const CELL: &str =
    "title = \"t\"\n[cell]\nrobot = [{ kind = \"irp6-track\" }, { kind = \"irp6-postument\" }]\n";

fn task(steps: &str) -> Task {
    Task::parse(&format!("{CELL}{steps}")).unwrap()
}

struct Driven {
    run: Run,
    status: RunStatus,
    progress: Vec<Progress>,
}

impl Driver for Driven {
    fn step(&mut self, now: Micros, rx: Vec<(Micros, Frame)>, tx: &mut dyn FnMut(Frame)) {
        self.status = self.run.step(now, rx, &mut |frame| tx(frame));
        self.progress.extend(self.run.progress());
    }
}

fn world(task: Task, scripts: [Script; 2]) -> World<Driven> {
    let config = config_of(&task.cell).unwrap();
    let run = Run::new(task, None, config, 1).unwrap();
    World::around(
        Driven {
            run,
            status: RunStatus::Running,
            progress: Vec::new(),
        },
        scripts,
    )
}

fn finish(world: &mut World<Driven>) -> RunStatus {
    assert!(
        world.until(300_000, |w| w.driver.status != RunStatus::Running),
        "the run does not end: {:?}",
        world.driver.progress.last()
    );
    world.driver.status.clone()
}

const FULL: &str = r#"
[[step]]
home = ["irp6-track", "irp6-postument"]
[[step]]
move = [
  { robot = "irp6-track", joints = [0.0, 0.0, 0.0, 0.02, 0.0, 0.0, 0.0], relative = true },
  { robot = "irp6-postument", motors = [2.0, 0.0, 0.0, 0.0, 0.0, 0.0], relative = true },
]
[[step]]
wait = { seconds = 0.3 }
[[step]]
tight = { robots = ["irp6-track", "irp6-postument"], displacement_m = [0.0, 0.0, 0.04], duration_s = 1.5 }
[[step]]
regulator = { robot = "irp6-track", law = "feed-forward" }
"#;

#[test]
fn a_task_runs_to_its_end() {
    let mut world = world(task(FULL), [Script::default(), Script::default()]);
    assert_eq!(finish(&mut world), RunStatus::Done);
    let progress = &world.driver.progress;
    let began = |p: &&Progress| matches!(p, Progress::StepBegan { of: 5, .. });
    assert_eq!(progress.iter().filter(began).count(), 5);
    assert_eq!(progress.last(), Some(&Progress::Released));
    assert!(progress.contains(&Progress::Node {
        step: 2,
        robot: 1,
        node: 1,
        of: 1
    }));
    // home, one move, one carry
    for peer in &world.peers {
        assert_eq!(peer.started.len(), 2);
        assert_eq!(peer.started[1].1, Instruction::Follow);
        assert_eq!(peer.state, NodeState::Holding);
        assert!(peer.stopped.is_empty(), "nobody had to be stopped");
    }
    assert_eq!(world.peers[0].started[0].0, world.peers[1].started[0].0);
    // where the plan said they would be: the feedback's units at the beginning of the carry
    let end = &world.driver.run.plan().unwrap().end;
    for (peer, place) in world.peers.iter().zip(end) {
        for (motor, planned) in peer.motors.iter().zip(&place.motors) {
            assert!((motor - planned).abs() < 1e-4, "{motor} {planned}");
        }
    }
    assert!(
        world
            .driver
            .run
            .checklists()
            .iter()
            .all(super::super::mp::checklist::Checklist::is_ok)
    );
}

#[test]
fn observers_are_told_the_way() {
    let mut world = world(task(FULL), [Script::default(), Script::default()]);
    let mut seen: Vec<&'static str> = Vec::new();
    while world.driver.status == RunStatus::Running && world.now.0 < 60_000_000 {
        world.tick();
        let name = match world.driver.run.segment(0) {
            Segment::None => "none",
            Segment::Homing => "homing",
            Segment::Motors { .. } => "motors",
            Segment::Joints { from, to } => {
                assert!((to[3] - from[3] - 0.02).abs() < 1e-12);
                "joints"
            }
            Segment::Line { .. } => "line",
            Segment::Carry { .. } => "carry",
            Segment::Path(_) => "path",
        };
        if seen.last() != Some(&name) {
            seen.push(name);
        }
    }
    assert_eq!(
        seen,
        ["none", "homing", "none", "joints", "none", "carry", "none"]
    );
}

#[test]
fn what_is_homed_is_not_homed_again() {
    let homed = || Script {
        homed: true,
        ..Script::default()
    };
    let mut world = world(task(FULL), [homed(), homed()]);
    assert_eq!(finish(&mut world), RunStatus::Done);
    assert!(!world.driver.progress.iter().any(|p| matches!(
        p,
        Progress::Robot(event) if matches!(event.what, crate::mp::event::What::Homing { .. })
    )));
}

#[test]
fn numbers_on_the_wire_are_those_of_the_kinds() {
    use robots::RobotKind::{Irp6Postument, Irp6Track};
    let nodes = |kinds: &[robots::RobotKind]| -> Vec<u8> {
        let config = config_of(&crate::task::Cell::of(kinds)).unwrap();
        config.robots.iter().map(|robot| robot.node.get()).collect()
    };
    assert_eq!(nodes(&[Irp6Postument]), [12]);
    assert_eq!(nodes(&[Irp6Postument, Irp6Track]), [12, 11]);
    assert_eq!(
        nodes(&[Irp6Postument, Irp6Postument, Irp6Track]),
        [12, 19, 11]
    );
}

fn plan(steps: &str, path: Option<&Path>) -> Result<Plan, String> {
    let task = task(steps);
    let config: Config = config_of(&task.cell).unwrap();
    let places = config
        .robots
        .iter()
        .map(|r| Place::unknown(r.arm))
        .collect();
    Plan::new(&task, path, &config, places).map_err(|error| error.to_string())
}

#[test]
fn a_tool_is_not_asked_for_more_than_its_node_takes() {
    // a share of 5 m/s; an RNT takes 0.2 m/s and 1 m/s²
    for (speeds, expected) in [
        (
            "speed = 0.05, acceleration = 0.1",
            Some("velocity in m/s of the tool out of range (expected at most 0.2, got 0.25)"),
        ),
        (
            "speed = 0.04, acceleration = 0.25",
            Some("acceleration in m/s² of the tool out of range (expected at most 1, got 1.25)"),
        ),
        ("speed = 0.04, acceleration = 0.2", None),
    ] {
        let text = format!(
            "title = \"fast\"\n[[cell.robot]]\nkind = \"rnt\"\n[[step]]\nhome = [\"rnt\"]\n[[step]]\n\
             move = {{ robot = \"rnt\", pose = {{ position_m = [0, 0, 0.01] }}, relative = true, {speeds} }}\n"
        );
        let task = Task::parse(&text).unwrap();
        let config: Config = config_of(&task.cell).unwrap();
        let places = config
            .robots
            .iter()
            .map(|r| Place::unknown(r.arm))
            .collect();
        let plan = Plan::new(&task, Some(Path::new("job.toml")), &config, places);
        let told = plan.err().map(|error| error.to_string());
        let expected = expected.map(|words| format!("job.toml:6: error: rnt: {words}"));
        assert_eq!(told, expected);
    }
}

#[test]
fn what_cannot_be_is_told_with_its_line() {
    let path = Path::new("job.toml");
    let error = plan(
        "[[step]]\nmove = { robot = \"irp6-track\", joints = [0, 0, 0, 0, 0, 0, 0] }\n",
        Some(path),
    );
    assert_eq!(
        error.unwrap_err(),
        "job.toml:4: error: irp6-track is not homed (expected a step `home` before, or a relative motion of motors)"
    );
    let home = "[[step]]\nhome = [\"irp6-track\"]\n";
    let far = format!(
        "{home}[[step]]\nmove = {{ robot = \"irp6-track\", pose = {{ position_m = [9, 0, 0], rotation_rad = [0, 0, 0] }} }}\n"
    );
    let error = plan(&far, Some(path)).unwrap_err();
    assert!(
        error.starts_with("job.toml:6: error: irp6-track: at "),
        "{error}"
    );
    assert!(!error.contains('\n'));
    let limit = format!(
        "{home}[[step]]\nmove = {{ robot = \"irp6-track\", joints = [0, 0, 0, 0, 0, 0, 9], relative = true }}\n"
    );
    let error = plan(&limit, None).unwrap_err();
    assert!(
        error.contains("line 6: error: irp6-track: the goal: "),
        "{error}"
    );
}

#[test]
fn a_task_that_cannot_be_moves_nothing() {
    let steps = "[[step]]\nmove = { robot = \"irp6-track\", joints = [0, 0, 0, 0, 0, 0, 0] }\n";
    let mut world = world(task(steps), [Script::default(), Script::default()]);
    match finish(&mut world) {
        RunStatus::Failed(error @ RunError::Plan(_)) => assert_eq!(error.exit_code(), 11),
        other => panic!("{other:?}"),
    }
    for peer in &world.peers {
        assert!(peer.started.is_empty());
        assert!(matches!(
            peer.state,
            NodeState::Configuring | NodeState::Disabled
        ));
    }
}

#[test]
fn unhomed_motors_may_jog() {
    let steps = "[[step]]\nmove = { robot = \"irp6-track\", motors = [1, 0, 0, 0, 0, 0, 0], relative = true }\n";
    let mut world = world(task(steps), [Script::default(), Script::default()]);
    assert_eq!(finish(&mut world), RunStatus::Done);
    assert_eq!(world.peers[0].started.len(), 1);
}

#[test]
fn a_node_without_feedback_is_lost() {
    let mut world = world(task(FULL), [Script::default(), Script::default()]);
    world.peers[1].feedback_on = false;
    match finish(&mut world) {
        RunStatus::Failed(RunError::Failure {
            failure: Failure::Lost { who, .. },
            ..
        }) => {
            assert_eq!(who.robot, 1);
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn streams_begin_together_and_go_on_alone() {
    let text = |nodes: usize, axes: usize| {
        let line = |value: f64| format!("{}\n", vec![value.to_string(); axes].join(" "));
        let node = format!("{}{}{}", line(0.1), line(0.1), line(0.01));
        format!("JOINT\n{nodes}\nRELATIVE\n{}", node.repeat(nodes))
    };
    let mut replayed = task("[[step]]\nhome = [\"irp6-track\", \"irp6-postument\"]\n");
    let replays = [(0, 3, 7), (1, 2, 6)].map(|(robot, nodes, axes)| crate::task::Replay {
        robot,
        path: "x.trj".into(),
        trajectory: crate::trj::parse(&text(nodes, axes), axes).unwrap(),
    });
    replayed.steps.push(crate::task::Step {
        name: "replay".into(),
        line: 9,
        action: crate::task::Action::Replay {
            replays: replays.to_vec(),
            coordination: crate::task::Coordination::None,
        },
    });
    let mut world = world(replayed, [Script::default(), Script::default()]);
    assert_eq!(finish(&mut world), RunStatus::Done);
    let starts = |robot: usize| -> Vec<Micros> {
        world.peers[robot]
            .started
            .iter()
            .map(|(at, _)| *at)
            .collect()
    };
    assert_eq!((starts(0).len(), starts(1).len()), (3, 2));
    assert_eq!(starts(0)[0], starts(1)[0]);
}

#[test]
fn the_operator_ends_it_at_rest_and_released() {
    let mut world = world(task(FULL), [Script::default(), Script::default()]);
    assert!(world.until(30_000, |w| w.peers[0].state == NodeState::Moving));
    let now = world.now;
    let mut frames = Vec::new();
    world
        .driver
        .run
        .stop(StopKind::Path, now, &mut |frame| frames.push(frame));
    for peer in &mut world.peers {
        peer.step(now, &frames, &mut |_| {});
    }
    match finish(&mut world) {
        RunStatus::Failed(error) => {
            assert_eq!(error.exit_code(), 12);
            assert!(
                error.to_string().contains("stopped by the operator"),
                "{error}"
            );
        }
        other => panic!("{other:?}"),
    }
    for (peer, image) in world.peers.iter().zip(world.driver.run.mp().robots()) {
        assert_eq!(peer.state, NodeState::Holding);
        assert_eq!(image.epoch(), None);
    }
    assert!(
        world
            .driver
            .progress
            .ends_with(&[Progress::AtRest, Progress::Released])
    );
}

#[test]
fn a_fault_ends_the_task_with_who_and_what() {
    let mut world = world(task(FULL), [Script::default(), Script::default()]);
    assert!(world.until(30_000, |w| w.peers[1].state == NodeState::Moving));
    world.peers[1].script.fault_at = Some(world.now);
    match finish(&mut world) {
        RunStatus::Failed(RunError::Failure {
            step: Some(step),
            failure: Failure::Fault { who, .. },
        }) => {
            assert!(step.starts_with("move "), "{step}");
            assert_eq!(who.robot, 1);
        }
        other => panic!("{other:?}"),
    }
    assert_eq!(world.peers[0].stopped.len(), 1);
}

#[test]
fn the_shipped_task_runs() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tasks/two-arms.toml");
    let task = Task::load(&path, &Files::on_disk()).unwrap();
    let config = config_of(&task.cell).unwrap();
    let places = config
        .robots
        .iter()
        .map(|r| Place::unknown(r.arm))
        .collect();
    let plan = Plan::new(&task, Some(&path), &config, places).unwrap();
    let loose = plan
        .steps
        .iter()
        .any(|s| matches!(&s.work, Work::Groups(g) if g.len() > 1));
    let mut world = world(task, [Script::default(), Script::default()]);
    assert_eq!(finish(&mut world), RunStatus::Done);
    assert_eq!(NEXT_NODE, 1);
    let end = world.driver.run.plan().unwrap().end.clone();
    for (peer, place) in world.peers.iter().zip(&end) {
        for (motor, planned) in peer.motors.iter().zip(&place.motors) {
            // units of the feedback from which relative motions and carries begin, through the gears
            assert!((motor - planned).abs() < 1e-3, "{motor} {planned}");
        }
    }
    if loose {
        // every node of the loose steps was announced, in order
        assert!(
            world.peers.iter().all(|p| p.decisions.starts_with(&[1, 2])),
            "{:?}",
            world.peers[0].decisions
        );
    }
}
