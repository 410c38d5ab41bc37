//! `mrroc plan`: motions without a robot: of axes, each proved before it is told, and of a tool along a
//! path, as the robot's node would choose them (`path`); and what is in a program or drawing (`cad`).
//!
//! Of `profile`: positions are in any unit, rad or m; velocities, accelerations and jerks in it per s, s² and s³;
//! times in s.
//!
//! ```text
//!   profile  {"p0":[…],"p1":[…],"v_max":[…],"a_max":[…],"j_max":[…]}, and if wanted
//!            "v0" "a0" "v1" "a1" "v_min" "a_min" "p_min" "p_max" "sync" "minimum_duration"
//!              → {"duration_s":…,"axes":[[{"t":…,"j":…,"a0":…,"v0":…,"p0":…},…],…]}
//!   without a motion → {"error":"end-outside-limits"|…,"axis":0,"message":"…"}
//! ```
//!
//! A phase lasts `t` with jerk `j`; `a0`, `v0` and `p0` are where it begins. Axes count from 0 in JSON
//! and from 1 in words.

mod answer;
mod cad;
mod case;
mod error;
mod line;
mod motion;
mod path;
mod profile;
mod table;
#[cfg(test)]
mod test;

use std::io::{BufRead, Write};

use clap::{Args, Subcommand};

use cad::Cad;
pub(crate) use error::PlanError;
use path::PathPlan;
use profile::Profile;

/// Plans of motion
#[derive(Debug, Args)]
pub(crate) struct Plan {
    #[command(subcommand)]
    what: What,
}

#[derive(Debug, Subcommand)]
enum What {
    Profile(Box<Profile>),
    Path(PathPlan),
    Cad(Cad),
}

impl Plan {
    /// Plans what the flags ask for, or every line of `input`.
    ///
    /// # Errors
    /// [`PlanError`]; lines without a motion are answers, lines that cannot be read are reported after
    /// the last one.
    pub(crate) fn run(self, out: &mut dyn Write, input: &mut dyn BufRead) -> Result<(), PlanError> {
        match self.what {
            What::Profile(profile) => profile.run(out, input),
            What::Path(path) => path.run(out),
            What::Cad(cad) => cad.run(out),
        }
    }
}
