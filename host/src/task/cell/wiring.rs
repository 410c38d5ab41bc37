//! The drives and the force sensor of a robot in a cell file: which they are, and where.

use super::{BusKind, Cell, DriveGroup};
use crate::input::{DataError, Problem, shown};
use crate::task::document::{Fields, Value, one_of};
use protocol::canopen::lss::Identity;
use robots::RobotKind;

/// Which devices drives must be: `{ axis = 1, vendor = 0, product = 402, revision = 0x10000, serial = 17 }`, at most one
/// an axis, and each device once.
pub(super) fn identities(
    value: &Value<'_, '_>,
    kind: RobotKind,
) -> Result<Vec<(u8, Identity)>, DataError> {
    let mut found: Vec<(u8, Identity)> = Vec::new();
    let axes = kind.axes() as u64;
    for one in value.list()? {
        let fields = one.fields(
            "an identity",
            &["axis", "vendor", "product", "revision", "serial"],
        )?;
        let axis = fields.required("axis")?;
        let number = axis.integer(&format!("1 to {axes}"), |axis| (1..=axes).contains(&axis))?;
        let part = |key| -> Result<u32, DataError> {
            let greatest = u64::from(u32::MAX);
            let part = fields.required(key)?;
            let part = part.integer("0 to 0xFFFFFFFF", |part| part <= greatest)?;
            Ok(u32::try_from(part).unwrap_or(u32::MAX))
        };
        let identity = Identity {
            vendor: part("vendor")?,
            product: part("product")?,
            revision: part("revision")?,
            serial: part("serial")?,
        };
        let index = u8::try_from(number - 1).unwrap_or(u8::MAX);
        let taken = |(axis, other): &(u8, Identity)| *axis == index || *other == identity;
        if found.iter().any(taken) {
            return Err(one.error(
                Problem::Conflict,
                "an identity of two axes, or an axis of two identities",
                "each once",
                format!("axis {number}, serial {}", identity.serial),
            ));
        }
        found.push((index, identity));
    }
    Ok(found)
}

/// Do the drives speak the fast profile? They are asked to by `fast_drives = true`, and all their buses must be FD.
pub(super) fn fast_drives(
    cell: &Cell,
    fields: &Fields<'_, '_>,
    drives: &[DriveGroup],
) -> Result<bool, DataError> {
    let Some(value) = fields.optional("fast_drives") else {
        return Ok(false);
    };
    let wanted = value.boolean()?;
    let mut buses = drives.iter().filter_map(|group| cell.buses.get(group.bus));
    match buses.find(|bus| bus.kind == BusKind::Classic) {
        Some(bus) if wanted => Err(value.error(
            Problem::Conflict,
            "the fast profile on a classical bus",
            "every bus of its drives to be FD",
            bus.name.clone(),
        )),
        Some(_) | None => Ok(wanted),
    }
}

/// The bus of the force sensor: one of the drives', or one of its own where the node has a port left.
pub(super) fn force_bus(
    cell: &Cell,
    value: &Value<'_, '_>,
    kind: RobotKind,
    drives: &[DriveGroup],
) -> Result<usize, DataError> {
    let bus = bus_index(cell, value)?;
    let wrong = |expected: &str, got: String| {
        Err(value.error(Problem::Conflict, "a force sensor", expected, got))
    };
    if !kind.has_force_sensor() {
        return wrong(
            "a robot that has one: irp6-track, irp6-postument",
            kind.name().to_owned(),
        );
    }
    match drives.iter().find(|group| group.bus == bus) {
        Some(group) if group.axes.len() > 5 => wrong(
            "a bus with at most five drives: its frames take 13.5 %",
            format!("{} drives", group.axes.len()),
        ),
        None if drives.len() > 1 => wrong(
            "a bus of its drives: a node has two",
            "a third one".to_owned(),
        ),
        Some(_) | None => Ok(bus),
    }
}

/// The bus of a name.
pub(super) fn bus_index(cell: &Cell, value: &Value<'_, '_>) -> Result<usize, DataError> {
    let name = value.text()?;
    let index = cell.buses.iter().position(|bus| bus.name == name);
    index.ok_or_else(|| {
        let names: Vec<&str> = cell.buses.iter().map(|bus| bus.name.as_str()).collect();
        let expected = if names.is_empty() {
            "a [[bus]] of that name".to_owned()
        } else {
            one_of(&names)
        };
        value.error(Problem::UnknownName, "unknown bus", expected, shown(name))
    })
}

/// Which axes are on which bus: every axis once.
pub(super) fn drives(
    cell: &Cell,
    value: &Value<'_, '_>,
    kind: RobotKind,
) -> Result<Vec<DriveGroup>, DataError> {
    let mut groups = Vec::new();
    let mut taken = vec![false; kind.axes()];
    let range = format!("1 to {}", kind.axes());
    for group in value.list()? {
        let fields = group.fields("a group of drives", &["bus", "axes"])?;
        let bus = bus_index(cell, &fields.required("bus")?)?;
        let listed = fields.required("axes")?;
        let mut axes = Vec::new();
        for axis in listed.list()? {
            let number = axis.integer(&range, |axis| (1..=kind.axes() as u64).contains(&axis))?;
            let index = usize::try_from(number).unwrap_or(usize::MAX) - 1;
            match taken.get_mut(index) {
                Some(taken) if !*taken => *taken = true,
                _ => {
                    return Err(axis.error(
                        Problem::Conflict,
                        "an axis on two buses",
                        "every axis once",
                        format!("axis {number} again"),
                    ));
                }
            }
            axes.push(index);
        }
        if axes.is_empty() {
            return Err(listed.error(
                Problem::WrongCount,
                "a group of drives without axes",
                "at least one",
                "none",
            ));
        }
        groups.push(DriveGroup { bus, axes });
    }
    if let Some(index) = taken.iter().position(|taken| !taken) {
        return Err(value.error(
            Problem::Missing,
            "an axis on no bus",
            format!("axes {range}, every one once"),
            format!("no axis {}", index + 1),
        ));
    }
    Ok(groups)
}
