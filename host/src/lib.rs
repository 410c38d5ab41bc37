//! The Master Process `C_0`, the keeping of nodes, tasks and their plans, paths from files and drawings, summaries and plots.
#![forbid(unsafe_code)]

pub mod cad;
pub mod error;
pub mod input;
pub mod instruct;
pub mod maintenance;
pub mod mp;
pub mod path;
pub mod plot;
pub mod program;
pub mod record;
pub mod summary;
pub mod task;
pub mod trj;
