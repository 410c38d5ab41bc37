//! The outputs at the tool: switched at rest over the bus, kept in motion, off when nobody answers for them.

use hil_sim::cell::Observer;
use mrroc_tests::coordinator::{Coordinator, speeds};
use protocol::fault::Refusal;
use protocol::message::{
    Instruction, NodeState, OUTPUT_SPINDLE, Reply, Request, ServoLaw, StopKind,
};
use protocol::time::Micros;
use robots::RobotKind;

/// The levels at the latest SYNC.
#[derive(Default)]
struct Levels(u16);

impl Observer for Levels {
    fn outputs(&mut self, _: usize, _: u64, levels: u16) {
        self.0 = levels;
    }
}

/// What the drive drives a macrostep from now.
fn levels(c: &mut Coordinator) -> u16 {
    c.macrostep();
    let mut seen = Levels::default();
    let soon = c.cell.now() + Micros::from_millis(4);
    c.cell.advance(soon, &mut seen);
    seen.0
}

fn switch(on: u16) -> impl FnOnce(u32) -> Request {
    move |epoch| Request::Outputs {
        epoch,
        mask: OUTPUT_SPINDLE,
        on,
    }
}

fn ready() -> Coordinator {
    let mut c = Coordinator::new(RobotKind::Irp6Postument, ServoLaw::DrivePosition, 3);
    c.acquire();
    c.enable();
    c.home();
    c
}

#[test]
fn an_output_is_switched_and_kept_while_the_robot_moves() {
    let mut c = ready();
    assert_eq!(levels(&mut c), 0);
    c.accepted(switch(OUTPUT_SPINDLE));
    assert_eq!(levels(&mut c), OUTPUT_SPINDLE);
    // bits outside the mask stay
    c.accepted(|epoch| Request::Outputs {
        epoch,
        mask: 2,
        on: 0xFFFF,
    });
    assert_eq!(levels(&mut c), 3);
    c.execute(Instruction::MoveMotors {
        target: [5.0; 6].into_iter().collect(),
        relative: true,
        speeds: speeds(6, 0.5, 0.5),
    });
    assert_eq!(levels(&mut c), 3);
    c.accepted(switch(0));
    assert_eq!(levels(&mut c), 2);
}

#[test]
fn it_is_not_switched_in_motion() {
    let mut c = ready();
    c.begin(Instruction::MoveMotors {
        target: [20.0; 6].into_iter().collect(),
        relative: true,
        speeds: speeds(6, 0.5, 0.5),
    });
    c.wait_for(NodeState::Moving);
    let request = switch(OUTPUT_SPINDLE)(c.epoch());
    assert_eq!(
        c.request(&request),
        Reply::Refused(Refusal::WrongState {
            state: NodeState::Moving
        })
    );
    assert_eq!(levels(&mut c), 0);
}

#[test]
fn torque_off_and_a_lost_master_switch_it_off() {
    let mut c = ready();
    c.accepted(switch(OUTPUT_SPINDLE));
    assert_eq!(levels(&mut c), OUTPUT_SPINDLE);
    c.accepted(|epoch| Request::Disable { epoch });
    c.wait_for(NodeState::Disabled);
    assert_eq!(levels(&mut c), 0);
    // and stays off when torque is on again
    c.accepted(|epoch| Request::Enable { epoch });
    c.wait_for(NodeState::Holding);
    assert_eq!(levels(&mut c), 0);
    c.accepted(switch(OUTPUT_SPINDLE));
    assert_eq!(levels(&mut c), OUTPUT_SPINDLE);
    c.talks = false;
    // the lease lasts a second at most
    for _ in 0..60 {
        c.macrostep();
    }
    assert_eq!(levels(&mut c), 0);
}

#[test]
fn a_quick_stop_switches_it_off() {
    let mut c = ready();
    c.accepted(switch(OUTPUT_SPINDLE));
    assert_eq!(levels(&mut c), OUTPUT_SPINDLE);
    c.begin(Instruction::MoveMotors {
        target: [20.0; 6].into_iter().collect(),
        relative: true,
        speeds: speeds(6, 0.5, 0.5),
    });
    c.wait_for(NodeState::Moving);
    c.stop(StopKind::Quick);
    for _ in 0..100 {
        c.macrostep();
    }
    assert_eq!(levels(&mut c), 0);
}
