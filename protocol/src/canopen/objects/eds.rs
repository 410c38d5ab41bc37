//! The electronic data sheet (CiA 306) of the object table: text that other tools load.

use core::fmt::{Result, Write};

use super::{Access, DataType, Initial, Mappable, Object, TABLE, group};

/// What an EDS file says besides the objects.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sheet<'a> {
    /// The file's own name.
    pub file_name: &'a str,
    /// What it describes, in one line.
    pub description: &'a str,
    /// Order code.
    pub order_code: &'a str,
}

/// Indices of the mandatory part of a device.
const MANDATORY: [u16; 3] = [0x1000, 0x1001, 0x1018];
/// Identity, sub-indices 1 to 3.
const IDENTITY: u16 = super::index::IDENTITY;
/// PDOs in each direction.
const PDOS: u8 = 4;

/// Writes the sheet. `initial` gives the values that this device has instead of the table's.
///
/// Dates are left out: the text depends on the table alone, so that it can be compared.
///
/// # Errors
/// Those of `out`.
pub fn write(
    out: &mut impl Write,
    sheet: &Sheet<'_>,
    initial: &impl Fn(&Object) -> Option<i64>,
) -> Result {
    head(out, sheet, initial)?;
    list(out, "MandatoryObjects", |index| MANDATORY.contains(&index))?;
    list(out, "OptionalObjects", |index| {
        !MANDATORY.contains(&index) && !is_of_maker(index)
    })?;
    list(out, "ManufacturerObjects", is_of_maker)?;
    for object in &TABLE {
        let at = object.at;
        match (group(at.index), at.sub) {
            (Some(group), 0) => {
                writeln!(out, "[{:04X}]", at.index)?;
                writeln!(out, "ParameterName={}", group.name)?;
                writeln!(out, "ObjectType=0x{:X}", group.kind.code())?;
                let subs = TABLE.iter().filter(|other| other.at.index == at.index);
                writeln!(out, "SubNumber={}\n", subs.count())?;
                writeln!(out, "[{:04X}sub0]", at.index)?;
            }
            (Some(_), sub) => writeln!(out, "[{:04X}sub{sub:X}]", at.index)?,
            (None, _) => writeln!(out, "[{:04X}]", at.index)?,
        }
        variable(out, object, initial(object))?;
    }
    Ok(())
}

fn head(
    out: &mut impl Write,
    sheet: &Sheet<'_>,
    initial: &impl Fn(&Object) -> Option<i64>,
) -> Result {
    writeln!(out, "[FileInfo]\nFileName={}", sheet.file_name)?;
    writeln!(out, "FileVersion=1\nFileRevision=0\nEDSVersion=4.0")?;
    writeln!(out, "Description={}\nCreatedBy=mrroc\n", sheet.description)?;
    let number = |sub| {
        let object = TABLE
            .iter()
            .find(|object| object.at.index == IDENTITY && object.at.sub == sub);
        object.map_or(0, |object| initial(object).unwrap_or(number_of(object)))
    };
    writeln!(out, "[DeviceInfo]\nVendorName=mrroc")?;
    writeln!(out, "VendorNumber=0x{:X}", number(1))?;
    writeln!(out, "ProductName=mrroc simulated servo drive")?;
    writeln!(out, "ProductNumber=0x{:X}", number(2))?;
    writeln!(out, "RevisionNumber=0x{:X}", number(3))?;
    writeln!(out, "OrderCode={}", sheet.order_code)?;
    for rate in [10, 20, 50, 125, 250, 500, 800, 1000] {
        writeln!(out, "BaudRate_{rate}=1")?;
    }
    writeln!(
        out,
        "SimpleBootUpMaster=0\nSimpleBootUpSlave=1\nGranularity=8"
    )?;
    writeln!(out, "DynamicChannelsSupported=0\nGroupMessaging=0")?;
    writeln!(out, "NrOfRXPDO={PDOS}\nNrOfTXPDO={PDOS}\nLSS_Supported=1\n")?;
    writeln!(out, "[DummyUsage]\nDummy0001=0")?;
    for dummy in 2..=7 {
        writeln!(out, "Dummy{dummy:04}=1")?;
    }
    writeln!(out, "\n[Comments]\nLines=0\n")
}

fn list(out: &mut impl Write, section: &str, wanted: impl Fn(u16) -> bool) -> Result {
    let indices = || {
        TABLE
            .iter()
            .filter(|object| object.at.sub == 0 && wanted(object.at.index))
    };
    writeln!(out, "[{section}]\nSupportedObjects={}", indices().count())?;
    for (number, object) in (1..).zip(indices()) {
        let number: u16 = number;
        writeln!(out, "{number}=0x{:04X}", object.at.index)?;
    }
    writeln!(out)
}

const fn is_of_maker(index: u16) -> bool {
    0x2000 <= index && index < 0x6000
}

const fn number_of(object: &Object) -> i64 {
    match object.initial {
        Initial::Number(number) => number,
        Initial::PlusNode(base) => base as i64,
        Initial::Text(_) => 0,
    }
}

fn variable(out: &mut impl Write, object: &Object, initial: Option<i64>) -> Result {
    writeln!(out, "ParameterName={}\nObjectType=0x7", object.name)?;
    writeln!(out, "DataType=0x{:04X}", object.data_type.code())?;
    let access = match (object.access, object.mappable) {
        (Access::Constant, _) => "const",
        (Access::Read, _) => "ro",
        (Access::Write, Mappable::Both) => "rww",
        (Access::Write, Mappable::No | Mappable::Transmit) => "rw",
    };
    writeln!(out, "AccessType={access}")?;
    match (object.initial, initial) {
        (Initial::Text(_), _) if object.data_type == DataType::Domain => {}
        (Initial::PlusNode(base), _) => writeln!(out, "DefaultValue=$NODEID+0x{base:X}")?,
        (Initial::Text(text), _) => writeln!(out, "DefaultValue={text}")?,
        (Initial::Number(_), Some(number)) | (Initial::Number(number), None) => {
            if object.data_type.is_signed() {
                writeln!(out, "DefaultValue={number}")?;
            } else {
                writeln!(out, "DefaultValue=0x{number:X}")?;
            }
        }
    }
    let mappable = object.mappable != Mappable::No;
    writeln!(out, "PDOMapping={}", u8::from(mappable))?;
    if let Some((low, high)) = object.limits {
        writeln!(out, "LowLimit={low}\nHighLimit={high}")?;
    }
    writeln!(out)
}

/// The type's name in CiA 301.
#[must_use]
pub const fn type_name(data_type: DataType) -> &'static str {
    match data_type {
        DataType::I8 => "INTEGER8",
        DataType::I16 => "INTEGER16",
        DataType::I32 => "INTEGER32",
        DataType::U8 => "UNSIGNED8",
        DataType::U16 => "UNSIGNED16",
        DataType::U32 => "UNSIGNED32",
        DataType::Text => "VISIBLE_STRING",
        DataType::Domain => "DOMAIN",
    }
}
