//! How a streamed path is followed, by its set-points.

use super::{distance, raise};
use host::path::Streamed;
use host::summary::PathSummary;
use nalgebra::Vector3;
use protocol::time::Micros;
use std::sync::Arc;

/// Two set-points this near to each other are the same, m: the tool's way of a few units of the drives.
const STILL_M: f64 = 2e-7;

/// A path under way, or behind.
#[derive(Debug)]
pub(crate) struct Following {
    streamed: Arc<Streamed>,
    /// When it was told first of, and when its set-points moved first and last.
    pub(crate) begun: Option<Micros>,
    moved: Option<(Micros, Micros)>,
    /// The set-point before: servo step and position.
    before: Option<(u32, Vector3<f64>)>,
    way_m: f64,
    fastest_m_s: Option<f64>,
    error_m: Option<f64>,
}

impl Following {
    pub(crate) const fn new(streamed: Arc<Streamed>) -> Self {
        Self {
            streamed,
            begun: None,
            moved: None,
            before: None,
            way_m: 0.0,
            fastest_m_s: None,
            error_m: None,
        }
    }

    /// The set-point of a servo step of `step_s` seconds: position of the tool in the base frame, m,
    /// and its distance from the curve.
    pub(crate) fn setpoint(
        &mut self,
        at: Micros,
        step: u32,
        step_s: f64,
        position: &Vector3<f64>,
        deviation: Option<f64>,
    ) {
        self.begun.get_or_insert(at);
        raise(&mut self.error_m, deviation);
        let Some((before, from)) = self.before.replace((step, *position)) else {
            return;
        };
        let steps = step.wrapping_sub(before);
        let way = distance(&from, position);
        if steps == 0 || way <= STILL_M {
            return;
        }
        let (first, _) = *self.moved.get_or_insert((at, at));
        self.moved = Some((first, at));
        self.way_m += way;
        raise(
            &mut self.fastest_m_s,
            Some(way / (f64::from(steps) * step_s)),
        );
    }

    pub(crate) fn summary(&self) -> PathSummary {
        let moving_s = self
            .moved
            .map(|(first, last)| last.since(first).as_secs_f64())
            .filter(|span| *span > 0.0);
        PathSummary {
            points: self.streamed.marks.len(),
            length_m: self.streamed.course.length_m(),
            moving_s,
            feed_mean_m_s: moving_s.map(|span| self.way_m / span),
            feed_max_m_s: self.fastest_m_s,
            setpoint_path_error_max_m: self.error_m,
        }
    }
}

#[cfg(test)]
mod test {
    use super::*;
    use host::path::{Goal, Mark, Reference, SHARP, ToolPath, Way};
    use motion::Pose;

    #[test]
    fn feed_and_time_are_those_of_the_setpoints_that_move() {
        let mark = Mark {
            line: 1,
            way: Way::Line { corner: SHARP },
            to: Goal {
                position_m: [0.1, 0.0, 0.0],
                rotation_rad: None,
            },
            feed_m_s: None,
        };
        let path = ToolPath {
            file: None,
            marks: vec![mark],
        };
        let streamed = path.from(&Pose::identity(), Reference::Base).unwrap();
        let mut following = Following::new(Arc::new(streamed));
        assert_eq!(following.summary().moving_s, None);
        // 50 steps at rest, 500 at 0.1 m/s, every other one lost, 50 at rest
        for k in 0..600_u32 {
            let moved = f64::from(k.clamp(50, 550) - 50);
            if k % 2 == 0 {
                let at = Vector3::new(2e-4 * moved, 0.0, 0.0);
                following.setpoint(Micros(2000 * u64::from(k)), k, 2e-3, &at, Some(1e-9));
            }
        }
        let summary = following.summary();
        assert_eq!(summary.points, 1);
        assert!((summary.length_m - 0.1).abs() < 1e-12);
        // 500 steps, seen from the end of the first pair
        assert!((summary.moving_s.unwrap() - 0.996).abs() < 1e-9);
        let max = summary.feed_max_m_s.unwrap();
        assert!((max - 0.1).abs() < 1e-9, "{max}");
        assert_eq!(summary.setpoint_path_error_max_m, Some(1e-9));
    }
}
