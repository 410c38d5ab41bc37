//! Scenarios of one drive on its plant, seen from the wire, in virtual time.

mod bench;
mod cyclic;
mod homing;
mod network;
mod safety;
mod services;
mod stops;
mod way;
