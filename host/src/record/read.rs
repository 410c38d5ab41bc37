//! Reading records, as a stream: memory is that of a chunk, and of the attached files.

use super::{About, BUS_TOPIC, Event, FILE_TYPE, METADATA, STEPS_TOPIC, cdr};
use mcap::records::Record as Part;
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use mcap::{McapError, parse_record};
use protocol::transfer::Mtu;
use std::collections::BTreeMap;
use std::fmt;
use std::io::Read;
use std::path::PathBuf;

/// The largest part of a file, a chunk or an attachment, bytes.
const MOST_BYTES: usize = 64 << 20;

/// Why a record cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    /// It is no MCAP file, or damaged.
    #[error("not an MCAP file: {0}")]
    Mcap(#[from] McapError),
    /// Another program's, or another kind of record.
    #[error("not a record of mrroc: {what} (expected {expected}, got {got})")]
    Other {
        /// What is wrong.
        what: &'static str,
        /// What was expected.
        expected: &'static str,
        /// What there is.
        got: String,
    },
}

impl RecordError {
    fn other(what: &'static str, expected: &'static str, got: impl Into<String>) -> Self {
        Self::Other {
            what,
            expected,
            got: got.into(),
        }
    }
}

/// What a channel carries.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Topic {
    Bus(usize),
    Steps,
    /// Nothing that a replay needs.
    Other,
}

/// A record being read.
pub struct Reader<R> {
    source: R,
    parts: LinearReader,
    about: About,
    topics: BTreeMap<u16, Topic>,
    ended: bool,
    complete: bool,
}

impl<R> fmt::Debug for Reader<R> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut shown = f.debug_struct("Reader");
        shown.field("about", &self.about).finish_non_exhaustive()
    }
}

impl<R: Read> Reader<R> {
    /// Begins to read a record.
    ///
    /// # Errors
    /// It is none.
    pub fn open(source: R) -> Result<Self, RecordError> {
        let options = LinearReaderOptions::default()
            .with_prevalidate_chunk_crcs(true)
            .with_record_length_limit(MOST_BYTES);
        let mut record = Self {
            source,
            parts: LinearReader::new_with_options(options),
            about: About {
                version: String::new(),
                arguments: Vec::new(),
                mtu: Mtu::Classic,
                buses: Vec::new(),
                files: BTreeMap::new(),
            },
            topics: BTreeMap::new(),
            ended: false,
            complete: false,
        };
        let mut described = false;
        // what it is about comes before the first channel
        while record.topics.is_empty() {
            match record.next_part()? {
                Some(Part::Metadata(data)) if data.name == METADATA => {
                    described = true;
                    record.describe(&data.metadata)?;
                }
                Some(Part::Attachment { header, data, .. }) if header.media_type == FILE_TYPE => {
                    let text = String::from_utf8(data.into_owned()).map_err(|_| {
                        RecordError::other("an attached file", "UTF-8", header.name.clone())
                    })?;
                    let path = PathBuf::from(header.name);
                    record.about.files.insert(path, text);
                }
                Some(Part::Channel(channel)) => record.channel(channel.id, &channel.topic),
                Some(_) => {}
                None => break,
            }
        }
        if described {
            Ok(record)
        } else {
            let what = "what it is about";
            Err(RecordError::other(what, "metadata `mrroc`", "none"))
        }
    }

    /// Which run it was.
    pub const fn about(&self) -> &About {
        &self.about
    }

    /// Was it written to its end? Known when everything was read.
    pub const fn is_complete(&self) -> bool {
        self.complete
    }

    /// What happened next, and when, ns. `None` at the end; a record whose program was killed ends where
    /// it was cut off.
    ///
    /// # Errors
    /// The record is damaged.
    pub fn next_event(&mut self) -> Result<Option<(u64, Event)>, RecordError> {
        loop {
            let Some(part) = self.next_part()? else {
                return Ok(None);
            };
            match part {
                Part::Channel(channel) => self.channel(channel.id, &channel.topic),
                Part::Message { header, data } => {
                    let wrong =
                        |expected| RecordError::other("a message", expected, "something else");
                    let event = match self.topics.get(&header.channel_id) {
                        Some(Topic::Bus(bus)) => {
                            let frame = cdr::to_frame(&data);
                            Event::Frame(*bus, frame.ok_or_else(|| wrong("a CAN frame"))?)
                        }
                        Some(Topic::Steps) => {
                            let step = cdr::to_step(&data);
                            Event::Step(step.ok_or_else(|| wrong("a step"))?)
                        }
                        Some(Topic::Other) | None => continue,
                    };
                    return Ok(Some((header.publish_time, event)));
                }
                _ => {}
            }
        }
    }

    fn channel(&mut self, id: u16, topic: &str) {
        let bus = topic.strip_prefix(BUS_TOPIC);
        let bus = bus.and_then(|name| self.about.buses.iter().position(|bus| bus == name));
        let topic = match bus {
            Some(bus) => Topic::Bus(bus),
            None if topic == STEPS_TOPIC => Topic::Steps,
            None => Topic::Other,
        };
        self.topics.insert(id, topic);
    }

    fn describe(&mut self, said: &BTreeMap<String, String>) -> Result<(), RecordError> {
        let value = |key: &'static str| {
            let missing = || RecordError::other("its metadata", key, "nothing");
            said.get(key).cloned().ok_or_else(missing)
        };
        let list = |key: &'static str| {
            let text = value(key)?;
            serde_json::from_str::<Vec<String>>(&text)
                .map_err(|_| RecordError::other("its metadata", "a list of texts", text))
        };
        self.about.version = value("version")?;
        self.about.arguments = list("arguments")?;
        self.about.buses = list("buses")?;
        self.about.mtu = match value("frames")?.as_str() {
            "classical" => Mtu::Classic,
            "fd" => Mtu::Fd,
            other => {
                let expected = "`classical` or `fd`";
                return Err(RecordError::other("its frames", expected, other));
            }
        };
        Ok(())
    }

    fn next_part(&mut self) -> Result<Option<Part<'static>>, RecordError> {
        while !self.ended {
            match self.parts.next_event() {
                None => {
                    self.ended = true;
                    self.complete = true;
                }
                Some(Err(McapError::UnexpectedEof)) => self.ended = true,
                Some(Err(error)) => return Err(error.into()),
                Some(Ok(LinearReadEvent::ReadRequest(bytes))) => {
                    let room = self.parts.insert(bytes);
                    let read = self.source.read(room).map_err(McapError::from)?;
                    self.parts.notify_read(read);
                }
                Some(Ok(LinearReadEvent::Record { data, opcode })) => {
                    return Ok(Some(parse_record(opcode, data)?.into_owned()));
                }
            }
        }
        Ok(None)
    }
}
