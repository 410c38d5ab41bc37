//! Writes what went over the buses, in the order of time: as an MCAP file that can be replayed, or as a
//! candump log.

use bus::candump::{self, MAX_CHANNEL};
use host::error::Error;
use host::record::{self, About, Event, MasterStep};
use protocol::frame::Frame;
use protocol::time::Micros;
use std::fs::File;
use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};

/// A file of this ending is MCAP, any other a candump log.
const MCAP: &str = "mcap";

/// A record being written.
pub(crate) struct Recorder {
    path: PathBuf,
    format: Format,
    /// Not yet written: buses report one after the other, a record goes by time.
    waiting: Vec<(u64, Item)>,
    failed: Option<io::Error>,
}

enum Format {
    Candump {
        channels: Vec<String>,
        writer: candump::Writer<BufWriter<File>>,
    },
    Mcap(Box<record::Writer<BufWriter<File>>>),
}

enum Item {
    Event(Event),
    Joints { robot: usize, position: Vec<f64> },
}

impl Recorder {
    /// A new record; `robots` are names and axes of those whose joints are recorded.
    ///
    /// # Errors
    /// The file cannot be created.
    pub(crate) fn create(
        path: &Path,
        about: About,
        robots: &[(String, usize)],
    ) -> Result<Self, Error> {
        let create = |source| Error::create(path, source);
        let out = BufWriter::new(File::create(path).map_err(create)?);
        let format = if path.extension().is_some_and(|ending| ending == MCAP) {
            let writer = record::Writer::new(out, &about, robots);
            Format::Mcap(Box::new(writer.map_err(io::Error::other).map_err(create)?))
        } else {
            Format::Candump {
                channels: channels(about.buses),
                writer: candump::Writer::new(out),
            }
        };
        Ok(Self {
            path: path.into(),
            format,
            waiting: Vec::new(),
            failed: None,
        })
    }

    /// A frame of a bus.
    pub(crate) fn frame(&mut self, bus: usize, at_ns: u64, frame: &Frame) {
        let event = Event::Frame(bus, *frame);
        self.waiting.push((at_ns, Item::Event(event)));
    }

    /// A step of the Master Process.
    pub(crate) fn step(&mut self, at: Micros, step: MasterStep) {
        let event = Event::Step(step);
        self.waiting.push((at.0 * 1000, Item::Event(event)));
    }

    /// Where a robot's joints are, rad or m.
    pub(crate) fn joints(&mut self, robot: usize, at: Micros, position: Vec<f64>) {
        let joints = Item::Joints { robot, position };
        self.waiting.push((at.0 * 1000, joints));
    }

    /// Time has passed: nothing earlier than what waits will come. Writes it.
    pub(crate) fn passed(&mut self) {
        // stable: of what happens at the same instant the buses keep their order
        self.waiting.sort_by_key(|(at_ns, _)| *at_ns);
        for (at_ns, item) in self.waiting.drain(..) {
            if let Err(error) = self.format.write(at_ns, &item) {
                self.failed.get_or_insert(error);
            }
        }
    }

    /// Finish the record.
    ///
    /// # Errors
    /// The first that writing met.
    pub(crate) fn close(mut self) -> Result<(), Error> {
        self.passed();
        let finished = self.format.finish();
        let written = self.failed.take().map_or(finished, Err);
        written.map_err(|source| Error::write(&self.path, source))
    }
}

impl Format {
    fn write(&mut self, at_ns: u64, item: &Item) -> io::Result<()> {
        match (self, item) {
            (Self::Candump { channels, writer }, Item::Event(Event::Frame(bus, frame))) => {
                let channel = channels.get(*bus).map_or("bus", String::as_str);
                writer.write(Micros(at_ns / 1000), channel, frame)
            }
            // a log has frames only
            (Self::Candump { .. }, Item::Event(Event::Step(_)) | Item::Joints { .. }) => Ok(()),
            (Self::Mcap(writer), Item::Event(event)) => {
                writer.event(at_ns, event).map_err(io::Error::other)
            }
            (Self::Mcap(writer), Item::Joints { robot, position }) => {
                let written = writer.joints(at_ns, *robot, position);
                written.map_err(io::Error::other)
            }
        }
    }

    fn finish(self) -> io::Result<()> {
        match self {
            Self::Candump { mut writer, .. } => writer.flush(),
            Self::Mcap(writer) => {
                let out = writer.finish().map_err(io::Error::other)?;
                out.into_inner().map(drop).map_err(io::Error::from)
            }
        }
    }
}

/// Names a candump log can hold: a longer one, or one with other characters, becomes `bus` and its
/// number.
fn channels(names: Vec<String>) -> Vec<String> {
    let fits = |name: &str| {
        let plain = name.bytes().all(|b| b.is_ascii_graphic());
        !name.is_empty() && name.len() <= MAX_CHANNEL && plain
    };
    let each = names.into_iter().enumerate();
    each.map(|(k, name)| if fits(&name) { name } else { format!("bus{k}") })
        .collect()
}

#[cfg(test)]
mod test {
    use super::*;

    #[test]
    fn channels_fit_a_log() {
        let names = [
            "mp",
            "conveyor.0",
            "fifteen-letters",
            "irp6-postument.0",
            "two words",
            "",
        ];
        let channels = channels(names.map(String::from).to_vec());
        let written = [
            "mp",
            "conveyor.0",
            "fifteen-letters",
            "bus3",
            "bus4",
            "bus5",
        ];
        assert_eq!(channels, written);
    }
}
