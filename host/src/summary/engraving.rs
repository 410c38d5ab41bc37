//! What became of an engraved board.

use serde::Serialize;

/// Distances from a path, m.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct PathErrors {
    /// The greatest.
    pub max_m: f64,
    /// The root of the mean square.
    pub rms_m: f64,
    /// How many instants were measured.
    pub count: u64,
    #[serde(skip)]
    squares: f64,
}

impl PathErrors {
    /// One more.
    #[expect(clippy::cast_precision_loss, reason = "far fewer than 2⁵³")]
    pub fn add(&mut self, error_m: f64) {
        self.count += 1;
        self.squares += error_m * error_m;
        self.rms_m = libm::sqrt(self.squares / self.count as f64);
        if error_m > self.max_m {
            self.max_m = error_m;
        }
    }
}

/// What became of the board.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct EngravingSummary {
    /// Volume that was cut away, m³.
    pub removed_m3: f64,
    /// The deepest cut, m.
    pub depth_m: f64,
    /// Way of the tool in the wood, m, and how long that took, s.
    pub cut_m: f64,
    /// s
    pub cut_s: f64,
    /// The greatest speed of the mechanics in the wood, m/s.
    pub feed_max_m_s: f64,
    /// Of the set-points.
    pub setpoints: PathErrors,
    /// Of the simulated mechanics.
    pub mechanics: PathErrors,
    /// On the path, the least distance of a joint to a limit of its position, as a share of half of its range,
    /// and its axis from 1.
    pub joint_margin: (f64, usize),
    /// The greatest velocity of a motor as a share of the limit in force, and its axis from 1.
    pub motor_velocity_share: (f64, usize),
    /// SYNCs at which the tool was in the wood although the spindle stood still.
    pub stalled: u64,
    /// SYNCs at which the shank or holder touched the board, or the tool went through it.
    pub collisions: u64,
    /// FNV-1a of the map of heights, hexadecimal.
    pub digest: String,
}
