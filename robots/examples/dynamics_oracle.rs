//! The chains for other programs: `oracles/pinocchio` asks.
//!
//! `dynamics_oracle urdf CHAIN` prints a URDF file. `dynamics_oracle answers CHAIN COUNT SEED` prints a
//! line for each random state, numbers that parse back to the bit: q, q̇, q̈, wrench at the flange
//! (force, moment), τ; then ours: flange (position, rotation by columns), torques of (q, q̇, q̈), mass
//! matrix, accelerations of (q, q̇, τ). Chains: `irp6-track`, `irp6-postument`, `irp6-arm`, `polycrank`,
//! `rnt`.

use nalgebra::Vector3;
use robots::description::Range;
use robots::dynamics::{
    Chain, IRP6_ARM, IRP6_POSTUMENT, IRP6_TRACK, POLYCRANK, STANDARD_GRAVITY, Wrench,
};
use robots::urdf::{JointLimits, joint_limits, write_urdf};
use robots::{Irp6Arm, Irp6Postument, Irp6Track, Joints, Rnt, Robot};
use std::fmt::Write as _;
use std::io::{BufWriter, Write};

/// Limits of a joint that turns without end.
const OPEN: JointLimits = JointLimits {
    position: Range {
        lower: -100.0,
        upper: 100.0,
    },
    velocity: 10.0,
    effort: 1000.0,
};

/// Numbers in [−1, 1): a multiplicative congruential generator, so that runs are alike.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        let high = u32::try_from(self.0 >> 32).unwrap_or(0);
        f64::from(high) / f64::from(1_u32 << 31) - 1.0
    }
    fn numbers<const N: usize>(&mut self, scale: f64) -> [f64; N] {
        [0.0; N].map(|_: f64| scale * self.next())
    }
}

fn answers<const N: usize>(
    chain: &Chain<N>,
    count: u32,
    seed: u64,
) -> Result<(), Box<dyn std::error::Error>> {
    let mut random = Random(seed);
    let mut out = BufWriter::new(std::io::stdout().lock());
    let gravity: Vector3<f64> = STANDARD_GRAVITY;
    for _ in 0..count {
        let (q, dq, ddq) = (
            random.numbers::<N>(3.1),
            random.numbers(3.0),
            random.numbers(10.0),
        );
        let (force, moment): ([f64; 3], [f64; 3]) = (random.numbers(50.0), random.numbers(10.0));
        let tau: [f64; N] = random.numbers(50.0);
        let wrench = Wrench {
            force: force.into(),
            moment: moment.into(),
        };
        let posture = chain.at(&Joints(q));
        let flange = posture.flange();
        let torques = posture.inverse_dynamics(&dq, &ddq, &gravity, &wrench);
        let matrix = posture.mass_matrix();
        let accelerations = posture.forward_dynamics(&dq, &tau, &gravity, &wrench);
        let mut line = String::new();
        let inputs = [&q[..], &dq, &ddq, &force, &moment, &tau];
        let ours = [
            flange.position.as_slice(),
            flange.rotation.as_slice(),
            &torques,
            matrix.as_slice(),
            &accelerations,
        ];
        for number in inputs.into_iter().chain(ours).flatten() {
            write!(line, "{number:e} ")?;
        }
        writeln!(out, "{}", line.trim_end())?;
    }
    out.flush()?;
    Ok(())
}

fn answer<const N: usize>(
    arguments: &[&str],
    chain: &Chain<N>,
    limits: &[JointLimits; N],
) -> Result<(), Box<dyn std::error::Error>> {
    match arguments {
        ["urdf", name] => {
            let mut text = String::new();
            write_urdf(&mut text, name, "", limits, chain)?;
            print!("{text}");
            Ok(())
        }
        ["answers", _, count, seed] => answers(chain, count.parse()?, seed.parse()?),
        _ => Err("expected urdf CHAIN, or answers CHAIN COUNT SEED".into()),
    }
}

fn of_robot<const N: usize>(robot: &impl Robot<N>) -> [JointLimits; N] {
    joint_limits(robot.description(), &robot.motor_slopes())
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match arguments.get(1).copied() {
        Some("irp6-track") => answer(&arguments, &IRP6_TRACK, &of_robot(&Irp6Track::KEEP)),
        Some("irp6-postument") => answer(&arguments, &IRP6_POSTUMENT, &of_robot(&Irp6Postument)),
        Some("irp6-arm") => answer(&arguments, &IRP6_ARM, &of_robot(&Irp6Arm)),
        // without end, so that a joint would be a pair of numbers there: some range
        Some("polycrank") => answer(&arguments, &POLYCRANK, &[OPEN; 7]),
        Some("rnt") => {
            let chain = Rnt.chain().ok_or("the RNT has a chain")?;
            answer(&arguments, &chain, &of_robot(&Rnt))
        }
        _ => Err("no such chain".into()),
    }
}
