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
//! | [`axis`] | one motor with its brake, friction and stops |
//! | [`motor`] | its winding: current loop, voltage, heat |
//! | `receptors` | its encoder, index and switches |
//! | `encoder` | how an encoder can be wrong |
//! | `commissioning` | what drives without gears are tuned for |
//! | [`contact`] | a tool's tip and the stiff bodies around it |
//! | [`force_sensor`] | force and moment at the wrist, and their node on a bus |
//! | `friction` | coupled axes with dry friction, brakes and stops |
//! | [`gear`] | a gear that gives: spring, damping, backlash |
//! | [`mechanics`] | how the motors of a robot move together, and robots whose motors do not |
//! | [`parameters`] | the simulated robots from their descriptions |
//! | [`random`] | seeded random numbers, one stream per purpose |
//! | [`rigid_body`] | the links of an arm: full rigid-body dynamics |
//! | [`robot`] | the drives and plants of one robot on its buses |

pub mod axis;
mod commissioning;
pub mod contact;
mod encoder;
pub mod force_sensor;
mod friction;
pub mod gear;
pub mod mechanics;
pub mod motor;
pub mod parameters;
pub mod random;
mod receptors;
pub mod rigid_body;
pub mod robot;
