//! The drives as the node sees them: CANopen master of one robot's axes.
//!
//! Each [`DriveLink`] brings one CiA 402 drive from power-up to "operational" by a fixed script of
//! SDO writes, then exchanges process data with it at every SYNC. It decides nothing about motion.

mod layer;
mod link;
mod script;

pub use link::{DriveLink, Task};
pub use script::{AxisSetup, DRIVE_HEARTBEAT_MS};

use crate::capacity::DRIVE_BUSES;
use crate::config::DriveAddress;
use crate::io::Port;
use layer::Layer;
use protocol::canopen::sync::SyncProducer;
use protocol::canopen::{lss, nmt, node::NodeId as DriveId};
use protocol::fault::Cause;
use protocol::frame::{Frame, Id};
use protocol::message::Event;
use protocol::time::Micros;
use protocol::units::MAX_AXES;

/// What one axis reported for one SYNC.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct AxisActual {
    /// Position, drive units.
    pub position: i32,
    /// Torque, per mille of rated.
    pub torque: i16,
    /// Statusword.
    pub statusword: u16,
    /// Did it arrive for this SYNC? If not, the values are the last ones.
    pub fresh: bool,
}

/// All drives of the robot.
#[derive(Debug)]
pub struct Drives<const N: usize> {
    links: [DriveLink; N],
    /// The LSS master of each bus.
    layers: [Layer; DRIVE_BUSES],
    sync: SyncProducer,
    master: DriveId,
    heartbeat: nmt::HeartbeatProducer,
    buses: u8,
}

/// A drive that has not booted in this time after a reset is missing: slow ones take 2 s.
const BOOT_TIMEOUT: Micros = Micros::from_millis(3000);

/// The period of the node's own heartbeat to its drives; they watch for three times that.
pub const MASTER_HEARTBEAT: Micros = Micros::from_millis(100);

impl<const N: usize> Drives<N> {
    /// Drives at these addresses, nothing known of them yet.
    #[must_use]
    pub fn new(
        now: Micros,
        addresses: &[DriveAddress; N],
        setups: &[AxisSetup; N],
        sync_cob: u16,
        master: DriveId,
    ) -> Self {
        let mut k = 0_usize;
        let links = addresses.map(|address| {
            let setup = setups.get(k).copied().unwrap_or_default();
            k = k.saturating_add(1);
            DriveLink::new(now, address, setup)
        });
        let buses = addresses
            .iter()
            .map(|a| a.bus.saturating_add(1))
            .max()
            .unwrap_or(0);
        Self {
            links,
            layers: layers(),
            sync: SyncProducer::new(sync_cob, 0),
            master,
            heartbeat: nmt::HeartbeatProducer::new(now, MASTER_HEARTBEAT),
            buses,
        }
    }

    /// The links, in axis order.
    #[must_use]
    pub const fn links(&self) -> &[DriveLink; N] {
        &self.links
    }

    /// One link.
    pub fn link_mut(&mut self, axis: usize) -> Option<&mut DriveLink> {
        self.links.get_mut(axis)
    }

    /// A frame from a drive bus.
    pub fn on_frame(&mut self, now: Micros, bus: u8, frame: &Frame) {
        let Id::Standard(cob) = frame.id() else {
            return;
        };
        if cob == lss::SLAVE_COB {
            if let Some(layer) = self.layers.get_mut(usize::from(bus)) {
                layer.on_answer(frame.data());
            }
            return;
        }
        let id = (cob & 0x7F) as u8;
        let at = |link: &&mut DriveLink| link.address().bus == bus && link.address().id.get() == id;
        if let Some(link) = self.links.iter_mut().find(at) {
            link.on_frame(now, cob & !0x7F, frame);
        }
    }

    /// Forget what was known and configure every drive again.
    pub fn restart(&mut self, now: Micros) {
        for link in &mut self.links {
            link.restart(now);
        }
        self.layers = layers();
    }

    /// What was found out about who a drive is, since the last call: [`Event::DriveFound`].
    pub fn take_news(&mut self) -> Option<Event> {
        let of_axes = (0_u8..8).zip(&mut self.links);
        let mut of_axes = of_axes.filter_map(|(axis, link)| link.take_news(axis));
        of_axes
            .next()
            .or_else(|| self.layers.iter_mut().find_map(Layer::take_stranger))
    }

    /// Send SYNC on every drive bus: drives latch their targets and sample their actual values.
    pub fn sync(&mut self, tx: &mut impl FnMut(Port, Frame)) {
        let frame = self.sync.produce();
        for bus in 0..self.buses {
            tx(Port::Drives(bus), frame);
        }
        for link in &mut self.links {
            link.on_sync();
        }
    }

    /// In the fast profile: send the groups of this servo step, for each controlword one.
    pub fn send_groups(&mut self, tx: &mut impl FnMut(Port, Frame)) {
        for bus in 0..self.buses {
            // each group takes one drive at least
            for _ in 0..N {
                let mut group = None;
                for link in &mut self.links {
                    link.join(bus, &mut group);
                }
                let Some(frame) = group.and_then(|group| group.frame(self.sync.cob())) else {
                    break;
                };
                tx(Port::Drives(bus), frame);
            }
        }
    }

    /// Configuration, requests in progress, heartbeats; after the servo's frames are out.
    pub fn poll(&mut self, now: Micros, tx: &mut impl FnMut(Port, Frame)) {
        if self.heartbeat.due(now) {
            let frame = nmt::heartbeat_frame(self.master, nmt::State::Operational);
            for bus in 0..self.buses {
                tx(Port::Drives(bus), frame);
            }
        }
        for link in &mut self.links {
            link.poll(now, tx);
        }
        for layer in &mut self.layers {
            if let Some((port, frame)) = layer.poll(now, &mut self.links) {
                tx(port, frame);
            }
        }
    }

    /// Are all drives configured and operational?
    pub fn ready(&self) -> bool {
        self.links.iter().all(DriveLink::is_ready)
    }

    /// The first thing that is wrong with a drive, and with which.
    #[must_use]
    pub fn fault(&self) -> Option<(usize, Cause)> {
        (0..MAX_AXES)
            .zip(&self.links)
            .find_map(|(axis, link)| Some((axis, link.fault()?)))
    }
}

/// LSS masters that know nothing of their buses.
fn layers() -> [Layer; DRIVE_BUSES] {
    let mut bus = 0_u8;
    [(); DRIVE_BUSES].map(|()| {
        let layer = Layer::new(bus);
        bus = bus.saturating_add(1);
        layer
    })
}
