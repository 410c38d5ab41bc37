//! Writes what went over the buses as a candump log, in the order of time.

use bus::candump::{MAX_CHANNEL, Writer};
use host::error::Error;
use protocol::frame::Frame;
use protocol::time::Micros;
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

/// A log being written.
pub(crate) struct Recorder {
    path: PathBuf,
    channels: Vec<String>,
    writer: Writer<BufWriter<File>>,
    /// Not yet written: buses report one after the other, a log goes by time.
    waiting: Vec<(u64, usize, Frame)>,
    failed: Option<std::io::Error>,
}

impl Recorder {
    /// A new log; `names` of the buses become its channels.
    ///
    /// # Errors
    /// The file cannot be created.
    pub(crate) fn create(path: &Path, names: Vec<String>) -> Result<Self, Error> {
        let file = File::create(path).map_err(|source| Error::create(path, source))?;
        Ok(Self {
            path: path.into(),
            channels: channels(names),
            writer: Writer::new(BufWriter::new(file)),
            waiting: Vec::new(),
            failed: None,
        })
    }

    /// A frame of a bus.
    pub(crate) fn frame(&mut self, bus: usize, at_ns: u64, frame: &Frame) {
        self.waiting.push((at_ns, bus, *frame));
    }

    /// Time has passed: nothing earlier than what waits will come. Writes it.
    pub(crate) fn passed(&mut self) {
        // stable: of frames of the same instant the buses keep their order
        self.waiting.sort_by_key(|(at_ns, ..)| *at_ns);
        for (at_ns, bus, frame) in self.waiting.drain(..) {
            let channel = self.channels.get(bus).map_or("bus", String::as_str);
            let written = self.writer.write(Micros(at_ns / 1000), channel, &frame);
            if let Err(error) = written {
                self.failed.get_or_insert(error);
            }
        }
    }

    /// Finish the log.
    ///
    /// # Errors
    /// The first that writing met.
    pub(crate) fn close(mut self) -> Result<(), Error> {
        self.passed();
        let flushed = self.writer.flush();
        let written = self.failed.take().map_or(flushed, Err);
        written.map_err(|source| Error::write(&self.path, source))
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
            "irp6-postument.0",
            "a-name-of-18-bytes",
            "two words",
            "",
        ];
        let channels = channels(names.map(String::from).to_vec());
        assert_eq!(channels, ["mp", "irp6-postument.0", "bus2", "bus3", "bus4"]);
    }
}
