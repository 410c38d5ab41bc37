//! Program download, CiA 302-3: objects 1F50 (data), 1F51 (control), 1F56 (identification), 1F57 (status).
//!
//! The drive keeps one program over every reset, tells its CRC-32 and what is wrong with it. It never runs one: what moves
//! the axis is this simulation, whatever was downloaded.
//!
//! ```text
//! 1F51 = 0 stop ─▶ 1F51 = 3 clear ─▶ 1F50 data ─▶ 1F56 CRC-32, 1F57 = 0 ─▶ 1F51 = 1 start
//! ```

use protocol::canopen::objects::{index, slot};
use protocol::canopen::sdo::Abort;

use super::Dictionary;

/// The longest program, bytes.
pub const CAPACITY: usize = 65_536;

/// What object 1F57 tells, in its bits 1 to 7.
pub mod flash {
    /// No error.
    pub const GOOD: u32 = 0;
    /// There is no valid program.
    pub const NO_PROGRAM: u32 = 1 << 1;
    /// The data are none: there is not a byte.
    pub const FORMAT: u32 = 3 << 1;
    /// It was not cleared before.
    pub const NOT_CLEARED: u32 = 4 << 1;
    /// It may not be written now: the program runs, or the axis has torque.
    pub const SECURED: u32 = 7 << 1;
}

/// What is written to object 1F51.
mod control {
    pub(super) const STOP: u32 = 0;
    pub(super) const START: u32 = 1;
    pub(super) const RESET: u32 = 2;
    pub(super) const CLEAR: u32 = 3;
}

/// The drive's place for a program.
#[derive(Clone, Debug)]
pub(crate) struct Program {
    data: Vec<u8>,
    /// Without a program in this place the drive's own runs.
    running: bool,
    cleared: bool,
    status: u32,
}

impl Default for Program {
    fn default() -> Self {
        Self {
            data: Vec::new(),
            running: true,
            cleared: false,
            status: flash::GOOD,
        }
    }
}

impl Program {
    pub(super) fn data(&self) -> &[u8] {
        &self.data
    }

    /// Object 1F51 was written.
    fn control(&mut self, command: u32, energised: bool) -> Result<(), Abort> {
        if energised {
            self.status = flash::SECURED;
            return Err(Abort::DeviceState);
        }
        match command {
            control::STOP => self.running = false,
            control::START | control::RESET => {
                if self.cleared && self.data.is_empty() {
                    self.status = flash::NO_PROGRAM;
                    return Err(Abort::DeviceState);
                }
                (self.running, self.status) = (true, flash::GOOD);
            }
            control::CLEAR => {
                if self.running {
                    self.status = flash::SECURED;
                    return Err(Abort::DeviceState);
                }
                self.data.clear();
                (self.cleared, self.status) = (true, flash::NO_PROGRAM);
            }
            _ => return Err(Abort::Range),
        }
        Ok(())
    }

    /// Object 1F50 was written.
    fn load(&mut self, data: &[u8], energised: bool) -> Result<(), Abort> {
        let (status, abort) = if self.running || energised {
            (flash::SECURED, Abort::DeviceState)
        } else if !self.cleared || !self.data.is_empty() {
            (flash::NOT_CLEARED, Abort::DeviceState)
        } else if data.is_empty() {
            (flash::FORMAT, Abort::TooShort)
        } else if data.len() > CAPACITY {
            (flash::FORMAT, Abort::TooLong)
        } else {
            self.data = data.to_vec();
            self.status = flash::GOOD;
            return Ok(());
        };
        self.status = status;
        Err(abort)
    }

    /// CRC-32 of the program as Ethernet has it (polynomial 04C1 1DB7, reflected), 0 without one.
    fn identification(&self) -> u32 {
        if self.data.is_empty() {
            return 0;
        }
        !self.data.iter().fold(u32::MAX, |crc, byte| {
            (0..8).fold(crc ^ u32::from(*byte), |crc, _| {
                crc >> 1 ^ if crc & 1 == 1 { 0xEDB8_8320 } else { 0 }
            })
        })
    }
}

impl Dictionary {
    /// A program has come.
    pub(super) fn load_program(&mut self, data: &[u8]) -> Result<(), Abort> {
        let done = self.program.load(data, self.energised);
        self.publish_program();
        done
    }

    /// What is to happen to the program.
    pub(super) fn control_program(&mut self, command: u32) -> Result<(), Abort> {
        let done = self.program.control(command, self.energised);
        self.publish_program();
        done
    }

    /// Writes what the program's place tells into its objects.
    pub(super) fn publish_program(&mut self) {
        let program = &self.program;
        let told = [
            (index::PROGRAM_CONTROL, u32::from(program.running)),
            (index::PROGRAM_IDENTIFICATION, program.identification()),
            (index::FLASH_STATUS, program.status),
        ];
        for (index, value) in told {
            self.values[slot(index, 1)] = value;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_identification_is_the_crc_of_everybody() {
        let of = |data: &[u8]| {
            let data = data.to_vec();
            Program {
                data,
                ..Program::default()
            }
            .identification()
        };
        // the check value of CRC-32/ISO-HDLC
        assert_eq!(of(b"123456789"), 0xCBF4_3926);
        assert_eq!(of(b""), 0);
    }
}
