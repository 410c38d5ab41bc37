//! Images as files: the header of `firmware::update::image`, then the program.

use clap::Args;
use firmware::update::image::{self, CRC, HEADER};
use host::error::Error;
use process::{End, exit};
use protocol::maintenance::ImageHeader;
use protocol::schema::SCHEMA_HASH;
use std::fs::File;
use std::io::{ErrorKind, Read, Write};
use std::path::{Path, PathBuf};

/// No microcontroller has a slot of this length, bytes.
const MOST: u64 = 16 * 1024 * 1024;

/// Make an image of a program.
#[derive(Args, Debug)]
pub(super) struct Pack {
    /// The program: the bytes as they are in flash, linked for the address of an image.
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

impl Pack {
    /// Writes the image.
    pub(super) fn run(self, out: &mut impl Write) -> Result<(), End> {
        let bytes = read(&self.program)?;
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
