//! What an image is told when it starts: which robot it controls, and how its cell is wired. A board
//! with pins has this in its own source; an emulated one is told by its host.

use crate::bytes::{Reader, Writer};
use crate::tandem::{Halves, Tandem};
use core::marker::PhantomData;
use firmware::capacity::PATH_SAMPLES_SMALL;
use firmware::ecp::{NoPrograms, Programs};
use firmware::process::drive_buses;
use firmware::{ConfigError, Node, NodeSetup, Station};
use protocol::message::ServoLaw;
use protocol::time::Micros;
use protocol::transfer::Mtu;
use protocol::units::{MAX_AXES, PerAxis};
use robots::{Robot, RobotKind, RobotVisitor, TrackRule};

/// What is the same in every step of a node's life.
#[derive(Clone, Debug, PartialEq)]
pub struct Boot {
    /// Local time of the start.
    pub now: Micros,
    /// The robot.
    pub kind: RobotKind,
    /// How its cell is wired.
    pub station: Station,
    /// The drive bus of every axis.
    pub buses: PerAxis<u8>,
}

/// Why there is no node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BootError {
    /// Not every axis was given a drive bus.
    Axes,
    /// The robot was left out of this image.
    Robot,
    /// The configuration cannot be used.
    Config(ConfigError),
    /// The place is taken: it had a node before.
    Occupied,
}

impl core::fmt::Display for BootError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Axes => write!(f, "expected a drive bus for each axis"),
            Self::Robot => write!(f, "the robot was left out of this image: see its features"),
            Self::Config(error) => write!(f, "{error}"),
            Self::Occupied => write!(f, "this image has made a node before"),
        }
    }
}

impl core::error::Error for BootError {}

/// The node of a board: one with a small memory.
pub type BoardNode<R, const N: usize, P = NoPrograms> = Node<R, N, P, PATH_SAMPLES_SMALL>;

/// Memory for one node, whatever its robot; it stays there for ever.
pub trait Home {
    /// Make the node and keep it.
    ///
    /// # Errors
    /// [`BootError::Occupied`]
    fn keep<T: Send + 'static>(self, make: impl FnOnce() -> T)
    -> Result<&'static mut T, BootError>;
}

/// Does this image know the robot? Its features say so.
#[must_use]
pub const fn known(kind: RobotKind) -> bool {
    match kind {
        RobotKind::Irp6Track => cfg!(feature = "irp6-track"),
        RobotKind::Irp6Postument => cfg!(feature = "irp6-postument"),
        RobotKind::Polycrank => cfg!(feature = "polycrank"),
        RobotKind::Irp6Arm => cfg!(feature = "irp6-arm"),
        RobotKind::Conveyor => cfg!(feature = "conveyor"),
        RobotKind::Irp6TrackGripper => cfg!(feature = "irp6-track-gripper"),
        RobotKind::Irp6PostumentGripper => cfg!(feature = "irp6-postument-gripper"),
        RobotKind::Rnt => cfg!(feature = "rnt"),
    }
}

/// Programs of the user, for a robot of any number of axes: linked into an image by [`Boot::node_with`].
pub trait Linked {
    /// Those for `N` axes.
    type Programs<const N: usize>: Programs<N> + core::fmt::Debug + Send + 'static;
    /// As they are at the start.
    fn programs<const N: usize>() -> Self::Programs<N>;
}

/// The built-in instructions only.
#[derive(Clone, Copy, Debug)]
pub struct NothingLinked;

impl Linked for NothingLinked {
    type Programs<const N: usize> = NoPrograms;
    fn programs<const N: usize>() -> NoPrograms {
        NoPrograms
    }
}

impl Boot {
    /// The bytes of [`Self::write`].
    pub const BYTES: usize = 32 + MAX_AXES;

    /// A node on a board that nobody has configured: the first robot that this image knows, alone in its cell, on
    /// buses of its own, at a fifth of its speed.
    #[must_use]
    pub fn unconfigured(now: Micros) -> Option<Self> {
        let kind = RobotKind::ALL.into_iter().find(|kind| known(*kind))?;
        Some(Self {
            now,
            kind,
            station: Station {
                effector: kind.effector(),
                unique_id: 0,
                mtu: Mtu::Fd,
                law: ServoLaw::DrivePosition,
                velocity_factor: 0.2,
                one_wire: false,
                track: TrackRule::Keep,
            },
            buses: drive_buses(kind),
        })
    }

    /// The node of this robot, in its home.
    ///
    /// # Errors
    /// [`BootError`]
    pub fn node(&self, home: impl Home) -> Result<Halves, BootError> {
        self.node_with::<NothingLinked>(home)
    }

    /// The same, with programs of the user.
    ///
    /// # Errors
    /// [`BootError`]
    pub fn node_with<L: Linked>(&self, home: impl Home) -> Result<Halves, BootError> {
        // after this the compiler knows which of the robots are left, and drops the others
        if known(self.kind) {
            let linked = PhantomData::<L>;
            let boot = self;
            self.kind
                .visit(self.station.track, Make { boot, home, linked })
        } else {
            Err(BootError::Robot)
        }
    }

    /// As bytes; nothing if the buffer is shorter than [`Self::BYTES`].
    #[must_use]
    pub fn write(&self, buffer: &mut [u8]) -> Option<usize> {
        let mut out = Writer::new(buffer);
        let station = &self.station;
        let kind = RobotKind::ALL.iter().position(|kind| *kind == self.kind)?;
        out.put(&self.now.0.to_le_bytes())?;
        out.put(&station.unique_id.to_le_bytes())?;
        out.put(&station.velocity_factor.to_le_bytes())?;
        out.put(&[
            u8::try_from(kind).ok()?,
            station.effector,
            u8::from(station.mtu == Mtu::Fd),
            law_code(station.law),
            u8::from(station.one_wire),
            u8::from(station.track == TrackRule::InFront),
            0,
            u8::try_from(self.buses.len()).ok()?,
        ])?;
        let mut buses = [0; MAX_AXES];
        for (to, from) in buses.iter_mut().zip(&self.buses) {
            *to = *from;
        }
        out.put(&buses)?;
        Some(out.len())
    }

    /// What [`Self::write`] wrote; nothing if it did not write this.
    #[must_use]
    pub fn read(bytes: &[u8]) -> Option<Self> {
        let mut bytes = Reader(bytes);
        let now = Micros(bytes.u64()?);
        let unique_id = bytes.u64()?;
        let velocity_factor = f64::from_bits(bytes.u64()?);
        let kind = *RobotKind::ALL.get(usize::from(bytes.u8()?))?;
        let effector = bytes.u8()?;
        let mtu = if flag(bytes.u8()?)? {
            Mtu::Fd
        } else {
            Mtu::Classic
        };
        let law = law_of(bytes.u8()?)?;
        let one_wire = flag(bytes.u8()?)?;
        let track = if flag(bytes.u8()?)? {
            TrackRule::InFront
        } else {
            TrackRule::Keep
        };
        let (zero, axes) = (bytes.u8()?, usize::from(bytes.u8()?));
        let buses = bytes.take(MAX_AXES)?;
        if zero != 0 || !bytes.0.is_empty() {
            return None;
        }
        let mut drive_buses = PerAxis::new();
        for bus in buses.get(..axes)? {
            drive_buses.push(*bus).ok()?;
        }
        Some(Self {
            now,
            kind,
            station: Station {
                effector,
                unique_id,
                mtu,
                law,
                velocity_factor,
                one_wire,
                track,
            },
            buses: drive_buses,
        })
    }
}

const fn flag(byte: u8) -> Option<bool> {
    match byte {
        0 => Some(false),
        1 => Some(true),
        _ => None,
    }
}

const fn law_code(law: ServoLaw) -> u8 {
    match law {
        ServoLaw::DrivePosition => 0,
        ServoLaw::Original => 1,
        ServoLaw::FeedForward => 2,
        ServoLaw::ComputedTorque => 3,
    }
}

const fn law_of(code: u8) -> Option<ServoLaw> {
    match code {
        0 => Some(ServoLaw::DrivePosition),
        1 => Some(ServoLaw::Original),
        2 => Some(ServoLaw::FeedForward),
        3 => Some(ServoLaw::ComputedTorque),
        _ => None,
    }
}

struct Make<'a, H, L> {
    boot: &'a Boot,
    home: H,
    linked: PhantomData<L>,
}

impl<H: Home, L: Linked> RobotVisitor for Make<'_, H, L> {
    type Output = Result<Halves, BootError>;

    fn visit<R, const N: usize>(self, robot: R) -> Self::Output
    where
        R: Robot<N> + Copy + core::fmt::Debug + Send + Sync + 'static,
    {
        let Boot {
            now,
            station,
            buses,
            ..
        } = self.boot;
        let buses = <[u8; N]>::try_from(buses.as_slice()).map_err(|_| BootError::Axes)?;
        let config = station.config(buses).map_err(BootError::Config)?;
        let setup = NodeSetup::new(robot, config).map_err(BootError::Config)?;
        // all that can fail is done: the node is made where it stays
        let home = self.home;
        let tandem = home.keep(Tandem::<R, N, _, PATH_SAMPLES_SMALL>::new)?;
        Ok(tandem.begin(*now, setup, L::programs()))
    }
}

#[cfg(test)]
mod test {
    use super::*;
    use std::boxed::Box;

    /// On a host: memory that is never given back.
    struct Leaked;

    impl Home for Leaked {
        fn keep<T: Send + 'static>(
            self,
            make: impl FnOnce() -> T,
        ) -> Result<&'static mut T, BootError> {
            Ok(Box::leak(Box::new(make())))
        }
    }

    fn boot(kind: RobotKind) -> Boot {
        Boot {
            now: Micros(7_000_000_000_123),
            kind,
            station: Station {
                effector: kind.effector(),
                unique_id: 0xFEDC_BA98_7654_3210,
                mtu: Mtu::Fd,
                law: ServoLaw::FeedForward,
                velocity_factor: 0.3,
                one_wire: true,
                track: TrackRule::InFront,
            },
            buses: core::iter::repeat_n(1, kind.axes()).collect(),
        }
    }

    #[test]
    fn what_is_written_is_read_and_nothing_else() {
        for kind in RobotKind::ALL {
            let boot = boot(kind);
            let mut buffer = [0; Boot::BYTES];
            assert_eq!(boot.write(&mut buffer), Some(Boot::BYTES));
            assert_eq!(Boot::read(&buffer), Some(boot.clone()));
            assert_eq!(Boot::read(&buffer[1..]), None);
            assert_eq!(boot.write(&mut buffer[1..].to_vec()), None);
            for (at, wrong) in [
                (24, 99),
                (26, 2),
                (27, 4),
                (28, 2),
                (29, 2),
                (30, 1),
                (31, 9),
            ] {
                let mut other = buffer;
                other[at] = wrong;
                assert_eq!(Boot::read(&other), None, "byte {at}");
            }
        }
    }

    #[test]
    fn every_robot_gets_its_node() {
        for kind in RobotKind::ALL {
            let mut boot = boot(kind);
            let node = boot.node(Leaked).unwrap().node;
            assert_eq!(node.identity().robot, kind.name());
            assert_eq!(node.next_wake(), boot.now);
            let _ = boot.buses.pop();
            assert_eq!(boot.node(Leaked).unwrap_err(), BootError::Axes);
            boot.buses = core::iter::repeat_n(0, kind.axes()).collect();
            boot.station.velocity_factor = f64::NAN;
            assert_eq!(
                boot.node(Leaked).unwrap_err(),
                BootError::Config(ConfigError::VelocityFactor)
            );
        }
    }
    #[test]
    fn a_board_that_nobody_has_configured_gets_a_node() {
        let boot = Boot::unconfigured(Micros(5)).unwrap();
        assert!(known(boot.kind));
        let node = boot.node(Leaked).unwrap().node;
        assert_eq!(node.identity().robot, boot.kind.name());
        let mut buffer = [0; Boot::BYTES];
        assert!(boot.write(&mut buffer).is_some());
        assert_eq!(Boot::read(&buffer), Some(boot));
    }
}
