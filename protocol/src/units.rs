//! Shapes and units shared by both wires.

// schema: begin

/// The most axes one node controls: MRROC++'s `MAX_SERVOS`.
pub const MAX_AXES: usize = 8;

/// One value per axis, in the robot's axis order.
pub type PerAxis<T> = heapless::Vec<T, MAX_AXES>;

/// Drive position units per encoder increment (CiA 402 factor group, objects 608F/6091/6092).
///
/// Demands are finer than the encoder, so that the third difference of a quantised set-point says
/// something about jerk: at 4000 increments a turn one unit is 1.57 µrad of the motor shaft.
/// The IRp-6's longest axis (N: 3000 rad, 2000 increments a turn) needs 9.6·10⁸ of 2³¹ units, a
/// 4000-increment axis reaches 3373 rad.
pub const UNITS_PER_INCREMENT: i64 = 1000;

// schema: end
