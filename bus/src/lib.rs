//! How frames travel: the virtual wire, the socketcand hub, SocketCAN, and their logs.
//!
//! | module | one line |
//! |---|---|
//! | [`wire`] | a virtual segment with arbitration and exact frame lengths, in virtual time |
//! | [`hub`] | a loopback TCP server of the socketcand protocol, and its client |
//! | [`socketcan`](open_can) | Linux network interfaces (module `socketcan`, Linux only) |
//! | [`slcan`] | adapters on serial lines and TCP ports |
//! | [`candump`] | log lines of can-utils, written and read |
//! | [`spec`] | what `--bus` may say |
//!
//! A transport in real time implements [`Bus`]. A virtual [`wire::Wire`] does not: it has no time
//! of its own, and is driven by its owner.
#![forbid(unsafe_code)]

mod can;
pub mod candump;
pub mod hub;
pub mod slcan;
#[cfg(target_os = "linux")]
pub mod socketcan;
pub mod spec;
pub mod wire;

pub use can::{Hears, MAX_IDS, open_can};

use protocol::frame::Frame;
use protocol::time::Micros;
use std::fmt;
use std::io;
use std::sync::OnceLock;
use std::time::{Duration, Instant};

/// A frame and when it was received, local time ([`now`]).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Received {
    /// The frame.
    pub frame: Frame,
    /// When this process saw it, or when the driver stamped it.
    pub at: Micros,
}

/// A CAN controller whose state has changed, as one line that says what it means and what helps.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StateChange {
    /// The connection.
    pub bus: String,
    /// Its state from now on.
    pub state: wire::confinement::State,
}

impl fmt::Display for StateChange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let bus = &self.bus;
        match self.state {
            wire::confinement::State::Active => write!(f, "{bus}: error-active again"),
            wire::confinement::State::Passive => write!(
                f,
                "{bus}: error-passive: frames are damaged or nobody acknowledges them; look at the cable, its two \
                 terminations, the bit rate, and whether the others have power"
            ),
            wire::confinement::State::BusOff => {
                write!(f, "{bus}: bus-off: nothing is sent or heard any more")?;
                match bus.strip_prefix("can:") {
                    Some(interface) => write!(
                        f,
                        "; once the cause is gone, `ip link set {interface} type can restart`"
                    ),
                    None => Ok(()),
                }
            }
        }
    }
}

/// A connection to a bus, in real time. Own frames are not received.
pub trait Bus {
    /// Hands a frame to the transport; never blocks.
    ///
    /// # Errors
    /// [`BusError::Full`] when the transport has no room now, [`BusError::Down`] while it is switched
    /// off: the frame was not sent, and later ones may be. Anything else: see [`BusError`].
    fn send(&mut self, frame: &Frame) -> Result<(), BusError>;

    /// The next frame that has arrived, if any; never blocks.
    ///
    /// # Errors
    /// When the transport has failed; it then stays failed.
    fn receive(&mut self) -> Result<Option<Received>, BusError>;

    /// The state of the CAN controller behind this connection, each time it has changed; of a transport that tells it.
    fn take_change(&mut self) -> Option<StateChange> {
        None
    }

    /// Returns when a frame has arrived or at `deadline` ([`now`]), whichever is first.
    ///
    /// # Errors
    /// When the transport has failed.
    fn wait(&mut self, deadline: Micros) -> Result<(), BusError>;
}

impl<B: Bus + ?Sized> Bus for Box<B> {
    fn send(&mut self, frame: &Frame) -> Result<(), BusError> {
        (**self).send(frame)
    }
    fn receive(&mut self) -> Result<Option<Received>, BusError> {
        (**self).receive()
    }
    fn take_change(&mut self) -> Option<StateChange> {
        (**self).take_change()
    }
    fn wait(&mut self, deadline: Micros) -> Result<(), BusError> {
        (**self).wait(deadline)
    }
}

/// Why a transport did not do what was asked. Every message is one line.
#[derive(Debug, thiserror::Error)]
pub enum BusError {
    /// No room to send now; try again or drop what is stale.
    #[error("{bus}: the transmit queue is full")]
    Full {
        /// The connection.
        bus: String,
    },
    /// The interface is switched off; frames are lost until it is switched on.
    #[error("{bus}: the interface is down")]
    Down {
        /// The connection.
        bus: String,
    },
    /// A CAN FD frame on a transport that carries classical frames only.
    #[error("{bus}: CAN FD frames are not supported here (classical CAN only)")]
    FdUnsupported {
        /// The connection.
        bus: String,
    },
    /// The connection could not be made.
    #[error("{bus}: {reason}")]
    Open {
        /// The connection.
        bus: String,
        /// Why, and what to do.
        reason: String,
    },
    /// The other side ended the connection or broke the protocol.
    #[error("{bus}: connection lost: {reason}")]
    Lost {
        /// The connection.
        bus: String,
        /// How.
        reason: String,
    },
    /// The operating system refused.
    #[error("{bus}: {source}")]
    Io {
        /// The connection.
        bus: String,
        /// Its words.
        source: io::Error,
    },
}

/// Local time: µs since this function was first called in this process; monotonic.
#[must_use]
pub fn now() -> Micros {
    static ORIGIN: OnceLock<Instant> = OnceLock::new();
    let elapsed = ORIGIN.get_or_init(Instant::now).elapsed();
    Micros(u64::try_from(elapsed.as_micros()).unwrap_or(u64::MAX))
}

/// The time left until `deadline`.
pub(crate) fn until(deadline: Micros) -> Duration {
    Duration::from_micros(deadline.since(now()).0)
}
