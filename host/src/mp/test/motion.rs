//! Robots that move by themselves: together, in error, and stopped.

use super::world::{Loss, World, ready};
use crate::mp::behaviour::{acknowledge, execute, start_programs, wait_until};
use crate::mp::event::What;
use crate::mp::failure::Failure;
use crate::mp::watch::Watch;
use crate::mp::{Job, Mp, MpStatus};
use protocol::fault::{Cause, Refusal};
use protocol::message::{AxisSpeeds, Instruction, NodeState, Progress, StopKind};
use protocol::time::Micros;

fn small_move(axes: usize) -> Instruction {
    Instruction::MoveMotors {
        target: (0..axes).map(|_| 1.0).collect(),
        relative: true,
        speeds: AxisSpeeds {
            velocity: (0..axes).map(|_| 0.1).collect(),
            acceleration: (0..axes).map(|_| 0.1).collect(),
        },
    }
}

fn both() -> Vec<(usize, Instruction)> {
    vec![(0, small_move(7)), (1, small_move(6))]
}

fn move_both(world: &mut World<Mp>) -> MpStatus {
    let (grid, timing) = (world.driver.grid(), world.driver.config().timing);
    world.run(
        execute(both(), grid, &timing),
        Watch::work(vec![0, 1], timing.silence_ms),
    )
}

/// Both robots in the middle of their move.
fn both_moving() -> World<Mp> {
    let mut world = ready();
    let (grid, timing) = (world.driver.grid(), world.driver.config().timing);
    let job = execute(both(), grid, &timing);
    world
        .driver
        .begin(Job::new("move", job, Watch::work(vec![0, 1], 500)));
    assert!(world.until(1000, |w| {
        w.peers.iter().all(|p| p.state == NodeState::Moving)
    }));
    world
}

#[test]
fn two_robots_start_in_the_same_servo_step() {
    let mut world = ready();
    assert_eq!(move_both(&mut world), MpStatus::Ended);
    let starts: Vec<Micros> = world.peers.iter().map(|p| p.started[0].0).collect();
    assert_eq!(starts[0], starts[1]);
    for (image, peer) in world.driver.robots().iter().zip(&world.peers) {
        assert_eq!(peer.progress, Progress::Done);
        // one position unit
        assert!(
            image
                .demanded_motors()
                .unwrap()
                .iter()
                .all(|m| (m - 1.0).abs() < 4e-6)
        );
    }
}

#[test]
fn lost_frames_neither_repeat_nor_split_a_motion() {
    for seed in 0..6 {
        let mut world = ready();
        world.loss = Loss::of(10, seed);
        assert_eq!(move_both(&mut world), MpStatus::Ended, "seed {seed}");
        for peer in &world.peers {
            assert_eq!(peer.started.len(), 1, "executed exactly once");
        }
        assert_eq!(world.peers[0].started[0].0, world.peers[1].started[0].0);
    }
}

#[test]
fn a_fault_of_one_stops_the_other_in_the_same_macrostep() {
    let mut world = ready();
    world.peers[1].script.fault_at = Some(world.now + Micros::from_millis(300));
    let at = world.now + Micros::from_millis(300);
    let failure = match move_both(&mut world) {
        MpStatus::Failed(failure) => failure,
        other => panic!("{other:?}"),
    };
    match &failure {
        Failure::Fault { who, fault, axis } => {
            assert_eq!(who.name, "irp6-postument");
            assert_eq!(fault.cause, Cause::FollowingError);
            assert_eq!(*axis, world.driver.robots()[1].axis_name(1));
        }
        other => panic!("{other}"),
    }
    world.until(200, |_| false);
    // one feedback period of 10 ms, one macrostep, one tick each way
    let stopped = world.peers[0].stopped[0];
    assert!(
        at < stopped && stopped.since(at) <= Micros::from_millis(36),
        "{stopped:?} {at:?}"
    );
    assert_eq!(world.peers[0].state, NodeState::Holding);
    assert_eq!(world.peers[1].state, NodeState::Faulted);
    let events = world.driver.events();
    assert!(
        events
            .iter()
            .any(|e| matches!(&e.what, What::Failed { failure: f, .. } if *f == failure))
    );

    // no self-resume; after the acknowledgement a new command moves again
    assert!(matches!(
        move_both(&mut world),
        MpStatus::Failed(Failure::Fault { .. })
    ));
    let status = world.run(acknowledge(&[1]), Watch::requests(vec![1]));
    assert_eq!(status, MpStatus::Ended);
    assert!(world.until(200, |w| w.driver.robots()[1].state()
        == Some(NodeState::Holding)));
    assert_eq!(move_both(&mut world), MpStatus::Ended);
}

#[test]
fn a_refusal_of_one_keeps_the_other_from_going_on_alone() {
    let mut world = ready();
    world.peers[0].script.refuse = Some(Refusal::Unreachable);
    match move_both(&mut world) {
        MpStatus::Failed(Failure::Refused {
            who,
            refusal: Refusal::Unreachable,
            ..
        }) => {
            assert_eq!(who.robot, 0);
        }
        other => panic!("{other:?}"),
    }
    world.until(500, |_| false);
    assert_ne!(world.peers[1].progress, Progress::Done);
    assert_eq!(world.peers[1].state, NodeState::Holding);
}

#[test]
fn the_operators_stop_is_on_the_wire_at_once() {
    let mut world = both_moving();
    let mut frames = Vec::new();
    let now = world.now;
    world
        .driver
        .stop(StopKind::Path, now, &mut |frame| frames.push(frame));
    assert!(!frames.is_empty());
    assert_eq!(
        *world.driver.status(),
        MpStatus::Failed(Failure::Stopped {
            kind: StopKind::Path
        })
    );
    for peer in &mut world.peers {
        peer.step(now, &frames, &mut |_| {});
        assert_eq!(peer.stopped, [now]);
    }
    assert!(world.until(500, |w| {
        w.peers.iter().all(|p| p.state == NodeState::Holding)
    }));
    // and it is not the end: the next job is unaffected by the aborted instruction
    assert_eq!(move_both(&mut world), MpStatus::Ended);
}

#[test]
fn a_stop_survives_the_loss_of_its_first_broadcast() {
    let mut world = both_moving();
    let now = world.now;
    world.driver.stop(StopKind::Path, now, &mut |_| {});
    assert!(world.until(60, |w| w.peers.iter().all(|p| !p.stopped.is_empty())));
}

#[test]
fn a_lost_lease_is_an_error_and_nothing_goes_on() {
    let mut world = both_moving();
    // the process was halted for longer than the lease lasts
    world.period = Micros::from_millis(250);
    world.until(600, |_| false);
    match world.driver.status() {
        MpStatus::Failed(Failure::Fault { fault, .. }) => {
            assert_eq!(fault.cause, Cause::LeaseExpired);
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn programs_of_the_nodes_are_started_by_a_constant() {
    let mut world = ready();
    let status = world.run(
        start_programs(&[0, 1], 4, 0.5),
        Watch::work(vec![0, 1], 500),
    );
    assert_eq!(status, MpStatus::Ended);
    world.until(200, |_| false);
    for peer in &world.peers {
        assert_eq!(
            peer.started[0].1,
            Instruction::Program {
                program: 4,
                argument: 0.5
            }
        );
    }
}

#[test]
fn a_wait_ends_in_its_instant() {
    let mut world = ready();
    let i = world.driver.instant() + 25;
    assert_eq!(
        world.run(wait_until(i), Watch::work(vec![0, 1], 500)),
        MpStatus::Ended
    );
    assert_eq!(world.driver.instant(), i);
}

#[test]
fn the_same_inputs_give_the_same_bytes() {
    let run = || {
        let mut world = ready();
        world.loss = Loss::of(5, 9);
        let status = move_both(&mut world);
        (
            format!("{status:?} {:?}", world.driver.events()),
            world.sent,
            world.now,
        )
    };
    assert_eq!(run(), run());
}
