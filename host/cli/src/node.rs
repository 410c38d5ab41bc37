//! `mrroc node`: who a node is, why it started, its first fault, and its next image.

mod faults;
mod image;
mod show;
#[cfg(test)]
mod test;

use crate::run::{catch_interrupt, interrupted};
use crate::world::{bus_error, open_bus};
use bus::Bus;
use bus::spec::Place;
use clap::{Args, Subcommand};
use host::error::Error;
use host::maintenance::{Client, KEEPER, Sending, Wire};
use process::{End, exit};
use protocol::frame::Frame;
use protocol::id::NodeId;
use protocol::time::Micros;
use protocol::transfer::Mtu;
use robots::RobotKind;
use serde_json::json;
use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};

/// Ask and update one node.
#[derive(Args, Debug)]
pub(crate) struct Node {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand, Debug)]
enum Command {
    /// Who it is: unique id, versions, schema hash, configuration, image, start, first fault.
    Info(Asking),
    /// Why it started.
    ResetCause(Asking),
    /// The first fault since the last one was acknowledged or cleared, and the signals before it; survives a reset.
    Faults(Faults),
    /// Send an image into the slot that does not run; it starts on trial at the next reset. Takes the lease; torque must
    /// be off. Goes on where an earlier attempt ended.
    Flash(Flash),
    /// Keep the image that runs on trial; without this the other starts again at the next reset.
    Confirm(Asking),
    /// Start it anew, with the image that was sent last if there is one; waits until it is back. Takes the lease; torque must
    /// be off.
    Restart(Asking),
    /// Make an image of a program: the header that a node checks, and the program.
    Pack(image::Pack),
}

/// Whom to ask, and how.
#[derive(Args, Debug)]
struct Asking {
    /// hub, hub:PORT, hub:HOST:PORT, can:INTERFACE,
    /// slcan:DEVICE or slcan:HOST:PORT.
    #[arg(long, default_value = "hub")]
    bus: Place,
    /// The node: a robot, whose node has the number of its kind, or a number (0 to 127).
    #[arg(long, value_name = "ROBOT|NUMBER", value_parser = target)]
    node: Target,
    /// Our own number on the bus; it must be nobody else's.
    #[arg(long = "as", value_name = "NUMBER", default_value_t = KEEPER, value_parser = clap::value_parser!(u8).range(0..=127))]
    me: u8,
    /// Print one JSON value.
    #[arg(long)]
    json: bool,
}

#[derive(Args, Debug)]
struct Faults {
    #[command(flatten)]
    asking: Asking,
    /// Draw the signals before the fault (.svg or .png).
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
    /// Then forget the record, so that the next fault is recorded. Takes the lease; torque must be off.
    #[arg(long)]
    clear: bool,
}

#[derive(Args, Debug)]
struct Flash {
    /// The image, as `mrroc node pack` makes it.
    image: PathBuf,
    #[command(flatten)]
    asking: Asking,
    /// No progress on stderr.
    #[arg(long, short)]
    quiet: bool,
}

/// A node, and what messages call it.
#[derive(Clone, Debug, PartialEq)]
struct Target {
    id: NodeId,
    name: String,
}

fn target(text: &str) -> Result<Target, String> {
    let of = |id: Option<NodeId>, name: String| id.map(|id| Target { id, name });
    let found = match (RobotKind::from_name(text), text.parse::<u8>()) {
        (Ok(kind), _) => of(NodeId::effector(kind.effector()), kind.name().into()),
        (Err(_), Ok(number)) => of(NodeId::new(number), format!("node {number}")),
        (Err(_), Err(_)) => None,
    };
    found.ok_or_else(|| {
        let known = RobotKind::ALL.map(RobotKind::name).join(", ");
        format!(
            "expected a number from 0 to {} or one of {known}",
            NodeId::MAX
        )
    })
}

/// A bus between processes, in real time.
struct OnBus {
    bus: Box<dyn Bus>,
    mtu: Mtu,
}

impl Wire for OnBus {
    fn mtu(&self) -> Mtu {
        self.mtu
    }
    fn now(&self) -> Micros {
        bus::now()
    }
    fn send(&mut self, frame: &Frame) -> Result<(), Error> {
        match self.bus.send(frame) {
            // lost like any other frame: what is not answered is sent again
            Err(bus::BusError::Full { .. } | bus::BusError::Down { .. }) => Ok(()),
            sent => sent.map_err(|e| bus_error(&e)),
        }
    }
    fn pass(&mut self, until: Micros, rx: &mut Vec<(Micros, Frame)>) -> Result<(), Error> {
        self.bus.wait(until).map_err(|e| bus_error(&e))?;
        while let Some(received) = self.bus.receive().map_err(|e| bus_error(&e))? {
            rx.push((received.at, received.frame));
        }
        Ok(())
    }
    fn ends(&self) -> bool {
        interrupted()
    }
}

impl Node {
    /// Carries out the command; the exit code.
    ///
    /// # Errors
    /// One line, and an exit code.
    pub(crate) fn run(self, out: &mut impl Write) -> Result<u8, End> {
        match self.command {
            Command::Pack(pack) => pack.run(out).map(|()| exit::OK),
            Command::Info(asking) => asking.talk(|client| {
                let text = info(client, &asking)?;
                Ok(written(out, &text))
            }),
            Command::ResetCause(asking) => asking.talk(|client| {
                let report = client.reset_cause()?;
                Ok(written(
                    out,
                    &show::started(client.name(), &report, asking.json),
                ))
            }),
            Command::Faults(faults) => faults.run(out),
            Command::Flash(flash) => flash.run(out),
            Command::Restart(asking) => asking.talk(|client| {
                let report = with_lease(client, |client| {
                    let report = client.restart()?;
                    Ok(report)
                })?;
                Ok(written(
                    out,
                    &show::started(client.name(), &report, asking.json),
                ))
            }),
            Command::Confirm(asking) => asking.talk(|client| {
                with_lease(client, |client| {
                    client.confirm()?;
                    Ok(())
                })?;
                let text = if asking.json {
                    show::line(&json!({"confirmed": true}))
                } else {
                    format!("{}: the image that runs is kept\n", client.name())
                };
                Ok(written(out, &text))
            }),
        }
    }
}

impl Asking {
    fn talk<T>(
        &self,
        talk: impl FnOnce(&mut Client<'_, OnBus>) -> Result<T, End>,
    ) -> Result<T, End> {
        let me = NodeId::new(self.me).unwrap_or(NodeId::MP);
        if me == self.node.id {
            return Err(End::usage(format!(
                "--as: {me} is the number of the node itself"
            )));
        }
        let (bus, mtu) = open_bus(&self.bus)?;
        catch_interrupt()?;
        let mut wire = OnBus { bus, mtu };
        let mut client = Client::new(&mut wire, me, self.node.id, self.node.name.clone());
        talk(&mut client)
    }
}

/// Takes the lease for what writes, and gives it back whatever happened.
fn with_lease<T>(
    client: &mut Client<'_, OnBus>,
    work: impl FnOnce(&mut Client<'_, OnBus>) -> Result<T, Error>,
) -> Result<T, Error> {
    client.acquire()?;
    let result = work(client);
    let released = client.release();
    let done = result?;
    released?;
    Ok(done)
}

/// A reader that has gone away is no error of ours.
fn written(out: &mut impl Write, text: &str) -> u8 {
    let _ = out.write_all(text.as_bytes());
    exit::OK
}

fn info(client: &mut Client<'_, OnBus>, asking: &Asking) -> Result<String, End> {
    let number = asking.node.id.get();
    let identity = match client.identify() {
        Err(Error::Silent { .. }) => {
            // an older one, or one without a keeper
            let identity = client.identify_plainly()?;
            return Ok(if asking.json {
                show::line(&show::plain_json(&identity))
            } else {
                show::plain(number, &identity)
            });
        }
        identity => identity?,
    };
    let reset = client.reset_cause()?;
    let fault = client.first_fault()?;
    let next = match identity.image {
        Some(_) => Some(client.image_status()?),
        None => None,
    };
    let all = show::Info {
        identity: &identity,
        reset: &reset,
        fault: fault.as_ref(),
        next: next.as_ref(),
    };
    Ok(if asking.json {
        show::line(&all.json())
    } else {
        all.text(number)
    })
}

impl Faults {
    fn run(self, out: &mut impl Write) -> Result<u8, End> {
        if let Some(plot) = &self.plot {
            host::plot::check_name(plot)?;
        }
        self.asking.talk(|client| {
            let identity = client.identify()?;
            let record = client.first_fault()?;
            let Some(record) = record else {
                let text = if self.asking.json {
                    show::line(&json!({"robot": identity.robot.as_str(), "fault": null}))
                } else {
                    format!("{}: no fault is recorded\n", client.name())
                };
                return Ok(written(out, &text));
            };
            let samples = client.samples(&record)?;
            let found = faults::Found::new(&identity.robot, record, samples);
            if let Some(plot) = &self.plot {
                host::plot::save(&found.picture(), plot)?;
            }
            if self.clear {
                with_lease(client, |client| client.clear(&record))?;
            }
            let text = if self.asking.json {
                show::line(&found.json(self.clear))
            } else {
                found.text(client.name(), self.clear)
            };
            Ok(written(out, &text))
        })
    }
}

impl Flash {
    fn run(self, out: &mut impl Write) -> Result<u8, End> {
        let image = image::load(&self.image)?;
        let mut progress = Progress::new(self.quiet || self.asking.json, &self.image);
        self.asking.talk(|client| {
            let status = with_lease(client, |client| {
                client.send_image(&image.header, &image.bytes, |sending| progress.tell(sending))
            });
            progress.end();
            let status = status?;
            let version = show::version(image.header.version);
            let text = if self.asking.json {
                show::line(&json!({
                    "version": version,
                    "crc": format!("{:08x}", image.header.crc),
                    "bytes": image.header.length,
                    "slot": format!("{:?}", status.slot),
                    "phase": format!("{:?}", status.phase),
                }))
            } else {
                format!(
                    "{}: {version} (CRC {:08x}, {} bytes) is in slot {:?} and starts on trial at the next reset;\n\
                     when it runs well: mrroc node confirm\n",
                    client.name(),
                    image.header.crc,
                    image.header.length,
                    status.slot
                )
            };
            Ok(written(out, &text))
        })
    }
}

/// Progress on stderr: in place on a terminal, else a line every tenth.
struct Progress {
    quiet: bool,
    terminal: bool,
    name: String,
    shown: Option<u64>,
}

impl Progress {
    fn new(quiet: bool, image: &Path) -> Self {
        let name = image.file_name().unwrap_or_default().to_string_lossy();
        Self {
            quiet,
            terminal: std::io::stderr().is_terminal(),
            name: name.chars().take(60).collect(),
            shown: None,
        }
    }

    fn tell(&mut self, sending: Sending) {
        if self.quiet {
            return;
        }
        // a closed stderr is no reason to leave an image half sent
        let _ = match sending {
            Sending::Dropped { image } => writeln!(
                std::io::stderr(),
                "another image was under way, {image:08x}: forgotten"
            ),
            Sending::Bytes { done, of } => {
                let percent = u64::from(done) * 100 / u64::from(of).max(1);
                let step = if self.terminal { percent } else { percent / 10 };
                if self.shown.replace(step) == Some(step) {
                    return;
                }
                let line = format!("{}: {percent:3} % of {of} bytes", self.name);
                if self.terminal {
                    write!(std::io::stderr(), "\r{line}")
                } else {
                    writeln!(std::io::stderr(), "{line}")
                }
            }
            Sending::Verified => {
                self.end();
                writeln!(std::io::stderr(), "{}: verified", self.name)
            }
            Sending::Activated => return,
        };
    }

    /// The line that is drawn in place is complete.
    fn end(&mut self) {
        if self.terminal && !self.quiet && self.shown.take().is_some() {
            let _ = writeln!(std::io::stderr());
        }
    }
}
