//! The controller node as an image on an emulated microcontroller, instead of in this process: QEMU's
//! machine `mps2-an386`, coupled in lock step (`firmware/boards/README.md`).
//!
//! | module | one line |
//! |---|---|
//! | [`cost`] | instructions of a servo step |
//! | [`elf`] | sizes, symbols and stack frames of an image |
//! | [`golden`] | measured numbers beside accepted ones |
//! | [`log`] | the log of an image as text |
//! | [`machine`] | the emulator as a process, and its two files |
//! | [`mailbox`] | the emulated node in real time |
//! | [`node`] | the emulated node, in the place of one in this process |
//! | [`tape`] | everything that went into and came out of a node, and its replay |
//! | [`traces`] | short lives of nodes, each unlike the others |

pub mod bootloader;
pub mod cost;
pub mod elf;
pub mod golden;
pub mod log;
pub mod machine;
#[cfg(unix)]
pub mod mailbox;
pub mod node;
pub mod tape;
pub mod traces;
