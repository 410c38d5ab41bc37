//! Time-optimal motions of several axes: exact, optimal, never outside their limits, typed when refused.
mod cases;
mod checker;
mod data;
mod golden;
mod invalid;
mod issues;
mod laws;
mod optimal;
mod range;
mod together;
mod velocity;
