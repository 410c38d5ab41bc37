//! The object table as documentation.

use core::fmt::{Result, Write};

use super::{Access, Initial, Mappable, TABLE, eds, group};

/// Writes the table in Markdown, one row for each object.
///
/// # Errors
/// Those of `out`.
pub fn write(out: &mut impl Write) -> Result {
    writeln!(
        out,
        "| object | name | type | access | PDO | default | limits |"
    )?;
    writeln!(out, "|---|---|---|---|---|---|---|")?;
    for object in &TABLE {
        let at = object.at;
        match group(at.index) {
            Some(group) => write!(
                out,
                "| {:04X}:{:02X} | {}: {} ",
                at.index, at.sub, group.name, object.name
            )?,
            None => write!(out, "| {:04X} | {} ", at.index, object.name)?,
        }
        let access = match object.access {
            Access::Constant => "const",
            Access::Read => "ro",
            Access::Write => "rw",
        };
        let pdo = match object.mappable {
            Mappable::No => "",
            Mappable::Transmit => "T",
            Mappable::Both => "RT",
        };
        let kind = eds::type_name(object.data_type);
        write!(out, "| {kind} | {access} | {pdo} | ")?;
        match object.initial {
            Initial::Number(number) if number >= 0x1_0000 && at.index < 0x2000 => {
                write!(out, "{number:08X}h")?;
            }
            Initial::Number(number) => write!(out, "{number}")?,
            Initial::PlusNode(base) => write!(out, "{base:X}h + node")?,
            Initial::Text(text) => write!(out, "{text:?}")?,
        }
        match object.limits {
            Some((low, high)) => writeln!(out, " | {low} … {high} |")?,
            None => writeln!(out, " | |")?,
        }
    }
    Ok(())
}
