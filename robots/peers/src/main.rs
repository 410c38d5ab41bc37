//! Forward and inverse kinematics of the IRp-6 beside rs-opw-kinematics with an arm of the same class: six axes,
//! closed form, the IRp-6's lengths, all branches.
//!
//! The mechanisms are not the same: theirs has a spherical wrist and up to eight branches; the IRp-6's wrist has its
//! first axis parallel to shoulder and elbow, and up to sixteen, since V turns more than once. Each side therefore
//! solves poses of its own arm, of joints spread evenly, and is checked by its own forward kinematics first.
//!
//! `kinematics` prints ns a call, medians of 51 runs over 1000 poses, both sides in turns.
//! `kinematics SIDE QUESTION COUNT` does COUNT calls, for a profiler: ours or theirs; forward or inverse.

use std::hint::black_box;
use std::time::Instant;

use robots::{Irp6Postument, Joints, Robot};
use rs_opw_kinematics::kinematic_traits::Kinematics;
use rs_opw_kinematics::kinematics_impl::OPWKinematics;
use rs_opw_kinematics::parameters::opw_kinematics::Parameters;

const POSES: usize = 1000;
const RUNS: usize = 51;

/// The IRp-6's lower arm, upper arm and wrist, m, as an ortho-parallel arm.
fn theirs() -> OPWKinematics {
    OPWKinematics::new(Parameters {
        a1: 0.0,
        a2: 0.0,
        b: 0.0,
        c1: 0.0,
        c2: 0.455,
        c3: 0.67,
        c4: 0.19,
        offsets: [0.0; 6],
        sign_corrections: [1; 6],
        dof: 6,
    })
}

/// Joints spread evenly: multiples of the powers of a root of x⁷ = x + 1, modulo 1, between `from` and `to`.
fn joints(ranges: &[(f64, f64); 6]) -> Vec<[f64; 6]> {
    let steps = [
        0.898_654, 0.807_579, 0.725_734, 0.652_184, 0.586_088, 0.526_690,
    ];
    let mut all = Vec::with_capacity(POSES);
    let mut number = 0.0;
    while all.len() < POSES {
        number += 1.0;
        let mut joints = [0.0; 6];
        for ((q, step), (from, to)) in joints.iter_mut().zip(steps).zip(ranges) {
            let unit = number * step;
            *q = from + (unit - libm::floor(unit)) * (to - from);
        }
        all.push(joints);
    }
    all
}

/// Calls over and over, each time with the next input.
fn calls<T, U>(inputs: &[T], count: usize, call: impl Fn(&T) -> U) {
    for input in inputs.iter().cycle().take(count) {
        black_box(call(black_box(input)));
    }
}

fn ns<T, U>(inputs: &[T], call: impl Fn(&T) -> U) -> f64 {
    let start = Instant::now();
    calls(inputs, POSES, call);
    start.elapsed().as_secs_f64() * 1e6
}

fn median(mut runs: Vec<f64>) -> f64 {
    runs.sort_unstable_by(f64::total_cmp);
    runs.get(runs.len() / 2).copied().unwrap_or(f64::NAN)
}

fn main() {
    let arm = Irp6Postument;
    let axes = &arm.description().axes;
    let ours = joints(&axes.each_ref().map(|axis| {
        let range = axis.joint_position;
        (range.lower, range.upper)
    }));
    let ours: Vec<_> = ours
        .into_iter()
        .map(|q| (Joints(q), arm.forward(&Joints(q))))
        .collect();
    let peer = theirs();
    // the elbow bent, wherever the rest is
    let theirs = joints(&[
        (-3.0, 3.0),
        (-1.5, 1.5),
        (-1.0, 2.0),
        (-3.0, 3.0),
        (0.1, 2.0),
        (-3.0, 3.0),
    ]);
    let theirs: Vec<_> = theirs.into_iter().map(|q| (q, peer.forward(&q))).collect();

    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match arguments[..] {
        [] => {}
        [side, question, count] => {
            let count = count.parse().expect("COUNT is a number");
            match (side, question) {
                ("ours", "forward") => calls(&ours, count, |(q, _)| arm.forward(q)),
                ("ours", "inverse") => calls(&ours, count, |(q, pose)| arm.inverse(pose, q)),
                ("theirs", "forward") => calls(&theirs, count, |(q, _)| peer.forward(q)),
                ("theirs", "inverse") => calls(&theirs, count, |(_, pose)| peer.inverse(pose)),
                _ => panic!("expected ours or theirs, forward or inverse"),
            }
            return;
        }
        _ => panic!("expected nothing, or SIDE QUESTION COUNT"),
    }

    let (mut branches, mut peers) = (0, 0);
    for (q, pose) in &ours {
        let found = arm.inverse(pose, q).expect("a pose of the arm");
        branches += found.branches().len();
        for q in found.branches() {
            assert!((arm.forward(q).position - pose.position).norm() < 1e-9);
        }
    }
    for (q, pose) in &theirs {
        let found = peer.inverse(pose);
        assert!(!found.is_empty(), "no solution of {q:?}");
        peers += found.len();
        for q in &found {
            assert!((peer.forward(q).translation - pose.translation).length() < 1e-6);
        }
    }
    println!("branches of {POSES} poses: ours {branches}, theirs {peers}");

    let [mut a, mut b, mut c, mut d] = [const { Vec::new() }; 4];
    for _ in 0..RUNS {
        a.push(ns(&ours, |(q, _)| arm.forward(q)));
        b.push(ns(&theirs, |(q, _)| peer.forward(q)));
        c.push(ns(&ours, |(q, pose)| arm.inverse(pose, q)));
        d.push(ns(&theirs, |(_, pose)| peer.inverse(pose)));
    }
    for (question, ours, theirs) in [("forward", a, b), ("inverse", c, d)] {
        let (ours, theirs) = (median(ours), median(theirs));
        println!(
            "{question} {ours:.0} ns, theirs {theirs:.0} ns, ratio {:.2}",
            ours / theirs
        );
    }
}
