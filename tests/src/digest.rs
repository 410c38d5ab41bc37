//! A record as one number: FNV-1a of 64 bits, published by Fowler, Noll and Vo. It finds differences;
//! it is no defence against anybody.

use bus::candump::Writer;
use hil_sim::cell::Observer;
use protocol::frame::Frame;
use protocol::time::Micros;
use std::io;

/// FNV-1a over bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fnv(u64);

impl Default for Fnv {
    fn default() -> Self {
        Self(0xCBF2_9CE4_8422_2325)
    }
}

impl Fnv {
    /// The number so far.
    #[must_use]
    pub const fn value(self) -> u64 {
        self.0
    }
}

impl io::Write for Fnv {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        for byte in bytes {
            self.0 = (self.0 ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01B3);
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// The number of some bytes.
#[must_use]
pub fn of(bytes: &[u8]) -> u64 {
    let mut fnv = Fnv::default();
    // writing to a number cannot fail
    let _ = io::Write::write(&mut fnv, bytes);
    fnv.value()
}

/// Records every frame of a cell as the lines of a candump log, and keeps only their number.
#[derive(Debug)]
pub struct Record {
    text: Vec<u8>,
    fnv: Fnv,
    /// How many frames.
    pub frames: u64,
}

impl Default for Record {
    fn default() -> Self {
        Self {
            text: Vec::with_capacity(256),
            fnv: Fnv::default(),
            frames: 0,
        }
    }
}

impl Record {
    /// The number of the record so far.
    #[must_use]
    pub const fn value(&self) -> u64 {
        self.fnv.value()
    }
}

impl Observer for Record {
    fn frame(&mut self, bus: usize, at_ns: u64, frame: &Frame) {
        self.frames += 1;
        self.text.clear();
        let written =
            Writer::new(&mut self.text).write(Micros(at_ns / 1000), &format!("bus{bus}"), frame);
        debug_assert!(written.is_ok(), "memory takes everything");
        let _ = io::Write::write(&mut self.fnv, &self.text);
    }

    fn motors(&mut self, station: usize, at_ns: u64, motor_rad: &[f64]) {
        let _ = io::Write::write(&mut self.fnv, &(station as u64).to_le_bytes());
        let _ = io::Write::write(&mut self.fnv, &at_ns.to_le_bytes());
        for rad in motor_rad {
            let _ = io::Write::write(&mut self.fnv, &rad.to_bits().to_le_bytes());
        }
    }
}

#[cfg(test)]
mod test {
    use super::*;

    #[test]
    fn the_published_test_vectors() {
        assert_eq!(of(b""), 0xCBF2_9CE4_8422_2325);
        assert_eq!(of(b"a"), 0xAF63_DC4C_8601_EC8C);
        assert_eq!(of(b"foobar"), 0x8594_4171_F739_67E8);
    }
}
