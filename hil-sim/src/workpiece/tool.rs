//! What cuts: the shape of a rotating cutter, and what of the tool must never touch.

/// The cutting end of a tool, as the solid that its edges sweep when it turns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cutter {
    /// A flat end mill: a cylinder.
    Flat {
        /// Diameter, m.
        diameter_m: f64,
    },
    /// A ball-end mill: a hemisphere below a cylinder.
    Ball {
        /// Diameter, m.
        diameter_m: f64,
    },
    /// A V-bit or engraving cutter: a cone with a flat tip, as high as the cutting length.
    V {
        /// Diameter of the flat tip, m; 0 is a point.
        tip_m: f64,
        /// Angle between opposite edges (the included angle), rad.
        angle_rad: f64,
    },
}

/// What is above the cutting end, along the axis of the tool: none of it may touch the board.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shank {
    /// From the tip to the end of the edges, m.
    pub cutting_length_m: f64,
    /// Diameter of the shank, from the end of the edges up to the holder, m.
    pub diameter_m: f64,
    /// From the tip to the holder, m; at least the cutting length.
    pub stick_out_m: f64,
    /// Diameter of the holder, m.
    pub holder_diameter_m: f64,
}

/// Why there is no such tool.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ToolError {
    /// A length that must be positive and finite is not.
    #[error("{what} of a tool: expected more than 0 and at most {LARGEST_M} m, got {got} m")]
    Length {
        /// Which.
        what: &'static str,
        /// Its value, m.
        got: f64,
    },
    /// The included angle of a V-bit.
    #[error("angle of a V-bit: expected 0.1 to 3.0 rad, got {got} rad")]
    Angle {
        /// Its value, rad.
        got: f64,
    },
    /// The edges of a ball-end mill must reach up to its equator.
    #[error(
        "cutting length of a ball-end mill: expected at least its radius {radius_m} m, got {got} m"
    )]
    ShortBall {
        /// The radius, m.
        radius_m: f64,
        /// The cutting length, m.
        got: f64,
    },
    /// The holder begins where the edges are.
    #[error("stick-out of a tool: expected at least its cutting length {cutting_m} m, got {got} m")]
    StickOut {
        /// The cutting length, m.
        cutting_m: f64,
        /// The stick-out, m.
        got: f64,
    },
}

/// How long a holder is taken to be, m: what is above it is not over the board.
pub(super) const HOLDER_M: f64 = 0.3;

/// No length of a tool is greater, m.
pub const LARGEST_M: f64 = 1.0;

/// A tool: its cutting end, checked, as numbers that are quick to work with.
///
/// The tip is the lowest point of the axis. Heights along the axis count from the tip towards the shank.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tool {
    pub(super) profile: Profile,
    /// Largest radius of the cutting end, m.
    pub(super) radius_m: f64,
    pub(super) shank: Shank,
}

/// The height h(r) of the cutting end above the tip: convex and never falling with the radius r.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Profile {
    /// h = 0
    Flat,
    /// h = R − √(R² − r²)
    Ball,
    /// h = slope·(r − tip) beyond the radius of the tip; slope = 1/tan(half the included angle).
    V { tip_radius_m: f64, slope: f64 },
}

impl Tool {
    /// A tool.
    ///
    /// # Errors
    /// [`ToolError`]: a length that is not positive, an angle that is none, parts in the wrong order.
    pub fn new(cutter: Cutter, shank: Shank) -> Result<Self, ToolError> {
        let cutting = length("cutting length", shank.cutting_length_m)?;
        length("shank diameter", shank.diameter_m)?;
        length("stick-out", shank.stick_out_m)?;
        length("holder diameter", shank.holder_diameter_m)?;
        if shank.stick_out_m < cutting {
            return Err(ToolError::StickOut {
                cutting_m: cutting,
                got: shank.stick_out_m,
            });
        }
        let (profile, radius_m) = match cutter {
            Cutter::Flat { diameter_m } => (Profile::Flat, 0.5 * length("diameter", diameter_m)?),
            Cutter::Ball { diameter_m } => {
                let radius_m = 0.5 * length("diameter", diameter_m)?;
                if cutting < radius_m {
                    return Err(ToolError::ShortBall {
                        radius_m,
                        got: cutting,
                    });
                }
                (Profile::Ball, radius_m)
            }
            Cutter::V { tip_m, angle_rad } => {
                if !(0.1..=3.0).contains(&angle_rad) {
                    return Err(ToolError::Angle { got: angle_rad });
                }
                if !(0.0..=LARGEST_M).contains(&tip_m) {
                    return Err(ToolError::Length {
                        what: "tip diameter",
                        got: tip_m,
                    });
                }
                let widening = libm::tan(0.5 * angle_rad);
                let profile = Profile::V {
                    tip_radius_m: 0.5 * tip_m,
                    slope: 1.0 / widening,
                };
                let radius_m = 0.5 * tip_m + cutting * widening;
                (profile, 0.5 * length("greatest diameter", 2.0 * radius_m)?)
            }
        };
        Ok(Self {
            profile,
            radius_m,
            shank,
        })
    }

    /// No point of the tool is farther from its tip, m.
    pub(super) fn reach_m(&self) -> f64 {
        let shank = &self.shank;
        shank.stick_out_m + HOLDER_M + self.radius_m + shank.diameter_m + shank.holder_diameter_m
    }

    /// The height of the cutting end above the tip at a distance from the axis (m), m; none beyond
    /// its largest radius.
    #[must_use]
    pub fn height_m(&self, distance_m: f64) -> Option<f64> {
        let r = distance_m.abs();
        (r <= self.radius_m).then(|| match self.profile {
            Profile::Ball => self.radius_m - libm::sqrt(self.radius_m * self.radius_m - r * r),
            Profile::V {
                tip_radius_m,
                slope,
            } if r > tip_radius_m => slope * (r - tip_radius_m),
            Profile::Flat | Profile::V { .. } => 0.0,
        })
    }

    /// The radius of the cutting end at a height above the tip (m, not negative), m.
    #[must_use]
    pub fn radius_at_m(&self, height_m: f64) -> f64 {
        let full = self.radius_m;
        match self.profile {
            Profile::Ball if height_m < full => libm::sqrt(height_m * (2.0 * full - height_m)),
            Profile::V {
                tip_radius_m,
                slope,
            } if tip_radius_m + height_m / slope < full => tip_radius_m + height_m / slope,
            Profile::Flat | Profile::Ball | Profile::V { .. } => full,
        }
    }
}

fn length(what: &'static str, got: f64) -> Result<f64, ToolError> {
    if got > 0.0 && got <= LARGEST_M {
        Ok(got)
    } else {
        Err(ToolError::Length { what, got })
    }
}
