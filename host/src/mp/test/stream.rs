//! A path streamed to a node that has little room, over a wire that loses frames.

use super::peer::{Script, path::PathScript};
use super::world::{Loss, World, config, ready, ready_with};
use crate::mp::behaviour::stream;
use crate::mp::failure::Failure;
use crate::mp::generator::Stream;
use crate::mp::watch::Watch;
use crate::mp::{Job, Mp, MpStatus};
use proptest::prelude::*;
use protocol::fault::{PathProblem, Refusal};
use protocol::message::{
    Instruction, NodeState, PATH_BATCH, PathElement, PoseMessage, PoseSpeeds, Progress, StopKind,
};
use protocol::time::Micros;
use std::sync::Arc;

const SPEEDS: PoseSpeeds = PoseSpeeds {
    velocity_m_s: 0.1,
    angular_velocity_rad_s: 1.0,
    acceleration_m_s2: 1.0,
    angular_acceleration_rad_s2: 5.0,
};

/// The robot that follows: the postument.
const ROBOT: usize = 1;

/// So many points 1 mm apart from where the robot is, and the end.
fn path(world: &World<Mp>, points: usize) -> Arc<[PathElement]> {
    let tool = world.driver.sensors().tool_pose(ROBOT).fresh().unwrap();
    let base = world.driver.config().robots[ROBOT].t_world_base;
    let start = base.inverse() * tool;
    let mut at = start.position;
    let mut elements: Vec<PathElement> = (0..points)
        .map(|_| {
            at.z -= 1e-3;
            PathElement::Through(PoseMessage {
                position_m: at.into(),
                rotation_rad: start.rotation_vector().into(),
            })
        })
        .collect();
    elements.push(PathElement::End);
    elements.into()
}

fn scripted(path: PathScript) -> World<Mp> {
    let mut world = ready();
    world.peers[ROBOT].script = Script {
        path,
        ..Script::default()
    };
    world
}

fn watch() -> Watch {
    Watch::work(vec![ROBOT], 500)
}

/// Streams a path; what the node has of it must be a beginning of it, whatever happens.
fn run(world: &mut World<Mp>, elements: &Arc<[PathElement]>) -> MpStatus {
    let status = world.run(
        stream(Stream::new(ROBOT, SPEEDS, elements.clone())),
        watch(),
    );
    let taken = &world.peers[ROBOT].path;
    assert!(elements.starts_with(&taken.elements));
    assert_eq!(taken.unwelcome, 0, "{:?}", taken.requests);
    assert!(taken.requests.iter().all(|(_, count)| *count <= PATH_BATCH));
    status
}

#[test]
fn a_path_arrives_whole_and_in_order() {
    let mut world = scripted(PathScript::default());
    let elements = path(&world, 41);
    assert_eq!(run(&mut world, &elements), MpStatus::Ended);
    let peer = &world.peers[ROBOT];
    assert_eq!(peer.path.elements, elements.to_vec());
    assert_eq!((peer.path.passed, peer.progress), (42, Progress::Done));
    assert_eq!(
        peer.started.last().map(|(_, what)| what),
        Some(&Instruction::FollowPath { speeds: SPEEDS })
    );
    // the first request asks for room, and nothing is sent twice without a loss
    assert_eq!(peer.path.requests[0], (0, 0));
    let sent: usize = peer.path.requests.iter().map(|(_, count)| count).sum();
    assert_eq!(sent, elements.len());
}

#[test]
fn a_slow_node_is_asked_now_and_then() {
    let mut world = scripted(PathScript {
        capacity: 2,
        element_ms: 400,
        ..PathScript::default()
    });
    let elements = path(&world, 9);
    let begun = world.now;
    assert_eq!(run(&mut world, &elements), MpStatus::Ended);
    let requests = u64::try_from(world.peers[ROBOT].path.requests.len()).unwrap();
    let macrosteps = world.now.since(begun).0 / 20_000;
    // 9 elements of 400 ms; at most one question in three macrosteps and one request an element
    assert!(macrosteps >= 180, "{macrosteps}");
    assert!(
        (macrosteps / 8..=macrosteps / 3 + 10).contains(&requests),
        "{requests} in {macrosteps}"
    );
}

#[test]
fn a_node_that_wants_no_more_is_waited_for_until_the_operator_stops_it() {
    let mut world = scripted(PathScript {
        closed_from: Some(7),
        ..PathScript::default()
    });
    let elements = path(&world, 20);
    let job = stream(Stream::new(ROBOT, SPEEDS, elements.clone()));
    world.driver.begin(Job::new("path", job, watch()));
    assert!(!world.until(5000, |w| *w.driver.status() != MpStatus::Running));
    assert_eq!(world.peers[ROBOT].path.elements, elements[..7].to_vec());
    let now = world.now;
    world.driver.stop(StopKind::Path, now, &mut |_| {});
    assert!(world.until(500, |w| w.peers[ROBOT].state == NodeState::Holding));
    assert!(matches!(
        world.driver.status(),
        MpStatus::Failed(Failure::Stopped { .. })
    ));
}

#[test]
fn a_refused_element_ends_it_with_its_number() {
    for refused in [0, 13, 20] {
        let mut world = scripted(PathScript {
            refuse: Some(refused),
            ..PathScript::default()
        });
        let elements = path(&world, 20);
        match run(&mut world, &elements) {
            MpStatus::Failed(Failure::Instruction { who, refusal }) => {
                assert_eq!(who.robot, ROBOT);
                let problem = PathProblem::NoLength;
                let element = refused;
                assert_eq!(refusal, Refusal::Path { element, problem });
            }
            other => panic!("{refused}: {other:?}"),
        }
    }
}

#[test]
fn a_fault_ends_it() {
    let mut world = scripted(PathScript {
        element_ms: 100,
        ..PathScript::default()
    });
    world.peers[ROBOT].script.fault_at = Some(world.now + Micros::from_millis(700));
    let elements = path(&world, 20);
    assert!(matches!(
        run(&mut world, &elements),
        MpStatus::Failed(Failure::Fault { .. })
    ));
    let passed = world.peers[ROBOT].path.passed;
    assert!((3..9).contains(&passed), "{passed}");
}

#[test]
fn overrides_are_sent_when_they_are_due() {
    let mut world = scripted(PathScript {
        element_ms: 100,
        ..PathScript::default()
    });
    let elements = path(&world, 20);
    let overrides = vec![(10, 0.0), (60, 1.0), (5000, 0.5)];
    let generator = Stream::new(ROBOT, SPEEDS, elements.clone()).overriding(overrides);
    assert_eq!(world.run(stream(generator), watch()), MpStatus::Ended);
    let peer = &world.peers[ROBOT];
    assert_eq!(peer.path.elements, elements.to_vec());
    let shares: Vec<f32> = peer
        .path
        .overrides
        .iter()
        .map(|(_, share)| *share)
        .collect();
    // what was not due before the end is not sent
    assert_eq!(shares, [0.0, 1.0]);
    let began = peer.started.last().unwrap().0;
    for ((at, _), steps) in peer.path.overrides.iter().zip([10, 60]) {
        let late = at.since(began).0 / 1000 - steps * 20;
        // the feedback that tells that it runs, a request before it, and the way there
        assert!(late <= 100, "{late} ms");
    }
}

#[test]
fn the_end_is_noticed_though_its_answer_is_lost() {
    for seed in 0..10 {
        let mut world = scripted(PathScript {
            element_ms: 2,
            ..PathScript::default()
        });
        let elements = path(&world, 3);
        world.loss = Loss::of(40, seed);
        match run(&mut world, &elements) {
            MpStatus::Ended => {
                assert_eq!(world.peers[ROBOT].path.elements, elements.to_vec());
            }
            // of so many losses the link itself may fail, but never for another reason
            MpStatus::Failed(
                Failure::Unanswered { .. } | Failure::Lost { .. } | Failure::Fault { .. },
            ) => {}
            other => panic!("seed {seed}: {other:?}"),
        }
    }
}

/// As [`scripted`], but only a hundred unanswered requests end it: four elements and their answer are seven
/// frames, all of which arrive in 4 of 10 tries when 12 % of the frames are lost.
fn patient(path: PathScript) -> World<Mp> {
    let mut config = config();
    config.timing.tries = 100;
    let mut world = ready_with(config);
    world.peers[ROBOT].script.path = path;
    world
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]
    #[test]
    fn losses_cost_time_but_no_element(
        seed in any::<u64>(),
        per_cent in 0..12u64,
        capacity in 1..10usize,
        element_ms in 2..60u64,
        points in 1..30usize,
    ) {
        let mut world = patient(PathScript { capacity, element_ms, ..PathScript::default() });
        let elements = path(&world, points);
        world.loss = Loss::of(per_cent, seed);
        prop_assert_eq!(run(&mut world, &elements), MpStatus::Ended);
        prop_assert_eq!(&world.peers[ROBOT].path.elements, &elements.to_vec());
        prop_assert_eq!(world.peers[ROBOT].path.passed, points + 1);
    }
}
