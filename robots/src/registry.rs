//! Robots by name.

use core::fmt;

/// The robots there are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum RobotKind {
    /// [`crate::Irp6Track`], 7 axes.
    Irp6Track,
    /// [`crate::Irp6Postument`], 6 axes.
    Irp6Postument,
}

impl RobotKind {
    /// All of them.
    pub const ALL: [Self; 2] = [Self::Irp6Track, Self::Irp6Postument];

    /// The name commands and files use.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Irp6Track => "irp6-track",
            Self::Irp6Postument => "irp6-postument",
        }
    }

    /// The number j of its effector `E_j` where nothing else is said: nodes, simulators and
    /// coordinators agree on it.
    #[must_use]
    pub const fn effector(self) -> u8 {
        match self {
            Self::Irp6Track => 1,
            Self::Irp6Postument => 2,
        }
    }

    /// How many axes it has.
    #[must_use]
    pub const fn axes(self) -> usize {
        match self {
            Self::Irp6Track => 7,
            Self::Irp6Postument => 6,
        }
    }

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
