//! Writing records.

use super::cdr::{self, Schema};
use super::{About, BUS_TOPIC, Event, FILE_TYPE, METADATA, STEPS_TOPIC};
use mcap::records::{MessageHeader, Metadata};
use mcap::{Attachment, McapResult, WriteOptions};
use protocol::transfer::Mtu;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt;
use std::io::{Seek, Write};

/// Schemas and messages are of ROS 2.
const PROFILE: &str = "ros2";
const SCHEMA_ENCODING: &str = "ros2msg";
const MESSAGE_ENCODING: &str = "cdr";

/// A program that is killed loses what of its record was in memory: so much at most, 0.1 s of a busy cell.
const CHUNK_BYTES: u64 = 1 << 17;

/// A channel, and how many messages it has.
#[derive(Clone, Copy, Debug)]
struct Channel {
    id: u16,
    messages: u32,
}

/// A robot whose joints are recorded.
#[derive(Clone, Debug)]
struct Joints {
    channel: Channel,
    robot: String,
    names: Vec<String>,
}

/// A record being written. It is complete after [`Self::finish`].
pub struct Writer<W: Write + Seek> {
    out: mcap::Writer<W>,
    buses: Vec<Channel>,
    steps: Channel,
    joints: Vec<Joints>,
    /// `log_time` of the last message.
    last_ns: u64,
}

impl<W: Write + Seek> fmt::Debug for Writer<W> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut shown = f.debug_struct("Writer");
        shown.field("buses", &self.buses).finish_non_exhaustive()
    }
}

impl<W: Write + Seek> Writer<W> {
    /// A record of this run; `robots` are names and axes of those whose joints are recorded.
    ///
    /// # Errors
    /// Those of the output.
    pub fn new(out: W, about: &About, robots: &[(String, usize)]) -> McapResult<Self> {
        let options = WriteOptions::new()
            .compression(None)
            .chunk_size(Some(CHUNK_BYTES))
            .profile(PROFILE)
            .library(format!("mrroc {}", about.version));
        let mut out = options.create(out)?;
        out.write_metadata(&metadata(about))?;
        for (path, text) in &about.files {
            out.attach(&Attachment {
                log_time: 0,
                create_time: 0,
                name: path.to_string_lossy().into_owned(),
                media_type: FILE_TYPE.into(),
                data: Cow::Borrowed(text.as_bytes()),
            })?;
        }
        let buses = about.buses.iter();
        let buses = buses
            .map(|name| channel(&mut out, &format!("{BUS_TOPIC}{name}"), cdr::CAN_FRAME))
            .collect::<McapResult<_>>()?;
        let steps = channel(&mut out, STEPS_TOPIC, cdr::MASTER_STEP)?;
        let joints = robots
            .iter()
            .map(|(robot, axes)| {
                Ok(Joints {
                    channel: channel(
                        &mut out,
                        &format!("/{robot}/joint_states"),
                        cdr::JOINT_STATE,
                    )?,
                    robot: robot.clone(),
                    names: (1..=*axes).map(|axis| format!("{robot}/{axis}")).collect(),
                })
            })
            .collect::<McapResult<_>>()?;
        Ok(Self {
            out,
            buses,
            steps,
            joints,
            last_ns: 0,
        })
    }

    /// What happened.
    ///
    /// # Errors
    /// Those of the output.
    pub fn event(&mut self, at_ns: u64, event: &Event) -> McapResult<()> {
        let (channel, data) = match event {
            Event::Frame(bus, frame) => (self.buses.get_mut(*bus), cdr::frame(frame)),
            Event::Step(step) => (Some(&mut self.steps), cdr::step(*step)),
        };
        match channel {
            Some(channel) => message(&mut self.out, channel, &mut self.last_ns, at_ns, &data),
            None => Ok(()),
        }
    }

    /// Where a robot's joints are, rad or m.
    ///
    /// # Errors
    /// Those of the output.
    pub fn joints(&mut self, at_ns: u64, robot: usize, position: &[f64]) -> McapResult<()> {
        let Some(joints) = self.joints.get_mut(robot) else {
            return Ok(());
        };
        let data = cdr::joints(at_ns, &joints.robot, &joints.names, position);
        let channel = &mut joints.channel;
        message(&mut self.out, channel, &mut self.last_ns, at_ns, &data)
    }

    /// Writes what makes the record complete.
    ///
    /// # Errors
    /// Those of the output.
    pub fn finish(mut self) -> McapResult<W> {
        self.out.finish()?;
        Ok(self.out.into_inner())
    }
}

fn channel<W: Write + Seek>(
    out: &mut mcap::Writer<W>,
    topic: &str,
    (name, text): Schema,
) -> McapResult<Channel> {
    let schema = out.add_schema(name, SCHEMA_ENCODING, text.as_bytes())?;
    let id = out.add_channel(schema, topic, MESSAGE_ENCODING, &BTreeMap::new())?;
    Ok(Channel { id, messages: 0 })
}

fn message<W: Write + Seek>(
    out: &mut mcap::Writer<W>,
    channel: &mut Channel,
    last_ns: &mut u64,
    at_ns: u64,
    data: &[u8],
) -> McapResult<()> {
    *last_ns = at_ns.max(*last_ns);
    let header = MessageHeader {
        channel_id: channel.id,
        sequence: channel.messages,
        log_time: *last_ns,
        publish_time: at_ns,
    };
    channel.messages = channel.messages.wrapping_add(1);
    out.write_to_known_channel(&header, data)
}

fn metadata(about: &About) -> Metadata {
    let arguments = serde_json::to_string(&about.arguments).unwrap_or_default();
    let buses = serde_json::to_string(&about.buses).unwrap_or_default();
    let mtu = match about.mtu {
        Mtu::Classic => "classical",
        Mtu::Fd => "fd",
    };
    let pairs = [
        ("version", about.version.clone()),
        ("arguments", arguments),
        ("buses", buses),
        ("frames", mtu.to_owned()),
    ];
    Metadata {
        name: METADATA.into(),
        metadata: pairs.map(|(key, value)| (key.to_owned(), value)).into(),
    }
}
