//! How frames travel: the virtual wire, the socketcand hub, SocketCAN, and their logs.
//!
//! | module | one line |
//! |---|---|
//! | [`wire`] | a virtual segment with arbitration and exact frame lengths, in virtual time |
#![forbid(unsafe_code)]

pub mod wire;
