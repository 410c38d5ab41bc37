//! The node's ports on real buses.

use crate::answers::{Answers, PATIENCE};
use bus::hub::HubClient;
use bus::spec::Place;
use bus::{Bus, BusError, Hears, StateChange, now, open_can};
use firmware::config::ForceAddress;
use firmware::process::drive_buses;
use firmware::{Port, Received};
use process::{End, exit};
use protocol::frame::{Frame, Id};
use protocol::time::Micros;
use protocol::transfer::Mtu;
use robots::RobotKind;
use std::thread;
use std::time::Duration;

/// The first attempt to reach a hub; only then is it told that the process waits.
const FIRST_TRY: Micros = Micros::from_millis(500);
/// How long the process waits for its hub in all.
const HUB_PATIENCE: Micros = Micros::from_millis(10_000);
/// The MP's bus is looked at this often, so that the arrival of a frame is known this well.
const SLICE: Micros = Micros(250);
/// Between two looks for late answers.
const LOOK: Duration = Duration::from_micros(50);

/// What hangs on a connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Serves {
    Mp,
    Drives(u8),
    /// 29-bit identifiers are the MP's, 11-bit ones the drives'.
    OneWire,
}

impl Serves {
    const fn port_of(self, frame: &Frame) -> Port {
        match (self, frame.id()) {
            (Self::Mp, _) | (Self::OneWire, Id::Extended(_)) => Port::Mp,
            (Self::Drives(bus), _) => Port::Drives(bus),
            (Self::OneWire, Id::Standard(_)) => Port::Drives(0),
        }
    }

    fn carries(self, port: Port) -> bool {
        match self {
            Self::Mp => port == Port::Mp,
            Self::Drives(bus) => port == Port::Drives(bus),
            Self::OneWire => true,
        }
    }
}

struct Connection {
    bus: Box<dyn Bus>,
    serves: Serves,
    answers: Answers,
    failed: bool,
}

/// What happened on the buses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Traffic {
    /// Frames sent.
    pub(crate) sent: u64,
    /// Frames received.
    pub(crate) received: u64,
    /// Frames for which the transport had no room.
    pub(crate) dropped: u64,
    /// SYNCs whose answers were late and awaited.
    pub(crate) awaited: u64,
    /// The longest time answers were awaited.
    pub(crate) awaited_worst: Micros,
}

/// All connections of the node.
pub(crate) struct Ports {
    connections: Vec<Connection>,
    awaits: bool,
    traffic: Traffic,
    failure: Option<BusError>,
}

/// The connections, and what follows from them.
pub(crate) struct Opened {
    /// The ports.
    pub(crate) ports: Ports,
    /// Frame size towards the MP.
    pub(crate) mtu: Mtu,
}

/// Connects to the buses of a robot's node, with that of its force sensor. On one wire `drives` are the ids of its own:
/// others do not concern it.
///
/// # Errors
/// When the bus is not there, after a bounded wait for a hub.
pub(crate) fn open(
    place: &Place,
    robot: RobotKind,
    drives: &[u8],
    force: Option<ForceAddress>,
    wait: &mut dyn FnMut(String),
) -> Result<Opened, End> {
    let unavailable = |error: BusError| End::new(exit::UNAVAILABLE, error.to_string());
    match place {
        Place::Hub { host, port } => {
            let give_up = now() + HUB_PATIENCE;
            let sensor = force.map(|force| force.bus);
            let last = drive_buses(robot).into_iter().chain(sensor).max();
            let buses = last.map_or(0, |last| last + 1);
            let drives = (0..buses).map(|bus| (Serves::Drives(bus), format!("{robot}.{bus}")));
            let mut connections = Vec::new();
            for (serves, channel) in std::iter::once((Serves::Mp, "mp".to_owned())).chain(drives) {
                let first = HubClient::connect(host, *port, &channel, now() + FIRST_TRY);
                let client = first.or_else(|error| {
                    wait(format!(
                        "{robot}: {error}; trying again for {:.0} s",
                        give_up.since(now()).as_secs_f64()
                    ));
                    HubClient::connect(host, *port, &channel, give_up)
                });
                connections.push(Connection::new(
                    Box::new(client.map_err(unavailable)?),
                    serves,
                ));
            }
            Ok(Opened {
                ports: Ports::new(connections, true),
                mtu: Mtu::Classic,
            })
        }
        Place::Can { interface } => {
            // its two frames have identifiers whose last seven bits are these
            let sensor = force.map(|force| force.number.force_cob().to_le_bytes()[0] & 0x7F);
            let sensor = sensor.into_iter().flat_map(|first| [first, first + 1]);
            let ids: Vec<u8> = drives.iter().copied().chain(sensor).collect();
            let (bus, mtu) = open_can(interface, Hears::Node(&ids)).map_err(unavailable)?;
            Ok(one_wire(bus, mtu))
        }
        Place::Slcan(adapter) => {
            let line = adapter.open().map_err(unavailable)?;
            Ok(one_wire(Box::new(line), Mtu::Classic))
        }
    }
}

fn one_wire(bus: Box<dyn Bus>, mtu: Mtu) -> Opened {
    let connections = vec![Connection::new(bus, Serves::OneWire)];
    Opened {
        ports: Ports::new(connections, false),
        mtu,
    }
}

impl Connection {
    fn new(bus: Box<dyn Bus>, serves: Serves) -> Self {
        Self {
            bus,
            serves,
            answers: Answers::default(),
            failed: false,
        }
    }
}

impl Ports {
    const fn new(connections: Vec<Connection>, awaits: bool) -> Self {
        let traffic = Traffic {
            sent: 0,
            received: 0,
            dropped: 0,
            awaited: 0,
            awaited_worst: Micros(0),
        };
        Self {
            connections,
            awaits,
            traffic,
            failure: None,
        }
    }

    /// What happened so far.
    pub(crate) const fn traffic(&self) -> Traffic {
        self.traffic
    }

    /// A CAN controller whose state has changed: each change is told once.
    pub(crate) fn take_change(&mut self) -> Option<StateChange> {
        let mut connections = self.connections.iter_mut();
        connections.find_map(|connection| connection.bus.take_change())
    }

    /// Why a connection has failed: told once.
    pub(crate) fn take_failure(&mut self) -> Option<BusError> {
        self.failure.take()
    }

    /// Has every connection failed?
    pub(crate) fn all_failed(&self) -> bool {
        self.connections.iter().all(|connection| connection.failed)
    }

    /// Sends a frame; one for which there is no room, or no bus now, is lost and counted.
    pub(crate) fn send(&mut self, port: Port, frame: &Frame) {
        let Self {
            connections,
            traffic,
            failure,
            ..
        } = self;
        let carries = connections
            .iter_mut()
            .find(|c| c.serves.carries(port) && !c.failed);
        let Some(connection) = carries else { return };
        match connection.bus.send(frame) {
            Ok(()) => {
                traffic.sent += 1;
                if port != Port::Mp {
                    connection.answers.sent(frame);
                }
            }
            Err(BusError::Full { .. } | BusError::Down { .. }) => traffic.dropped += 1,
            Err(error) => {
                connection.failed = true;
                failure.get_or_insert(error);
            }
        }
    }

    /// Waits for an instant, then hands over what has arrived.
    pub(crate) fn wait_until(&mut self, at: Micros, rx: &mut Vec<Received>) {
        loop {
            let left = at.since(now());
            if left == Micros(0) {
                break;
            }
            thread::sleep(Duration::from_micros(left.min(SLICE).0));
            self.take(rx, Serves::Mp);
        }
        for serves in [
            Serves::Mp,
            Serves::Drives(0),
            Serves::Drives(1),
            Serves::OneWire,
        ] {
            self.take(rx, serves);
        }
    }

    /// On a hub: waits a little for drives that have not answered yet.
    pub(crate) fn await_answers(&mut self, rx: &mut Vec<Received>) {
        if !self.awaits || !self.missing() {
            return;
        }
        let began = now();
        while self.missing() && now().since(began) < PATIENCE {
            thread::sleep(LOOK);
            self.take(rx, Serves::Drives(0));
            self.take(rx, Serves::Drives(1));
        }
        self.traffic.awaited += 1;
        let waited = now().since(began);
        self.traffic.awaited_worst = self.traffic.awaited_worst.max(waited);
        for connection in &mut self.connections {
            connection.answers.settle();
        }
    }

    fn missing(&self) -> bool {
        self.connections
            .iter()
            .any(|connection| !connection.failed && connection.answers.missing())
    }

    fn take(&mut self, rx: &mut Vec<Received>, which: Serves) {
        let Self {
            connections,
            traffic,
            failure,
            ..
        } = self;
        for connection in connections
            .iter_mut()
            .filter(|c| c.serves == which && !c.failed)
        {
            loop {
                match connection.bus.receive() {
                    Ok(Some(bus::Received { frame, at })) => {
                        let port = connection.serves.port_of(&frame);
                        traffic.received += 1;
                        if port != Port::Mp {
                            connection.answers.received(&frame);
                        }
                        rx.push(Received { port, at, frame });
                    }
                    Ok(None) => break,
                    Err(error) => {
                        connection.failed = true;
                        failure.get_or_insert(error);
                        break;
                    }
                }
            }
        }
    }
}
