//! `mrroc eds`: the data sheet (EDS, CiA 306) of the drive of one axis, from the table that is its object
//! dictionary.

use std::io::Write;
use std::path::PathBuf;

use clap::Args;
use hil_sim::drive::data_sheet;
use hil_sim::plant::parameters;
use process::{End, exit};

use crate::commands::robot;

/// The data sheet of a drive
#[derive(Debug, Args)]
pub(crate) struct Eds {
    /// The robot's name, such as irp6-track
    robot: String,
    /// The axis, from 1
    axis: usize,
    /// Write a file instead
    #[arg(long, short, value_name = "FILE")]
    output: Option<PathBuf>,
}

impl Eds {
    /// Writes the sheet.
    ///
    /// # Errors
    /// There is no such robot or axis, or the sheet cannot be written.
    pub(crate) fn run(self, out: &mut dyn Write) -> Result<(), End> {
        let kind = robot(&self.robot)?;
        // the seed moves where motors start, not what drives are
        let setup = parameters::robot(kind, 0);
        let axis = self.axis.checked_sub(1).and_then(|k| setup.axes.get(k));
        let axis = axis.ok_or_else(|| {
            let axes = setup.axes.len();
            End::usage(format!(
                "{kind} has no axis {}: expected 1 to {axes}",
                self.axis
            ))
        })?;
        let name = format!("{kind}-{}.eds", self.axis);
        let description = format!("drive of axis {} of {kind}", self.axis);
        let sheet = data_sheet(&axis.drive, &name, &description);
        written(self.output, out, &sheet)
    }
}

/// Writes `text` into a file, or where there is none, to `out`.
///
/// # Errors
/// It cannot be written.
pub(crate) fn written(file: Option<PathBuf>, out: &mut dyn Write, text: &str) -> Result<(), End> {
    match file {
        Some(path) => std::fs::write(&path, text)
            .map_err(|error| End::new(exit::CANNOT_CREATE, format!("{}: {error}", path.display()))),
        None => out
            .write_all(text.as_bytes())
            .map_err(|error| End::new(exit::IO, format!("stdout: {error}"))),
    }
}

#[cfg(test)]
mod test {
    use super::*;

    fn sheet(robot: &str, axis: usize) -> Result<String, End> {
        let mut out = Vec::new();
        let eds = Eds {
            robot: robot.into(),
            axis,
            output: None,
        };
        eds.run(&mut out)?;
        Ok(String::from_utf8(out).unwrap())
    }

    #[test]
    fn a_sheet_has_the_values_of_its_axis() {
        let first = sheet("irp6-postument", 1).unwrap();
        assert!(first.starts_with("[FileInfo]\nFileName=irp6-postument-1.eds\n"));
        let drive = parameters::robot(robots::RobotKind::Irp6Postument, 0).axes[0].drive;
        let torque = format!(
            "[6076]\nParameterName=Motor rated torque\nObjectType=0x7\nDataType=0x0007\n\
             AccessType=ro\nDefaultValue=0x{:X}\n",
            drive.rated_torque_mnm
        );
        assert!(first.contains(&torque), "{torque}");
    }

    #[test]
    fn robots_and_axes_that_are_not_there_are_told() {
        for (robot, axis) in [("irp6-postument", 0), ("irp6-postument", 7), ("irp7", 1)] {
            assert_eq!(
                sheet(robot, axis).unwrap_err().code,
                exit::USAGE,
                "{robot} {axis}"
            );
        }
    }
}
