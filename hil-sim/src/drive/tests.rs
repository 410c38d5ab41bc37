//! Scenarios of one drive on its plant, seen from the wire, in virtual time.

mod bench;
mod cyclic;
mod homing;
mod network;
mod probing;
mod program;
mod safety;
mod services;
mod stops;
mod way;
