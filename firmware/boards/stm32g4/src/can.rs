//! The three FDCAN, whose clock is the processor's.

use crate::clock::HZ;
use board::bit_timing::{BitTiming, M_CAN, Rate, TimingError, classic, fd};
use board::mcan::{MCan, MEMORY, Silent};
use board::port::CanPort;
use board_cortex_m::window::Window;
use firmware::Port;
use protocol::frame::Id;

/// CANopen at 1 Mbit/s; also the MP bus where it is classical.
pub const CLASSIC: BitTiming = sure(classic(HZ, Rate::canopen(1_000_000), &M_CAN));
/// The MP bus at 1 and 5 Mbit/s.
pub const FD: BitTiming = sure(fd(HZ, Rate::MP_NOMINAL, Rate::MP_DATA, &M_CAN));
/// SYNC of a bus of one's own: of it the controller tells when it was sent.
const SYNC: Id = Id::Standard(0x80);
/// Frames that wait.
const WAITING: usize = 16;

/// A port by an FDCAN.
pub type Can = CanPort<Window, WAITING>;

/// Evaluated by the compiler.
const fn sure(timing: Result<BitTiming, TimingError>) -> BitTiming {
    match timing {
        Ok(timing) => timing,
        Err(_) => panic!("this clock has no such bit rate"),
    }
}

/// FDCAN1 to 3, each with its part of the message memory: what towards the MP, and two drive buses.
///
/// # Errors
/// [`Silent`]
///
/// # Safety
/// To be called once.
pub unsafe fn start(mp: &BitTiming) -> Result<[Can; 3], Silent> {
    let can = |number: usize, port, timing| {
        // SAFETY: the registers of one FDCAN, and the part of the memory that is its own; once, as was promised
        let (registers, memory) = unsafe {
            (
                Window::new(0x4000_6400 + 0x400 * number, 0x104 / 4),
                Window::new(0x4000_A400 + 4 * MEMORY * number, MEMORY),
            )
        };
        MCan::start(registers, memory, timing, Some(SYNC)).map(|can| CanPort::new(port, can))
    };
    Ok([
        can(0, Port::Mp, mp)?,
        can(1, Port::Drives(0), &CLASSIC)?,
        can(2, Port::Drives(1), &CLASSIC)?,
    ])
}
