//! E, the mechanics: motors, gears, friction, gravity, encoders, switches, brakes of one robot.
//!
//! ```text
//! drive ──torque──▶ current loop ──▶ rotors + links of the arm ──▶ encoder count ──▶ drive
//!                                    ▲ friction, brakes, stops     home switch
//!                        gravity ────┘                             index pulse, limit switches
//! ```
//!
//! | module | one line |
//! |---|---|
//! | [`axis`] | one motor with its receptors |
//! | `commissioning` | what drives without gears are tuned for |
//! | `friction` | coupled axes with dry friction, brakes and stops |
//! | [`mechanics`] | how the motors of a robot move together, and robots whose motors do not |
//! | [`parameters`] | the simulated robots from their descriptions |
//! | [`random`] | seeded random numbers, one stream per purpose |
//! | [`rigid_body`] | the links of an arm: full rigid-body dynamics |
//! | [`robot`] | the drives and plants of one robot on its buses |

pub mod axis;
mod commissioning;
mod friction;
pub mod mechanics;
pub mod parameters;
pub mod random;
pub mod rigid_body;
pub mod robot;
