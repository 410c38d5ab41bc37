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
/// The IRp-6's longest axis (N: 3000 rad, 2000 increments a turn) needs 9.6·10⁸ of 2³¹ units; axes
/// that turn without end pass them, and their drives' positions are then modulo 2³² ([`modulo`]).
pub const UNITS_PER_INCREMENT: i64 = 1000;

// schema: end

/// The 32 bits in which a drive counts: the position modulo 2³² units.
#[must_use]
#[expect(
    clippy::cast_possible_truncation,
    reason = "modulo 2^32 is what is wanted"
)]
pub const fn modulo(units: i64) -> i32 {
    units as i32
}

/// The position that a drive's 32 bits mean: of all that differ by 2³² units the one nearest to
/// where the axis was known to be, which is right as long as it has moved by less than 2³¹ since.
#[must_use]
pub const fn nearest(bits: i32, known: i64) -> i64 {
    known.saturating_add(bits.wrapping_sub(modulo(known)) as i64)
}

#[cfg(test)]
mod test {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn what_moved_less_than_half_the_range_is_found_again(
            known in -(1_i64 << 60)..1_i64 << 60, moved in -(1_i64 << 31)..1_i64 << 31,
        ) {
            let position = known + moved;
            prop_assert_eq!(nearest(modulo(position), known), position);
        }
    }

    #[test]
    fn what_moved_half_the_range_or_more_is_not() {
        assert_eq!(nearest(modulo(1 << 31), 0), -(1 << 31));
        assert_eq!(nearest(modulo((1 << 31) + 5), 0), 5 - (1 << 31));
        assert_eq!(nearest(modulo(1 << 32), 0), 0);
    }

    #[test]
    fn positions_of_a_limited_axis_are_what_they_were() {
        for units in [i32::MIN, -1, 0, 1, i32::MAX] {
            assert_eq!(modulo(i64::from(units)), units);
            assert_eq!(nearest(units, 0), i64::from(units));
        }
    }
}
