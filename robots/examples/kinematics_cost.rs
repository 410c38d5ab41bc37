//! What kinematics cost on this machine: median ns a call, over 1000 configurations inside the joint limits.

use std::hint::black_box;
use std::time::Instant;

use robots::{Irp6Postument, Joints, Motors, Rnt, Robot};

const CONFIGURATIONS: u32 = 1000;
const RUNS: usize = 51;

/// Median over the runs, ns a call.
fn median<T, U>(inputs: &[T], call: impl Fn(&T) -> U) -> f64 {
    let mut runs: Vec<f64> = (0..RUNS)
        .map(|_| {
            let start = Instant::now();
            for input in inputs {
                black_box(call(black_box(input)));
            }
            start.elapsed().as_secs_f64() * 1e9 / f64::from(CONFIGURATIONS)
        })
        .collect();
    runs.sort_unstable_by(f64::total_cmp);
    runs.get(RUNS / 2).copied().unwrap_or(f64::NAN)
}

/// Configurations spread evenly: multiples of the golden ratio and its powers, modulo 1.
fn configurations(robot: &impl Robot<6>) -> Vec<(Joints<6>, Motors<6>)> {
    let spread = [
        0.754_878, 0.569_840, 0.430_160, 0.324_718, 0.245_122, 0.185_037,
    ];
    (1..)
        .map(|i| {
            let mut joints = [0.0; 6];
            for ((q, axis), step) in joints.iter_mut().zip(&robot.description().axes).zip(spread) {
                let unit = f64::from(i) * step;
                let range = axis.joint_position;
                *q = range.lower + (unit - libm::floor(unit)) * (range.upper - range.lower);
            }
            Joints(joints)
        })
        .filter_map(|joints| Some((joints, robot.motors(&joints).ok()?)))
        .take(CONFIGURATIONS as usize)
        .collect()
}

fn report(robot: &impl Robot<6>) {
    let name = robot.description().name;
    let inputs = configurations(robot);
    let poses: Vec<_> = inputs
        .iter()
        .map(|(joints, _)| (robot.forward(joints), *joints))
        .collect();
    let line = |what: &str, ns: f64| println!("{name} {what} {ns:.0}");
    line("forward", median(&inputs, |(q, _)| robot.forward(q)));
    line("jacobian", median(&inputs, |(q, _)| robot.jacobian(q)));
    line(
        "inverse",
        median(&poses, |(pose, q)| robot.inverse(pose, q)),
    );
    line(
        "inverse_near",
        median(&poses, |(pose, q)| robot.inverse_near(pose, q)),
    );
    line(
        "joints_to_motors",
        median(&inputs, |(q, _)| robot.motors(q)),
    );
    line(
        "motors_to_joints",
        median(&inputs, |(_, m)| robot.joints(m)),
    );
}

fn main() {
    report(&Irp6Postument);
    report(&Rnt);
}
