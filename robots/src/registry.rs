//! Robots by name: the one list of all there are.

use core::fmt;

use crate::conveyor::Conveyor;
use crate::irp6::{Irp6Arm, Irp6Gripper, Irp6Postument, Irp6Track, TrackRule};
use crate::polycrank::Polycrank;
use crate::rnt::Rnt;
use crate::robot::Robot;

/// What is done with a robot whose kind is known only at run time: [`RobotKind::visit`].
pub trait RobotVisitor {
    /// What comes of it.
    type Output;

    /// Do it with this robot.
    fn visit<R, const N: usize>(self, robot: R) -> Self::Output
    where
        R: Robot<N> + Copy + fmt::Debug + Send + Sync + 'static;
}

/// Declares the kinds. A row is a robot: its kind, name, number of the effector, axes, and the value
/// it is for a [`TrackRule`].
macro_rules! kinds {
    (|$rule:ident| $(
        $(#[doc = $doc:literal])*
        $kind:ident, $name:literal, $effector:literal, $axes:literal => $robot:expr;
    )*) => {
        /// The robots there are.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum RobotKind {
            $( $(#[doc = $doc])* $kind, )*
        }

        impl RobotKind {
            /// All of them.
            pub const ALL: [Self; [$($name),*].len()] = [$(Self::$kind),*];

            /// The name commands and files use.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self {
                    $( Self::$kind => $name, )*
                }
            }

            /// The number j of its effector `E_j` where nothing else is said: nodes, simulators
            /// and coordinators agree on it.
            #[must_use]
            pub const fn effector(self) -> u8 {
                match self {
                    $( Self::$kind => $effector, )*
                }
            }

            /// How many axes it has.
            #[must_use]
            pub const fn axes(self) -> usize {
                match self {
                    $( Self::$kind => $axes, )*
                }
            }

            /// Hand the robot of this kind to `visitor`. The rule is that of a robot on a track;
            /// others have none.
            pub fn visit<V: RobotVisitor>(self, $rule: TrackRule, visitor: V) -> V::Output {
                match self {
                    $( Self::$kind => visitor.visit($robot), )*
                }
            }
        }
    };
}

kinds! { |rule|
    /// [`Irp6Track`], 7 axes.
    Irp6Track, "irp6-track", 1, 7 => Irp6Track { rule };
    /// [`Irp6Postument`], 6 axes.
    Irp6Postument, "irp6-postument", 2, 6 => Irp6Postument;
    /// [`Polycrank`], 7 axes.
    Polycrank, "polycrank", 3, 7 => Polycrank;
    /// [`Irp6Arm`], 5 axes.
    Irp6Arm, "irp6-arm", 4, 5 => Irp6Arm;
    /// [`Conveyor`], 1 axis.
    Conveyor, "conveyor", 5, 1 => Conveyor;
    /// [`Irp6Gripper::Track`], 1 axis.
    Irp6TrackGripper, "irp6-track-gripper", 6, 1 => Irp6Gripper::Track;
    /// [`Irp6Gripper::Postument`], 1 axis.
    Irp6PostumentGripper, "irp6-postument-gripper", 7, 1 => Irp6Gripper::Postument;
    /// [`Rnt`], 6 axes.
    Rnt, "rnt", 8, 6 => Rnt;
}

impl RobotKind {
    /// The robot of a name.
    ///
    /// # Errors
    /// [`UnknownRobot`], whose text lists the known names.
    pub fn from_name(name: &str) -> Result<Self, UnknownRobot<'_>> {
        Self::ALL
            .into_iter()
            .find(|kind| kind.name() == name)
            .ok_or(UnknownRobot { name })
    }

    /// Has it a force sensor in its wrist? MRROC++ had one in either arm of six joints.
    #[must_use]
    pub const fn has_force_sensor(self) -> bool {
        matches!(self, Self::Irp6Track | Self::Irp6Postument)
    }
}

impl fmt::Display for RobotKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// There is no robot of this name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UnknownRobot<'a> {
    /// The name asked for.
    pub name: &'a str,
}

impl fmt::Display for UnknownRobot<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "unknown robot \"{}\"; known:", self.name)?;
        let mut separator = " ";
        for kind in RobotKind::ALL {
            write!(f, "{separator}{kind}")?;
            separator = ", ";
        }
        Ok(())
    }
}

impl core::error::Error for UnknownRobot<'_> {}
