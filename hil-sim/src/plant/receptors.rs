//! What a drive is told of its axis: encoder, index, switches; and how they can be wrong.

use core::f64::consts::TAU;

use super::axis::PlantParameters;
pub use super::encoder::EncoderFault;
use super::encoder::Wrong;
use super::random::SplitMix64;

/// What the drive receives from its axis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sensed {
    /// Encoder count since power-up, or from motor angle 0 of an absolute encoder.
    pub count: i64,
    /// The count at an index pulse that passed in this substep.
    pub index: Option<i64>,
    /// Home switch.
    pub home: bool,
    /// Negative limit switch.
    pub negative_limit: bool,
    /// Positive limit switch.
    pub positive_limit: bool,
    /// Motor current, A.
    pub current_a: f64,
}

/// Faults of the axis' receptors.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Broken {
    /// What the encoder does.
    pub encoder: Option<EncoderFault>,
    /// The encoder has jumped by so many increments: all it tells is off by them. A whole turn is an absolute
    /// encoder that lost one.
    pub jump: i64,
    /// This bit of the count is inverted.
    pub flipped_bit: Option<u8>,
    /// The home switch is stuck at this level.
    pub switch: Option<bool>,
    /// No index pulse is reported.
    pub index: bool,
}

/// The encoder, the index and the switches of one axis.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Receptors {
    increments_per_rad: f64,
    /// The encoder count is `floor(angle · increments / 2π − phase)`.
    phase: f64,
    /// The motor angles between which nothing happens to the index.
    quiet_rad: [f64; 2],
    /// Is that the width of a pulse?
    in_pulse: bool,
    /// How wide a pulse is beyond the increment in which it begins, rad.
    width_rad: f64,
    bounce_left_s: f64,
    switch: bool,
    random: SplitMix64,
    broken: Broken,
    /// The encoder, while it is wrong.
    wrong: Option<Wrong>,
    increments_per_turn: u32,
    pub(super) sensed: Sensed,
}

impl Receptors {
    /// At power-up, the motor at rest at `start_rad`.
    pub(super) fn new(p: &PlantParameters, start_rad: f64, random: SplitMix64) -> Self {
        let increments_per_rad = f64::from(p.increments_per_turn) / TAU;
        let turn = libm::floor(start_rad / TAU) * TAU;
        let width_rad = f64::from(p.index_increments.saturating_sub(1)) / increments_per_rad;
        let in_pulse = start_rad < turn + width_rad;
        let mut receptors = Self {
            increments_per_rad,
            phase: if p.absolute {
                0.0
            } else {
                start_rad * increments_per_rad
            },
            quiet_rad: if in_pulse {
                [turn, turn + width_rad]
            } else {
                [turn + width_rad, turn + TAU]
            },
            in_pulse,
            width_rad,
            bounce_left_s: 0.0,
            switch: start_rad < p.switch_rad,
            random,
            broken: Broken::default(),
            wrong: None,
            increments_per_turn: p.increments_per_turn,
            sensed: Sensed::default(),
        };
        receptors.sense(p, start_rad, 0.0, 0.0);
        receptors
    }

    /// The motor is at this angle at the end of a substep of `dt_s`.
    #[inline]
    pub(super) fn sense(&mut self, p: &PlantParameters, angle_rad: f64, current_a: f64, dt_s: f64) {
        self.sensed.index = None;
        let [low, high] = self.quiet_rad;
        if angle_rad < low || angle_rad >= high {
            self.pass_index(angle_rad);
        }
        self.sensed.count = self.told(floor(angle_rad * self.increments_per_rad - self.phase));
        if let Some(wrong) = &mut self.wrong {
            wrong.pass(dt_s);
        }
        let [low, high] = p.limit_rad;
        self.sensed.negative_limit = angle_rad < low;
        self.sensed.positive_limit = angle_rad > high;
        self.sensed.current_a = current_a;
        self.sense_switch(p, angle_rad, dt_s);
    }

    /// What is wrong with them.
    pub(super) const fn broken(&self) -> Broken {
        self.broken
    }

    /// Breaks or mends them.
    pub(super) fn set_broken(&mut self, broken: Broken) {
        self.broken = broken;
        if self.wrong.as_ref().map(Wrong::fault) != broken.encoder {
            let (count, turn, random) = (self.sensed.count, self.increments_per_turn, self.random);
            let wrong = |fault| Wrong::new(fault, count, turn, random);
            self.wrong = broken.encoder.map(wrong);
        }
    }

    /// What the encoder makes of a count.
    fn told(&mut self, count: i64) -> i64 {
        if let Some(wrong) = &mut self.wrong {
            return wrong.told(count);
        }
        let count = count.wrapping_add(self.broken.jump);
        match self.broken.flipped_bit {
            Some(bit) => count ^ 1_i64.wrapping_shl(u32::from(bit)),
            None => count,
        }
    }

    /// The motor has left the angles between which nothing happened: it leaves a pulse, or has come to one.
    #[cold]
    fn pass_index(&mut self, angle_rad: f64) {
        let [low, high] = self.quiet_rad;
        let upwards = angle_rad >= high;
        // where the pulse begins, seen from below, and where it is met
        let (begin, met) = match (self.in_pulse, upwards) {
            (true, _) => (low, None),
            (false, true) => (high, Some(high)),
            (false, false) => (low - self.width_rad, Some(low)),
        };
        self.in_pulse = angle_rad >= begin && angle_rad < begin + self.width_rad;
        self.quiet_rad = if self.in_pulse {
            [begin, begin + self.width_rad]
        } else if upwards {
            [begin + self.width_rad, begin + TAU]
        } else {
            [begin - TAU + self.width_rad, begin]
        };
        if let Some(at) = met
            && !self.broken.index
            && self.broken.encoder != Some(EncoderFault::Frozen)
        {
            let count = floor(at * self.increments_per_rad - self.phase);
            self.sensed.index = Some(self.told(count));
        }
    }

    fn sense_switch(&mut self, p: &PlantParameters, angle_rad: f64, dt_s: f64) {
        let edge = p.switch_rad
            + if self.switch {
                p.switch_hysteresis_rad
            } else {
                0.0
            };
        let active = angle_rad < edge;
        if active != self.switch {
            self.switch = active;
            self.bounce_left_s = p.bounce_s;
        }
        self.sensed.home = if let Some(stuck) = self.broken.switch {
            stuck
        } else if self.bounce_left_s > 0.0 {
            self.bounce_left_s -= dt_s;
            self.random.coin()
        } else {
            self.switch
        };
    }
}

/// The greatest integer not above `x`; much faster than `libm::floor`, for numbers below 2⁶³.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_precision_loss,
    reason = "encoder counts stay far below 2^53"
)]
#[inline]
pub(super) fn floor(x: f64) -> i64 {
    let cut = x as i64;
    if cut as f64 > x { cut - 1 } else { cut }
}
