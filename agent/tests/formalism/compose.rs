//! Composition: (16), (17), (18), inhibition and suppression.

use agent::args::{F, V};
use agent::{
    Behaviour, Command, Compete, Compose, Composition, First, Greatest, Inhibit, Reaction, Step,
    Sum, Superpose, Suppress, Vector, Wire, condition, function,
};
use proptest::array::uniform4;
use proptest::prelude::*;

use crate::cell::{Arm, Script, arm, run};

const UP: Wire = Wire { by: 0, of: 1 };
const DOWN: Wire = Wire { by: 1, of: 0 };

#[test]
fn inhibition_eliminates_while_the_inhibitor_demands() {
    let k = Inhibit {
        wires: &[UP],
        then: Sum([1.0, 10.0, 100.0]),
    };
    assert_eq!(k.compose([Some(1.0), Some(2.0), Some(3.0)]), Some(301.0));
    assert_eq!(k.compose([None, Some(2.0), Some(3.0)]), Some(320.0));
    assert_eq!(k.compose([Some(1.0), None, None]), Some(1.0));
}

#[test]
fn suppression_substitutes_while_the_suppressor_demands() {
    let k = Suppress {
        wires: &[UP],
        then: Sum([1.0, 10.0, 100.0]),
    };
    assert_eq!(k.compose([Some(1.0), Some(2.0), Some(3.0)]), Some(311.0));
    assert_eq!(k.compose([None, Some(2.0), Some(3.0)]), Some(320.0));
    assert_eq!(k.compose([Some(1.0), None, None]), Some(11.0));
}

#[test]
fn wires_act_at_once_on_the_results_as_computed() {
    let both = [UP, DOWN];
    let inhibit = Inhibit {
        wires: &both,
        then: First,
    };
    assert_eq!(inhibit.compose([Some(1.0), Some(2.0)]), None);
    assert_eq!(inhibit.compose([Some(1.0), None]), Some(1.0));
    let swap = Suppress {
        wires: &both,
        then: Sum([1.0, 10.0]),
    };
    assert_eq!(swap.compose([Some(1.0), Some(2.0)]), Some(12.0));
}

#[test]
fn wires_to_nowhere_do_nothing() {
    let wires = [Wire { by: 9, of: 0 }, Wire { by: 0, of: 9 }];
    assert_eq!(
        Inhibit {
            wires: &wires,
            then: First
        }
        .compose([Some(1.0)]),
        Some(1.0)
    );
    assert_eq!(
        Suppress {
            wires: &wires,
            then: First
        }
        .compose([Some(1.0)]),
        Some(1.0)
    );
}

#[test]
fn a_layered_controller_is_subsumption() {
    // Layer 0 avoids, layer 1 seeks, layer 2 wanders; the higher the layer, the earlier its place.
    let near = condition::<Arm, F<(), (), V>, _>(|x| *x.v() > 0.8);
    let seen = condition::<Arm, F<(), (), V>, _>(|x| *x.v() > 0.4);
    let mut b = Compete::new(
        (
            Reaction::new(near, function::<Arm, F<(), (), ()>, _>(|_| -1.0)),
            Reaction::new(seen, function::<Arm, F<(), (), V>, _>(|x| *x.v())),
            function::<Arm, F<(), (), ()>, _>(|_| 0.25),
        ),
        First,
    );
    let steps = run(&mut b, &[0.0, 0.5, 0.9]);
    assert_eq!(steps, [0.25, 0.5, -1.0].map(Step::Demand));
}

#[test]
fn who_has_ended_takes_no_further_part() {
    let short = Script::new(&[Step::Demand(1.0)]);
    let long = Script::new(&[Step::Demand(10.0), Step::Hold, Step::Demand(20.0)]);
    let mut b = Superpose::weighted((short, long), [1.0, 1.0]);
    let steps = run(&mut b, &[0.0; 9]);
    assert_eq!(
        steps,
        [
            Step::Demand(11.0),
            Step::Hold,
            Step::Demand(20.0),
            Step::Done
        ]
    );
}

#[test]
fn greatest_ignores_what_is_no_number() {
    let k = Greatest(|y: &f64| *y);
    let chosen = k.compose([Some(f64::NAN), Some(2.0), None, Some(f64::NAN)]);
    assert_eq!(chosen, Some(2.0));
    assert_eq!(k.compose([None::<f64>; 3]), None);
    let tie = Greatest(|_: &f64| 0.0);
    assert_eq!(tie.compose([None, Some(3.0), Some(4.0)]), Some(3.0));
}

#[test]
fn a_whole_command_superposes_part_by_part() {
    type Y = Command<[f64; 2], f64>;
    let y = |a, b, v| Y {
        e: [a, b],
        v,
        t: (),
    };
    let sum = Sum([2.0, -1.0]).compose([Some(y(1.0, 2.0, 3.0)), Some(y(10.0, 20.0, 30.0))]);
    assert_eq!(sum, Some(y(-8.0, -16.0, -24.0)));
}

/// Integers small enough that sums and products of doubles are exact.
fn exact() -> impl Strategy<Value = f64> {
    (-1000..1000_i32).prop_map(f64::from)
}

fn exact4() -> impl Strategy<Value = [f64; 4]> {
    uniform4(exact())
}

proptest! {
    /// (17) is linear: in the demands, and in the weights.
    #[test]
    fn superposition_is_linear(w in exact4(), y in exact4(), z in exact4(), k in exact()) {
        let sum = |y: [f64; 4]| Sum(w).compose(y.map(Some)).unwrap();
        let mixed = y.scaled(k).plus(z);
        prop_assert_eq!(sum(mixed).to_bits(), (k * sum(y) + sum(z)).to_bits());
    }

    #[test]
    fn the_order_of_superposition_does_not_matter(w in exact4(), y in exact4()) {
        let turned = |a: [f64; 4]| [a[1], a[2], a[3], a[0]];
        prop_assert_eq!(
            Sum(w).compose(y.map(Some)).map(|s| s + 0.0),
            Sum(turned(w)).compose(turned(y).map(Some)).map(|s| s + 0.0)
        );
    }

    /// (16): the maximum of what was demanded, and one of the demands.
    #[test]
    fn the_greatest_wins(y in uniform4(proptest::option::of(-1e9..1e9_f64))) {
        let greatest = Greatest(|y: &f64| *y).compose(y);
        prop_assert_eq!(greatest, y.into_iter().flatten().reduce(|a, b| if b > a { b } else { a }));
    }

    /// (18) of functions is the composition of their values.
    #[test]
    fn the_loop_composes_the_partial_results(v in -1e3..1e3_f64) {
        let f = |k: f64| function::<Arm, F<(), (), V>, _>(move |x| k * x.v());
        let mut b = Compose::new([f(1.0), f(-2.0), f(0.5)], Greatest(|y: &f64| *y));
        let expected = if v > 0.0 { v } else { -2.0 * v };
        prop_assert_eq!(b.step(&arm(0, v)), Step::Demand(expected));
    }
}
