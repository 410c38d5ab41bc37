//! What is thought: the formalism in which robot controllers are written here.
//!
//! A controller is a coordinator `C_0` and executors `C_1 … C_n`, one for each effector. Each
//! perceives through images, and demands what is to be attained by the next instant. What a user
//! writes is small: **generators** `(f', f'', f_τ)` and **conditions** `f_I`, pure functions whose
//! argument lists are types. They are run by two instructions, **Move** and **Wait**, from which
//! all behaviours are composed.
//!
//! This crate is not a controller: it does no I/O, has no clock, no allocation, no dependency, and
//! cannot panic. The same program runs on a workstation, in simulation, and on a microcontroller.
//! (The feature `alloc` makes a `Box` of a generator, condition or behaviour one itself.)
//!
//! The formalism is C. Zieliński's; every symbol below is his.
//! \[Z1\] is *A Quasi-Formal Approach to Structuring Multi-Robot System Controllers*;
//! \[Z2\] is *Formal approach to the design of robot programming frameworks: the behavioural control
//! case* (Bull. Pol. Ac.: Tech. 53(1), 2005). `docs/theory.md` lists every equation and its item.
//!
//! # A first program
//!
//! Lower a tool until it touches: a generator that reads the sensor, and a condition to start it.
//!
//! ```
//! use agent::args::{Executor, F, V};
//! use agent::{Behaviour, Generator, Input, Move, Step, Subsystem, Then, Wait, X, condition};
//!
//! /// `C_j`: one vertical axis with a force sensor and a button.
//! struct Press;
//! impl Subsystem for Press {
//!     type Level = Executor;
//!     type Coordination = (); //      c_0: not coordinated
//!     type Effector = f64; //         e_j: height, m
//!     type Sensors = (f64, bool); //  v_j: force, N; button
//!     type Transmissions = ();
//!     type Command = f64; //          yc_e: height increment for the next step, m
//! }
//!
//! /// `f^1(c_j, v_j)`: down by a fixed step until the force is reached.
//! struct Lower {
//!     by_m: f64,
//!     until_n: f64,
//! }
//! impl Generator<Press> for Lower {
//!     type Own = u32; // c_j: steps made
//!     type Args = F<(), (), V>; // reading x.e() here would not compile
//!     fn first(&self, _: X<'_, Press, Self::Args>) -> (u32, f64) {
//!         (1, -self.by_m / 2.0) // f': start gently
//!     }
//!     fn next(&self, steps: &mut u32, _: X<'_, Press, Self::Args>) -> f64 {
//!         *steps += 1;
//!         -self.by_m // f''
//!     }
//!     fn terminal(&self, steps: &u32, x: X<'_, Press, Self::Args>) -> bool {
//!         x.v().0 >= self.until_n || *steps >= 500 // f_τ
//!     }
//! }
//!
//! let pressed = condition::<Press, F<(), (), V>, _>(|x| x.v().1); // f_I^1(c_j, v_j)
//! let mut program = Then::new(
//!     Wait::new(pressed),
//!     Move::new(Lower { by_m: 0.001, until_n: 5.0 }),
//! );
//!
//! let mut at = |i, v| program.step(&Input { i, c0: (), e: 0.2, v, t: () });
//! assert_eq!(at(0, (0.0, false)), Step::Hold);
//! assert_eq!(at(1, (0.0, true)), Step::Demand(-0.0005));
//! assert_eq!(at(2, (0.1, false)), Step::Demand(-0.001));
//! assert_eq!(at(3, (5.2, false)), Step::Done);
//! ```
//!
//! # The loop
//!
//! One Move, after \[Z2\] Fig. 3. [`Process`] checks `f_E` in front of every box of the right side;
//! what is written `──▶` and `◀──` is done by whoever calls `step`, once per instant.
//!
//! ```text
//!   i := i_0
//!      │
//!      ▼
//!   (c_c, yC) := f'(xC)
//!      │
//!      ├◀───────────────────────────────────────────┐
//!      ▼                                            │
//!   yc_e ──▶ e    yc_V ──▶ V    yc_T ──▶ T          │
//!      │                                            │
//!   i := i + 1                                      │
//!      │                                            │
//!   xc_e ◀── e    xc_V ◀── V    xc_T ◀── T          │
//!      │                                            │
//!      ▼                                            │
//!   f_E(c, e, r)? ── yes ──▶ Error, i_m* = i        │
//!      │ no                                         │
//!      ▼                                            │
//!   f_τ(c_c, xC)? ── no ──▶ (c_c, yC) := f''(c_c, xC)
//!      │ yes
//!      ▼
//!   Ended, i_m = i
//! ```
//!
//! # From symbol to item
//!
//! | symbol | item |
//! |---|---|
//! | `C_0`, `C_j` | [`Subsystem`]; its level is [`args::Coordinator`] or [`args::Executor`] |
//! | `xC = ⟨xc_e, xc_V, xc_T⟩`, `c_0` | [`Input`]; seen through an argument list: [`X`] |
//! | `yC = ⟨yc_e, yc_V, yc_T⟩` | [`Subsystem::Command`]; with all three parts: [`Command`] |
//! | `c_c` | [`Generator::Own`]; of a whole program: the [`Behaviour`] itself |
//! | `f', f'', f_τ` | [`Generator::first`], [`Generator::next`], [`Generator::terminal`] |
//! | `f** = const` | [`Constant`] |
//! | `f_I`, `p` | [`Condition`]; [`And`], [`Or`], [`Not`] |
//! | `f_E` | [`ErrorCondition`], run by [`Process`] |
//! | `f_v` | [`VirtualSensor`], run by [`Vsp`]; in the user's process: [`Image`] |
//! | superscript `q` | [`Class`], from the [`args::F`] list |
//! | Move, Wait | [`Move`], [`Wait`] |
//! | `e^{i+1} = e^i` | [`Step::Hold`] |
//! | `b`, `n_s` | [`Behaviour`]; [`ForSteps`], [`Sequence`], [`Then`], [`Repeat`] |
//! | `if p then b`, the loops over it | [`Reaction`]; [`Select`], [`React`], [`SelectByChance`] |
//! | `max`, `Σ`, inhibition, suppression | [`Compete`] with [`Greatest`], [`Inhibit`], [`Suppress`]; [`Superpose`] |
//! | `P_q`, `ζ`, `θ`, `ψ`, `n` | [`Response`], [`Stimulus`], [`Adaptation`] |
//! | total state of `c` | [`TotalState`], given to a [`Recorder`] |
//!
//! # Words
//!
//! - **Agent**: a control subsystem with its effector, virtual sensors and transmissions.
//! - **Image**: what a process knows of an effector or sensor. The only thing it touches.
//! - **Instant** `i`: a step boundary. **Step**: from `i` to `i + 1`.
//! - **Class**: which of `c_0`, `e`, `v` a function takes as arguments.
//! - **Coordination**: the MP's influence on an ECP. *None*: the start constant `f**` only;
//!   *loose*: decisions from a finite set, now and then; *tight*: set values, every step or a low
//!   multiple. Without it, effectors may still **cooperate**: through what their sensors perceive.
//! - **Exteroceptors** perceive the environment, and virtual sensors are made of them.
//!   **Proprioceptors** perceive the effector (encoders), and are part of `e`. **Interoceptors**
//!   perceive the controller itself (lost messages, missed deadlines), and are part of `c`.
//! - **Ontologies** of an effector (\[Z2\] Fig. 1): motor shafts, joints, end-effector pose. Each is
//!   an image of its own type, defined with the robots, not here.
//!
//! # Many robots at once
//!
//! Move and Wait do not change with the number of robots and sensors: their parameters are lists
//! (\[Z1\] §V). On the MP level, `Effector` is the list of images, and `Command` the list of what is
//! said to each ECP.
//!
//! ```
//! use agent::args::{Coordinator, E, F};
//! use agent::{Behaviour, Input, Move, Step, Subsystem, Wait, condition, generator};
//!
//! /// `C_0` of two robots that carry one body. Positions along the track, m.
//! struct Mp;
//! impl Subsystem for Mp {
//!     type Level = Coordinator;
//!     type Coordination = ();
//!     type Effector = [f64; 2]; //          e_c = ⟨e_c1, e_c2⟩
//!     type Sensors = ();
//!     type Transmissions = ();
//!     type Command = [Option<f64>; 2]; //   to each ECP, or nothing
//! }
//!
//! // f^2(c_0, e_c), tight coordination: both advance, their distance stays as it was
//! let mut carry = Move::new(generator::<Mp, F<(), E, ()>, _, _, _, _>(
//!     |x| ((x.e()[1] - x.e()[0], 1), x.e().map(|p| Some(p + 0.25))),
//!     |(distance, n), x| {
//!         *n += 1;
//!         [Some(x.e()[0] + 0.25), Some(x.e()[0] + 0.25 + *distance)]
//!     },
//!     |(_, n), _| *n == 2,
//! ));
//! let mut met = Wait::new(condition::<Mp, F<(), E, ()>, _>(|x| x.e()[1] - x.e()[0] < 1.5));
//!
//! let at = |e| Input::<Mp> { i: 0, c0: (), e, v: (), t: () };
//! assert_eq!(met.step(&at([0.0, 1.0])), Step::Done);
//! assert_eq!(carry.step(&at([0.0, 1.0])), Step::Demand([Some(0.25), Some(1.25)]));
//! assert_eq!(carry.step(&at([0.25, 1.5])), Step::Demand([Some(0.5), Some(1.5)]));
//! assert_eq!(carry.step(&at([0.5, 1.5])), Step::Done);
//! ```
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

#[cfg(feature = "alloc")]
extern crate alloc;

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
pub use instruction::{Move, MoveIn, Step, Wait};
pub use process::{Outcome, Process};
pub use random::{SplitMix64, Uniform};
pub use record::{Recorder, TotalState};
pub use response::{Adaptation, Response};
pub use select::{Choice, Choices, React, Reaction, Reactions, Select};
pub use sensor::{Image, Reading, VirtualSensor, Vsp};
pub use subsystem::{Command, Input, Subsystem, X};
