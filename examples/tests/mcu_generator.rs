//! The generator that is linked into images, on the host: what the joints do is the function, whatever node runs it.

use board::boot::Linked as _;
use host::mp::behaviour::{sequence, start_programs};
use host::mp::condition::AllDone;
use mcu_generator::{DURATION_S, Linked, figure};
use mrroc_examples::{Arm, World, apart};

/// A servo step of the IRp-6, s.
const SERVO_S: f64 = 0.002;

#[test]
fn the_joints_draw_the_figure_of_the_generator() {
    let mut world = World::new(vec![Arm::postument(Linked::programs::<6>()).unwrap()]).unwrap();
    world.get_ready().unwrap();
    let program = start_programs(&[0], 1, 0.0);
    let done = Box::new(agent::Wait::new(AllDone { robots: vec![0] }));
    let mut joints: Vec<Vec<f64>> = vec![vec![]; 6];
    world
        .watch(sequence(vec![program, done]), |world| {
            for (joint, q) in joints.iter_mut().zip(world.joints(0).unwrap()) {
                joint.push(q);
            }
        })
        .unwrap();
    assert_eq!(world.faults(), 0);
    for (axis, joint) in joints.iter().enumerate() {
        let start = joint[0];
        let moved: Vec<f64> = joint.iter().map(|q| q - start).collect();
        let sizes = moved.iter().map(|q| q.abs());
        let largest = sizes.max_by(f64::total_cmp).unwrap();
        let Some(k) = [(4, 2.0), (5, 3.0)].iter().find(|(a, _)| *a == axis) else {
            // what does not move gives in its gears and brakes by some hundredths of a millirad
            assert!(largest < 1e-3, "joint {axis} moved by {largest}");
            continue;
        };
        // a quarter of a second of rest, then the function of time
        let wanted: Vec<f64> = (0..moved.len())
            .map(|n| figure(k.1, f64::from(u32::try_from(n).unwrap()) * SERVO_S - 0.25)[0])
            .collect();
        assert!(moved.len() > 4000, "the figure takes {DURATION_S} s");
        assert!(largest > 0.03, "joint {axis}: {largest}");
        // the lag of a drive and its gear: as in example 2, where the same curve differs by 0.2 mrad from itself
        let off = apart(&moved, &wanted);
        assert!(off < 2e-3, "joint {axis}: {off}");
    }
}
