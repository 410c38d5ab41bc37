//! A robot in motion, to break something, and what comes of it.

use super::*;

/// The servo step, µs.
const STEP_US: u64 = 2000;

/// Counts SYNCs: the node's servo steps.
#[derive(Default)]
struct Syncs(u32);

impl Observer for Syncs {
    fn frame(&mut self, bus: usize, _: u64, frame: &Frame) {
        if bus == DRIVE_BUS && frame.data().is_empty() && frame.id() == Id::Standard(0x080) {
            self.0 += 1;
        }
    }
}

/// A move under way, and the number of the last servo step.
pub(super) fn moving() -> (Coordinator, u32) {
    let target = [60.0, 20.0, 20.0, 20.0, 20.0, 20.0];
    let (mut c, counted) = begun(false, &target, 0.5);
    for _ in 0..10 {
        c.macrostep(&mut ());
    }
    let step = counted.step(&c);
    (c, step)
}

/// The same of the fourth motor alone, homed, once it turns as fast as that, rad/s.
pub(super) fn fast(rad_s: f64) -> (Coordinator, u32) {
    let (mut c, counted) = begun(true, &[0.0, 0.0, 0.0, 140.0, 0.0, 0.0], 1.0);
    let velocity = |c: &Coordinator| {
        let robot = c.cell.robots().next().unwrap().1;
        robot.plant(3).unwrap().velocity_rad_s()
    };
    for _ in 0..200 {
        if velocity(&c) > rad_s {
            let step = counted.step(&c);
            return (c, step);
        }
        c.macrostep(&mut ());
    }
    panic!("{rad_s} rad/s are not reached: {:?}", c.feedback);
}

/// The number of a servo step, and when it was.
struct Counted(u32, Micros);

impl Counted {
    /// The last servo step now.
    fn step(&self, c: &Coordinator) -> u32 {
        self.0 + u32::try_from(c.cell.now().since(self.1).0 / STEP_US).unwrap()
    }
}

fn begun(homed: bool, target: &[f64], fraction: f32) -> (Coordinator, Counted) {
    let mut syncs = Syncs::default();
    let mut c = Coordinator::new(RobotKind::Irp6Postument, ServoLaw::DrivePosition);
    for _ in 0..50 {
        c.macrostep(&mut syncs);
    }
    let counted = Counted(syncs.0, c.cell.now());
    c.enable();
    if homed {
        c.home();
    }
    let request = Request::Execute {
        epoch: c.epoch,
        id: 1,
        start_at: Micros(0),
        instruction: Instruction::MoveMotors {
            target: target.iter().copied().collect(),
            relative: true,
            speeds: speeds(6, fraction),
        },
    };
    assert_eq!(c.request(&request), Reply::Accepted);
    c.wait("moving", 2.0, |f| f.state == NodeState::Moving);
    (c, counted)
}

/// The fault the node ends with, and after how many steps.
pub(super) fn ends(c: &mut Coordinator, onset: u32) -> (Cause, Option<u8>, u32) {
    c.wait("faulted", 3.0, |f| f.state == NodeState::Faulted);
    let fault = c.feedback.as_ref().and_then(|f| f.fault).unwrap();
    assert_eq!(fault.during, NodeState::Moving);
    (fault.cause, fault.axis, fault.step - onset)
}

pub(super) fn motors(c: &Coordinator) -> Vec<f64> {
    c.cell.robots().next().unwrap().1.motor_rad().to_vec()
}

/// Once the brakes have closed nothing moves by more than an encoder increment in a second, however the bus is.
pub(super) fn rests(c: &mut Coordinator) {
    for _ in 0..25 {
        c.macrostep(&mut ());
    }
    let before = motors(c);
    for _ in 0..50 {
        c.macrostep(&mut ());
    }
    for (before, after) in before.iter().zip(motors(c)) {
        assert!((after - before).abs() < 1.6e-3, "{before} {after}");
    }
}

/// Back to torque after the node was told that the fault is known.
pub(super) fn resumes(c: &mut Coordinator) {
    let epoch = c.epoch;
    assert_eq!(c.request(&Request::Acknowledge { epoch }), Reply::Accepted);
    c.wait("configured", 5.0, |f| f.state == NodeState::Disabled);
    assert_eq!(c.request(&Request::Enable { epoch }), Reply::Accepted);
    c.wait("enabled", 3.0, |f| f.state == NodeState::Unsynchronised);
}
