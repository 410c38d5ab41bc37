//! A CAN frame with its port and time as bytes, little endian:
//!
//! | bytes | content |
//! |---|---|
//! | 1 | port: FF towards the MP, else the number of the drive bus |
//! | 1 | bit 0: identifier of 29 bits; bit 1: CAN FD |
//! | 1 | length of the payload, L |
//! | 1 | 0 |
//! | 4 | identifier |
//! | 8 | when it was received, µs; 0 in a frame that is sent |
//! | L | payload |

use crate::bytes::{Reader, Writer};
use firmware::{Port, Received};
use protocol::frame::{Frame, Id, MAX_DATA};
use protocol::time::Micros;

/// The port towards the MP.
const MP: u8 = 0xFF;
/// The identifier has 29 bits.
const EXTENDED: u8 = 1;
/// A CAN FD frame.
const FD: u8 = 2;

/// Bytes before the payload.
pub const HEADER: usize = 16;
/// The longest frame.
pub const LONGEST: usize = HEADER + MAX_DATA;

/// Write a frame; how many bytes it took, or nothing if the buffer has no room for it.
#[must_use]
pub fn write(received: &Received, buffer: &mut [u8]) -> Option<usize> {
    let mut out = Writer::new(buffer);
    put(received, &mut out)?;
    Some(out.len())
}

pub(crate) fn put(received: &Received, out: &mut Writer<'_>) -> Option<()> {
    let port = match received.port {
        Port::Mp => MP,
        Port::Drives(bus) => bus,
    };
    let frame = &received.frame;
    let (id, extended) = match frame.id() {
        Id::Standard(id) => (u32::from(id), 0),
        Id::Extended(id) => (id, EXTENDED),
    };
    let fd = if frame.is_fd() { FD } else { 0 };
    let length = u8::try_from(frame.data().len()).ok()?;
    let mut header = [0; HEADER];
    {
        let mut head = Writer::new(&mut header);
        head.put(&[port, extended | fd, length, 0])?;
        head.put(&id.to_le_bytes())?;
        head.put(&received.at.0.to_le_bytes())?;
    }
    out.put(&header)?;
    out.put(frame.data())
}

/// Read one frame; and how many bytes it took. Nothing if these bytes do not begin with a frame.
#[must_use]
pub fn read(bytes: &[u8]) -> Option<(Received, usize)> {
    let mut reader = Reader(bytes);
    let received = take(&mut reader)?;
    Some((received, bytes.len().checked_sub(reader.0.len())?))
}

pub(crate) fn take(bytes: &mut Reader<'_>) -> Option<Received> {
    let (port, flags, length, zero) = (bytes.u8()?, bytes.u8()?, bytes.u8()?, bytes.u8()?);
    let (id, at) = (bytes.u32()?, bytes.u64()?);
    let data = bytes.take(usize::from(length))?;
    if flags & !(EXTENDED | FD) != 0 || zero != 0 {
        return None;
    }
    let id = if flags & EXTENDED == 0 {
        Id::Standard(u16::try_from(id).ok()?)
    } else {
        Id::Extended(id)
    };
    let frame = if flags & FD == 0 {
        Frame::classic(id, data)
    } else {
        Frame::fd(id, data)
    };
    Some(Received {
        port: if port == MP {
            Port::Mp
        } else {
            Port::Drives(port)
        },
        at: Micros(at),
        frame: frame?,
    })
}

#[cfg(test)]
mod test {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn what_is_written_is_read(
            port in any::<u8>(), extended in any::<bool>(), fd in any::<bool>(), id in any::<u32>(),
            at in any::<u64>(), data in proptest::collection::vec(any::<u8>(), 0..=8),
        ) {
            let port = if port == MP { Port::Mp } else { Port::Drives(port) };
            let id = if extended { Id::Extended(id & 0x1FFF_FFFF) } else { Id::Standard(id as u16 & 0x7FF) };
            let frame = if fd { Frame::fd(id, &data) } else { Frame::classic(id, &data) };
            let received = Received { port, at: Micros(at), frame: frame.unwrap() };
            let mut buffer = [0; LONGEST + 1];
            let len = write(&received, &mut buffer).unwrap();
            prop_assert_eq!(len, HEADER + data.len());
            prop_assert_eq!(read(&buffer), Some((received, len)));
            for short in 0..len {
                prop_assert_eq!(read(&buffer[..short]), None);
                prop_assert_eq!(write(&received, &mut buffer[..short].to_vec()), None);
            }
        }

        #[test]
        fn no_bytes_are_too_strange(bytes in proptest::collection::vec(any::<u8>(), 0..100)) {
            if let Some((received, len)) = read(&bytes) {
                let mut buffer = [0; LONGEST];
                prop_assert_eq!(write(&received, &mut buffer), Some(len));
                prop_assert_eq!(&buffer[..len], &bytes[..len]);
            }
        }
    }
}
