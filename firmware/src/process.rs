//! A node without its type parameters, for hosts that run several kinds side by side.

use crate::config::{ConfigError, DriveAddress, NodeConfig};
use crate::ecp::Programs;
use crate::io::{Port, Received};
use crate::node::Node;
use protocol::canopen::node::NodeId as DriveId;
use protocol::canopen::sync::DEFAULT_COB;
use protocol::frame::Frame;
use protocol::id::NodeId;
use protocol::message::{Identity, NodeState, ServoLaw};
use protocol::time::Micros;
use protocol::transfer::Mtu;
use protocol::units::PerAxis;
use robots::{Robot, RobotKind, RobotVisitor, TrackRule};

/// What every node does, whatever its robot.
pub trait NodeProcess: core::fmt::Debug {
    /// [`Node::step`]
    fn step(&mut self, now: Micros, rx: &[Received], tx: &mut dyn FnMut(Port, Frame));
    /// [`Node::next_wake`]
    fn next_wake(&self) -> Micros;
    /// [`Node::state`]
    fn state(&self) -> NodeState;
    /// [`Node::identity`]
    fn identity(&self) -> Identity;
    /// [`Librarian::restarts`](crate::maintenance::Librarian::restarts)
    fn restarts(&self) -> bool {
        false
    }
    /// Would the next servo step find the ECP still at work? Where time can wait, in lock step, it does.
    fn wants_time(&mut self) -> bool {
        false
    }
}

impl<R, const N: usize, P, const W: usize> NodeProcess for Node<R, N, P, W>
where
    R: Robot<N> + Copy + core::fmt::Debug,
    P: Programs<N> + core::fmt::Debug,
{
    fn step(&mut self, now: Micros, rx: &[Received], mut tx: &mut dyn FnMut(Port, Frame)) {
        Self::step(self, now, rx, &mut tx);
    }
    fn next_wake(&self) -> Micros {
        Self::next_wake(self)
    }
    fn state(&self) -> NodeState {
        Self::state(self)
    }
    fn identity(&self) -> Identity {
        Self::identity(self)
    }
}

/// What differs between the nodes of one cell; drives and ids follow by rule.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Station {
    /// The effector's number j, from 1: node id, drive ids and SYNC follow from it.
    pub effector: u8,
    /// Identifies the process.
    pub unique_id: u64,
    /// Frame size on the MP bus.
    pub mtu: Mtu,
    /// How the loops are closed at start.
    pub law: ServoLaw,
    /// Fraction of the hard velocity limit, (0, 1].
    pub velocity_factor: f64,
    /// All buses of the cell are one wire.
    pub one_wire: bool,
    /// Where the inverse kinematics of a robot on a track puts the track.
    pub track: TrackRule,
}

/// Drives of one wire, beyond the first robot's, are numbered from ten times (j − 1) on.
const DRIVES_PER_EFFECTOR: u8 = 10;
/// SYNC of effector j ≥ 2 on a shared wire: above every EMCY of drives below 96.
const SHARED_SYNC: u16 = 0x0E0;
/// CANopen id of the first effector's node; the others' count down.
const FIRST_MASTER: u8 = 127;

impl Station {
    /// The configuration of a robot whose axes hang on drive buses as `buses` says.
    ///
    /// Each robot on buses of its own: drives 1, 2, … and SYNC 080. On one wire everything is
    /// unique: drives 10·(j−1)+1, …, SYNC 0E0+j from the second robot on, node ids 127, 126, ….
    ///
    /// # Errors
    /// [`ConfigError`], also when the numbers run out.
    pub fn config<const N: usize>(&self, buses: [u8; N]) -> Result<NodeConfig<N>, ConfigError> {
        let others = self.effector.saturating_sub(1);
        let first = if self.one_wire {
            others.saturating_mul(DRIVES_PER_EFFECTOR)
        } else {
            0
        };
        let mut axis = 0_u8;
        let mut wrong = None;
        let drives = buses.map(|bus| {
            axis = axis.saturating_add(1);
            let bus = if self.one_wire { 0 } else { bus };
            DriveId::new(first.saturating_add(axis)).map_or_else(
                || {
                    wrong = Some(ConfigError::DuplicateDrive {
                        axis: axis.saturating_sub(1),
                    });
                    DriveAddress {
                        bus,
                        id: DriveId::FIRST,
                    }
                },
                |id| DriveAddress { bus, id },
            )
        });
        if let Some(error) = wrong {
            return Err(error);
        }
        let shared = self.one_wire && others > 0;
        let config = NodeConfig {
            node: NodeId::effector(self.effector).unwrap_or(NodeId::MP),
            unique_id: self.unique_id,
            mtu: self.mtu,
            drives,
            sync_cob: if shared {
                SHARED_SYNC.saturating_add(u16::from(self.effector))
            } else {
                DEFAULT_COB
            },
            master: self.master(),
            fast_drives: false,
            law: self.law,
            velocity_factor: self.velocity_factor,
            force: None,
            identities: [None; N],
            find_drives: false,
            stored_setup: false,
        };
        config.validate()?;
        Ok(config)
    }

    /// The node's own number on the buses of its drives.
    #[must_use]
    pub fn master(&self) -> DriveId {
        let before = if self.one_wire {
            self.effector.saturating_sub(1)
        } else {
            0
        };
        DriveId::new(FIRST_MASTER.saturating_sub(before)).unwrap_or(DriveId::FIRST)
    }
}

/// Which drive bus each axis of a kind hangs on, when every robot has buses of its own:
/// [`robots::RobotDescription::drive_buses`].
#[must_use]
pub fn drive_buses(kind: RobotKind) -> PerAxis<u8> {
    struct Buses;
    impl RobotVisitor for Buses {
        type Output = PerAxis<u8>;
        fn visit<R: Robot<N>, const N: usize>(self, robot: R) -> PerAxis<u8> {
            robot.description().drive_buses().into_iter().collect()
        }
    }
    kind.visit(TrackRule::Keep, Buses)
}
