//! Steps a second of one simulated arm of seven axes, the Polycrank, in substeps of 0.25 ms: its rigid-body
//! dynamics with brakes and friction alone, and with its seven drives.
//!
//! `cargo run --release -p mrroc-hil-sim --example arm_steps`

use hil_sim::plant::axis::{AxisPlant, Drive};
use hil_sim::plant::parameters;
use hil_sim::plant::random::SplitMix64;
use hil_sim::plant::robot::{SUBSTEP_NS, SimRobot};
use robots::RobotKind;
use std::time::Instant;

const STEPS: u32 = 400_000;

fn report(what: &str, since: Instant) {
    let seconds = since.elapsed().as_secs_f64();
    println!("{what}: {:.0} steps/s", f64::from(STEPS) / seconds);
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut setup = parameters::robot(RobotKind::Polycrank, 1);
    let dt_s = 1e-9 * f64::from(u32::try_from(SUBSTEP_NS)?);
    let mut plants: Vec<AxisPlant> = setup
        .axes
        .iter()
        .map(|axis| AxisPlant::new(axis.plant, axis.start_rad, dt_s, SplitMix64::new(1)))
        .collect();
    let since = Instant::now();
    for step in 0..STEPS {
        let torque_nm = if step % 4000 < 2000 { 3.0 } else { -3.0 };
        let command = Drive {
            torque_nm,
            release_brake: true,
        };
        setup.mechanics.step(&mut plants, &[command; 7], dt_s);
    }
    report("rigid bodies", since);
    let setup = parameters::robot(RobotKind::Polycrank, 1);
    let mut robot = SimRobot::new(setup, 1)?;
    let since = Instant::now();
    robot.advance(u64::from(STEPS) * SUBSTEP_NS, &mut |_| ());
    report("with idle drives", since);
    Ok(())
}
