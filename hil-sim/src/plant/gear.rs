//! A gear that gives: a spring with damping and backlash between a motor and its links.

use super::robot::SUBSTEP_NS;

/// A gear as seen at the motor shaft. A stiffness c at the joint is c/n² there, with n the gear's slope in motor
/// radians per radian of the joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gear {
    /// Torque per twist beyond the backlash, N·m/rad.
    pub stiffness_nm_rad: f64,
    /// Torque per rate of twist while the flanks touch, N·m·s/rad.
    pub damping_nms_rad: f64,
    /// Play of the shaft while the links stand, rad from flank to flank.
    pub backlash_rad: f64,
}

/// Why an axis cannot have this gear.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum GearError {
    /// There is no such axis, or nothing behind it.
    #[error("there is no such axis with links behind it")]
    Axis,
    /// A number is negative or none, or there is no stiffness.
    #[error("stiffness must be positive, damping and backlash at least 0, all finite")]
    Number,
    /// It swings or stops the rotor too fast for the substep.
    #[error("too stiff or too much damped for the rotor's inertia and a substep of 0.25 ms")]
    Stiff,
}

impl Gear {
    /// Can a rotor of this inertia, kg·m², be simulated behind it? Its own frequency ω = √(c/J) may make ω·dt 0.5 at
    /// most, a fourth of where the explicit spring becomes unstable, and damping d·dt/J likewise.
    pub(super) fn check(&self, rotor_kg_m2: f64) -> Result<(), GearError> {
        let Self {
            stiffness_nm_rad: c,
            damping_nms_rad: d,
            backlash_rad: play,
        } = *self;
        let sound = c > 0.0 && d >= 0.0 && play >= 0.0;
        if !sound || !(c + d + play).is_finite() {
            return Err(GearError::Number);
        }
        #[expect(clippy::cast_precision_loss, reason = "a small constant")]
        let dt_s = SUBSTEP_NS as f64 * 1e-9;
        if c * dt_s * dt_s > 0.25 * rotor_kg_m2 || d * dt_s > 0.5 * rotor_kg_m2 {
            return Err(GearError::Stiff);
        }
        Ok(())
    }

    /// The torque the shaft hands on to the links, N·m, twisted by `twist_rad` against them at `rate_rad_s`.
    ///
    /// Flanks push only: damping never pulls them together.
    pub(super) fn torque_nm(&self, twist_rad: f64, rate_rad_s: f64) -> f64 {
        let half = 0.5 * self.backlash_rad;
        let damped = self.damping_nms_rad * rate_rad_s;
        if twist_rad > half {
            let torque = self.stiffness_nm_rad * (twist_rad - half) + damped;
            if torque > 0.0 || half == 0.0 {
                torque
            } else {
                0.0
            }
        } else if twist_rad < -half {
            let torque = self.stiffness_nm_rad * (twist_rad + half) + damped;
            if torque < 0.0 || half == 0.0 {
                torque
            } else {
                0.0
            }
        } else {
            0.0
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GEAR: Gear = Gear {
        stiffness_nm_rad: 2.0,
        damping_nms_rad: 0.01,
        backlash_rad: 0.1,
    };

    #[test]
    fn there_is_no_torque_inside_the_backlash_and_never_a_pull() {
        let cases = [
            (0.04, 100.0, 0.0),
            (-0.04, -100.0, 0.0),
            (0.15, 0.0, 0.2),
            (-0.15, 0.0, -0.2),
            (0.15, 1.0, 0.21),
            (0.06, -100.0, 0.0),
            (-0.06, 100.0, 0.0),
        ];
        for (twist, rate, expected) in cases {
            let torque = GEAR.torque_nm(twist, rate);
            assert!(
                (torque - expected).abs() < 1e-12,
                "{twist} {rate}: {torque}"
            );
        }
    }

    #[test]
    fn gears_that_cannot_be_are_refused() {
        let with = |change: fn(&mut Gear)| {
            let mut gear = GEAR;
            change(&mut gear);
            gear.check(1e-4).unwrap_err()
        };
        assert_eq!(GEAR.check(1e-4), Ok(()));
        assert_eq!(with(|g| g.stiffness_nm_rad = 0.0), GearError::Number);
        assert_eq!(with(|g| g.stiffness_nm_rad = f64::NAN), GearError::Number);
        assert_eq!(with(|g| g.damping_nms_rad = -1.0), GearError::Number);
        assert_eq!(with(|g| g.backlash_rad = f64::INFINITY), GearError::Number);
        // 0.25·1e-4/(0.25 ms)² = 400 N·m/rad, 0.5·1e-4/0.25 ms = 0.2 N·m·s/rad
        assert_eq!(with(|g| g.stiffness_nm_rad = 401.0), GearError::Stiff);
        assert_eq!(with(|g| g.damping_nms_rad = 0.21), GearError::Stiff);
    }
}
