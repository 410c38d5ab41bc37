//! Paths whose derivatives are known in closed form, and the judge of a motion along them.

use motion::AxisLimits;
use motion::feed::{Feed, FeedLimits, NormLimits, PushError, Sample, Status, Step, ToolSample};

/// A sum of a slope, sines (amplitude, angular frequency by s, phase) and smooth steps
/// height·tanh((s − place)/width).
#[derive(Clone, Debug, Default)]
pub(crate) struct Wave {
    pub(crate) slope: f64,
    pub(crate) sines: Vec<[f64; 3]>,
    pub(crate) steps: Vec<[f64; 3]>,
}

impl Wave {
    /// First, second and third derivative.
    pub(crate) fn derivatives(&self, s: f64) -> [f64; 3] {
        let mut out = [self.slope, 0.0, 0.0];
        for [amplitude, w, phase] in &self.sines {
            let (sin, cos) = (libm::sin(w * s + phase), libm::cos(w * s + phase));
            out[0] += amplitude * w * cos;
            out[1] -= amplitude * w * w * sin;
            out[2] -= amplitude * w * w * w * cos;
        }
        for [height, place, width] in &self.steps {
            let tanh = libm::tanh((s - place) / width);
            let slope = 1.0 - tanh * tanh;
            out[0] += height / width * slope;
            out[1] -= 2.0 * height / (width * width) * tanh * slope;
            out[2] += height / (width * width * width) * slope * (6.0 * tanh * tanh - 2.0);
        }
        out
    }
}

/// Joints, position of the tool, angular velocity of the tool (as the derivative of three waves).
#[derive(Clone, Debug)]
pub(crate) struct Path<const N: usize> {
    pub(crate) joints: [Wave; N],
    pub(crate) linear: [Wave; 3],
    pub(crate) angular: [Wave; 3],
    pub(crate) feed: f64,
}

impl<const N: usize> Path<N> {
    pub(crate) fn of_joints(joints: [Wave; N]) -> Self {
        Self {
            joints,
            linear: Default::default(),
            angular: Default::default(),
            feed: f64::INFINITY,
        }
    }

    pub(crate) fn sample(&self, s: f64) -> Sample<N> {
        let joints = self.joints.each_ref().map(|wave| wave.derivatives(s));
        let tool = |waves: &[Wave; 3]| {
            let each = waves.each_ref().map(|wave| wave.derivatives(s));
            [0, 1, 2].map(|order| each.map(|derivatives| derivatives[order]))
        };
        Sample {
            first: joints.map(|d| d[0]),
            second: joints.map(|d| d[1]),
            third: joints.map(|d| d[2]),
            tool: ToolSample {
                linear: tool(&self.linear),
                angular: tool(&self.angular),
            },
            feed: self.feed,
        }
    }
}

pub(crate) const FREE: NormLimits = NormLimits {
    v: None,
    a: None,
    j: None,
};

pub(crate) fn joint_limits<const N: usize>(v: f64, a: f64, j: f64) -> FeedLimits<N> {
    FeedLimits {
        joints: [AxisLimits { v, a, j }; N],
        linear: FREE,
        angular: FREE,
    }
}

/// Largest quotient of a quantity and its limit: velocity, acceleration, jerk.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Worst(pub(crate) [f64; 3]);

impl Worst {
    fn put(&mut self, order: usize, value: f64, limit: f64) {
        if value / limit > self.0[order] {
            self.0[order] = value / limit;
        }
    }

    /// At one moment of the motion, by the chain rule.
    pub(crate) fn look<const N: usize>(
        &mut self,
        path: &Path<N>,
        limits: &FeedLimits<N>,
        [s, v, a, j]: [f64; 4],
    ) {
        let sample = path.sample(s);
        let moved = |d1: f64, d2: f64, d3: f64| {
            [
                d1 * v,
                d1 * a + d2 * v * v,
                d1 * j + 3.0 * d2 * v * a + d3 * v * v * v,
            ]
        };
        for i in 0..N {
            let x = moved(sample.first[i], sample.second[i], sample.third[i]);
            let limit = [limits.joints[i].v, limits.joints[i].a, limits.joints[i].j];
            for order in 0..3 {
                self.put(order, x[order].abs(), limit[order]);
            }
        }
        for ([d1, d2, d3], limits) in [
            (sample.tool.linear, limits.linear),
            (sample.tool.angular, limits.angular),
        ] {
            let mut squares = [0.0; 3];
            for i in 0..3 {
                let x = moved(d1[i], d2[i], d3[i]);
                for order in 0..3 {
                    squares[order] += x[order] * x[order];
                }
            }
            for (order, limit) in [limits.v, limits.a, limits.j].into_iter().enumerate() {
                self.put(
                    order,
                    libm::sqrt(squares[order]),
                    limit.unwrap_or(f64::INFINITY),
                );
            }
        }
        let [d, ..] = sample.tool.linear;
        let speed = libm::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]) * v.abs();
        self.put(0, speed, sample.feed);
    }
}

/// How a run is made.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Course {
    pub(crate) length: f64,
    pub(crate) grid: f64,
    pub(crate) step_s: f64,
}

/// What came of it.
#[derive(Clone, Debug)]
pub(crate) struct Run {
    pub(crate) steps: Vec<Step>,
    pub(crate) worst: Worst,
    pub(crate) duration: f64,
}

/// Supplies the samples of one piece.
pub(crate) struct Source {
    next: usize,
    done: bool,
}

impl Source {
    pub(crate) fn new() -> Self {
        Self {
            next: 0,
            done: false,
        }
    }

    /// Pushes as many samples as there is room for, up to `most`; ends the path at its length.
    pub(crate) fn supply<const N: usize, const W: usize, const M: usize>(
        &mut self,
        feed: &mut Feed<N, W, M>,
        path: &Path<N>,
        course: &Course,
        most: usize,
    ) {
        for _ in 0..most {
            if self.done || feed.room() < 2 {
                return;
            }
            let s = self.next as f64 * course.grid;
            let result = if s < course.length - 1e-6 * course.grid || self.next == 0 {
                self.next += 1;
                feed.push(&path.sample(s))
            } else {
                self.done = true;
                let fraction = (course.length - (s - course.grid)) / course.grid;
                let last = path.sample(course.length);
                feed.end_piece(&last, if fraction < 1.0 { fraction } else { 1.0 })
                    .and_then(|()| feed.finish())
            };
            match result {
                Ok(()) => {}
                Err(PushError::Full) => return,
                Err(error) => panic!("{error} at {s}"),
            }
        }
    }
}

/// No run of these tests is longer.
const MOST_STEPS: usize = 40_000;

/// Runs to the end with an override for each step, looking 8000 times a second.
pub(crate) fn run<const N: usize, const W: usize, const M: usize>(
    path: &Path<N>,
    limits: &FeedLimits<N>,
    course: &Course,
    most_samples: usize,
    mut feed_override: impl FnMut(usize) -> f64,
) -> Run {
    let mut feed = Feed::<N, W, M>::new(limits, course.grid, course.step_s).unwrap();
    let mut source = Source::new();
    let mut worst = Worst::default();
    let looks = (course.step_s * 8000.0).round() as usize;
    let mut steps = Vec::new();
    for k in 0..MOST_STEPS {
        source.supply(&mut feed, path, course, most_samples);
        let step = feed.step(feed_override(k));
        for i in 0..=looks {
            let at = step.phase.at(course.step_s * i as f64 / looks as f64);
            assert!(
                at.p >= -1e-12 && at.p <= course.length * (1.0 + 1e-12),
                "off the path: {}",
                at.p
            );
            worst.look(path, limits, [at.p, at.v, at.a, at.j]);
        }
        let end = step.phase.at(course.step_s);
        // the cubic and the sums differ by rounding and, once, by the snap to a wall: 1e-9 of the grid
        let (ds, dv) = ((end.p - step.end.p).abs(), (end.v - step.end.v).abs());
        assert!(
            ds < 2e-9 * course.grid && dv < 1e-9,
            "a jump: {ds} {dv} {step:?}"
        );
        steps.push(step);
        if step.status == Status::Done {
            return Run {
                worst,
                duration: steps.len() as f64 * course.step_s,
                steps,
            };
        }
    }
    panic!("never done: {:?}", steps.last());
}
