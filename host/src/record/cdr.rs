//! Messages as CDR (OMG DDS-XTypes 7.4, plain, little endian), with their schemas in ROS 2's notation.

use super::MasterStep;
use protocol::frame::{Frame, Id};

/// Name and text of a schema.
pub(super) type Schema = (&'static str, &'static str);

/// Of a frame.
pub(super) const CAN_FRAME: Schema = (
    "mrroc_msgs/msg/CanFrame",
    "# A frame of a CAN bus, at its end\n\
     uint32 id\n\
     # 29 bits instead of 11\n\
     bool extended\n\
     # CAN FD\n\
     bool fd\n\
     uint8[] data\n",
);

/// Of a step of the Master Process.
pub(super) const MASTER_STEP: Schema = (
    "mrroc_msgs/msg/MasterStep",
    "# A step of the Master Process\n\
     # how many frames of others it was given\n\
     uint32 received\n\
     # the operator asked for a stop\n\
     bool stop\n",
);

/// Of a robot's joints.
pub(super) const JOINT_STATE: Schema = (
    "sensor_msgs/msg/JointState",
    "std_msgs/Header header\n\
     string[] name\n\
     float64[] position\n\
     float64[] velocity\n\
     float64[] effort\n\
     ================================================================================\n\
     MSG: std_msgs/Header\n\
     builtin_interfaces/Time stamp\n\
     string frame_id\n\
     ================================================================================\n\
     MSG: builtin_interfaces/Time\n\
     int32 sec\n\
     uint32 nanosec\n",
);

/// Representation: plain CDR, little endian, no options.
const HEADER: [u8; 4] = [0, 1, 0, 0];

/// Bytes being written; primitives are aligned to their size, counted behind the header.
struct Encoder(Vec<u8>);

impl Encoder {
    fn new() -> Self {
        Self(HEADER.to_vec())
    }

    fn aligned(mut self, to: usize, bytes: &[u8]) -> Self {
        while !(self.0.len() - HEADER.len()).is_multiple_of(to) {
            self.0.push(0);
        }
        self.0.extend_from_slice(bytes);
        self
    }

    fn bool(self, value: bool) -> Self {
        self.aligned(1, &[u8::from(value)])
    }

    fn u32(self, value: u32) -> Self {
        self.aligned(4, &value.to_le_bytes())
    }

    fn length(self, length: usize) -> Self {
        self.u32(u32::try_from(length).unwrap_or(u32::MAX))
    }

    fn text(self, text: &str) -> Self {
        self.length(text.len() + 1)
            .aligned(1, text.as_bytes())
            .aligned(1, &[0])
    }

    fn floats(self, values: &[f64]) -> Self {
        let counted = self.length(values.len());
        values.iter().fold(counted, |encoder, value| {
            encoder.aligned(8, &value.to_le_bytes())
        })
    }
}

/// Bytes being read.
struct Decoder<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Decoder<'a> {
    fn new(bytes: &'a [u8]) -> Option<Self> {
        let bytes = bytes.strip_prefix(&HEADER)?;
        Some(Self { bytes, at: 0 })
    }

    fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let end = self.at.checked_add(count)?;
        let taken = self.bytes.get(self.at..end)?;
        self.at = end;
        Some(taken)
    }

    fn bool(&mut self) -> Option<bool> {
        match self.take(1)? {
            [0] => Some(false),
            [1] => Some(true),
            _ => None,
        }
    }

    fn u32(&mut self) -> Option<u32> {
        self.at = self.at.next_multiple_of(4);
        let bytes = self.take(4)?.try_into().ok()?;
        Some(u32::from_le_bytes(bytes))
    }

    /// Everything must have been read.
    fn end<T>(self, value: T) -> Option<T> {
        (self.at == self.bytes.len()).then_some(value)
    }
}

pub(super) fn frame(frame: &Frame) -> Vec<u8> {
    let (id, extended) = match frame.id() {
        Id::Standard(id) => (u32::from(id), false),
        Id::Extended(id) => (id, true),
    };
    let encoder = Encoder::new().u32(id).bool(extended).bool(frame.is_fd());
    let data = frame.data();
    encoder.length(data.len()).aligned(1, data).0
}

/// `None` for what is no frame.
pub(super) fn to_frame(bytes: &[u8]) -> Option<Frame> {
    let mut decoder = Decoder::new(bytes)?;
    let number = decoder.u32()?;
    let id = if decoder.bool()? {
        (number >> 29 == 0).then_some(Id::Extended(number))
    } else {
        let short = u16::try_from(number).ok().filter(|id| *id <= 0x7FF);
        short.map(Id::Standard)
    }?;
    let fd = decoder.bool()?;
    let length = usize::try_from(decoder.u32()?).ok()?;
    let data = decoder.take(length)?;
    let frame = if fd {
        Frame::fd(id, data)
    } else {
        Frame::classic(id, data)
    }?;
    decoder.end(frame)
}

pub(super) fn step(step: MasterStep) -> Vec<u8> {
    Encoder::new().u32(step.received).bool(step.stop).0
}

/// `None` for what is no step.
pub(super) fn to_step(bytes: &[u8]) -> Option<MasterStep> {
    let mut decoder = Decoder::new(bytes)?;
    let step = MasterStep {
        received: decoder.u32()?,
        stop: decoder.bool()?,
    };
    decoder.end(step)
}

/// The joints of a robot; `position` in rad or m.
pub(super) fn joints(at_ns: u64, robot: &str, names: &[String], position: &[f64]) -> Vec<u8> {
    let seconds = u32::try_from(at_ns / 1_000_000_000).unwrap_or(u32::MAX);
    let nanos = u32::try_from(at_ns % 1_000_000_000).unwrap_or(0);
    let encoder = Encoder::new().u32(seconds).u32(nanos).text(robot);
    let named = names
        .iter()
        .fold(encoder.length(names.len()), |encoder, name| {
            encoder.text(name)
        });
    named.floats(position).floats(&[]).floats(&[]).0
}
