//! A record, fed back: the Master Process and the nodes are made once more, given what others sent them at
//! the times of the record, and what they send is compared with what they sent.
//!
//! Nothing else is simulated: no wire, no drive, no mechanics. So a record of one version shows whether
//! another behaves the same, and a record of a real bus shows what its Master Process did, and why.

mod comparison;
mod master;
mod node;
#[cfg(test)]
mod test;

use crate::commands::{Asked, Cli};
use crate::run::coordinated;
use crate::world::{force_address, known_drives, stations};
use clap::Args;
use comparison::{Comparison, shown};
use hil_sim::cell::Wiring;
use host::error::Error;
use host::input::{DataError, Files, InputError, Problem};
use host::program::config_of;
use host::record::{About, Event, Reader, RecordError};
use host::task::Cell;
use master::MasterReplay;
use node::NodeReplay;
use process::{End, exit};
use protocol::id::NodeId;
use std::fs::File;
use std::io::{self, BufReader, Read, Write};
use std::path::{Path, PathBuf};

/// Progress is told once in this time of the record, ns.
const PROGRESS_NS: u64 = 10_000_000_000;

/// Arguments of `mrroc replay`.
#[derive(Args, Debug)]
pub(crate) struct Replay {
    /// A record (.mcap) that `--record` wrote.
    file: PathBuf,
    /// Print the result as one JSON value.
    #[arg(long)]
    json: bool,
    /// No progress on stderr.
    #[arg(long, short)]
    quiet: bool,
}

/// What is replayed.
struct Parts {
    master: MasterReplay,
    nodes: Vec<(String, NodeReplay)>,
}

/// How it went.
struct Outcome {
    about: About,
    complete: bool,
    end_ns: u64,
    /// Robots whose drive buses are not in the record.
    unseen: Vec<String>,
    parts: Parts,
}

impl Replay {
    /// Replays; the exit code says whether everything is as it was.
    pub(crate) fn run(&self, out: &mut impl Write) -> Result<u8, End> {
        if self.file.is_dir() {
            return Err(Error::from(InputError::NotAFile(self.file.clone())).into());
        }
        let file = File::open(&self.file).map_err(|error| self.unreadable(error))?;
        let reader = Reader::open(BufReader::new(file)).map_err(|error| self.wrong(&error))?;
        let outcome = self.replay(reader)?;
        let text = if self.json {
            outcome.to_json().to_string() + "\n"
        } else {
            outcome.to_text()
        };
        // a reader that has gone away does not change the result
        let _ = out.write_all(text.as_bytes());
        Ok(if outcome.same() {
            exit::OK
        } else {
            exit::DIFFERENT
        })
    }

    fn replay<R: Read>(&self, mut reader: Reader<R>) -> Result<Outcome, End> {
        let about = reader.about().clone();
        let (mut parts, unseen) = parts(&about, &self.file)?;
        let (mut end_ns, mut told_ns) = (0, 0);
        while let Some((at_ns, event)) = reader.next_event().map_err(|error| self.wrong(&error))? {
            end_ns = at_ns.max(end_ns);
            match event {
                Event::Frame(bus, frame) => {
                    parts.master.frame(at_ns, bus, &frame);
                    for (_, node) in &mut parts.nodes {
                        node.frame(at_ns, bus, &frame);
                    }
                }
                Event::Step(step) => {
                    if parts.master.step(at_ns, step).is_none() {
                        let what = "the record lacks frames";
                        let expected = format!("the {} of a step", step.received);
                        return Err(self.data(what, &expected, "fewer").into());
                    }
                }
            }
            if !self.quiet && end_ns - told_ns >= PROGRESS_NS {
                told_ns = end_ns;
                let _ = writeln!(io::stderr(), "replayed {} s", end_ns / 1_000_000_000);
            }
        }
        parts.master.comparison.end(end_ns);
        for (_, node) in &mut parts.nodes {
            node.advance(end_ns);
            node.comparison.end(end_ns);
        }
        Ok(Outcome {
            about,
            complete: reader.is_complete(),
            end_ns,
            unseen,
            parts,
        })
    }

    fn unreadable(&self, error: io::Error) -> Error {
        let path = self.file.clone();
        match error.kind() {
            io::ErrorKind::NotFound => InputError::Absent(path),
            io::ErrorKind::PermissionDenied => InputError::Refused(path),
            _ => InputError::Io(path, error),
        }
        .into()
    }

    fn wrong(&self, error: &RecordError) -> Error {
        match error {
            RecordError::Other {
                what,
                expected,
                got,
            } => self.data(what, expected, got),
            RecordError::Mcap(error) => {
                self.data("not a record", "an MCAP file", &error.to_string())
            }
        }
    }

    fn data(&self, what: &str, expected: &str, got: &str) -> Error {
        DataError {
            path: Some(self.file.clone()),
            line: 1,
            column: 1,
            problem: Problem::Syntax,
            what: what.to_owned(),
            expected: expected.to_owned(),
            got: got.to_owned(),
        }
        .into()
    }
}

/// The parts that a record can be fed to, and the robots of which it does not say enough.
fn parts(about: &About, record: &Path) -> Result<(Parts, Vec<String>), End> {
    let files = Files::kept(about.files.clone());
    let asked = Cli::asked(about.arguments.iter().cloned(), &files)?;
    let Asked { task, path } = asked.ok_or_else(|| Error::Usage {
        what: format!("{}: not the record of a task", record.display()),
        expected: "one of run, home or move".into(),
        got: about.arguments.join(" "),
    })?;
    let (cell, seed) = (task.cell.clone(), task.seed);
    let config = config_of(&cell)
        .ok_or_else(|| Error::Internal("the cell has more robots than numbers".into()))?;
    let ids: Vec<NodeId> = config.robots.iter().map(|robot| robot.node).collect();
    let master = MasterReplay::new(coordinated(task, path.as_deref(), config, about.mtu)?);
    let (nodes, unseen) = nodes(&cell, &ids, seed, about)?;
    Ok((Parts { master, nodes }, unseen))
}

type Nodes = Vec<(String, NodeReplay)>;

fn nodes(
    cell: &Cell,
    ids: &[NodeId],
    seed: u64,
    about: &About,
) -> Result<(Nodes, Vec<String>), Error> {
    let (mut nodes, mut unseen) = (Vec::new(), Vec::new());
    // behind the Master Process' bus
    let mut bus = 1;
    let stations = stations(cell, ids, seed, about.mtu);
    for ((robot, id), (station, bus_of_axis)) in cell.robots.iter().zip(ids).zip(stations) {
        let numbers = (*id, station.master());
        let wiring = Wiring {
            buses: &bus_of_axis,
            fast: robot.fast_drives,
            force: force_address(robot),
            drives: known_drives(robot),
        };
        let node = NodeReplay::new(robot.kind, &station, numbers, (bus, &wiring))
            .map_err(|error| Error::Internal(error.to_string()))?;
        bus += node.buses();
        if bus <= about.buses.len() {
            nodes.push((robot.name.clone(), node));
        } else {
            unseen.push(robot.name.clone());
        }
    }
    Ok((nodes, unseen))
}

/// A part's name, how many frames it was given, and what it sent.
type Row<'a> = (&'a str, u64, &'a Comparison);

impl Outcome {
    fn rows(&self) -> impl Iterator<Item = Row<'_>> {
        let Parts { master, nodes } = &self.parts;
        let nodes = nodes.iter();
        let nodes = nodes.map(|(name, node)| (name.as_str(), node.received, &node.comparison));
        std::iter::once(("mp", master.received, &master.comparison)).chain(nodes)
    }

    fn same(&self) -> bool {
        self.rows()
            .all(|(.., comparison)| comparison.difference().is_none())
    }

    fn bus(&self, number: usize) -> &str {
        self.about.buses.get(number).map_or("?", String::as_str)
    }

    fn to_text(&self) -> String {
        use std::fmt::Write as _;
        let mut text = String::new();
        let mut line = |line: std::fmt::Arguments<'_>| {
            // a String takes everything
            let _ = writeln!(text, "{line}");
        };
        line(format_args!(
            "{:16} {:>10} {:>10}  {}",
            "part", "received", "sent", "compared with the record"
        ));
        for (name, received, comparison) in self.rows() {
            let result = comparison.difference().map_or_else(
                || "the same".to_owned(),
                |difference| {
                    format!(
                        "differs at {:.6} s on {}: recorded {}, now {}",
                        seconds(difference.at_ns),
                        self.bus(difference.bus),
                        shown(difference.recorded.as_ref()),
                        shown(difference.replayed.as_ref()),
                    )
                },
            );
            let same = comparison.same();
            line(format_args!(
                "{name:16} {received:>10} {same:>10}  {result}"
            ));
        }
        for name in &self.unseen {
            line(format_args!(
                "{name:16} {:>10} {:>10}  its drives are not in the record",
                "-", "-"
            ));
        }
        let end = if self.complete {
            "complete"
        } else {
            "cut off: its program was killed"
        };
        line(format_args!(
            "{:.3} s of `mrroc {}`, recorded by version {}; {end}",
            seconds(self.end_ns),
            self.about.arguments.join(" "),
            self.about.version,
        ));
        text
    }

    fn to_json(&self) -> serde_json::Value {
        let parts = self.rows().map(|(name, received, comparison)| {
            let difference = comparison.difference().map(|difference| {
                serde_json::json!({
                    "at_s": seconds(difference.at_ns),
                    "bus": self.bus(difference.bus),
                    "recorded": shown(difference.recorded.as_ref()),
                    "replayed": shown(difference.replayed.as_ref()),
                })
            });
            serde_json::json!({
                "part": name,
                "received": received,
                "sent": comparison.same(),
                "difference": difference,
            })
        });
        serde_json::json!({
            "same": self.same(),
            "complete": self.complete,
            "duration_s": seconds(self.end_ns),
            "version": self.about.version,
            "arguments": self.about.arguments,
            "parts": parts.collect::<Vec<_>>(),
            "unseen": self.unseen,
        })
    }
}

#[expect(
    clippy::cast_precision_loss,
    reason = "a record is shorter than months"
)]
fn seconds(ns: u64) -> f64 {
    ns as f64 * 1e-9
}
