//! What `--bus` may say.
//!
//! ```text
//! virtual            in this process, with the simulator
//! hub                a socketcand hub on this machine, port 29536
//! hub:PORT           the same, another port
//! hub:HOST:PORT      a hub elsewhere (loopback only, unless remote hosts are allowed)
//! can:IFACE          a Linux CAN interface, e.g. can:can0
//! slcan:DEVICE       an adapter on a serial device, e.g. slcan:/dev/ttyACM0
//! slcan:HOST:PORT    an adapter behind a TCP port (as for hubs: loopback only, unless …)
//! ```
//!
//! Who can bring the robots along in its own process takes a [`BusSpec`]; who needs a bus to others
//! takes a [`Place`], which is never virtual.

use crate::BusError;
use crate::hub::DEFAULT_PORT;
use crate::slcan::Slcan;
use std::fmt;
use std::net::IpAddr;
use std::str::FromStr;

/// Which bus to use.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum BusSpec {
    /// In this process, with the simulator.
    Virtual,
    /// Between processes.
    Place(Place),
}

/// A bus between processes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Place {
    /// A socketcand hub.
    Hub {
        /// Name or address, without brackets.
        host: String,
        /// TCP port.
        port: u16,
    },
    /// A Linux CAN interface.
    Can {
        /// Its name, 1 to 15 bytes.
        interface: String,
    },
    /// An adapter that speaks slcan.
    Slcan(Adapter),
}

/// Where an adapter is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Adapter {
    /// A serial device: its path, or its name.
    Device(String),
    /// A TCP port.
    Tcp {
        /// Name or address, without brackets.
        host: String,
        /// TCP port.
        port: u16,
    },
}

/// May a hub be on another machine?
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reach {
    /// This machine only.
    Loopback,
    /// Any machine. The hub's protocol has neither authentication nor encryption.
    Remote,
}

/// What names a [`Place`].
const PLACES: &str = "hub, hub:PORT, hub:HOST:PORT, can:INTERFACE, slcan:DEVICE or slcan:HOST:PORT";
/// What names a [`BusSpec`].
const ALL: &str =
    "virtual, hub, hub:PORT, hub:HOST:PORT, can:INTERFACE, slcan:DEVICE or slcan:HOST:PORT";

/// Why a text names no bus. Every message is one line.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SpecError {
    /// Not one of the kinds.
    #[error("unknown bus {text:?}: expected {expected}")]
    Unknown {
        /// What was given.
        text: String,
        /// What is possible.
        expected: &'static str,
    },
    /// `virtual` where others must be reached.
    #[error("bus \"virtual\": it lives inside one process (expected {PLACES})")]
    Virtual,
    /// Not a TCP port.
    #[error("bus {text:?}: {port:?} is not a port (1 to 65535)")]
    Port {
        /// What was given.
        text: String,
        /// The part at fault.
        port: String,
    },
    /// No host name, or one with characters that no host name has.
    #[error("bus {text:?}: {host:?} is not a host name or address (IPv6 in brackets)")]
    Host {
        /// What was given.
        text: String,
        /// The part at fault.
        host: String,
    },
    /// Not the name of a serial device.
    #[error("bus {text:?}: {name:?} is not a device (1 to 64 characters, no space or colon)")]
    Device {
        /// What was given.
        text: String,
        /// The part at fault.
        name: String,
    },
    /// On another machine, which was not allowed.
    #[error("bus {text:?}: {host:?} is not this machine; remote ones must be allowed explicitly")]
    Remote {
        /// What was given.
        text: String,
        /// The part at fault.
        host: String,
    },
    /// Not an interface name.
    #[error("bus {text:?}: {name:?} is not an interface name (1 to 15 characters, no / or space)")]
    Interface {
        /// What was given.
        text: String,
        /// The part at fault.
        name: String,
    },
}

impl BusSpec {
    /// The bus that `text` names.
    ///
    /// # Errors
    /// When it names none, or a hub on another machine although `reach` is loopback.
    pub fn parse(text: &str, reach: Reach) -> Result<Self, SpecError> {
        if text == "virtual" {
            return Ok(Self::Virtual);
        }
        match Place::parse(text, reach) {
            Err(SpecError::Unknown { text, .. }) => Err(SpecError::Unknown {
                text,
                expected: ALL,
            }),
            place => place.map(Self::Place),
        }
    }
}

impl Place {
    /// The bus between processes that `text` names.
    ///
    /// # Errors
    /// When it names none, or a hub on another machine although `reach` is loopback.
    pub fn parse(text: &str, reach: Reach) -> Result<Self, SpecError> {
        match text.split_once(':') {
            None if text == "virtual" => Err(SpecError::Virtual),
            None if text == "hub" => Ok(Self::hub("127.0.0.1", DEFAULT_PORT)),
            Some(("hub", place)) => Self::parse_hub(text, place, reach),
            Some(("can", name)) if is_interface(name) => Ok(Self::Can {
                interface: name.to_owned(),
            }),
            Some(("can", name)) => Err(SpecError::Interface {
                text: shown(text),
                name: shown(name),
            }),
            Some(("slcan", place)) => Adapter::parse(text, place, reach).map(Self::Slcan),
            _ => Err(SpecError::Unknown {
                text: shown(text),
                expected: PLACES,
            }),
        }
    }

    /// `place` is what follows `hub:` in `text`.
    fn parse_hub(text: &str, place: &str, reach: Reach) -> Result<Self, SpecError> {
        let (host, port) = match place.rsplit_once(':') {
            Some((host, port)) => (bare(host), port),
            None => (Some("127.0.0.1"), place),
        };
        let (host, port) = reachable(text, place, (host, port), reach)?;
        Ok(Self::hub(host, port))
    }

    fn hub(host: &str, port: u16) -> Self {
        Self::Hub {
            host: host.to_owned(),
            port,
        }
    }
}

impl Adapter {
    /// `place` is what follows `slcan:` in `text`.
    fn parse(text: &str, place: &str, reach: Reach) -> Result<Self, SpecError> {
        if let Some((host, port)) = place.rsplit_once(':') {
            let (host, port) = reachable(text, place, (bare(host), port), reach)?;
            let host = host.to_owned();
            return Ok(Self::Tcp { host, port });
        }
        let length = place.chars().count();
        if (1..=64).contains(&length) && place.bytes().all(|b| b.is_ascii_graphic()) {
            return Ok(Self::Device(place.to_owned()));
        }
        Err(SpecError::Device {
            text: shown(text),
            name: shown(place),
        })
    }

    /// Connects to it.
    ///
    /// # Errors
    /// One line that says why there is none.
    pub fn open(&self) -> Result<Slcan, BusError> {
        match self {
            Self::Device(path) => Slcan::device(path),
            Self::Tcp { host, port } => Slcan::tcp(host, *port),
        }
    }
}

/// A host and a port, checked; `place` is the part of `text` that names them.
fn reachable<'a>(
    text: &str,
    place: &str,
    (host, port): (Option<&'a str>, &str),
    reach: Reach,
) -> Result<(&'a str, u16), SpecError> {
    let host = host
        .filter(|host| is_host(host))
        .ok_or_else(|| SpecError::Host {
            text: shown(text),
            host: shown(place),
        })?;
    let number = port
        .parse()
        .ok()
        .filter(|_| port.bytes().all(|b| b.is_ascii_digit()));
    let Some(number @ 1..) = number else {
        return Err(SpecError::Port {
            text: shown(text),
            port: shown(port),
        });
    };
    if reach == Reach::Loopback && !is_loopback(host) {
        return Err(SpecError::Remote {
            text: shown(text),
            host: host.to_owned(),
        });
    }
    Ok((host, number))
}

impl FromStr for BusSpec {
    type Err = SpecError;

    /// As [`BusSpec::parse`], this machine only.
    fn from_str(text: &str) -> Result<Self, SpecError> {
        Self::parse(text, Reach::Loopback)
    }
}

impl FromStr for Place {
    type Err = SpecError;

    /// As [`Place::parse`], this machine only.
    fn from_str(text: &str) -> Result<Self, SpecError> {
        Self::parse(text, Reach::Loopback)
    }
}

impl fmt::Display for BusSpec {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Virtual => f.write_str("virtual"),
            Self::Place(place) => place.fmt(f),
        }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Hub { host, port } if host.contains(':') => write!(f, "hub:[{host}]:{port}"),
            Self::Hub { host, port } => write!(f, "hub:{host}:{port}"),
            Self::Can { interface } => write!(f, "can:{interface}"),
            Self::Slcan(adapter) => adapter.fmt(f),
        }
    }
}

impl fmt::Display for Adapter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Device(path) => write!(f, "slcan:{path}"),
            Self::Tcp { host, port } if host.contains(':') => write!(f, "slcan:[{host}]:{port}"),
            Self::Tcp { host, port } => write!(f, "slcan:{host}:{port}"),
        }
    }
}

/// As much of what was given as a message shows.
fn shown(text: &str) -> String {
    text.chars().take(80).collect()
}

/// Without the brackets of an IPv6 address; `None` if it has colons but no brackets.
fn bare(host: &str) -> Option<&str> {
    match host.strip_prefix('[') {
        Some(inner) => inner.strip_suffix(']').filter(|inner| inner.contains(':')),
        None => Some(host).filter(|host| !host.contains(':')),
    }
}

fn is_host(host: &str) -> bool {
    let known = |b: u8| b.is_ascii_alphanumeric() || matches!(b, b'.' | b'-' | b'_');
    host.parse::<IpAddr>().is_ok() || (1..=253).contains(&host.len()) && host.bytes().all(known)
}

/// Does this host name mean this machine, without asking a name server?
pub(crate) fn is_loopback(host: &str) -> bool {
    host == "localhost"
        || host
            .parse::<IpAddr>()
            .is_ok_and(|address| address.is_loopback())
}

/// As the Linux kernel's `dev_valid_name`.
fn is_interface(name: &str) -> bool {
    (1..=15).contains(&name.len())
        && name != "."
        && name != ".."
        && name
            .bytes()
            .all(|b| b.is_ascii_graphic() && b != b'/' && b != b':')
}

#[cfg(test)]
mod tests;
