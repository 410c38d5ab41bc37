//! Encoders that tell something else than where the motor is, in motion: what is found, after how many steps, and how
//! far the motor turns.

use super::scenario::{ends, fast, motors};
use super::*;
use hil_sim::plant::axis::EncoderFault;

const AXIS: usize = 3;

#[test]
fn every_wrong_encoder_is_found_in_time_and_with_its_cause() {
    for fault in EncoderFault::ALL {
        // A step of the fault's own passes before a SYNC samples it.
        let (cause, steps, travel) = match fault {
            // 200 increments at 21 rad/s or more; a drive in csp has given torque for nothing meanwhile
            EncoderFault::Frozen => (Cause::FollowingError, 4..=11, 10.0),
            // half a turn is twice as far as an encoder may move in a step
            EncoderFault::Jumping | EncoderFault::Garbage => (Cause::EncoderJump, 1..=2, 4.0),
            // 60 increments at 21 rad/s and more; what the loop has pushed the wrong way until then the brake has to take,
            // after 30 ms
            EncoderFault::Reversed => (Cause::Runaway, 2..=6, 3.0),
            // found by the drive, which misses lines between two of its index pulses: two turns at 20 rad/s and what
            // drifts away until then
            EncoderFault::Drifting => (Cause::DriveFault, 5..=400, 20.0),
        };
        let (mut c, onset) = fast(20.0);
        let before = motors(&c)[AXIS];
        let wrong = DriveFault::Encoder(fault);
        assert!(c.cell.robot_mut(0).unwrap().inject(AXIS, Some(wrong)));
        let (found, axis, after) = ends(&mut c, onset);
        println!(
            "{fault:?}: {found:?} after {after} steps, {:.2} rad",
            motors(&c)[AXIS] - before
        );
        assert_eq!((found, axis), (cause, Some(3)), "{fault:?}");
        assert!(steps.contains(&after), "{fault:?}: {after}");
        for _ in 0..50 {
            c.macrostep(&mut ());
        }
        let way = (motors(&c)[AXIS] - before).abs();
        println!("{fault:?}: {way:.2} rad in all");
        assert!(way < travel, "{fault:?}: {way}");
        assert!(
            c.cell
                .robots()
                .next()
                .unwrap()
                .1
                .plant(AXIS)
                .unwrap()
                .is_braked()
        );
        assert_eq!(c.state(), Some(NodeState::Faulted));
    }
}

#[test]
fn a_drive_that_misses_lines_of_its_encoder_says_so() {
    let (mut c, _) = fast(20.0);
    let wrong = DriveFault::Encoder(EncoderFault::Drifting);
    assert!(c.cell.robot_mut(0).unwrap().inject(AXIS, Some(wrong)));
    c.wait("faulted", 3.0, |f| f.state == NodeState::Faulted);
    let robot = c.cell.robots().next().unwrap().1;
    assert_eq!(robot.drive(AXIS).unwrap().error_code(), ErrorCode::ENCODER);
}

/// Two answers that are lost are not yet a silent drive, nor is what is known of the axis a frozen encoder then.
#[test]
fn answers_that_do_not_come_are_no_frozen_encoder() {
    // 57 increments a step, of which 100 are too many
    let (mut c, _) = fast(45.0);
    assert!(
        c.cell
            .robot_mut(0)
            .unwrap()
            .inject(AXIS, Some(DriveFault::Silent))
    );
    let now = c.cell.now();
    c.cell.advance(now + Micros(4000), &mut ());
    assert!(c.cell.robot_mut(0).unwrap().inject(AXIS, None));
    for _ in 0..5 {
        c.macrostep(&mut ());
    }
    assert_eq!(c.feedback.as_ref().and_then(|f| f.fault), None);
    assert_eq!(c.state(), Some(NodeState::Moving));
}
