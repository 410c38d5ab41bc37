//! What cutting costs: ten metres at 20 mm/s, a move a millisecond, for some tools.
//!
//! `cargo run --release -p mrroc-hil-sim --example cutting_cost`

use hil_sim::workpiece::{Board, CELL_M, Cutter, Shank, Tool};
use motion::Pose;
use std::time::Instant;

/// A move, m.
const STEP_M: f64 = 20e-6;
/// Ten metres of them.
const MOVES: u32 = 500_000;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let shank = Shank {
        cutting_length_m: 12e-3,
        diameter_m: 6e-3,
        stick_out_m: 30e-3,
        holder_diameter_m: 40e-3,
    };
    let bit = Cutter::V {
        tip_m: 1e-4,
        angle_rad: core::f64::consts::FRAC_PI_3,
    };
    let flat = Cutter::Flat { diameter_m: 3e-3 };
    let ball = Cutter::Ball { diameter_m: 6e-3 };
    println!(
        "{:<24} {:>8} {:>12} {:>14} {:>12} {:>16}",
        "10 m, 500 s of motion", "time [s]", "cells/move", "cells/s", "removed [ml]", "digest"
    );
    for (name, cutter, depth_m, tilt_rad) in [
        ("V 60°, 1 mm deep", bit, 1e-3, 0.0),
        ("V 60°, 3 mm deep", bit, 3e-3, 0.0),
        ("flat 3 mm, 2 mm deep", flat, 2e-3, 0.0),
        ("ball 6 mm, 2 mm deep", ball, 2e-3, 0.0),
        ("V 60°, 1 mm, tilted 5°", bit, 1e-3, 0.0873),
        ("ball 6 mm, tilted 5°", ball, 2e-3, 0.0873),
    ] {
        let tool = Tool::new(cutter, shank)?;
        let mut board = Board::new([0.3, 0.3], 18e-3, CELL_M)?;
        let mut cells = 0;
        let begin = Instant::now();
        let mut from = pose(0, depth_m, tilt_rad);
        for k in 1..=MOVES {
            let to = pose(k, depth_m, tilt_rad);
            cells += board.cut(&tool, &from, &to)?.cells;
            from = to;
        }
        let time_s = begin.elapsed().as_secs_f64();
        #[expect(clippy::cast_precision_loss, reason = "far below 2^53")]
        let cells = cells as f64;
        println!(
            "{name:<24} {time_s:>8.2} {:>12.0} {:>14.3e} {:>12.2} {:016x}",
            cells / f64::from(MOVES),
            cells / time_s,
            board.removed_m3() * 1e6,
            board.digest()
        );
    }
    Ok(())
}

/// On a spiral, ten metres long and 2.5 mm from turn to turn, in the middle of the board.
fn pose(step: u32, depth_m: f64, tilt_rad: f64) -> Pose {
    // s = b·θ²/2 of a spiral r = b·θ, but for its innermost turn
    let b = 2.5e-3 / core::f64::consts::TAU;
    let turned = libm::sqrt(2.0 * STEP_M * f64::from(step) / b);
    let mut pose = Pose::identity();
    pose.position.x = 0.15 + b * turned * libm::cos(turned);
    pose.position.y = 0.15 + b * turned * libm::sin(turned);
    pose.position.z = -depth_m;
    // half a turn about an axis near x: the tip down, leaning
    let (sin, cos) = libm::sincos(tilt_rad);
    pose.rotation.m22 = -cos;
    pose.rotation.m33 = -cos;
    pose.rotation.m23 = -sin;
    pose.rotation.m32 = sin;
    pose
}
