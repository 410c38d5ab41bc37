//! One question to a planner: where an axis is, where it shall be, what it may do.

/// Start, end and limits of one axis, in the axis' unit, per s, s², s³.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub struct Axis {
    /// Position at the start.
    pub p0: f64,
    /// Velocity at the start.
    pub v0: f64,
    /// Acceleration at the start.
    pub a0: f64,
    /// Position at the end.
    pub p1: f64,
    /// Velocity at the end.
    pub v1: f64,
    /// Acceleration at the end.
    pub a1: f64,
    /// Least velocity allowed, negative.
    pub v_min: f64,
    /// Greatest velocity allowed, positive.
    pub v_max: f64,
    /// Least acceleration allowed, negative.
    pub a_min: f64,
    /// Greatest acceleration allowed, positive.
    pub a_max: f64,
    /// Greatest |jerk| allowed.
    pub j_max: f64,
}

impl Axis {
    /// Whether the lower limits mirror the upper ones.
    #[must_use]
    pub fn is_symmetric(&self) -> bool {
        #[expect(clippy::float_cmp, reason = "the same numbers or others")]
        let mirrored = [self.v_min, self.a_min] == [-self.v_max, -self.a_max];
        mirrored
    }

    /// Whether the end may be asked for: inside the limits of velocity and acceleration, and
    /// reached without having left those of velocity just before.
    ///
    /// With a1 < 0 the velocity came from at least v1 + a1²/(2·j), with a1 > 0 from at most
    /// v1 − a1²/(2·j).
    #[must_use]
    pub fn has_valid_end(&self) -> bool {
        let came_by = self.a1 * self.a1 / (2.0 * self.j_max);
        (self.v_min..=self.v_max).contains(&self.v1)
            && (self.a_min..=self.a_max).contains(&self.a1)
            && !(self.a1 < 0.0 && self.v1 + came_by > self.v_max)
            && !(self.a1 > 0.0 && self.v1 - came_by < self.v_min)
    }
}

/// All axes of one motion; they shall end together.
pub type Case<const N: usize> = [Axis; N];
