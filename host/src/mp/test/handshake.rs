//! From silence to robots under torque, and everything that can be missing on the way.

use super::peer::Script;
use super::world::{Loss, World, ready};
use crate::mp::behaviour::{get_ready, release};
use crate::mp::checklist::{Checklist, State};
use crate::mp::event::What;
use crate::mp::failure::{Asked, Awaited, Failure};
use crate::mp::generator::Readiness;
use crate::mp::robot::Link;
use crate::mp::watch::Watch;
use crate::mp::{Mp, MpStatus};
use protocol::fault::Refusal;
use protocol::message::NodeState;
use protocol::time::Micros;

fn shake(world: &mut World<Mp>) -> MpStatus {
    let timing = world.driver.config().timing;
    world.run(
        get_ready(vec![0, 1], Readiness::Enabled, timing),
        Watch::requests(vec![0, 1]),
    )
}

fn failure(status: MpStatus) -> Failure {
    match status {
        MpStatus::Failed(failure) => failure,
        other => panic!("{other:?}"),
    }
}

#[test]
fn both_robots_come_under_torque() {
    let mut world = World::new([Script::default(), Script::default()]);
    assert_eq!(shake(&mut world), MpStatus::Ended);
    for (image, peer) in world.driver.robots().iter().zip(&world.peers) {
        assert_eq!(peer.state, NodeState::Unsynchronised);
        let list = Checklist::of(image, None);
        assert!(list.is_ok(), "{list}");
        let pending: Vec<&str> = list
            .items
            .iter()
            .filter(|item| item.state == State::Pending)
            .map(|item| item.what)
            .collect();
        assert_eq!(pending, ["homed"], "{list}");
    }
    let events = world.driver.events();
    for robot in [0, 1] {
        let named = |what: &What| matches!(what, What::Leased { robot: r, .. } if *r == robot);
        assert_eq!(events.iter().filter(|e| named(&e.what)).count(), 1);
    }
}

#[test]
fn a_fifth_of_all_frames_may_be_lost() {
    for seed in 0..4 {
        let mut world = World::new([Script::default(), Script::default()]);
        world.loss = Loss::of(20, seed);
        assert_eq!(shake(&mut world), MpStatus::Ended, "seed {seed}");
    }
}

#[test]
fn another_message_set_is_refused_before_the_lease() {
    let script = Script {
        schema: Some(0xBAD),
        ..Script::default()
    };
    let mut world = World::new([Script::default(), script]);
    let failure = failure(shake(&mut world));
    assert_eq!(failure.exit_code(), 76);
    let text = failure.to_string();
    assert!(
        text.starts_with("irp6-postument (node 12): message set differs (expected "),
        "{text}"
    );
    assert!(text.contains("got 0000000000000bad"), "{text}");
    let image = &world.driver.robots()[1];
    assert!(matches!(image.link(), Link::Identified { .. }));
    let list = Checklist::of(image, Some(&failure));
    assert!(!list.is_ok());
    assert!(
        list.to_string().contains("[!] message set: expected"),
        "{list}"
    );
    assert_eq!(list.json()["items"][3]["state"], "failed");
    assert_eq!(list.json()["items"][3]["got"], "0000000000000bad");
}

#[test]
fn a_silent_node_is_named_after_two_seconds() {
    let script = Script {
        silent: true,
        ..Script::default()
    };
    let mut world = World::new([script, Script::default()]);
    let failure = failure(shake(&mut world));
    assert_eq!(
        failure.to_string(),
        "irp6-track (node 11) does not answer Identify: no frame in 2.0 s; is mrroc-node running on this bus?"
    );
    // two seconds and the macrostep in which it is noticed, on either side
    assert!(
        (2_000_000..=2_080_000).contains(&world.now.0),
        "{:?}",
        world.now
    );
    let list = Checklist::of(&world.driver.robots()[0], Some(&failure));
    assert!(
        matches!(&list.items[0].state, State::Failed { hint, .. } if hint.contains("mrroc-node"))
    );
}

#[test]
fn a_lease_held_by_another_is_told() {
    let script = Script {
        held_by: Some(3),
        ..Script::default()
    };
    let mut world = World::new([Script::default(), script]);
    let failure = failure(shake(&mut world));
    assert_eq!(failure.exit_code(), 75);
    assert!(
        failure
            .to_string()
            .contains("node 3 holds the command lease"),
        "{failure}"
    );
    // nobody else's robot is stopped by our failure
    assert!(world.peers.iter().all(|peer| peer.stopped.is_empty()));
}

#[test]
fn drives_that_never_get_ready_are_named() {
    let script = Script {
        drives_never: true,
        ..Script::default()
    };
    let mut world = World::new([Script::default(), script]);
    match failure(shake(&mut world)) {
        Failure::TimedOut {
            awaited: Awaited::Drives,
            who,
            seen,
            ..
        } => {
            assert_eq!(who.robot, 1);
            assert!(seen.contains("no drive-ready event of"), "{seen}");
        }
        other => panic!("{other}"),
    }
}

#[test]
fn the_lease_is_kept_at_rest_and_given_back() {
    let mut world = ready();
    assert!(!world.until(1000, |world| {
        world.driver.robots().iter().any(|r| r.epoch().is_none())
    }));
    let behaviour = release(world.driver.robots(), true);
    assert_eq!(
        world.run(behaviour, Watch::requests(vec![0, 1])),
        MpStatus::Ended
    );
    for (image, peer) in world.driver.robots().iter().zip(&world.peers) {
        assert!(matches!(image.link(), Link::Identified { .. }));
        assert_eq!(peer.state, NodeState::Disabled);
    }
}

#[test]
fn a_node_that_falls_silent_is_lost() {
    let mut world = ready();
    world.peers[0].script.silent = true;
    assert!(world.until(1000, |world| *world.driver.robots()[0].link()
        == Link::Silent));
    assert!(
        world
            .driver
            .events()
            .iter()
            .any(|e| e.what == What::Lost { robot: 0 })
    );
    assert!(world.driver.robots()[0].feedback().fresh().is_none());
    assert_eq!(world.driver.sensors().tool_pose(0).fresh(), None);
}

#[test]
fn a_refusal_names_the_request() {
    let mut world = ready();
    world.peers[0].script.refuse = Some(Refusal::UnknownServoLaw);
    let instruction = protocol::message::Instruction::Hold { duration_ms: 5 };
    let grid = world.driver.grid();
    let timing = world.driver.config().timing;
    let behaviour = crate::mp::behaviour::execute(vec![(0, instruction)], grid, &timing);
    let status = world.run(behaviour, Watch::work(vec![0], 500));
    match failure(status) {
        Failure::Refused {
            asked: Asked::Execute,
            refusal,
            who,
        } => {
            assert_eq!((who.robot, refusal), (0, Refusal::UnknownServoLaw));
        }
        other => panic!("{other}"),
    }
}

#[test]
fn any_cadence_works() {
    for period in [2, 7, 20, 33] {
        let mut world = World::new([Script::default(), Script::default()]);
        world.period = Micros::from_millis(period);
        assert_eq!(shake(&mut world), MpStatus::Ended, "{period} ms");
    }
}
