//! The world says what goes wrong in it.

use firmware::ecp::NoPrograms;
use host::mp::behaviour::start_programs;
use mrroc_examples::{Arm, World};

#[test]
fn a_program_that_is_not_linked_in_is_refused() {
    let mut world = World::new(vec![Arm::postument(NoPrograms).unwrap()]).unwrap();
    world.get_ready().unwrap();
    let error = world.run(start_programs(&[0], 7, 0.0)).unwrap_err();
    let text = error.to_string();
    assert!(
        text.contains("irp6-postument") && text.contains("program 7"),
        "{text}"
    );
    assert_eq!(world.faults(), 0);
}

#[test]
fn an_arm_that_nobody_got_ready_runs_no_program() {
    let mut world = World::new(vec![Arm::postument(NoPrograms).unwrap()]).unwrap();
    assert!(world.run(start_programs(&[0], 1, 0.0)).is_err());
}
