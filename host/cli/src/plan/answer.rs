//! The JSON of `mrroc plan profile`.

use motion::profile::Phase;
use serde::Serialize;

use super::motion::{Motion, NoMotion};

/// An answer, written as one object.
#[derive(Debug, Serialize)]
#[serde(untagged)]
pub(super) enum Answer {
    Motion {
        duration_s: f64,
        axes: Vec<Vec<PhaseAnswer>>,
    },
    None {
        error: &'static str,
        #[serde(skip_serializing_if = "Option::is_none")]
        axis: Option<usize>,
        message: String,
    },
}

#[derive(Debug, Serialize)]
pub(super) struct PhaseAnswer {
    t: f64,
    j: f64,
    a0: f64,
    v0: f64,
    p0: f64,
}

impl From<&Phase> for PhaseAnswer {
    fn from(phase: &Phase) -> Self {
        let Phase { t, j, a0, v0, p0 } = *phase;
        Self { t, j, a0, v0, p0 }
    }
}

impl From<&Motion> for Answer {
    fn from(motion: &Motion) -> Self {
        let axes = motion.axes.iter();
        Self::Motion {
            duration_s: motion.duration,
            axes: axes
                .map(|phases| phases.iter().map(PhaseAnswer::from).collect())
                .collect(),
        }
    }
}

impl From<&NoMotion> for Answer {
    fn from(error: &NoMotion) -> Self {
        Self::None {
            error: error.code(),
            axis: error.axis(),
            message: error.to_string(),
        }
    }
}
