//! The JSON of `mrroc kin`: cases in, answers out.

use clap::Args;
use robots::KinematicError;
use serde::{Deserialize, Serialize};

/// A case of `fk`, `motors` and `jacobian`, by a line or by flags.
#[derive(Args, Debug, Deserialize)]
#[group(conflicts_with = "jsonl")]
#[serde(deny_unknown_fields)]
pub(super) struct JointsCase {
    /// Joint positions, rad or m, separated by commas
    #[arg(long, value_delimiter = ',', allow_hyphen_values = true)]
    pub(super) joints: Vec<f64>,
}

/// A case of `joints`, by a line or by flags.
#[derive(Args, Debug, Deserialize)]
#[group(conflicts_with = "jsonl")]
#[serde(deny_unknown_fields)]
pub(super) struct MotorsCase {
    /// Motor angles, rad, separated by commas
    #[arg(long, value_delimiter = ',', allow_hyphen_values = true)]
    pub(super) motors: Vec<f64>,
}

/// A case of `ik`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PoseCase {
    pub(super) position_m: [f64; 3],
    /// By rows.
    pub(super) rotation: [[f64; 3]; 3],
    pub(super) near: Vec<f64>,
}

#[derive(Debug, Serialize)]
#[serde(untagged)]
pub(super) enum Answer {
    Pose {
        position_m: [f64; 3],
        rotation: [[f64; 3]; 3],
    },
    Inverse {
        branches: Vec<Vec<f64>>,
        nearest: Vec<f64>,
    },
    Motors {
        motors: Vec<f64>,
    },
    Joints {
        joints: Vec<f64>,
    },
    Jacobian {
        jacobian: Vec<Vec<f64>>,
    },
    Limit {
        error: &'static str,
        quantity: &'static str,
        axis: usize,
        name: &'static str,
        value: f64,
        lower: f64,
        upper: f64,
    },
    None {
        error: &'static str,
        message: String,
    },
}

impl From<&KinematicError> for Answer {
    fn from(error: &KinematicError) -> Self {
        match *error {
            KinematicError::Limit {
                axis,
                name,
                quantity,
                value,
                lower,
                upper,
            } => Self::Limit {
                error: error.code(),
                quantity: quantity.name(),
                axis,
                name,
                value,
                lower,
                upper,
            },
            KinematicError::NotFinite
            | KinematicError::NotARotation { .. }
            | KinematicError::Unreachable
            | KinematicError::Singular => Self::None {
                error: error.code(),
                message: error.to_string(),
            },
        }
    }
}
