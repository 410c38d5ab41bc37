//! What an image is on disk and in a slot: a header of 96 bytes that says what follows, and the bytes themselves.
//!
//! | byte | |
//! |---|---|
//! | 0 | `MRROCIMG` |
//! | 8 | format, 1 |
//! | 9 | version: major, minor, patch |
//! | 12 | robot, 24 bytes, filled up with zeros |
//! | 36 | target, 24 bytes, filled up with zeros |
//! | 60 | schema hash, u64 |
//! | 68 | length of what follows, u32 |
//! | 72 | CRC-32 of what follows, u32 |
//! | 76 | zeros |
//! | 92 | CRC-32 of bytes 0 to 91, u32 |
//!
//! Numbers are little endian, CRCs are CRC-32/ISO-HDLC.

use protocol::maintenance::ImageHeader;

/// Bytes of a header: a multiple of every flash's write size.
pub const HEADER: usize = 96;

const MAGIC: &[u8; 8] = b"MRROCIMG";
const FORMAT: u8 = 1;
/// Bytes of a name.
const NAME: usize = 24;
/// Where the CRC of the header is.
const CHECKED: usize = 92;

/// CRC-32 of images, headers and records.
pub const CRC: crc::Crc<u32> = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC);

/// Why bytes are not the header of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HeaderError {
    /// Fewer than [`HEADER`] bytes.
    Short,
    /// It does not begin as one.
    Magic,
    /// A format of another time.
    Format(u8),
    /// Its own CRC does not fit.
    Crc,
    /// A name is no text.
    Name,
}

impl core::fmt::Display for HeaderError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Short => write!(f, "shorter than the {HEADER} bytes of a header"),
            Self::Magic => f.write_str("not an image: it does not begin with MRROCIMG"),
            Self::Format(got) => write!(f, "format of the header (expected {FORMAT}, got {got})"),
            Self::Crc => f.write_str("the header is damaged: its CRC does not fit"),
            Self::Name => f.write_str("a name in the header is no text"),
        }
    }
}

impl core::error::Error for HeaderError {}

/// The header as bytes.
#[must_use]
pub fn write(header: &ImageHeader) -> [u8; HEADER] {
    let [major, minor, patch] = [header.version.0, header.version.1, header.version.2];
    let mut bytes = [0; HEADER];
    put(&mut bytes, 0, MAGIC);
    put(&mut bytes, 8, &[FORMAT, major, minor, patch]);
    put(&mut bytes, 12, header.robot.as_bytes());
    put(&mut bytes, 36, header.target.as_bytes());
    put(&mut bytes, 60, &header.schema_hash.to_le_bytes());
    put(&mut bytes, 68, &header.length.to_le_bytes());
    put(&mut bytes, 72, &header.crc.to_le_bytes());
    let crc = CRC.checksum(bytes.get(..CHECKED).unwrap_or(&[]));
    put(&mut bytes, CHECKED, &crc.to_le_bytes());
    bytes
}

/// The header that these bytes begin with.
///
/// # Errors
/// [`HeaderError`]
pub fn read(bytes: &[u8]) -> Result<ImageHeader, HeaderError> {
    let bytes = bytes.get(..HEADER).ok_or(HeaderError::Short)?;
    if take::<8>(bytes, 0)? != *MAGIC {
        return Err(HeaderError::Magic);
    }
    let crc = CRC.checksum(bytes.get(..CHECKED).unwrap_or(&[]));
    if u32::from_le_bytes(take(bytes, CHECKED)?) != crc {
        return Err(HeaderError::Crc);
    }
    let [format, major, minor, patch] = take(bytes, 8)?;
    if format != FORMAT {
        return Err(HeaderError::Format(format));
    }
    Ok(ImageHeader {
        robot: name(&take(bytes, 12)?)?,
        target: name(&take(bytes, 36)?)?,
        version: (major, minor, patch),
        schema_hash: u64::from_le_bytes(take(bytes, 60)?),
        length: u32::from_le_bytes(take(bytes, 68)?),
        crc: u32::from_le_bytes(take(bytes, 72)?),
    })
}

/// What does not fit is left out: names are no longer than their places.
pub(super) fn put(bytes: &mut [u8], at: usize, what: &[u8]) {
    let places = bytes.iter_mut().skip(at);
    for (place, byte) in places.zip(what) {
        *place = *byte;
    }
}

pub(super) fn take<const N: usize>(bytes: &[u8], at: usize) -> Result<[u8; N], HeaderError> {
    let rest = bytes.get(at..).unwrap_or(&[]);
    rest.first_chunk::<N>().copied().ok_or(HeaderError::Short)
}

fn name(bytes: &[u8; NAME]) -> Result<heapless::String<NAME>, HeaderError> {
    let mut ends = bytes.split(|byte| *byte == 0);
    let text = ends.next().unwrap_or(&[]);
    if ends.any(|rest| !rest.is_empty()) {
        return Err(HeaderError::Name);
    }
    let text = core::str::from_utf8(text).map_err(|_| HeaderError::Name)?;
    heapless::String::try_from(text).map_err(|_| HeaderError::Name)
}

#[cfg(test)]
mod test {
    extern crate std;
    use super::*;
    use proptest::prelude::*;

    fn header(robot: &str, target: &str) -> ImageHeader {
        ImageHeader {
            robot: robot.try_into().unwrap(),
            target: target.try_into().unwrap(),
            version: (1, 2, 3),
            schema_hash: 0x0123_4567_89AB_CDEF,
            length: 100_000,
            crc: 0xCBF4_3926,
        }
    }

    /// Written by hand from the table above; the header's CRC by `python3 -c 'import zlib; …'`.
    #[test]
    fn the_layout_is_the_one_of_the_table() {
        let bytes = write(&header("irp6-track", "stm32g474"));
        assert_eq!(&bytes[..12], b"MRROCIMG\x01\x01\x02\x03");
        assert_eq!(&bytes[12..24], b"irp6-track\0\0");
        assert_eq!(&bytes[36..46], b"stm32g474\0");
        assert_eq!(
            bytes[60..68],
            [0xEF, 0xCD, 0xAB, 0x89, 0x67, 0x45, 0x23, 0x01]
        );
        assert_eq!(bytes[68..76], [0xA0, 0x86, 0x01, 0, 0x26, 0x39, 0xF4, 0xCB]);
        assert!(bytes[76..92].iter().all(|byte| *byte == 0));
        // the catalogue's check value of CRC-32/ISO-HDLC
        assert_eq!(CRC.checksum(b"123456789"), 0xCBF4_3926);
    }

    #[test]
    fn every_error_of_one_or_two_bits_is_found() {
        let good = write(&header("irp6-postument", "host"));
        let bits = HEADER * 8;
        for first in 0..bits {
            for second in (first..bits).step_by(13) {
                let mut bytes = good;
                bytes[first / 8] ^= 1 << (first % 8);
                if second != first {
                    bytes[second / 8] ^= 1 << (second % 8);
                }
                assert!(read(&bytes).is_err(), "{first} {second}");
            }
        }
    }

    #[test]
    fn what_is_no_header_is_told_apart() {
        let good = write(&header("irp6-track", "host"));
        assert_eq!(read(&good[..95]), Err(HeaderError::Short));
        assert_eq!(read(&[0xFF; HEADER]), Err(HeaderError::Magic));
        let mut other = good;
        other[8] = 2;
        assert_eq!(read(&other), Err(HeaderError::Crc));
        let crc = CRC.checksum(&other[..CHECKED]);
        put(&mut other, CHECKED, &crc.to_le_bytes());
        assert_eq!(read(&other), Err(HeaderError::Format(2)));
        for (at, byte) in [(12, 0xFF), (35, b'x')] {
            let mut other = good;
            other[at] = byte;
            let crc = CRC.checksum(&other[..CHECKED]);
            put(&mut other, CHECKED, &crc.to_le_bytes());
            assert_eq!(read(&other), Err(HeaderError::Name), "{at}");
        }
    }

    proptest! {
        #[test]
        fn what_is_written_is_read(
            robot in "[a-z0-9-]{0,24}", target in "[a-z0-9-]{0,24}", version: (u8, u8, u8),
            schema_hash: u64, length: u32, crc: u32,
        ) {
            let header = ImageHeader {
                robot: robot.as_str().try_into().unwrap(),
                target: target.as_str().try_into().unwrap(),
                version, schema_hash, length, crc,
            };
            prop_assert_eq!(read(&write(&header)), Ok(header));
        }

        #[test]
        fn any_bytes_are_a_header_or_not(bytes in proptest::collection::vec(any::<u8>(), 0..128)) {
            let _ = read(&bytes);
        }
    }
}
