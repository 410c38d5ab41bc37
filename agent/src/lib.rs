//! The formalism.
#![no_std]
#![forbid(unsafe_code)]
#![deny(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::unreachable,
    clippy::unimplemented,
    clippy::indexing_slicing,
    clippy::arithmetic_side_effects
)]

pub mod args;
mod behaviour;
mod bundle;
mod chance;
pub mod class;
mod compose;
mod condition;
mod error;
mod exp;
mod generator;
mod instruction;
mod process;
mod random;
mod record;
mod response;
mod select;
mod sensor;
mod subsystem;

pub use behaviour::{Behaviour, ForSteps, Repeat, Rest, Sequence, Then, function};
pub use bundle::{Bundle, Fixed, List};
pub use chance::{SelectByChance, Stimulus, Urge, stimulus};
pub use class::{Class, Inhabitant, Kind, missing};
pub use compose::{
    Compete, Compose, Composition, First, Greatest, Inhibit, Sum, Superpose, Suppress, Vector, Wire,
};
pub use condition::{Always, And, Condition, Never, Not, Or, Pure, Widen, condition, widen};
pub use error::{Check, ErrorCondition, NoError};
pub use generator::{Constant, Generator, Triple, generator};
pub use instruction::{Move, Step, Wait};
pub use process::{Outcome, Process};
pub use random::{SplitMix64, Uniform};
pub use record::{Recorder, TotalState};
pub use response::{Adaptation, Response};
pub use select::{Choice, Choices, React, Reaction, Reactions, Select};
pub use sensor::{Image, Reading, VirtualSensor, Vsp};
pub use subsystem::{Command, Input, Subsystem, X};
