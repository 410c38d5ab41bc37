//! E, the mechanics: motors, gears, friction, gravity, encoders, switches, brakes of one robot.
//!
//! ```text
//! drive ──torque──▶ current loop ──▶ rotor + reflected load ──▶ encoder count ──▶ drive
//!                                    ▲ friction, brake, stops   home switch
//!                        gravity ────┘                          index pulse, limit switches
//! ```
//!
//! | module | one line |
//! |---|---|
//! | [`axis`] | one motor with its load and its receptors |
//! | [`gravity`] | what the arm's weight does to the motors |
//! | [`parameters`] | the numbers of the IRp-6 robots, each with its source |
//! | [`random`] | seeded random numbers, one stream per purpose |
//! | [`robot`] | the drives and plants of one robot on its buses |

pub mod axis;
pub mod gravity;
pub mod parameters;
pub mod random;
pub mod robot;
