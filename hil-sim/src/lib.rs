//! E and the world: drives, mechanics, and a whole cell in lock step.
//!
//! | module | one line |
//! |---|---|
//! | [`drive`] | a conformant CiA 301 / CiA 402 slave for one axis |
//! | [`plant`] | motors, gears, friction, gravity, encoders, switches, brakes of one robot |
//! | [`cell`] | nodes, drives, mechanics and buses on one virtual clock |
//! | [`fault`] | faults somebody asks for, as text and as data |
//! | [`realtime`] | one robot's drives and mechanics on buses between processes |
//! | [`workpiece`] | a board, and what a cutter that is moved through it leaves |
#![forbid(unsafe_code)]

pub mod cell;
pub mod drive;
pub mod fault;
pub mod plant;
pub mod realtime;
pub mod workpiece;
