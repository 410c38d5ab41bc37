//! Chance: (21), (22), adapting thresholds, and the loop that draws.

use std::num::NonZeroU8;

use agent::args::{F, V};
use agent::{
    Adaptation, Always, Behaviour, Choices, Never, Pure, Reaction, Response, SelectByChance,
    SplitMix64, Step, Uniform, Urge, stimulus,
};
use proptest::collection::vec;
use proptest::prelude::*;

use crate::cell::{Arm, Script, arm};

/// Deviates from a list, then 0.
struct Given(Vec<f64>);
impl Uniform for Given {
    fn draw(&mut self) -> f64 {
        if self.0.is_empty() {
            0.0
        } else {
            self.0.remove(0)
        }
    }
}

type Force = Pure<F<(), (), V>, fn(agent::X<'_, Arm, F<(), (), V>>) -> f64>;
fn force() -> Force {
    stimulus::<Arm, F<(), (), V>, _>(|x| *x.v())
}

fn once(y: f64) -> Script {
    Script::new(&[Step::Demand(y)])
}

#[test]
fn the_papers_points() {
    let rising = Response::threshold(2.0);
    assert_eq!(rising.probability(2.0).to_bits(), 0.5_f64.to_bits());
    // 4²/(4² + 2²) = 16/20; 1²/(1² + 2²) = 1/5: exact but for one rounding
    assert!((rising.probability(4.0) - 0.8).abs() <= f64::EPSILON);
    assert!((rising.probability(1.0) - 0.2).abs() <= f64::EPSILON);
    let window = Response::window(40.0, 0.5);
    assert_eq!(window.probability(40.0).to_bits(), 1.0_f64.to_bits());
    // at θ ± 1/ψ: 1/e; the square makes both sides fall
    let inverse_e = 1.0 / std::f64::consts::E;
    for zeta in [38.0, 42.0] {
        assert!((window.probability(zeta) - inverse_e).abs() <= 4.0 * f64::EPSILON);
    }
}

#[test]
fn no_stimulus_no_action_and_no_nan() {
    for response in [Response::threshold(1.0), Response::window(1.0, 1.0)] {
        assert!(response.probability(f64::NAN) <= 0.0);
    }
    assert!(Response::threshold(1.0).probability(-3.0) <= 0.0);
    assert!(Response::threshold(0.0).probability(0.0) <= 0.0);
    assert!(Response::threshold(0.0).probability(1e-300) >= 1.0);
    assert!(Response::threshold(1e300).probability(f64::INFINITY) >= 1.0);
}

proptest! {
    /// (21) rises from 0 to 1, and rises more steeply the greater n.
    #[test]
    fn a_threshold_is_monotone_and_bounded(
        theta in 1e-3..1e3_f64,
        n in 1..=u8::MAX,
        a in 0.0..1e4_f64,
        b in 0.0..1e4_f64,
    ) {
        let response = Response::Threshold { theta, n: NonZeroU8::new(n).unwrap() };
        let (low, high) = if a <= b { (a, b) } else { (b, a) };
        let (p, q) = (response.probability(low), response.probability(high));
        prop_assert!(0.0 <= p && p <= q && q <= 1.0);
        prop_assert_eq!(low > theta && p < 0.5, false);
        prop_assert_eq!(high < theta && q > 0.5, false);
    }

    /// (22) is symmetric about θ, greatest there, and falls on both sides.
    #[test]
    fn a_window_is_symmetric_and_falls(
        theta in -100..100_i32,
        psi in 0.01..10.0_f64,
        near in 0..1000_u32,
        far in 0..1000_u32,
    ) {
        // Sixteenths, so that θ ± d is exact.
        let (theta, d) = (f64::from(theta), |n: u32| f64::from(n) / 16.0);
        let p = |zeta| Response::window(theta, psi).probability(zeta);
        prop_assert_eq!(p(theta - d(near)).to_bits(), p(theta + d(near)).to_bits());
        if near <= far {
            // exp is correct to 4 ulp, so monotone to that
            prop_assert!(p(theta + d(far)) <= p(theta + d(near)) * (1.0 + 8.0 * f64::EPSILON));
        }
        prop_assert!((0.0..=1.0).contains(&p(theta + d(far))));
    }

    /// A threshold stays within its bounds, whatever is chosen.
    #[test]
    fn adaptation_is_bounded(
        decisions in vec(any::<bool>(), 0..100),
        step in -1.0..1.0_f64,
        recover in -1.0..1.0_f64,
    ) {
        for rule in [
            Adaptation::reinforcement(step, recover, 0.5, 2.0),
            Adaptation::habituation(step, recover, 0.5, 2.0),
        ] {
            let mut theta = 1.0;
            for &chosen in &decisions {
                let before = theta;
                theta = rule.next(theta, chosen);
                prop_assert!((0.5..=2.0).contains(&theta));
                // What was chosen moves by `chosen`, what was not by `passed`: never the other way.
                let way = if chosen { rule.chosen } else { rule.passed };
                let moved = theta - before;
                prop_assert!(moved * way >= 0.0, "{before} to {theta}");
            }
        }
    }

    /// Same seed, same inputs: same run.
    #[test]
    fn a_seeded_run_is_repeatable(seed in any::<u64>(), forces in vec(0.0..4.0_f64, 0..50)) {
        let play = || {
            let urge = |theta, y| {
                Urge::new(Always, force(), Response::threshold(theta), once(y))
                    .adapting(Adaptation::habituation(0.5, 0.1, 0.1, 8.0))
            };
            let mut b = SelectByChance::new([urge(1.0, 1.0), urge(2.0, 2.0)], SplitMix64::new(seed));
            (0..).zip(&forces).map(|(i, &v)| b.step(&arm(i, v))).collect::<Vec<_>>()
        };
        prop_assert_eq!(play(), play());
    }
}

#[test]
fn the_first_whose_deviate_is_below_its_probability_is_run_to_its_end() {
    let first = Urge::new(Always, force(), Response::threshold(1.0), once(1.0));
    let two = Script::new(&[Step::Demand(2.0), Step::Demand(2.5)]);
    let second = Urge::new(Always, force(), Response::window(1.0, 1.0), two);
    // At ζ = θ the probabilities are 1/2 and 1.
    let given = Given(vec![
        0.6, 0.9, /* two steps of the second */ 0.4, 0.6, 0.0,
    ]);
    let mut b = SelectByChance::new((first, second), given);
    let steps: Vec<_> = (0..5).map(|i| b.step(&arm(i, 1.0))).collect();
    assert_eq!(steps, [2.0, 2.5, 1.0, 2.0, 2.5].map(Step::Demand));
}

#[test]
fn the_impossible_spends_no_deviate() {
    let never = Urge::new(Never, force(), Response::window(0.0, 0.0), once(9.0));
    let silent = Urge::new(Always, force(), Response::threshold(1.0), once(8.0));
    let certain = Reaction::new(Always, once(1.0));
    let even = Urge::new(
        Always,
        stimulus::<Arm, F<(), (), ()>, _>(|_| 1.0),
        Response::threshold(1.0),
        once(2.0),
    );
    let mut b = SelectByChance::new((never, silent, even, certain), Given(vec![0.4, 0.6, 0.6]));
    assert_eq!(b.step(&arm(0, 0.0)), Step::Demand(2.0));
    assert_eq!(b.current(), Some(2));
}

#[test]
fn if_chance_is_against_all_the_step_holds() {
    let urge = Urge::new(Always, force(), Response::threshold(1.0), once(1.0));
    let mut b = SelectByChance::new((urge,), Given(vec![0.5, 0.49]));
    assert_eq!(b.step(&arm(0, 1.0)), Step::Hold);
    assert_eq!(b.step(&arm(1, 1.0)), Step::Demand(1.0));
}

#[test]
fn the_addict_and_the_tired() {
    let run = |rule| {
        let urge = Urge::new(Always, force(), Response::threshold(1.0), once(1.0)).adapting(rule);
        let mut b = SelectByChance::new([urge], Given(vec![]));
        for i in 0..4 {
            assert_eq!(b.step(&arm(i, 1.0)), Step::Demand(1.0));
        }
        b.begin();
        let p = Choices::<Arm>::probability(b.choices(), 0, &arm(0, 1.0));
        (b.choices()[0].response().theta(), p)
    };
    let (theta, p) = run(Adaptation::reinforcement(0.125, 0.1, 0.25, 4.0));
    assert!((theta - 0.5).abs() <= 0.0 && p > 0.79 && p < 0.81);
    let (theta, p) = run(Adaptation::habituation(0.25, 0.1, 0.25, 4.0));
    assert!((theta - 2.0).abs() <= 0.0 && p > 0.19 && p < 0.21);
}

/// The frequency of a choice is its probability: 10 000 decisions at P = 0.2, five σ = 0.02.
#[test]
fn frequencies_are_the_probabilities() {
    let urge = Urge::new(Always, force(), Response::threshold(2.0), once(1.0));
    let mut b = SelectByChance::new((urge,), SplitMix64::new(20));
    let chosen = (0..10_000)
        .filter(|&i| b.step(&arm(i, 1.0)) != Step::Hold)
        .count();
    assert!((1800..=2200).contains(&chosen), "{chosen}");
}
