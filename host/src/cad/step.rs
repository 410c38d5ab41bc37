//! What every reader makes of a file: moves and actions, whatever machine they were written for.

use super::nurbs::Nurbs;
use std::sync::Arc;

/// A step of a program.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// Its line in the file, from 1.
    pub line: u32,
    /// What is to be done.
    pub what: What,
}

/// What is to be done.
#[derive(Clone, Debug, PartialEq)]
pub enum What {
    /// The tool moves.
    Move(Move),
    /// Something is done at rest.
    Action(Action),
}

/// The tool goes from one point to another. Coordinates are those of the program, m.
#[derive(Clone, Debug, PartialEq)]
pub struct Move {
    /// Where it begins, m; of the first move, where it ends.
    pub from_m: [f64; 3],
    /// Where it ends, m.
    pub to_m: [f64; 3],
    /// How it gets there.
    pub shape: Shape,
    /// How fast.
    pub speed: Speed,
    /// How near to the program the tool must stay.
    pub keeping: Keeping,
}

/// The shape of a move.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// A straight line.
    Line,
    /// About a centre, in a plane of two axes, and evenly along the third if the ends differ there.
    Arc {
        /// The centre, m; its coordinate along the third axis says nothing.
        centre_m: [f64; 3],
        /// The axes of the plane, right-handed with the third: 0 is x.
        plane: [usize; 3],
        /// The angle from the first axis towards the second, rad; negative: the other way.
        angle_rad: f64,
    },
    /// A rational B-spline.
    Nurbs(Arc<Nurbs>),
}

/// The speed of a move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Speed {
    /// As fast as the machine goes without cutting.
    Rapid,
    /// So many m/s.
    Feed(f64),
}

/// How near to the program the tool must stay.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Keeping {
    /// As near as the task says.
    Task,
    /// Within so many metres.
    Within(f64),
    /// Exactly: the tool rests in every corner.
    Exact,
}

/// What is done while the tool rests.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Action {
    /// The spindle turns, or stands still.
    Spindle {
        /// Clockwise seen from above, or not; absent: it stands still.
        clockwise: Option<bool>,
        /// Revolutions per second.
        speed_rev_s: f64,
    },
    /// Nothing, for so many seconds.
    Dwell(f64),
    /// The program waits for the operator; if optional, only where the operator wants that.
    Stop {
        /// M1 instead of M0.
        optional: bool,
    },
    /// Another tool is put in.
    Tool(u32),
}

impl Move {
    /// The point at a share of the way, from 0 to 1, m. Of a spline the share is of the parameter.
    #[must_use]
    pub fn at(&self, share: f64) -> [f64; 3] {
        match &self.shape {
            Shape::Line => mix(&self.from_m, &self.to_m, share),
            Shape::Arc {
                centre_m,
                plane,
                angle_rad,
            } => turned(
                &self.from_m,
                &self.to_m,
                centre_m,
                *plane,
                angle_rad * share,
                share,
            ),
            Shape::Nurbs(curve) => curve.at(share),
        }
    }

    /// Length of the way, m; that of a spline is the polygon of [`Nurbs::POLYGON`] points on it.
    #[must_use]
    pub fn length_m(&self) -> f64 {
        match &self.shape {
            Shape::Line => distance(&self.from_m, &self.to_m),
            Shape::Arc {
                centre_m,
                plane: [a, b, n],
                angle_rad,
            } => {
                let part = |k: usize| get(&self.from_m, k) - get(centre_m, k);
                let along = get(&self.to_m, *n) - get(&self.from_m, *n);
                libm::hypot(libm::hypot(part(*a), part(*b)) * angle_rad, along)
            }
            Shape::Nurbs(curve) => curve.length_m(),
        }
    }

    /// Points of which a polygon differs from the way by less than a share of 1e-4 of its size: for boxes.
    pub(super) fn outline(&self) -> impl Iterator<Item = [f64; 3]> + '_ {
        let count = match &self.shape {
            Shape::Line => 1,
            // 1 − cos(π/360): 4e-5 of the radius
            Shape::Arc { angle_rad, .. } => {
                steps(angle_rad.abs() / (core::f64::consts::PI / 180.0))
            }
            Shape::Nurbs(curve) => curve.polygon(),
        };
        (0..=count).map(move |k| self.at(f64::from(k) / f64::from(count)))
    }
}

/// The number of steps of at most 1 that a length takes, at least 1 and at most a million.
pub(super) fn steps(length: f64) -> u32 {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "not negative; the conversion saturates"
    )]
    let count = libm::ceil(length) as u32;
    count.clamp(1, 1_000_000)
}

/// A coordinate; 0 if there is no such axis.
pub(super) fn get(point: &[f64; 3], axis: usize) -> f64 {
    point.get(axis).copied().unwrap_or_default()
}

/// Sets a coordinate.
pub(super) fn set(point: &mut [f64; 3], axis: usize, value: f64) {
    if let Some(place) = point.get_mut(axis) {
        *place = value;
    }
}

/// a + (b − a)·share
pub(super) fn mix(a: &[f64; 3], b: &[f64; 3], share: f64) -> [f64; 3] {
    core::array::from_fn(|k| get(a, k) * (1.0 - share) + get(b, k) * share)
}

/// The distance of two points, m.
pub(super) fn distance(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    let sum = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum();
    libm::sqrt(sum)
}

/// `from` turned about a centre by an angle, and so far along the axis of turning.
fn turned(
    from: &[f64; 3],
    to: &[f64; 3],
    centre: &[f64; 3],
    [a, b, n]: [usize; 3],
    angle: f64,
    share: f64,
) -> [f64; 3] {
    if share >= 1.0 {
        return *to;
    }
    let (u, v) = (get(from, a) - get(centre, a), get(from, b) - get(centre, b));
    let (sin, cos) = (libm::sin(angle), libm::cos(angle));
    let mut at = mix(from, to, share);
    set(&mut at, a, get(centre, a) + u * cos - v * sin);
    set(&mut at, b, get(centre, b) + u * sin + v * cos);
    set(
        &mut at,
        n,
        get(from, n) * (1.0 - share) + get(to, n) * share,
    );
    at
}
