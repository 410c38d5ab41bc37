//! When the farthest motion reaches a distance.
//!
//! The farthest distance is a smooth function of the time with pieces: no limit of acceleration met, one,
//! both, and the velocity limit. With c as in [`super::farthest`] (dT = 2·dc), and the slope
//! w = d(distance)/dT integrated, each piece is a polynomial:
//!
//! ```text
//! no limit:       w = v0 − a0²/2 + (K²/c² + 4K + 3c²)/8
//! peak limited:   w = v1 − a1²/2 + (A² − 3Ax + 2x²)/2,   x² = 2Ac − K,   x = A − ω
//! valley limited: w = v0 − a0²/2 + (B² − 3By + 2y²)/2,   y² = 2Bc + K,   y = α + B
//! both:           w linear in c
//! velocity limit: w = v_up
//! ```
//!
//! Once the acceleration passes zero from above (c² ≥ |K| without limits) w grows: there the curve is
//! convex, and Newton's iteration from above cannot miss. Before that w may fall first.

use super::earliest::allowance;
use super::farthest::{Farthest, Full, Upward};
use crate::scalar::{cube_root, larger, smaller};

/// More iterations than bisection needs from any bracket that double precision can hold.
const MOST_BISECTIONS: u32 = 128;
/// Newton's iteration on a convex polynomial of degree 4 from a bracket: at worst the error shrinks to
/// 3/4 a step until it is small; the guesses below leave a few steps.
const MOST_NEWTON: u32 = 64;

/// The search for the time at which the farthest motion reaches the distance.
pub(super) struct Search<'a> {
    pub(super) side: &'a Upward,
    /// End of the times in which the ends can be joined.
    pub(super) end: f64,
}

/// A point of the curve farthest distance over time, relative to the distance asked.
#[derive(Clone, Copy)]
struct Point {
    time: f64,
    /// Positive: too far.
    over: f64,
    slope: f64,
}

impl Search<'_> {
    fn relative(&self, time: f64, farthest: &Farthest) -> Point {
        Point {
            time,
            over: farthest.distance - self.side.task.distance,
            slope: farthest.slope,
        }
    }

    fn point(&self, full: &Full, time: f64) -> Point {
        self.relative(time, &self.side.in_time_below(full, time))
    }

    fn c(&self, time: f64) -> f64 {
        0.5 * (time + (self.side.task.a0 - self.side.task.a1))
    }

    fn time(&self, c: f64) -> f64 {
        2.0 * c + (self.side.task.a1 - self.side.task.a0)
    }

    /// The first time after `time`, where the farthest motion is too near, at which it is not.
    pub(super) fn beyond(&self, time: f64, farthest: &Farthest) -> Option<f64> {
        let task = &self.side.task;
        let full = self.side.full();
        let mut low = self.relative(time, farthest);
        if time < smaller(full.time, self.end) {
            let crossing = self.time(self.crossing());
            if time < crossing {
                let last = smaller(smaller(crossing, self.end), full.time);
                match self.before_crossing(&full, low, last) {
                    Ok(found) => return Some(found),
                    Err(point) => low = point,
                }
            }
        }
        if self.end <= full.time {
            return None;
        }
        let over = full.distance() - task.distance;
        if over <= 0.0 || low.time >= full.time {
            let from = if low.time >= full.time {
                low.time - low.over / task.v_up
            } else {
                full.time - over / task.v_up
            };
            return Some(from).filter(|t| t.is_finite());
        }
        let high = Point {
            time: full.time,
            over,
            slope: task.v_up,
        };
        Some(self.convex(&full, low, high))
    }

    /// Where the acceleration begins to pass zero from above.
    fn crossing(&self) -> f64 {
        let (k, a_up, a_down) = (self.side.k, self.side.task.a_up, self.side.task.a_down);
        let (size, limit) = if k > 0.0 { (k, a_up) } else { (-k, a_down) };
        if size <= limit * limit {
            libm::sqrt(size)
        } else {
            0.5 * (limit + size / limit)
        }
    }

    /// The root up to `last`, where the acceleration keeps its sign; else the point at `last`.
    fn before_crossing(&self, full: &Full, low: Point, last: f64) -> Result<f64, Point> {
        // The curve can rise, fall, and rise again, if the velocity becomes negative: look at the first top.
        if low.slope > 0.0 && self.lowest_velocity() < 0.0 {
            for top in self.tops().into_iter().flatten() {
                if top > low.time && top < last {
                    let top = self.point(full, top);
                    if top.over >= 0.0 {
                        return Ok(self.bracketed(full, low, top));
                    }
                }
            }
        }
        let high = self.point(full, last);
        if high.over >= 0.0 {
            Ok(self.bracketed(full, low, high))
        } else {
            Err(high)
        }
    }

    /// The lowest velocity of a motion whose acceleration keeps its sign between peak and valley: at an end,
    /// or where the acceleration of an end was or comes to be zero.
    fn lowest_velocity(&self) -> f64 {
        let task = &self.side.task;
        let (from, to) = (smaller(task.a0, 0.0), larger(task.a1, 0.0));
        smaller(task.v0 - 0.5 * from * from, task.v1 - 0.5 * to * to)
    }

    /// Where the slopes of the pieces (head of this file) become negative, in ascending order.
    fn tops(&self) -> [Option<f64>; 2] {
        let (task, k) = (&self.side.task, self.side.k);
        let base = task.v0 - 0.5 * task.a0 * task.a0;
        // 3q² + (4K + 8·base)·q + K² = 0 with q = c²
        let half = 2.0 * k + 4.0 * base;
        let square = half * half - 3.0 * k * k;
        let free = (half < 0.0 && square >= 0.0)
            .then(|| self.time(libm::sqrt(k * k / (libm::sqrt(square) - half))));
        // 2x² − 3Ax + A² + 2·base = 0, and the same for the valley
        let (limit, k, base) = if k > 0.0 {
            (task.a_up, k, task.v1 - 0.5 * task.a1 * task.a1)
        } else {
            (task.a_down, -k, base)
        };
        let square = limit * limit - 16.0 * base;
        let limited = (square >= 0.0).then(|| {
            let x = 0.25 * (3.0 * limit - libm::sqrt(square));
            self.time(0.5 * (x * x + k) / limit)
        });
        match (free, limited) {
            (Some(a), Some(b)) if b < a => [limited, free],
            _ => [free, limited],
        }
    }

    /// A root between two points of which only the signs are known, and that the curve is smooth.
    fn bracketed(&self, full: &Full, mut low: Point, mut high: Point) -> f64 {
        let mut width = high.time - low.time;
        for i in 0..MOST_BISECTIONS {
            if high.over <= allowance(&self.side.task, high.time, high.slope)
                || width <= 2.0 * f64::EPSILON * high.time
            {
                break;
            }
            // every third step halves, whatever the guess does
            let guess = if i % 3 == 2 {
                low.time + 0.5 * width
            } else {
                guess(&low, &high)
            };
            let middle = self.point(full, guess);
            if libm::fabs(middle.over) <= allowance(&self.side.task, guess, middle.slope) {
                return guess;
            }
            if middle.over >= 0.0 {
                high = middle;
            } else {
                low = middle;
            }
            width = high.time - low.time;
        }
        high.time
    }

    /// The root between points at which the curve is convex: after the crossing.
    fn convex(&self, full: &Full, low: Point, high: Point) -> f64 {
        let (k, a_up, a_down) = (self.side.k, self.side.task.a_up, self.side.task.a_down);
        let (c_low, c_high) = (self.c(low.time), self.c(high.time));
        let never = f64::INFINITY;
        let peak_from = if k <= a_up * a_up {
            a_up + libm::sqrt(a_up * a_up - k)
        } else {
            c_low
        };
        let valley_from = if -k <= a_down * a_down {
            a_down + libm::sqrt(a_down * a_down + k)
        } else {
            c_low
        };
        let peak_first = peak_from <= valley_from;
        let one_from = smaller(if peak_first { peak_from } else { valley_from }, c_high);
        let span = a_up + a_down;
        let both_from = if peak_first {
            0.5 * (k + span * span) / a_up
        } else {
            0.5 * (span * span - k) / a_down
        };
        let both_from = smaller(larger(both_from, one_from), c_high);
        let mut at = low;
        let mut c = c_low;
        if c < one_from {
            let piece = Free::through(self.side, c, &at);
            let end = piece.at(one_from);
            if end >= 0.0 {
                return self.polished(full, &low, &high, self.time(piece.root(c, &at, one_from)));
            }
            (c, at) = (
                one_from,
                Point {
                    time: self.time(one_from),
                    over: end,
                    slope: piece.slope(one_from),
                },
            );
        }
        if c < both_from {
            let piece = Limited::through(self.side, peak_first, c, &at);
            let x_end = piece.x(both_from);
            let end = piece.at(x_end);
            if end >= 0.0 {
                return self.polished(full, &low, &high, self.time(piece.root(c, &at, both_from)));
            }
            (c, at) = (
                both_from,
                Point {
                    time: self.time(both_from),
                    over: end,
                    slope: piece.slope(x_end),
                },
            );
        }
        let _ = (c, never);
        // the slope grows linearly to its value where the velocity limit is met
        let length = high.time - at.time;
        let top_slope = 2.0 * (high.over - at.over) / length - at.slope;
        let bend = (top_slope - at.slope) / length;
        let discriminant = larger(at.slope * at.slope - 2.0 * bend * at.over, 0.0);
        let step = -2.0 * at.over / (at.slope + libm::sqrt(discriminant));
        self.polished(full, &low, &high, at.time + step)
    }

    /// The root of a piece is off by the rounding of its coefficients: a step or two on the curve itself.
    fn polished(&self, full: &Full, low: &Point, high: &Point, mut time: f64) -> f64 {
        for _ in 0..3 {
            let found = self.point(full, time);
            if libm::fabs(found.over) <= allowance(&self.side.task, time, found.slope) {
                return time;
            }
            let better = time - found.over / found.slope;
            if !(found.slope > 0.0 && better >= low.time && better <= high.time) {
                break;
            }
            time = better;
        }
        self.bracketed(full, *low, *high)
    }
}

/// A piece on which no limit of acceleration is met, as distance over c.
struct Free {
    /// distance = 2·half·c − k²/(4c) + c³/4 + constant
    half: f64,
    k2: f64,
    constant: f64,
}

impl Free {
    fn through(side: &Upward, c: f64, point: &Point) -> Self {
        let mut piece = Self {
            half: side.task.v0 - 0.5 * side.task.a0 * side.task.a0 + 0.5 * side.k,
            k2: side.k * side.k,
            constant: 0.0,
        };
        piece.constant = point.over - piece.at(c);
        piece
    }

    fn inverse(&self, c: f64) -> f64 {
        // without K there is no pole at c = 0
        if self.k2 > 0.0 { self.k2 / c } else { 0.0 }
    }

    fn at(&self, c: f64) -> f64 {
        c * (2.0 * self.half + 0.25 * c * c) - 0.25 * self.inverse(c) + self.constant
    }

    fn slope(&self, c: f64) -> f64 {
        self.half + 0.125 * (self.inverse(c) / c + 3.0 * c * c)
    }

    /// The root between `low`, below it, and `high`, above.
    fn root(&self, low: f64, at_low: &Point, high: f64) -> f64 {
        let mut c = smaller(low + 0.5 * above(-at_low.over, at_low.slope), high);
        for _ in 0..MOST_NEWTON {
            let step = self.at(c) / (2.0 * self.slope(c));
            let next = c - step;
            if !(next < c && next > low) {
                break;
            }
            c = next;
            if step <= 1e-9 * c {
                // quadratic convergence: the next step would be in the rounding
                c -= self.at(c) / (2.0 * self.slope(c));
                break;
            }
        }
        c
    }
}

/// An upper bound of how much later the distance is met: the root of x³/32 + slope·x = missing.
///
/// The curve exceeds this cubic where no limit is met and the acceleration passes zero.
fn above(missing: f64, slope: f64) -> f64 {
    let mut x = cube_root(32.0 * missing);
    if slope > 0.0 {
        x = smaller(x, missing / slope);
    } else if slope < 0.0 {
        x += libm::sqrt(-32.0 * slope);
    } else {
        return x;
    }
    for _ in 0..2 {
        let f = x * (x * x / 32.0 + slope) - missing;
        let f1 = 3.0 * x * x / 32.0 + slope;
        if f <= 0.0 || f1 <= 0.0 {
            break;
        }
        x -= f / f1;
    }
    x
}

/// A piece on which one acceleration limit is met, as distance over x = peak − valley.
struct Limited {
    limit: f64,
    /// ±K: x² = 2·limit·c − k
    k: f64,
    /// w = base + x·(x − 1.5·limit)
    base: f64,
    constant: f64,
}

impl Limited {
    fn through(side: &Upward, peak: bool, c: f64, point: &Point) -> Self {
        let task = &side.task;
        let (limit, k, v, a) = if peak {
            (task.a_up, side.k, task.v1, task.a1)
        } else {
            (task.a_down, -side.k, task.v0, task.a0)
        };
        let mut piece = Self {
            limit,
            k,
            base: v + 0.5 * (limit * limit - a * a),
            constant: 0.0,
        };
        piece.constant = point.over - piece.at(piece.x(c));
        piece
    }

    fn x(&self, c: f64) -> f64 {
        libm::sqrt(larger(2.0 * self.limit * c - self.k, 0.0))
    }

    fn slope(&self, x: f64) -> f64 {
        self.base + x * (x - 1.5 * self.limit)
    }

    /// ∫w dT, dT = 2x/limit·dx
    fn at(&self, x: f64) -> f64 {
        x * x * (self.base + x * (0.5 * x - self.limit)) / self.limit + self.constant
    }

    /// c of the root between `low`, below it, and `high`, above.
    fn root(&self, low: f64, at_low: &Point, high: f64) -> f64 {
        let (from, to) = (self.x(low), self.x(high));
        // by the inverse cubic through both ends, where it rises at both
        let (slope_low, slope_high) = (at_low.slope, self.slope(to));
        let mut x = to;
        if slope_low > 0.0 {
            let rise = self.at(to) - at_low.over;
            let u = -at_low.over / rise;
            let w = 1.0 - u;
            let per = 0.5 * self.limit * rise;
            let (d0, d1) = (per / (from * slope_low), per / (to * slope_high));
            let guess = from + u * u * (3.0 - 2.0 * u) * (to - from) + u * w * (w * d0 - u * d1);
            if guess > from && guess < to {
                x = guess;
            }
        }
        for _ in 0..MOST_NEWTON {
            let step = self.at(x) * self.limit / (2.0 * x * self.slope(x));
            let next = x - step;
            if !(next > from && next <= to) {
                break;
            }
            x = next;
            if libm::fabs(step) <= 1e-9 * x {
                break;
            }
        }
        0.5 * (x * x + self.k) / self.limit
    }
}

/// A time between both, near the root.
fn guess(low: &Point, high: &Point) -> f64 {
    let width = high.time - low.time;
    let newton = if high.over < -low.over || low.slope <= 0.0 {
        high.time - high.over / high.slope
    } else {
        low.time - low.over / low.slope
    };
    let inverse = if low.slope > 0.0 && high.slope > 0.0 {
        // the cubic T(over) with both slopes dT/d(over), at over = 0
        let rise = high.over - low.over;
        let u = -low.over / rise;
        let (d0, d1) = (rise / low.slope, rise / high.slope);
        let w = 1.0 - u;
        low.time + u * u * (3.0 - 2.0 * u) * width + u * w * (w * d0 - u * d1)
    } else {
        newton
    };
    if inverse > low.time && inverse < high.time {
        inverse
    } else if newton > low.time && newton < high.time {
        newton
    } else {
        low.time + 0.5 * width
    }
}
