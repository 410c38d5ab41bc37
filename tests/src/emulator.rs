//! The controller node as an image on an emulated microcontroller, instead of in this process: QEMU's
//! machine `mps2-an386`, coupled in lock step (`firmware/boards/README.md`).
//!
//! | module | one line |
//! |---|---|
//! | [`machine`] | the emulator as a process, and its two files |
//! | [`node`] | the emulated node, in the place of one in this process |
//! | [`tape`] | everything that went into and came out of a node, and its replay |
//! | [`traces`] | short lives of nodes, each unlike the others |

pub mod machine;
pub mod node;
pub mod tape;
pub mod traces;
