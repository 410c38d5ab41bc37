//! What a robot's node and drives are made of, before they are in a cell.

use super::CellError;
use crate::drive::quirk::Quirks;
use crate::plant::parameters::{RobotSetup, robot};
use firmware::config::ForceAddress;
use firmware::{DriveAddress, KnownDrives, Node, NodeProcess, Station};
use protocol::time::Micros;
use robots::{Robot, RobotKind, RobotVisitor};

/// How the drives of a robot, and what else hangs on their buses, are wired.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Wiring<'a> {
    /// On which of its drive buses each axis hangs (see [`firmware::process::drive_buses`]).
    pub buses: &'a [u8],
    /// The buses are CAN FD, on which node and drives speak the fast profile ([`protocol::canopen::fast`],
    /// experimental).
    pub fast: bool,
    /// The force sensor in the wrist, if there is one.
    pub force: Option<ForceAddress>,
    /// What the node is told of its drives.
    pub drives: KnownDrives<'a>,
}

impl<'a> Wiring<'a> {
    /// Classical buses for drives alone.
    #[must_use]
    pub const fn classic(buses: &'a [u8]) -> Self {
        Self {
            buses,
            fast: false,
            force: None,
            drives: KnownDrives {
                identities: &[],
                find: false,
                stored: false,
            },
        }
    }

    /// Buses of CAN FD for drives alone.
    #[must_use]
    pub const fn fast(buses: &'a [u8]) -> Self {
        Self {
            fast: true,
            ..Self::classic(buses)
        }
    }
}

/// The node that every robot of a kind has, begun at `now`, and where it expects its drives.
///
/// # Errors
/// [`CellError`]
pub fn node(
    kind: RobotKind,
    station: &Station,
    wiring: &Wiring<'_>,
    now: Micros,
) -> Result<(Box<dyn NodeProcess + Send>, Vec<DriveAddress>), CellError> {
    let build = Build {
        kind,
        station,
        wiring,
        now,
    };
    kind.visit(station.track, build)
}

/// Makes the node of a robot and says where its drives are.
struct Build<'a> {
    kind: RobotKind,
    station: &'a Station,
    wiring: &'a Wiring<'a>,
    now: Micros,
}

impl RobotVisitor for Build<'_> {
    type Output = Result<(Box<dyn NodeProcess + Send>, Vec<DriveAddress>), CellError>;

    fn visit<R, const N: usize>(self, robot: R) -> Self::Output
    where
        R: Robot<N> + Copy + core::fmt::Debug + Send + Sync + 'static,
    {
        let wrong = |source| CellError::Config {
            robot: self.kind,
            source,
        };
        let wiring = self.wiring;
        let buses = <[u8; N]>::try_from(wiring.buses).map_err(|_| CellError::Axes {
            robot: self.kind,
            expected: N,
            got: wiring.buses.len(),
        })?;
        let config = self.station.config(buses).map_err(wrong)?;
        let mut config = config.with_drives(&wiring.drives).map_err(wrong)?;
        config.fast_drives = wiring.fast;
        config.force = wiring.force;
        let node = Node::new(self.now, robot, config).map_err(wrong)?;
        Ok((Box::new(node), config.drives.to_vec()))
    }
}

/// The simulated robot of a kind, its drives where the node expects them.
#[must_use]
pub fn setup(kind: RobotKind, drives: &[DriveAddress], seed: u64, quirks: Quirks) -> RobotSetup {
    let mut setup = robot(kind, seed);
    for (axis, drive) in setup.axes.iter_mut().zip(drives) {
        axis.bus = drive.bus;
        axis.node = drive.id.get();
        axis.drive.quirks = quirks;
    }
    setup
}
