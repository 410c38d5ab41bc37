//! A node without its type parameters, for hosts that run several kinds side by side.

use crate::capacity::DRIVE_BUSES;
use crate::config::{ConfigError, DriveAddress, ForceAddress, NodeConfig};
use crate::ecp::Programs;
use crate::io::{Port, Received};
use crate::node::Node;
use protocol::canopen::node::NodeId as DriveId;
use protocol::canopen::sync::DEFAULT_COB;
use protocol::force_torque::SensorNumber;
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

    /// The force sensor of a robot on its drive bus `bus`: number 0 there, on one wire number j − 1.
    ///
    /// # Errors
    /// [`ForceBusError`]
    pub fn force(&self, kind: RobotKind, bus: u8) -> Result<ForceAddress, ForceBusError> {
        if !kind.has_force_sensor() {
            return Err(ForceBusError::NoSensor);
        }
        let buses = if self.one_wire { 1 } else { DRIVE_BUSES };
        if usize::from(bus) >= buses {
            return Err(ForceBusError::NoBus { buses });
        }
        let on = drive_buses(kind).into_iter().filter(|of| *of == bus);
        let on = on.count();
        if !self.one_wire && on > DRIVES_BESIDE_A_SENSOR {
            return Err(ForceBusError::Crowded { drives: on });
        }
        let number = if self.one_wire {
            self.effector.saturating_sub(1)
        } else {
            0
        };
        let number = SensorNumber::new(number).ok_or(ForceBusError::NoNumber)?;
        Ok(ForceAddress { bus, number })
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

/// More drives leave no room for a force sensor on a classical bus of 1 Mbit/s: 13 % of it each, and 13.5 % for the sensor.
const DRIVES_BESIDE_A_SENSOR: usize = 5;

/// Why a node cannot read a force sensor on a bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ForceBusError {
    /// The robot has none.
    NoSensor,
    /// The node has no such bus.
    NoBus {
        /// How many it has.
        buses: usize,
    },
    /// There is no room beside the drives of that bus.
    Crowded {
        /// How many there are.
        drives: usize,
    },
    /// One wire has no number left for it.
    NoNumber,
}

impl core::fmt::Display for ForceBusError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::NoSensor => {
                write!(f, "expected a robot that has a force sensor:")?;
                let mut separator = " ";
                for kind in RobotKind::ALL.into_iter().filter(|k| k.has_force_sensor()) {
                    write!(f, "{separator}{kind}")?;
                    separator = ", ";
                }
                Ok(())
            }
            Self::NoBus { buses: 1 } => write!(f, "expected bus 0: all is one wire"),
            Self::NoBus { buses } => write!(f, "expected a drive bus below {buses}"),
            Self::Crowded { drives } => write!(
                f,
                "expected a bus with at most {DRIVES_BESIDE_A_SENSOR} drives, got one with {drives}"
            ),
            Self::NoNumber => write!(
                f,
                "expected an effector below 17: a wire has 16 force sensors"
            ),
        }
    }
}

impl core::error::Error for ForceBusError {}

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

#[cfg(test)]
mod test {
    use super::*;

    fn force(
        kind: RobotKind,
        effector: u8,
        one_wire: bool,
        bus: u8,
    ) -> Result<(u8, u16), ForceBusError> {
        let station = Station {
            effector,
            unique_id: 0,
            mtu: Mtu::Classic,
            law: ServoLaw::DrivePosition,
            velocity_factor: 0.2,
            one_wire,
            track: TrackRule::Keep,
        };
        let address = station.force(kind, bus)?;
        Ok((address.bus, address.number.force_cob()))
    }

    #[test]
    fn a_force_sensor_is_the_first_of_its_bus_and_that_of_its_effector_on_one_wire() {
        let (track, postument) = (RobotKind::Irp6Track, RobotKind::Irp6Postument);
        // the track has four drives on its first bus and three on its second, the postument six on its only one
        assert_eq!(force(track, 1, false, 0), Ok((0, 0x680)));
        assert_eq!(force(track, 7, false, 1), Ok((1, 0x680)));
        assert_eq!(force(postument, 2, false, 1), Ok((1, 0x680)));
        assert_eq!(force(track, 1, true, 0), Ok((0, 0x680)));
        assert_eq!(force(postument, 16, true, 0), Ok((0, 0x69E)));
    }

    #[test]
    fn where_there_can_be_no_force_sensor_it_is_said_why() {
        let (postument, conveyor) = (RobotKind::Irp6Postument, RobotKind::Conveyor);
        for (got, error, word) in [
            (
                force(conveyor, 5, false, 0),
                ForceBusError::NoSensor,
                "irp6-track, irp6-postument",
            ),
            (
                force(postument, 2, false, 0),
                ForceBusError::Crowded { drives: 6 },
                "5 drives",
            ),
            (
                force(postument, 2, false, 2),
                ForceBusError::NoBus { buses: 2 },
                "below 2",
            ),
            (
                force(postument, 2, true, 1),
                ForceBusError::NoBus { buses: 1 },
                "one wire",
            ),
            (
                force(postument, 17, true, 0),
                ForceBusError::NoNumber,
                "below 17",
            ),
        ] {
            assert_eq!(got, Err(error));
            let mut text = heapless::String::<100>::new();
            core::fmt::Write::write_fmt(&mut text, format_args!("{error}")).unwrap();
            assert!(
                text.starts_with("expected") && text.contains(word),
                "{text}"
            );
        }
    }
}
