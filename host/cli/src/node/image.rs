//! Images as files: the header of `firmware::update::image`, then the program.

use clap::Args;
use firmware::update::image::{self, CRC, HEADER};
use firmware::update::stm32g474;
use host::error::Error;
use object::Endianness;
use object::read::elf::{ElfFile32, ProgramHeader as _, SectionHeader as _};
use process::{End, exit};
use protocol::maintenance::ImageHeader;
use protocol::schema::SCHEMA_HASH;
use std::fs::File;
use std::io::{ErrorKind, Read, Write};
use std::path::{Path, PathBuf};

/// The target with slots of its own address.
const STM32G474: &str = "stm32g474";
/// No microcontroller has a slot of this length, bytes.
const MOST: u64 = 16 * 1024 * 1024;

/// Make an image of a program.
#[derive(Args, Debug)]
pub(super) struct Pack {
    /// The program, linked for the address of an image: an ELF file, or the bytes as they are in flash.
    program: PathBuf,
    /// The robot it controls.
    #[arg(long, value_parser = robot)]
    robot: String,
    /// What it is made for: stm32g474, or host.
    #[arg(long, value_parser = name)]
    target: String,
    /// Its version, MAJOR.MINOR.PATCH, each at most 255.
    #[arg(long, value_name = "VERSION", value_parser = version)]
    image_version: (u8, u8, u8),
    /// Where to write the image.
    #[arg(long, short, value_name = "FILE")]
    output: PathBuf,
}

fn robot(text: &str) -> Result<String, String> {
    crate::commands::robot(text)
        .map(|kind| kind.name().into())
        .map_err(|error| error.to_string())
}

fn name(text: &str) -> Result<String, String> {
    let known = |b: u8| b.is_ascii_alphanumeric() || b"-_.".contains(&b);
    if (1..=24).contains(&text.len()) && text.bytes().all(known) {
        Ok(text.into())
    } else {
        Err("expected 1 to 24 letters, digits, - _ or .".into())
    }
}

pub(super) fn version(text: &str) -> Result<(u8, u8, u8), String> {
    let parts: Vec<_> = text.split('.').map(str::parse::<u8>).collect();
    match parts.as_slice() {
        [Ok(major), Ok(minor), Ok(patch)] => Ok((*major, *minor, *patch)),
        _ => Err("expected three numbers up to 255 with dots between, as 0.2.1".into()),
    }
}

/// A file, whole, with one line for what is wrong.
fn read(path: &Path) -> Result<Vec<u8>, End> {
    let failed = |error: std::io::Error| {
        let code = match error.kind() {
            ErrorKind::PermissionDenied => exit::PERMISSION,
            _ => exit::NO_INPUT,
        };
        End::new(code, format!("{}: cannot read: {error}", path.display()))
    };
    let file = File::open(path).map_err(failed)?;
    if file.metadata().is_ok_and(|about| !about.is_file()) {
        let text = format!("{}: not a file", path.display());
        return Err(End::new(exit::NO_INPUT, text));
    }
    let mut bytes = Vec::new();
    file.take(MOST + 1)
        .read_to_end(&mut bytes)
        .map_err(failed)?;
    if u64::try_from(bytes.len()).is_ok_and(|length| length > MOST) {
        return Err(wrong(path, format!("longer than {MOST} bytes")));
    }
    Ok(bytes)
}

fn wrong(path: &Path, what: impl std::fmt::Display) -> End {
    End::new(exit::DATA, format!("{}: {what}", path.display()))
}

/// What the sections of an ELF file put into flash, from their lowest address on; between them is erased flash. With
/// `begin` that address must be this one. (Segments may have the file's own header in front.)
fn flat(elf: &[u8], begin: Option<u32>) -> Result<Vec<u8>, String> {
    let file = ElfFile32::<Endianness>::parse(elf).map_err(|error| error.to_string())?;
    let (endian, elf) = (file.endian(), file.data());
    let mut parts = Vec::new();
    for section in file.elf_section_table().iter() {
        if section.sh_flags(endian) & object::elf::SHF_ALLOC == 0 {
            continue;
        }
        let bytes = section
            .data(endian, elf)
            .map_err(|error| error.to_string())?;
        let at = section.sh_offset(endian);
        // where a section is in flash is said by the segment it is in: one that runs in RAM has both addresses
        let loaded = file.elf_program_headers().iter().find_map(|part| {
            let inside = at.checked_sub(part.p_offset(endian))?;
            let in_file =
                part.p_type(endian) == object::elf::PT_LOAD && inside < part.p_filesz(endian);
            in_file.then(|| u64::from(part.p_paddr(endian)) + u64::from(inside))
        });
        if let Some(address) = loaded.filter(|_| !bytes.is_empty()) {
            parts.push((address, bytes));
        }
    }
    parts.sort_by_key(|(address, _)| *address);
    let first = parts.first().map_or(0, |(address, _)| *address);
    if let Some(begin) = begin.filter(|begin| u64::from(*begin) != first) {
        return Err(format!(
            "linked for another address (expected {begin:08x}, got {first:08x})"
        ));
    }
    let mut image = Vec::new();
    for (address, bytes) in parts {
        let at = usize::try_from(address - first).unwrap_or(usize::MAX);
        if at < image.len() {
            return Err(format!("two of its parts are at {address:08x}"));
        }
        if at.saturating_add(bytes.len()) as u64 > MOST {
            return Err(format!("longer than {MOST} bytes"));
        }
        image.resize(at, 0xFF);
        image.extend_from_slice(bytes);
    }
    Ok(image)
}

impl Pack {
    /// Writes the image.
    pub(super) fn run(self, out: &mut impl Write) -> Result<(), End> {
        let file = read(&self.program)?;
        let bytes = if file.starts_with(&object::elf::ELFMAG) {
            let begin = (self.target == STM32G474).then_some(stm32g474::IMAGE);
            flat(&file, begin).map_err(|what| wrong(&self.program, what))?
        } else {
            file
        };
        let length = u32::try_from(bytes.len()).unwrap_or(u32::MAX);
        if length == 0 {
            return Err(wrong(&self.program, "empty"));
        }
        let fits = |_| End::usage("a name is longer than 24 bytes");
        let header = ImageHeader {
            robot: self.robot.as_str().try_into().map_err(fits)?,
            target: self.target.as_str().try_into().map_err(fits)?,
            version: self.image_version,
            schema_hash: SCHEMA_HASH,
            length,
            crc: CRC.checksum(&bytes),
        };
        let mut file = image::write(&header).to_vec();
        file.extend(bytes);
        std::fs::write(&self.output, file).map_err(|error| Error::create(&self.output, error))?;
        let _ = writeln!(
            out,
            "{}: {} for {} of {}, {length} bytes, CRC {:08x}",
            self.output.display(),
            super::show::version(header.version),
            self.target,
            self.robot,
            header.crc
        );
        Ok(())
    }
}

/// An image, checked.
#[derive(Debug, PartialEq)]
pub(super) struct Image {
    pub(super) header: ImageHeader,
    pub(super) bytes: Vec<u8>,
}

/// Reads an image and checks it as far as can be without the node.
pub(super) fn load(path: &Path) -> Result<Image, End> {
    let mut file = read(path)?;
    let header = image::read(&file).map_err(|error| wrong(path, error))?;
    let bytes = file.split_off(HEADER);
    let expected = u64::from(header.length);
    let got = u64::try_from(bytes.len()).unwrap_or(u64::MAX);
    if expected != got || got == 0 {
        let what = format!("wrong length (expected {expected} bytes behind the header, got {got})");
        return Err(wrong(path, what));
    }
    let crc = CRC.checksum(&bytes);
    if crc != header.crc {
        let what = format!("damaged (expected CRC {:08x}, got {crc:08x})", header.crc);
        return Err(wrong(path, what));
    }
    Ok(Image { header, bytes })
}
