//! How the drive's CAN controller is, and what follows from it.

use bus::wire::confinement::State;
use protocol::canopen::emcy::ErrorCode;
use protocol::frame::Frame;

use super::SimDrive;

impl SimDrive {
    /// Its CAN controller is in this state at `now_ns`. `true`: it tells the controller to recover from bus-off, and
    /// to forget what waits; it does so at once, as most drives do, for what it may do then is decided by its power
    /// state.
    ///
    /// Error-passive is told (8120) and stops nothing. Bus-off is a communication error: the axis stops by 6007, the
    /// NMT state follows 1029; it can only be told when it is over (8140).
    pub fn on_bus_state(&mut self, now_ns: u64, state: State, out: &mut impl FnMut(Frame)) -> bool {
        self.now_ns = now_ns;
        let before = core::mem::replace(&mut self.can, state);
        match (before, state) {
            (State::Active, State::Passive) => self.report(ErrorCode::CAN_PASSIVE),
            (State::Active | State::Passive, State::BusOff) => {
                self.outbox.clear();
                self.communication_failed(ErrorCode::NONE);
            }
            (State::BusOff, State::Active | State::Passive) => self.report(ErrorCode::BUS_OFF_OVER),
            (State::Active | State::Passive, State::Active)
            | (State::Passive, State::Passive)
            | (State::BusOff, State::BusOff) => {}
        }
        self.flush(out);
        state == State::BusOff
    }
}
