//! The motion planner beside other planners: the same questions, the same judge, the same clock.
//!
//! | module | one line |
//! |---|---|
//! | [`case`](mod@case) | a question: start, end and limits of each axis |
//! | [`random`] | random numbers that are the same everywhere |
//! | [`class`] | the classes of questions |
//! | [`plan`] | the answer: phases; and what a planner is asked to do |
//! | [`planner`] | who is compared |
//! | [`ours`] | the planner of `motion` |
//! | [`ruckig`] | the C++ original of Ruckig |
//! | [`apart`] | the same in a process of its own |
//! | [`rsruckig`] | its port to Rust |
//! | [`judge`](mod@judge) | what an answer does wrong |
//! | [`tally`] | what is counted |
//! | [`correctness`] | very many cases, every plan judged |
//! | [`clock`] | how time is taken |
//! | [`timing`] | what a plan and a sample cost |
//! | [`count`] | instructions |
//! | [`goal`] | what is wanted, beside what was got |
//! | [`report`] | what is printed |
//!
//! A package of its own: its dependencies are fetched on demand and are no part of the product.

pub mod apart;
pub mod case;
pub mod class;
pub mod clock;
pub mod correctness;
pub mod count;
pub mod goal;
pub mod judge;
pub mod ours;
pub mod plan;
pub mod planner;
pub mod random;
pub mod report;
pub mod rsruckig;
pub mod ruckig;
pub mod tally;
pub mod timing;

/// Evaluates an expression for a number of axes known at run time.
#[macro_export]
macro_rules! with_axes {
    ($axes:expr, $n:ident => $body:expr) => {
        match $axes {
            1 => {
                const $n: usize = 1;
                $body
            }
            2 => {
                const $n: usize = 2;
                $body
            }
            3 => {
                const $n: usize = 3;
                $body
            }
            6 => {
                const $n: usize = 6;
                $body
            }
            7 => {
                const $n: usize = 7;
                $body
            }
            other => panic!("no instance for {other} axes"),
        }
    };
}
