//! Encoders that count the wrong way, on every axis of every robot: how far the motor turns until its brake has it.

use super::*;
use hil_sim::plant::axis::EncoderFault;
use hil_sim::plant::parameters;

/// The servo step, s: of every robot here.
const STEP_S: f64 = 0.002;
/// Steps of the promise.
const STEPS: u32 = 10;
/// How much of the motor's greatest torque weight may be: ASSUMED brakes are 1.5 times the regulator's clamp, power stages
/// 1.25 times, and both carry the arm.
const WEIGHT: f64 = 0.5;
/// How much less and more than on average, about which nothing moves, an arm's inertia may be at a motor.
const FOLDED: f64 = 0.5;
const STRETCHED: f64 = 2.0;

/// What `docs/faults/33.md` promises from this speed on, if it is found after so many steps, rad.
fn promised(p: &parameters::AxisSetup, speed: f64, steps: u32) -> f64 {
    let (inertia, peak_nm) = (
        p.plant.inertia_kg_m2,
        p.plant.torque_constant_nm_a * p.plant.current_limit_a,
    );
    let faster = peak_nm / (FOLDED * inertia);
    // one step more until the drive hears of it
    let found = f64::from(steps + 1) * STEP_S;
    let closing = p.plant.brake_close_s;
    let brakes = (p.plant.brake_nm - WEIGHT * peak_nm) / (STRETCHED * inertia);
    let told = speed + faster * found;
    let gripped = told + WEIGHT * faster * closing;
    0.5 * (speed + told) * found
        + 0.5 * (told + gripped) * closing
        + gripped * gripped / (2.0 * brakes)
}

#[test]
fn no_runaway_turns_a_motor_farther_than_is_promised() {
    for kind in RobotKind::ALL {
        let setup = parameters::robot(kind, 1);
        let mut c = Coordinator::new(kind, ServoLaw::DrivePosition);
        c.enable();
        for axis in 0..kind.axes() {
            let (speed, before) = under_way(&mut c, axis);
            let wrong = DriveFault::Encoder(EncoderFault::Reversed);
            assert!(c.cell.robot_mut(0).unwrap().inject(axis, Some(wrong)));
            let since = c.feedback.as_ref().unwrap().step;
            let onset = c.cell.now();
            let sampled = c.feedback.as_ref().unwrap().sampled_at;
            c.wait("faulted", 3.0, |f| f.state == NodeState::Faulted);
            let fault = c.feedback.as_ref().and_then(|f| f.fault).unwrap();
            let number = u8::try_from(axis).unwrap();
            // an encoder of 128 increments a turn: its drive, which counts its lines, is first
            let coarse = setup.axes[axis].plant.increments_per_turn < 1000;
            let cause = if coarse {
                Cause::DriveFault
            } else {
                Cause::Runaway
            };
            assert_eq!((fault.cause, fault.axis), (cause, Some(number)), "{kind}");
            // the last feedback is of a step before the onset
            let late = u32::try_from(onset.since(sampled).0 / 2000).unwrap();
            let steps = fault.step - since - late;
            for _ in 0..25 {
                c.macrostep(&mut ());
            }
            let robot = c.cell.robots().next().unwrap().1;
            assert!(robot.plant(axis).unwrap().is_braked());
            let way = (robot.motor_rad()[axis] - before).abs();
            let most = promised(&setup.axes[axis], speed, steps);
            println!(
                "{kind} axis {}: at {speed:.2} rad/s found after {steps} steps, {way:.3} rad of {most:.3}",
                axis + 1
            );
            // the most that was found is 2.8 rad: loops need their time to reach the motor's greatest torque
            let most = if most < 4.0 || coarse { most } else { 4.0 };
            assert!(
                coarse || steps <= STEPS + 1,
                "{kind} axis {axis}: {steps} steps"
            );
            // it goes on as fast as before at least until it is found
            let least = 0.5 * speed * f64::from(steps) * STEP_S;
            assert!(
                (least..most).contains(&way),
                "{kind} axis {axis}: {way} {most}"
            );
            assert!(c.cell.robot_mut(0).unwrap().inject(axis, None));
            // it is back where it was, which is a jump: of what is over
            for _ in 0..2 {
                c.macrostep(&mut ());
            }
            scenario::resumes(&mut c);
        }
    }
}

/// An axis on its way, its speed, rad/s, and where it is, rad.
fn under_way(c: &mut Coordinator, axis: usize) -> (f64, f64) {
    let axes = c.feedback.as_ref().unwrap().actual.len();
    c.next_id += 1;
    let request = Request::Execute {
        epoch: c.epoch,
        id: c.next_id,
        start_at: Micros(0),
        instruction: Instruction::MoveMotors {
            target: (0..axes)
                .map(|k| if k == axis { 20.0 } else { 0.0 })
                .collect(),
            relative: true,
            speeds: speeds(axes, 1.0),
        },
    };
    assert_eq!(c.request(&request), Reply::Accepted);
    let place = |c: &Coordinator| scenario::motors(c)[axis];
    let start = place(c);
    for _ in 0..500 {
        c.macrostep(&mut ());
        if (place(c) - start).abs() > 1.5 {
            let robot = c.cell.robots().next().unwrap().1;
            return (robot.plant(axis).unwrap().velocity_rad_s().abs(), place(c));
        }
    }
    panic!("axis {axis} does not move: {:?}", c.feedback);
}
