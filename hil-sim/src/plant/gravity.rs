//! What the arm's weight does to the motors.
//!
//! The IRp-6 drives lower arm, upper arm and hand by their *absolute* angles t2, t3, t4 (a
//! parallelogram), so each motor carries the weight of its own angle's term only. With masses m2 (at
//! the middle of the lower arm), m3 (middle of the upper arm), m4 (wrist and tool, at the flange)
//!
//! V = −g·[(m2/2 + m3 + m4)·a2·sin t2 + (m3/2 + m4)·a3·sin t3 + m4·d5·sin t4]   (z up)
//!
//! and the torque on motor k is −∂V/∂t / (dm/dt). The upper arm's mass hangs at the lower arm's end.

/// Torques the world puts on the motors of one robot.
pub trait GravityModel {
    /// Writes the load torque, N·m on each motor shaft, at the true motor angles, rad.
    fn load_torque_nm(&self, motor_rad: &[f64], load_nm: &mut [f64]);
}

/// No weight: tests, and axes that carry none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Weightless;

impl GravityModel for Weightless {
    fn load_torque_nm(&self, _motor_rad: &[f64], load_nm: &mut [f64]) {
        load_nm.fill(0.0);
    }
}

/// Standard gravity, m/s².
const G: f64 = 9.806_65;
/// Link lengths, m (MRROC++ `irp6ot_m`, `irp6p_m`).
const A2: f64 = 0.455;
const A3: f64 = 0.67;
const D5: f64 = 0.19;
/// Motor rad per mm of the 5 mm ball screws.
const SCREW: f64 = core::f64::consts::TAU / 5.0;

/// A ball screw of length l that turns an angle t: l² = base + m·cos t − n·sin t (mm², MRROC++).
#[derive(Clone, Copy, Debug, PartialEq)]
struct Screw {
    /// Length at motor angle `synchro_rad`, mm.
    l0: f64,
    m: f64,
    n: f64,
}

/// The constant term of both screws, mm².
const BASE: f64 = 77_895.25;
const LOWER: Screw = Screw {
    l0: 220.3374,
    m: 60_902.55,
    n: -29_346.68,
};
const UPPER: Screw = Screw {
    l0: 183.8348,
    m: -44_100.0,
    n: -51_240.0,
};

impl Screw {
    /// cos t and dm/dt (motor rad per rad) at `motor_rad` from the synchronisation offset.
    ///
    /// With m = R·cos φ, n = R·sin φ the law reads l² − base = R·cos(t + φ); on the branch the
    /// mechanism uses, sin(t + φ) < 0.
    fn at(self, motor_rad: f64) -> (f64, f64) {
        let l = motor_rad / SCREW + self.l0;
        let c = l * l - BASE;
        let square = self.m * self.m + self.n * self.n;
        let d2 = square - c * c;
        // Beyond the dead centre there is no position: stay there (the stops are far before).
        let d = if d2 > 0.0 { libm::sqrt(d2) } else { 0.0 };
        let cos = (self.m * c - self.n * d) / square;
        (cos, SCREW * d / (2.0 * l))
    }
}

/// Masses of the arm, kg.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Masses {
    /// Lower arm.
    pub lower_kg: f64,
    /// Upper arm.
    pub upper_kg: f64,
    /// Wrist and tool.
    pub wrist_kg: f64,
}

impl Masses {
    /// ASSUMED: none is published.
    pub const ASSUMED: Self = Self {
        lower_kg: 8.0,
        upper_kg: 6.0,
        wrist_kg: 5.0,
    };
}

/// The weight of an IRp-6 arm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Irp6Arm {
    /// Axes before the column: 1 on the track, 0 on the postument.
    before: usize,
    masses: Masses,
    /// Motor angles at which the screws have their length l0 and the hand is level, rad
    /// (MRROC++ `synchro_motor_position`).
    synchro_rad: [f64; 3],
}

impl Irp6Arm {
    /// The arm on the track: seven axes, the column is axis 1.
    #[must_use]
    pub const fn track(masses: Masses) -> Self {
        Self {
            before: 1,
            masses,
            synchro_rad: [-4.012, -6.219, 158.997],
        }
    }

    /// The arm on the postument: six axes, the column is axis 0.
    #[must_use]
    pub const fn postument(masses: Masses) -> Self {
        Self {
            before: 0,
            masses,
            synchro_rad: [-5.0, -8.527, 151.31],
        }
    }
}

impl Irp6Arm {
    /// The arm of five axes, the column is axis 0.
    #[must_use]
    pub const fn five_axes(masses: Masses) -> Self {
        Self {
            before: 0,
            masses,
            synchro_rad: [4.0, 9.0, 170.0],
        }
    }
}

impl GravityModel for Irp6Arm {
    fn load_torque_nm(&self, motor_rad: &[f64], load_nm: &mut [f64]) {
        load_nm.fill(0.0);
        let arm = self.before + 1;
        let (Some(&[lower, upper, hand]), Some(load)) = (
            motor_rad
                .get(arm..arm + 3)
                .and_then(|arm| arm.first_chunk::<3>()),
            load_nm
                .get_mut(arm..arm + 3)
                .and_then(|load| load.first_chunk_mut::<3>()),
        ) else {
            return;
        };
        let [s2, s3, s4] = self.synchro_rad;
        let Masses {
            lower_kg,
            upper_kg,
            wrist_kg,
        } = self.masses;
        let (cos2, ratio2) = LOWER.at(lower - s2);
        let (cos3, ratio3) = UPPER.at(upper - s3);
        let ratio4 = -128.0;
        let cos4 = libm::cos((hand - s4) / ratio4);
        *load = [
            G * (0.5 * lower_kg + upper_kg + wrist_kg) * A2 * cos2 / ratio2,
            G * (0.5 * upper_kg + wrist_kg) * A3 * cos3 / ratio3,
            G * wrist_kg * D5 * cos4 / ratio4,
        ];
    }
}

/// The weight on Polycrank's level axes 4, 5 and 6; the first three are vertical and the last, whose
/// load is on it, carry none.
///
/// With the masses m4 and m5 in the middle of their cranks of length a, m6 on axis 6 and m7 at the
/// flange, d along A, where A points down by cos ψ and ψ = q4 + q5 + q6,
///
/// V = g·[(m4/2 + m5 + m6 + m7)·a·sin q4 + (m5/2 + m6 + m7)·a·sin(q4 + q5) − m7·d·cos ψ]
///
/// and the torque on a direct drive is −∂V/∂q.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PolycrankArm {
    masses_kg: [f64; 4],
}

/// a4 = a5 and d7 of Polycrank, m (mzbikows/graspit).
const CRANK: f64 = 0.151;
const FLANGE: f64 = 0.043;

impl PolycrankArm {
    /// Masses of the links 4 to 7, kg. ASSUMED: none is published.
    pub const ASSUMED: Self = Self {
        masses_kg: [3.0, 2.5, 1.0, 0.5],
    };
}

impl GravityModel for PolycrankArm {
    fn load_torque_nm(&self, motor_rad: &[f64], load_nm: &mut [f64]) {
        load_nm.fill(0.0);
        let (Some(&[q4, q5, q6]), Some(load)) = (
            motor_rad.get(3..6).and_then(|q| q.first_chunk::<3>()),
            load_nm.get_mut(3..6).and_then(|l| l.first_chunk_mut::<3>()),
        ) else {
            return;
        };
        let [m4, m5, m6, m7] = self.masses_kg;
        let sixth = -G * m7 * FLANGE * libm::sin(q4 + q5 + q6);
        let fifth = sixth - G * (0.5 * m5 + m6 + m7) * CRANK * libm::cos(q4 + q5);
        let fourth = fifth - G * (0.5 * m4 + m5 + m6 + m7) * CRANK * libm::cos(q4);
        *load = [fourth, fifth, sixth];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The angle t of a screw by bisection of its law: independent of the closed form.
    fn angle(screw: Screw, motor: f64, mut low: f64, mut high: f64) -> f64 {
        let l = motor / SCREW + screw.l0;
        let law = |t: f64| BASE + screw.m * libm::cos(t) - screw.n * libm::sin(t) - l * l;
        assert!(law(low) < 0.0 && law(high) > 0.0);
        for _ in 0..80 {
            let mid = 0.5 * (low + high);
            if law(mid) < 0.0 {
                low = mid;
            } else {
                high = mid;
            }
        }
        0.5 * (low + high)
    }

    fn angles(motor: [f64; 3], synchro: [f64; 3]) -> [f64; 3] {
        let rad = |degrees: f64| degrees.to_radians();
        [
            angle(LOWER, motor[0] - synchro[0], rad(-140.0), rad(-40.0)),
            angle(UPPER, motor[1] - synchro[1], rad(-35.0), rad(45.0)),
            (motor[2] - synchro[2]) / -128.0,
        ]
    }

    fn potential(masses: Masses, [t2, t3, t4]: [f64; 3]) -> f64 {
        let (z2, z3, z4) = (
            -A2 * libm::sin(t2),
            -A3 * libm::sin(t3),
            -D5 * libm::sin(t4),
        );
        G * (masses.lower_kg * 0.5 * z2
            + masses.upper_kg * (z2 + 0.5 * z3)
            + masses.wrist_kg * (z2 + z3 + z4))
    }

    #[test]
    fn the_torque_is_the_slope_of_the_potential() {
        let arm = Irp6Arm::postument(Masses::ASSUMED);
        let mut worst = 0.0_f64;
        for k in 0..60 {
            let part = f64::from(k) / 59.0;
            let motor = [
                -100.0 + 190.0 * part,
                -70.0 + 160.0 * part,
                -60.0 + 400.0 * part,
            ];
            let mut load = [f64::NAN; 6];
            arm.load_torque_nm(&[0.0, motor[0], motor[1], motor[2], 7.0, 9.0], &mut load);
            for axis in 0..3 {
                let shifted = |by: f64| {
                    let mut motor = motor;
                    motor[axis] += by;
                    potential(Masses::ASSUMED, angles(motor, arm.synchro_rad))
                };
                let slope = (shifted(0.01) - shifted(-0.01)) / 0.02;
                // Central differences over 0.02 rad of torques below 1 N·m.
                let error = (load[axis + 1] + slope).abs();
                assert!(error < 1e-5, "axis {axis} at {motor:?}: {error}");
                worst = if load[axis + 1].abs() > worst {
                    load[axis + 1].abs()
                } else {
                    worst
                };
            }
            assert_eq!([load[0], load[4], load[5]].map(f64::to_bits), [0; 3]);
        }
        // The heaviest posture must be within what the drives can hold (1.5 N·m).
        assert!(worst > 0.2 && worst < 1.0, "{worst} N·m");
    }

    #[test]
    fn polycranks_torque_is_the_slope_of_its_potential() {
        // heights by the published table, link by link: an oracle apart from the closed form
        let potential = |q: [f64; 7]| {
            let (e1, e2) = (q[3], q[3] + q[4]);
            let z5 = CRANK * libm::sin(e1);
            let z6 = z5 + CRANK * libm::sin(e2);
            let z7 = z6 - FLANGE * libm::cos(e2 + q[5]);
            let middle5 = 0.5 * (z5 + z6);
            G * (3.0 * 0.5 * z5 + 2.5 * middle5 + z6 + 0.5 * z7)
        };
        for k in 0..40 {
            let q: [f64; 7] = [0.3, 0.5, 0.7, 0.9, 1.1, 1.3, 1.5].map(|by| f64::from(k) * by - 4.0);
            let mut load = [f64::NAN; 7];
            PolycrankArm::ASSUMED.load_torque_nm(&q, &mut load);
            for axis in 0..7 {
                let shifted = |by: f64| {
                    let mut q = q;
                    q[axis] += by;
                    potential(q)
                };
                let slope = (shifted(1e-4) - shifted(-1e-4)) / 2e-4;
                // central differences of at most 15 N·m: 15·1e-8/6
                assert!((load[axis] + slope).abs() < 1e-7, "{axis} {load:?} {slope}");
            }
        }
    }

    #[test]
    fn the_upright_lower_arm_carries_itself() {
        let arm = Irp6Arm::track(Masses::ASSUMED);
        let mut load = [1.0; 7];
        // At the synchronisation offset l = l0: t2 = −90°, t3 = 0, t4 = 0.
        arm.load_torque_nm(&[5.0, 5.0, -4.012, -6.219, 158.997, 0.0, 0.0], &mut load);
        assert!(load[2].abs() < 1e-6, "{}", load[2]);
        // t3 = 0: 8 kg at 0.67 m over the screw's 139 mm/rad · 2π/5 rad/mm = 175 rad/rad.
        assert!((load[3] - 0.30).abs() < 0.01, "{}", load[3]);
        assert!((load[4] + 9.806_65 * 5.0 * 0.19 / 128.0).abs() < 1e-12);
        assert_eq!(load[0].to_bits(), 0);
    }

    #[test]
    fn a_short_slice_is_no_arm() {
        let mut load = [1.0; 3];
        Irp6Arm::track(Masses::ASSUMED).load_torque_nm(&[0.0; 3], &mut load);
        assert_eq!(load.map(f64::to_bits), [0; 3]);
        let mut load = [1.0; 2];
        Weightless.load_torque_nm(&[0.0; 2], &mut load);
        assert_eq!(load.map(f64::to_bits), [0; 2]);
    }
}
