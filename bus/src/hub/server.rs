//! The server: one thread accepts, two threads serve each client.

use super::channel::{Channel, HubTap, Item, Member};
use super::element::{self, Command, Cutter};
use super::{HANDSHAKE, HOLD, MAX_CLIENTS, MAX_NAME, STUCK};
use crate::BusError;
use std::collections::BTreeMap;
use std::io::{self, Read, Write};
use std::net::{Shutdown, SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

/// From where clients may come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reachable {
    /// This machine only.
    Loopback,
    /// Any network this machine is in. Whoever connects can command the robots.
    Network,
}

/// A running hub; ends, with its connections, when dropped.
#[derive(Debug)]
pub struct HubServer {
    address: SocketAddr,
    shared: Arc<Shared>,
    acceptor: Option<JoinHandle<()>>,
}

#[derive(Debug)]
struct Shared {
    channels: Vec<Arc<Channel>>,
    ending: AtomicBool,
    clients: Mutex<BTreeMap<u64, TcpStream>>,
}

impl Shared {
    fn clients(&self) -> MutexGuard<'_, BTreeMap<u64, TcpStream>> {
        self.clients.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn channel(&self, name: &str) -> Option<&Arc<Channel>> {
        self.channels.iter().find(|channel| channel.name == name)
    }
}

impl HubServer {
    /// Listens on a loopback address (port 0: any free one) and offers these channels.
    ///
    /// # Errors
    /// When the address is not loopback, is taken, or a channel's name is impossible.
    pub fn bind(address: SocketAddr, channels: &[&str]) -> Result<Self, BusError> {
        Self::bind_to(address, channels, Reachable::Loopback)
    }

    /// As [`Self::bind`], on a network if that is asked for.
    ///
    /// # Errors
    /// As [`Self::bind`].
    pub fn bind_to(
        address: SocketAddr,
        channels: &[&str],
        reachable: Reachable,
    ) -> Result<Self, BusError> {
        let fail = |reason: String| BusError::Open {
            bus: format!("hub {address}"),
            reason,
        };
        if reachable == Reachable::Loopback && !address.ip().is_loopback() {
            return Err(fail(
                "not a loopback address; listening on a network must be allowed explicitly".into(),
            ));
        }
        for (k, name) in channels.iter().enumerate() {
            let printable = name
                .bytes()
                .all(|b| b.is_ascii_graphic() && b != b'<' && b != b'>');
            if name.is_empty() || name.len() > MAX_NAME || !printable {
                return Err(fail(format!(
                    "{name:?} is no channel name (1 to {MAX_NAME} printable characters, no < >)"
                )));
            }
            if channels.iter().take(k).any(|other| other == name) {
                return Err(fail(format!("two channels are named {name:?}")));
            }
        }
        let listener = TcpListener::bind(address).map_err(|error| {
            fail(format!(
                "cannot listen: {error} (is a hub running already?)"
            ))
        })?;
        let address = listener
            .local_addr()
            .map_err(|error| fail(error.to_string()))?;
        let shared = Arc::new(Shared {
            channels: channels.iter().map(|name| Channel::new(name)).collect(),
            ending: AtomicBool::new(false),
            clients: Mutex::default(),
        });
        let accepting = Arc::clone(&shared);
        let acceptor = thread::Builder::new()
            .name("hub".into())
            .spawn(move || accept(&listener, &accepting))
            .map_err(|error| fail(error.to_string()))?;
        Ok(Self {
            address,
            shared,
            acceptor: Some(acceptor),
        })
    }

    /// Where it listens.
    #[must_use]
    pub const fn address(&self) -> SocketAddr {
        self.address
    }

    /// Joins a channel within this process; `None` if there is none of this name.
    #[must_use]
    pub fn tap(&self, channel: &str) -> Option<HubTap> {
        self.shared.channel(channel).map(HubTap::new)
    }

    /// Frames sent in all channels so far.
    #[must_use]
    pub fn frames(&self) -> u64 {
        self.shared
            .channels
            .iter()
            .map(|channel| channel.frames())
            .sum()
    }

    /// Frames that were not given to a participant because it did not read.
    #[must_use]
    pub fn dropped(&self) -> u64 {
        self.shared
            .channels
            .iter()
            .map(|channel| channel.dropped())
            .sum()
    }

    /// Clients connected now.
    #[must_use]
    pub fn clients(&self) -> usize {
        self.shared.clients().len()
    }
}

impl Drop for HubServer {
    fn drop(&mut self) {
        self.shared.ending.store(true, Ordering::SeqCst);
        // Wakes the acceptor; a wildcard address is reached through loopback.
        let mut wake = self.address;
        if wake.ip().is_unspecified() {
            wake.set_ip(match wake {
                SocketAddr::V4(_) => std::net::Ipv4Addr::LOCALHOST.into(),
                SocketAddr::V6(_) => std::net::Ipv6Addr::LOCALHOST.into(),
            });
        }
        let woken = TcpStream::connect_timeout(&wake, Duration::from_secs(1)).is_ok();
        if let Some(acceptor) = self.acceptor.take()
            && woken
        {
            let _ = acceptor.join();
        }
        for stream in self.shared.clients().values() {
            let _ = stream.shutdown(Shutdown::Both);
        }
    }
}

fn accept(listener: &TcpListener, shared: &Arc<Shared>) {
    let mut next = 0;
    for stream in listener.incoming() {
        if shared.ending.load(Ordering::SeqCst) {
            return;
        }
        let Ok(stream) = stream else {
            // Out of descriptors, for instance: others may leave.
            thread::sleep(Duration::from_millis(10));
            continue;
        };
        if shared.clients().len() >= MAX_CLIENTS {
            let _ = (&stream).write_all(b"< error too many clients >");
            continue;
        }
        let Ok(registered) = stream.try_clone() else {
            continue;
        };
        next += 1;
        let number = next;
        shared.clients().insert(number, registered);
        let serving = Arc::clone(shared);
        let started = thread::Builder::new()
            .name(format!("hub client {number}"))
            .spawn(move || {
                let _ = serve(&stream, &serving);
                let _ = stream.shutdown(Shutdown::Both);
                serving.clients().remove(&number);
            });
        if started.is_err() {
            shared.clients().remove(&number);
        }
    }
}

/// What a connection has come to.
enum Mode {
    NoBus,
    /// A channel is open; nothing is delivered yet.
    Bcm(Arc<Channel>),
    Raw {
        member: Member,
        channel: Arc<Channel>,
        writer: Writer,
    },
}

/// Serves one client until it leaves or misbehaves.
fn serve(stream: &TcpStream, shared: &Shared) -> io::Result<()> {
    stream.set_nodelay(true)?;
    stream.set_write_timeout(Some(STUCK))?;
    stream.set_read_timeout(Some(HANDSHAKE))?;
    // Answers and frames come from two threads: whole elements only.
    let out = Arc::new(Mutex::new(stream.try_clone()?));
    say(&out, "< hi >")?;
    let mut mode = Mode::NoBus;
    let mut cutter = Cutter::default();
    let mut bytes = [0; 4096];
    loop {
        let read = (&*stream).read(&mut bytes)?;
        if read == 0 {
            return Ok(());
        }
        let mut result = Ok(());
        let cut = cutter.feed(bytes.get(..read).unwrap_or(&[]), &mut |text| {
            let previous = std::mem::replace(&mut mode, Mode::NoBus);
            match act(previous, element::command(text), shared, stream, &out) {
                Ok(next) => mode = next,
                Err(error) => result = Err(error),
            }
            result.is_ok()
        });
        result?;
        if cut.is_err() {
            return say(&out, "< error the command is too long >");
        }
    }
}

fn act(
    mode: Mode,
    command: Command,
    shared: &Shared,
    stream: &TcpStream,
    out: &Arc<Mutex<TcpStream>>,
) -> io::Result<Mode> {
    match (mode, command) {
        (mode, Command::Echo) => say(out, "< echo >").map(|()| mode),
        (Mode::NoBus, Command::Open(name)) => {
            let Some(channel) = shared.channel(&name) else {
                let names: Vec<&str> = shared.channels.iter().map(|c| c.name.as_str()).collect();
                let known = names.join(", ");
                say(
                    out,
                    &format!("< error could not open bus: this hub has {known} >"),
                )?;
                return Err(io::ErrorKind::NotFound.into());
            };
            stream.set_read_timeout(None)?;
            say(out, "< ok >")?;
            Ok(Mode::Bcm(Arc::clone(channel)))
        }
        (Mode::NoBus, _) => {
            say(out, "< error open a bus first >")?;
            Ok(Mode::NoBus)
        }
        (Mode::Bcm(channel), Command::RawMode) => {
            // A member before the acknowledgement, so that whatever is sent after it is heard; a
            // writer after it, so that no frame can come first or share its packet.
            let (member, items) = Member::join(&channel);
            say(out, "< ok >")?;
            let writer = Writer::start(items, Arc::clone(out))?;
            Ok(Mode::Raw {
                member,
                channel,
                writer,
            })
        }
        (mode @ Mode::Raw { .. }, Command::RawMode) | (mode @ Mode::Bcm(_), Command::BcmMode) => {
            say(out, "< ok >").map(|()| mode)
        }
        (
            Mode::Raw {
                channel,
                member,
                writer,
            },
            Command::BcmMode,
        ) => {
            drop(member);
            writer.join();
            say(out, "< ok >")?;
            Ok(Mode::Bcm(channel))
        }
        (
            Mode::Raw {
                member,
                channel,
                writer,
            },
            Command::Send(frame),
        ) => {
            member.publish(&frame);
            Ok(Mode::Raw {
                member,
                channel,
                writer,
            })
        }
        (Mode::Bcm(channel), Command::Send(frame)) => {
            channel.publish(u64::MAX, &frame);
            Ok(Mode::Bcm(channel))
        }
        (mode, Command::Open(_)) => say(out, "< error a bus is open already >").map(|()| mode),
        (mode, Command::Refused(why)) => say(out, &format!("< error {why} >")).map(|()| mode),
    }
}

fn say(out: &Mutex<TcpStream>, text: &str) -> io::Result<()> {
    out.lock()
        .unwrap_or_else(PoisonError::into_inner)
        .write_all(text.as_bytes())
}

/// The thread that writes frames to one client; it ends when the membership does.
struct Writer(JoinHandle<()>);

impl Writer {
    fn start(items: Receiver<Item>, out: Arc<Mutex<TcpStream>>) -> io::Result<Self> {
        let held = Instant::now() + HOLD;
        thread::Builder::new()
            .name("hub writer".into())
            .spawn(move || write_frames(&items, &out, held))
            .map(Self)
    }

    fn join(self) {
        let _ = self.0.join();
    }
}

/// Frames that are ready are sent in one packet, up to this many bytes.
const PACKET: usize = 8 * 1024;

fn write_frames(items: &Receiver<Item>, out: &Mutex<TcpStream>, held: Instant) {
    let mut text = String::new();
    loop {
        // Wakes now and then only to notice the end of the membership early.
        let item = match items.recv_timeout(Duration::from_secs(1)) {
            Ok(item) => item,
            Err(RecvTimeoutError::Timeout) => continue,
            Err(RecvTimeoutError::Disconnected) => return,
        };
        thread::sleep(held.saturating_duration_since(Instant::now()));
        text.clear();
        element::write_frame(&mut text, &item.frame, item.epoch_us);
        while text.len() < PACKET
            && let Ok(item) = items.try_recv()
        {
            element::write_frame(&mut text, &item.frame, item.epoch_us);
        }
        if say(out, &text).is_err() {
            // The client does not read: end its connection, which ends the reader, too.
            let stream = out.lock().unwrap_or_else(PoisonError::into_inner);
            let _ = stream.shutdown(Shutdown::Both);
            return;
        }
    }
}
