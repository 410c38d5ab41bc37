//! What a drive is commissioned with: motor data, loop bandwidths, delays.

use super::super::plant::parameters::units_per_rad;
use super::quirk::Quirks;

/// Milliseconds in nanoseconds.
pub const MS: u64 = 1_000_000;

/// 250 rad/s, the hard limit of the arms' motors, 1/min.
pub const MAX_SPEED_RPM: u32 = 2387;

/// The commissioning of one drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DriveParameters {
    /// Encoder increments per motor turn.
    pub increments_per_turn: u32,
    /// Rated current (object 6075), mA.
    pub rated_current_ma: u32,
    /// Rated torque (object 6076), mN·m: 1000 ‰ of the torque objects.
    pub rated_torque_mnm: u32,
    /// Greatest speed of the motor (object 6080), 1/min.
    pub max_speed_rpm: u32,
    /// Inertia the velocity loop is tuned for, kg·m².
    pub inertia_kg_m2: f64,
    /// Over-current trip, A.
    pub over_current_a: f64,
    /// How long the current may exceed it, ns.
    pub over_current_ns: u64,
    /// Bandwidth of the position loop, 1/s.
    pub position_bandwidth: f64,
    /// Bandwidth of the velocity loop, 1/s.
    pub velocity_bandwidth: f64,
    /// Integral action of the velocity loop, 1/s.
    pub velocity_integral: f64,
    /// Bandwidth of the velocity observer, 1/s.
    pub observer_bandwidth: f64,
    /// From power-up or reset to the boot-up message, ns.
    pub boot_ns: u64,
    /// From "enable operation" to following: current loop ready and brake open, ns.
    pub enable_ns: u64,
    /// How long torque is kept while the brake closes, ns.
    pub brake_close_ns: u64,
    /// From an SDO request to its answer, ns.
    pub sdo_ns: u64,
    /// Transmit mailboxes of its CAN controller.
    pub mailboxes: usize,
    /// Does it hang on a bus with CAN FD?
    pub fd: bool,
    /// Serial number (object 1018:4).
    pub serial: u32,
    /// What it does otherwise than the book.
    pub quirks: Quirks,
}

impl DriveParameters {
    /// The commissioning for a motor with `increments` a turn, `peak_a` greatest current, torque
    /// constant `nm_a` and `inertia_kg_m2` rotor and load.
    ///
    /// ASSUMED, as a maker would ship it: rated values are a quarter of the peak; velocity loop
    /// 250 1/s (the 0.3 ms current loop leaves it 80° of phase), position loop a third of it,
    /// observer three times; 150 ms to boot, 25 ms to follow, which covers the brake's 20 ms; a mailbox for each
    /// message of a cycle: four PDOs, emergency, heartbeat, SDO, LSS.
    #[must_use]
    pub fn new(increments: u32, peak_a: f64, nm_a: f64, inertia_kg_m2: f64, serial: u32) -> Self {
        Self {
            increments_per_turn: increments,
            rated_current_ma: whole(peak_a * 250.0),
            rated_torque_mnm: whole(peak_a * 250.0 * nm_a),
            max_speed_rpm: MAX_SPEED_RPM,
            inertia_kg_m2,
            over_current_a: 1.1 * peak_a,
            over_current_ns: 5 * MS,
            position_bandwidth: 80.0,
            velocity_bandwidth: 250.0,
            velocity_integral: 60.0,
            observer_bandwidth: 800.0,
            boot_ns: 150 * MS,
            enable_ns: 25 * MS,
            brake_close_ns: 35 * MS,
            sdo_ns: 0,
            mailboxes: 8,
            fd: false,
            serial,
            quirks: Quirks::default(),
        }
    }

    /// Greatest speed of the motor, rad/s.
    #[must_use]
    pub fn max_speed_rad_s(&self) -> f64 {
        f64::from(self.max_speed_rpm) * core::f64::consts::TAU / 60.0
    }

    /// Drive units per motor radian with the default scaling.
    #[must_use]
    pub fn units_per_rad(&self) -> f64 {
        units_per_rad(self.increments_per_turn)
    }
}

/// The nearest whole number of a positive value.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "saturates, and the value is positive"
)]
fn whole(value: f64) -> u32 {
    (value + 0.5) as u32
}
