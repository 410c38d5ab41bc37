//! What went over the buses of a run, and all that its replay needs, as an MCAP file
//! (<https://mcap.dev/spec>), which the field's viewers open.
//!
//! | topic | message |
//! |---|---|
//! | `/bus/NAME` | [`Event::Frame`]: a frame at its end, `mrroc_msgs/msg/CanFrame` |
//! | `/mp/steps` | [`Event::Step`]: a step of the Master Process, `mrroc_msgs/msg/MasterStep` |
//! | `/ROBOT/joint_states` | what a node says of its joints, `sensor_msgs/msg/JointState`, for viewers |
//!
//! Messages are CDR, their schemas ROS 2's, as in other robots' records. Times are ns of bus time: `publish_time` when
//! it was, `log_time` the same but never before the message before. The metadata `mrroc` says which program, command
//! and frames ([`About`]); every file that the command read is an attachment.

mod cdr;
mod read;
#[cfg(test)]
mod test;
mod write;

use protocol::frame::Frame;
use protocol::transfer::Mtu;
use std::collections::BTreeMap;
use std::path::PathBuf;

pub use read::{Reader, RecordError};
pub use write::Writer;

/// The name of the metadata.
const METADATA: &str = "mrroc";
/// The topic of a bus, before its name.
const BUS_TOPIC: &str = "/bus/";
/// The topic of the Master Process' steps.
const STEPS_TOPIC: &str = "/mp/steps";
/// The type of attached files.
const FILE_TYPE: &str = "text/plain";

/// Which run it was.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct About {
    /// The version of the program.
    pub version: String,
    /// Its arguments, without its name.
    pub arguments: Vec<String>,
    /// How long the frames from the Master Process were.
    pub mtu: Mtu,
    /// Names of the buses, the Master Process' first.
    pub buses: Vec<String>,
    /// Every text that was read, by its path as it was asked for.
    pub files: BTreeMap<PathBuf, String>,
}

/// What happened.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// A frame ended on a bus, by its number in [`About::buses`].
    Frame(usize, Frame),
    /// A step of the Master Process.
    Step(MasterStep),
}

/// A step of the Master Process.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MasterStep {
    /// How many frames it was given: the next of those that others sent on its bus.
    pub received: u32,
    /// The operator asked for a stop before it.
    pub stop: bool,
}
