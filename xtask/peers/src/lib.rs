//! The motion planner beside other planners: the same questions, the same judge, the same clock.
//!
//! | module | one line |
//! |---|---|
//! | [`case`](mod@case) | a question: start, end and limits of each axis |
//! | [`random`] | random numbers that are the same everywhere |
//! | [`class`] | the classes of questions |
//! | [`plan`] | the answer: phases; and what a planner is asked to do |
//! | [`ruckig`] | the C++ original of Ruckig |
//!
//! A package of its own: its dependencies are fetched on demand and are no part of the product.

pub mod case;
pub mod class;
pub mod plan;
pub mod random;
pub mod ruckig;

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
