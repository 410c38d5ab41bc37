use super::*;
use proptest::prelude::*;

/// Half the energy minus the push, plus friction: what the velocities make least.
fn objective(a: &[[f64; 4]; 4], b: &[f64; 4], r: &[Restraint; 4], v: &[f64; 4]) -> f64 {
    let mut sum = 0.0;
    for k in 0..4 {
        sum += v[k] * (0.5 * dot(&a[k], v) - b[k]) + r[k].dry * v[k].abs();
    }
    sum
}

/// `GᵀG` + 0.05: as badly conditioned as a stretched direct-drive arm.
fn matrix(g: &[[f64; 4]; 4]) -> [[f64; 4]; 4] {
    core::array::from_fn(|i| {
        core::array::from_fn(|j| {
            let sum: f64 = (0..4).map(|k| g[k][i] * g[k][j]).sum();
            sum + if i == j { 0.05 } else { 0.0 }
        })
    })
}

const START: [Contact; 4] = [
    Contact::Stuck,
    Contact::Forward,
    Contact::Backward,
    Contact::Stuck,
];

fn restraints(dry: &[f64; 4], room: &[[f64; 2]; 4]) -> [Restraint; 4] {
    core::array::from_fn(|k| Restraint {
        dry: dry[k],
        // a tenth of the axes is at a stop
        low: if room[k][0] < 0.1 { 0.0 } else { -room[k][0] },
        high: if room[k][1] < 0.1 { 0.0 } else { room[k][1] },
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]
    #[test]
    fn nothing_nearby_is_less(
        g in prop::array::uniform4(prop::array::uniform4(-1.0..1.0f64)),
        b in prop::array::uniform4(-2.0..2.0f64),
        dry in prop::array::uniform4(0.0..1.0f64),
        room in prop::array::uniform4(prop::array::uniform2(0.0..1.0f64)),
        by in prop::array::uniform4(-1.0..1.0f64),
    ) {
        let (a, r) = (matrix(&g), restraints(&dry, &room));
        let mut contacts = START;
        let v = System::new(a).velocities(&[0.0; 4], &b, &r, &mut contacts);
        let least = objective(&a, &b, &r, &v);
        for k in 0..4 {
            prop_assert!(r[k].low <= v[k] && v[k] <= r[k].high);
        }
        for size in [1e-4, 1e-2, 1.0] {
            let other = core::array::from_fn(|k| (v[k] + size * by[k]).clamp(r[k].low, r[k].high));
            // sums of some ten products of order 1
            prop_assert!(objective(&a, &b, &r, &other) >= least - 1e-13);
        }
        // once more from what it found: the same; where only descent came to an end, values within 1e-13 of the
        // least leave velocities within √(2·1e-13/0.05) = 2e-6, since 0.05 is the least eigenvalue
        let again = System::new(a).velocities(&[0.0; 4], &b, &r, &mut contacts);
        for k in 0..4 {
            prop_assert!((again[k] - v[k]).abs() < 4e-6);
        }
    }

    #[test]
    fn friction_and_stops_take_energy_only(
        g in prop::array::uniform4(prop::array::uniform4(-1.0..1.0f64)),
        v0 in prop::array::uniform4(-2.0..2.0f64),
        dry in prop::array::uniform4(0.0..1.0f64),
        room in prop::array::uniform4(prop::array::uniform2(0.0..1.0f64)),
    ) {
        let (a, r) = (matrix(&g), restraints(&dry, &room));
        let v = System::new(a).velocities(&v0, &[0.0; 4], &r, &mut START.clone());
        let energy = |v: &[f64; 4]| (0..4).map(|k| 0.5 * v[k] * dot(&a[k], v)).sum::<f64>();
        // energies of order 10
        prop_assert!(energy(&v) <= energy(&v0) + 1e-13);
    }

    /// The fallback alone finds the same, where the axes are not coupled too strongly.
    #[test]
    fn descent_finds_the_same(
        g in prop::array::uniform4(prop::array::uniform4(-0.2..0.2f64)),
        b in prop::array::uniform4(-2.0..2.0f64),
        dry in prop::array::uniform4(0.0..1.0f64),
        room in prop::array::uniform4(prop::array::uniform2(0.0..1.0f64)),
    ) {
        let r = restraints(&dry, &room);
        let mut a = matrix(&g);
        for (k, row) in a.iter_mut().enumerate() {
            row[k] += 0.5;
        }
        let found = System::new(a).velocities(&[0.0; 4], &b, &r, &mut START.clone());
        let mut v = [0.0; 4];
        descend(&a, &[0.0; 4], &b, &r, &mut v);
        for k in 0..4 {
            // a contraction by 0.4 at worst: 50 sweeps leave 1e-20
            prop_assert!((found[k] - v[k]).abs() < 1e-12);
        }
    }
}

/// A held axis passes nothing on; the others see their reduced system.
#[test]
fn a_stuck_axis_leaves_the_reduced_system_of_the_others() {
    let a = [[2.0, 1.0], [1.0, 3.0]];
    let held = Restraint {
        dry: 100.0,
        low: -9.0,
        high: 9.0,
    };
    let loose = Restraint { dry: 0.0, ..held };
    let mut contacts = [Contact::Stuck; 2];
    let mut system = System::new(a);
    let v = system.velocities(&[0.0; 2], &[0.5, 6.0], &[held, loose], &mut contacts);
    assert_eq!(v.map(f64::to_bits), [0.0, 2.0].map(f64::to_bits));
    assert_eq!(contacts, [Contact::Stuck, Contact::Forward]);
    // overloaded it slips: 2·v0 + v1 = 103 − 100, v0 + 3·v1 = 6
    let v = system.velocities(&[0.0; 2], &[103.0, 6.0], &[held, loose], &mut contacts);
    assert!(
        (v[0] - 0.6).abs() < 1e-12 && (v[1] - 1.8).abs() < 1e-12,
        "{v:?}"
    );
}
