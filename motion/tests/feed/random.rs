//! Random paths, limits and courses, all from one seed.

use crate::support::{Course, FREE, Path, Wave};
use motion::AxisLimits;
use motion::feed::{FeedLimits, NormLimits};

/// Knuth's linear congruential generator, MMIX constants.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    /// In [0, 1).
    pub(crate) fn share(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.share()
    }

    pub(crate) fn chance(&mut self, share: f64) -> bool {
        self.share() < share
    }

    fn one_of<T: Copy>(&mut self, all: &[T]) -> T {
        all[(self.share() * all.len() as f64) as usize]
    }

    fn wave(&mut self, slope: f64, sharp: f64) -> Wave {
        Wave {
            slope: self.between(-slope, slope),
            sines: (1..=4)
                .map(|k| {
                    let w = f64::from(k) * sharp * self.share();
                    let amplitude = self.between(-1.0, 1.0) / f64::from(k) / (1.0 + 0.3 * w);
                    [amplitude, w, self.between(0.0, 6.3)]
                })
                .collect(),
            steps: Vec::new(),
        }
    }
}

/// Override as a function of the macrostep.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Hand {
    Steady,
    /// Anything in [−0.7, 1.3] at every step.
    Restless,
    /// Held, reversed, run, each for up to 0.4 s.
    Switching,
    /// Now and then another value in [0, 1].
    Forwards,
}

pub(crate) struct Case {
    pub(crate) path: Path<3>,
    pub(crate) limits: FeedLimits<3>,
    pub(crate) course: Course,
    pub(crate) hand: Hand,
    /// Samples that arrive in a macrostep.
    pub(crate) most_samples: usize,
}

impl Case {
    pub(crate) fn new(random: &mut Random) -> Self {
        for _ in 0..4 {
            // neighbouring seeds begin alike
            random.share();
        }
        let sharp = random.between(1.0, 7.0);
        let (tool, jerk) = (random.chance(0.6), random.chance(0.7));
        let path = Path {
            joints: [0; 3].map(|_| random.wave(1.0, sharp)),
            linear: [0; 3].map(|_| random.wave(0.5, sharp)),
            angular: [0; 3].map(|_| random.wave(0.5, sharp)),
            feed: if random.chance(0.5) {
                f64::INFINITY
            } else {
                random.between(0.1, 1.1)
            },
        };
        let joints = [0; 3].map(|_| AxisLimits {
            v: random.between(0.3, 2.3),
            a: random.between(1.0, 9.0),
            j: if jerk {
                random.between(20.0, 220.0)
            } else {
                f64::INFINITY
            },
        });
        let mut maybe = |likely: bool, scale: f64| {
            (likely && random.chance(0.7)).then(|| random.between(0.3, 1.3) * scale)
        };
        let mut norm = || NormLimits {
            v: maybe(tool, 1.0),
            a: maybe(tool, 5.0),
            j: maybe(tool && jerk, 100.0),
        };
        let limits = FeedLimits {
            joints,
            linear: norm(),
            angular: norm(),
        };
        let course = Course {
            length: random.between(0.3, 2.0),
            grid: random.one_of(&[0.002, 0.005, 0.01]),
            step_s: random.one_of(&[0.001, 0.004, 0.01, 0.02]),
        };
        let hand = random.one_of(&[
            Hand::Steady,
            Hand::Restless,
            Hand::Switching,
            Hand::Forwards,
        ]);
        let most_samples = if random.chance(0.3) { 1 } else { 1000 };
        Self {
            path,
            limits,
            course,
            hand,
            most_samples,
        }
    }
}

impl Hand {
    /// After 3000 steps all let go, so that every run ends.
    pub(crate) fn overrides(self, mut random: Random, step_s: f64) -> impl FnMut(usize) -> f64 {
        let (mut value, mut left) = (1.0, 0);
        move |k| match self {
            _ if k > 3000 => 1.0,
            Self::Steady => 1.0,
            Self::Restless => random.between(-0.7, 1.3),
            Self::Switching => {
                if left == 0 {
                    value = random.one_of(&[1.0, 0.0, -1.0, 0.5, 1.0, 1.0, -0.3, 0.0]);
                    left = (random.share() * 0.4 / step_s) as usize + 1;
                }
                left -= 1;
                value
            }
            Self::Forwards => {
                if random.chance(0.02) {
                    value = random.share();
                }
                value
            }
        }
    }
}

/// Six joints as in the comparison with other solvers.
pub(crate) fn six_joints(random: &mut Random) -> Path<6> {
    Path::of_joints([0; 6].map(|_| random.wave(1.0, 3.0)))
}

pub(crate) const NO_TOOL: NormLimits = FREE;
