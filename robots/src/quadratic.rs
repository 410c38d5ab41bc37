//! A gear whose coordinate is a quadratic of the motor's travel: x = c0 + c1·m + c2·m².
//!
//! The machine lives on the branch that contains m = 0, where dx/dm has the sign of c1; the other
//! begins at the vertex m = −c1/(2·c2), a dead centre. With D = c1² − 4·c2·(c0 − x) the slope on that
//! branch is dx/dm = c1 + 2·c2·m = ±√D, so
//!
//! ```text
//!   m = 2·(x − c0)/(c1 ± √D)    m' = 1/(±√D) = g    m'' = −2·c2·g³    m''' = 12·c2²·g⁵
//! ```
//!
//! (the root in the form that does not cancel at x = c0). |m'| and |m''| fall with the distance from
//! the vertex, so over an interval their extremes are at its ends.

use crate::error::Quantity;
use crate::screw::{OutOfRange, Travel};

/// x = c0 + c1·m + c2·m², with c1 and c2 not 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quadratic {
    /// c0: x at no travel, m or rad.
    pub constant: f64,
    /// c1, m/rad or rad/rad.
    pub linear: f64,
    /// c2, m/rad² or rad/rad².
    pub square: f64,
}

impl Quadratic {
    /// The travel at the dead centre, rad.
    #[must_use]
    pub fn vertex(&self) -> f64 {
        -0.5 * self.linear / self.square
    }

    /// x at the dead centre, m or rad.
    #[must_use]
    pub fn extreme(&self) -> f64 {
        self.constant + 0.5 * self.linear * self.vertex()
    }

    /// Motor travel at `x`, with its derivatives.
    pub(crate) fn travel(&self, x: f64) -> Result<Travel, OutOfRange> {
        let square = self.linear * self.linear - 4.0 * self.square * (self.constant - x);
        if !(square > 0.0 && square.is_finite()) {
            let extreme = self.extreme();
            let (lower, upper) = if self.square > 0.0 {
                (extreme, f64::INFINITY)
            } else {
                (f64::NEG_INFINITY, extreme)
            };
            return Err(OutOfRange {
                quantity: Quantity::Joint,
                value: x,
                lower,
                upper,
            });
        }
        let slope = if self.linear < 0.0 {
            -libm::sqrt(square)
        } else {
            libm::sqrt(square)
        };
        let g = 1.0 / slope;
        Ok(Travel {
            travel: 2.0 * (x - self.constant) / (self.linear + slope),
            first: g,
            second: -2.0 * self.square * g * g * g,
            third: 12.0 * self.square * self.square * g * g * g * g * g,
        })
    }

    /// x at a motor travel, rad.
    pub(crate) fn position(&self, travel: f64) -> Result<f64, OutOfRange> {
        let slope = self.linear + 2.0 * self.square * travel;
        if !(slope * self.linear > 0.0 && slope.is_finite()) {
            let vertex = self.vertex();
            let (lower, upper) = if vertex < 0.0 {
                (vertex, f64::INFINITY)
            } else {
                (f64::NEG_INFINITY, vertex)
            };
            return Err(OutOfRange {
                quantity: Quantity::Motor,
                value: travel,
                lower,
                upper,
            });
        }
        Ok(self.constant + travel * (self.linear + self.square * travel))
    }

    /// The least and greatest dm/dx for x between `a` and `b`.
    pub(crate) fn slopes(&self, a: f64, b: f64) -> Result<(f64, f64), OutOfRange> {
        let (a, b) = (self.travel(a)?.first, self.travel(b)?.first);
        Ok(if a < b { (a, b) } else { (b, a) })
    }

    /// The greatest |d²m/dx²| for x between `a` and `b`.
    pub(crate) fn curvature(&self, a: f64, b: f64) -> Result<f64, OutOfRange> {
        let (a, b) = (self.travel(a)?.second.abs(), self.travel(b)?.second.abs());
        Ok(if a < b { b } else { a })
    }
}
