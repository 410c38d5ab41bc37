//! Steps of one simulated arm of seven axes, the Polycrank, in substeps of 0.25 ms: its rigid-body
//! dynamics with current loops, receptors, viscous and Coulomb friction, its seven motors driven to and fro.
//!
//! `cargo run --release -p mrroc-hil-sim --example arm_steps [STEPS]`; with `axes` instead of a number it prints
//! rotor (kg·m²), viscous (N·m·s/rad) and Coulomb friction (N·m) of every axis, for `oracles/mujoco`.

use hil_sim::plant::axis::{AxisPlant, Drive};
use hil_sim::plant::parameters;
use hil_sim::plant::random::SplitMix64;
use hil_sim::plant::robot::SUBSTEP_NS;
use robots::{Polycrank, Robot, RobotKind};

/// N·m on every motor, to and fro every half second.
const TORQUE_NM: f64 = 3.0;

/// How long a processor has worked for this program, so that others on the machine do not count, s. As Linux says it.
fn busy() -> Result<f64, Box<dyn std::error::Error>> {
    let text = std::fs::read_to_string("/proc/self/schedstat")?;
    let ns: f64 = text.split(' ').next().unwrap_or_default().parse()?;
    Ok(1e-9 * ns)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let steps: u32 = match std::env::args().nth(1).as_deref() {
        Some("axes") => {
            for axis in &Polycrank.description().axes {
                let motor = axis.motor;
                println!(
                    "{} {} {}",
                    motor.rotor_kg_m2 + motor.gear_kg_m2,
                    motor.viscous_nms_rad,
                    motor.coulomb_nm
                );
            }
            return Ok(());
        }
        Some(steps) => steps.parse()?,
        None => 400_000,
    };
    let mut setup = parameters::robot(RobotKind::Polycrank, 1);
    let dt_s = 1e-9 * f64::from(u32::try_from(SUBSTEP_NS)?);
    let mut plants: Vec<AxisPlant> = setup
        .axes
        .iter()
        .map(|axis| AxisPlant::new(axis.plant, axis.start_rad, dt_s, SplitMix64::new(1)))
        .collect();
    let since = busy()?;
    for step in 0..steps {
        let torque_nm = if step % 4000 < 2000 {
            TORQUE_NM
        } else {
            -TORQUE_NM
        };
        let command = Drive {
            torque_nm,
            release_brake: true,
        };
        setup.mechanics.step(&mut plants, &[command; 7], dt_s);
    }
    let seconds = busy()? - since;
    println!("{:.0} ns a step", 1e9 * seconds / f64::from(steps));
    Ok(())
}
