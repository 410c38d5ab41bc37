//! Linux CAN interfaces: can0, vcan0, …; classical and FD.

use crate::wire::confinement::State;
use crate::{Bus, BusError, Hears, MAX_IDS, Received, StateChange, now, until};
use ::socketcan::errors::{CanError, ControllerProblems};
use ::socketcan::{
    CanAnyFrame, CanDataFrame, CanErrorFrame, CanFdFrame, CanFdSocket, CanFilter,
    EmbeddedFrame as _, ExtendedId, ShouldRetry as _, Socket as _, SocketOptions as _, StandardId,
};
use protocol::frame::{Frame, Id};
use protocol::time::Micros;
use std::collections::VecDeque;
use std::io;
use std::time::Duration;

// Numbers of the generic Linux ABI (x86, ARM, RISC-V).
const EINVAL: i32 = 22;
const ENODEV: i32 = 19;
const ENXIO: i32 = 6;
const EPERM: i32 = 1;
const EPROTONOSUPPORT: i32 = 93;
const EAFNOSUPPORT: i32 = 97;
const ENETDOWN: i32 = 100;
const ENOBUFS: i32 = 105;

/// Frames of one socket that the kernel holds before they are on the bus, at most. It sends them in
/// the order in which it got them, so an urgent frame waits for no more than these.
pub const KERNEL_QUEUE: usize = 8;

/// Frames that wait for the kernel in this process, most urgent first, at most; with more,
/// [`BusError::Full`].
pub const QUEUE: usize = 256;

/// In an identifier of the kernel: it has 29 bits.
const EXTENDED: u32 = 0x8000_0000;

/// Error frames that tell of a change of state: controller, bus-off, restarted (linux/can/error.h).
const ERRORS: u32 = 0x004 | 0x040 | 0x100;

/// Changes of state that nobody has asked for yet, at most; then the oldest is forgotten.
const CHANGES: usize = 16;

/// Between two looks at whether the kernel takes more.
const LOOK: Duration = Duration::from_millis(1);

/// What the kernel counts for a frame that waits: a buffer of 512 bytes for the frame, its private
/// part and its shared information, and 256 for its description, on a 64-bit machine.
const FRAME_BYTES: usize = 768;

/// A raw socket on one interface.
///
/// An interface that is switched off is waited for: nothing arrives, and sending is
/// [`BusError::Down`], until it is switched on again. One that is removed is [`BusError::Lost`].
#[derive(Debug)]
pub struct SocketCan {
    label: String,
    socket: CanFdSocket,
    waiting: Option<Received>,
    unsent: VecDeque<Frame>,
    ignored: u64,
    state: State,
    changes: VecDeque<State>,
}

impl SocketCan {
    /// Opens an interface that exists and is up.
    ///
    /// # Errors
    /// One line that says what to do: no CAN support in the kernel, no such interface, …
    pub fn open(interface: &str, hears: Hears<'_>) -> Result<Self, BusError> {
        let label = format!("can:{interface}");
        let opened = CanFdSocket::open(interface).and_then(|socket| {
            socket.set_nonblocking(true)?;
            if let Some(filters) = filters(hears) {
                socket.set_filters(&filters)?;
            }
            socket.set_error_filter(ERRORS)?;
            // the kernel doubles what it is given, and admits a frame while the sum is below that
            socket
                .as_raw_socket()
                .set_send_buffer_size(KERNEL_QUEUE * FRAME_BYTES / 2)?;
            Ok(socket)
        });
        match opened {
            Ok(socket) => Ok(Self {
                label,
                socket,
                waiting: None,
                unsent: VecDeque::new(),
                ignored: 0,
                state: State::Active,
                changes: VecDeque::new(),
            }),
            Err(error) => Err(BusError::Open {
                bus: label,
                reason: explain(&error, interface),
            }),
        }
    }

    /// Remote frames received so far; they are not handed on.
    #[must_use]
    pub const fn ignored(&self) -> u64 {
        self.ignored
    }

    fn error(&self, source: io::Error) -> BusError {
        let bus = self.label.clone();
        match source.raw_os_error() {
            Some(ENETDOWN) => BusError::Down { bus },
            Some(ENODEV | ENXIO) => BusError::Lost {
                bus,
                reason: "the interface is gone".into(),
            },
            _ => BusError::Io { bus, source },
        }
    }

    /// Gives a frame to the kernel; `false` if that holds as many as it may.
    fn write(&self, frame: &Frame) -> Result<bool, BusError> {
        let Some(any) = to_socketcan(frame) else {
            return Err(self.error(io::Error::new(
                io::ErrorKind::InvalidInput,
                "the identifier is out of range",
            )));
        };
        let Err(error) = self.socket.write_frame(&any) else {
            return Ok(true);
        };
        match error.raw_os_error() {
            Some(ENOBUFS) => Ok(false),
            Some(EINVAL) if frame.is_fd() => Err(BusError::FdUnsupported {
                bus: self.label.clone(),
            }),
            _ if error.kind() == io::ErrorKind::WouldBlock => Ok(false),
            _ => Err(self.error(error)),
        }
    }

    /// Gives the kernel what waits, as far as it takes it. What waits for an interface that is
    /// switched off is old before that is on again: it is lost.
    fn flush(&mut self) -> Result<(), BusError> {
        while let Some(frame) = self.unsent.front() {
            match self.write(frame) {
                Ok(true) => {
                    self.unsent.pop_front();
                }
                Ok(false) => break,
                Err(error) => {
                    self.unsent.clear();
                    return Err(error);
                }
            }
        }
        Ok(())
    }

    /// The same for who does not want to send: that the interface is down is nothing to tell.
    fn flush_if_up(&mut self) -> Result<(), BusError> {
        match self.flush() {
            Err(BusError::Down { .. }) => Ok(()),
            flushed => flushed,
        }
    }

    /// A data frame is kept, an error frame may change the state, anything else is counted.
    fn take(&mut self, frame: CanAnyFrame) -> Option<Received> {
        if let CanAnyFrame::Error(error) = frame {
            if let Some(state) = state_after(error)
                && std::mem::replace(&mut self.state, state) != state
            {
                if self.changes.len() >= CHANGES {
                    self.changes.pop_front();
                }
                self.changes.push_back(state);
            }
            return None;
        }
        let taken = from_socketcan(frame).map(|frame| Received { frame, at: now() });
        if taken.is_none() {
            self.ignored += 1;
        }
        taken
    }
}

/// What the kernel is to hand on; `None`: everything. A filter is an identifier and the bits of it that
/// count.
fn filters(hears: Hears<'_>) -> Option<Vec<CanFilter>> {
    let extended = CanFilter::new(EXTENDED, EXTENDED);
    match hears {
        Hears::All => None,
        Hears::Node(ids) if ids.len() > MAX_IDS => None,
        Hears::Extended => Some(vec![extended]),
        Hears::Standard => Some(vec![CanFilter::new(0, EXTENDED)]),
        Hears::Node(ids) => {
            let of = |id: &u8| CanFilter::new(u32::from(*id & 0x7F), EXTENDED | 0x7F);
            let of_ids = ids.iter().map(of);
            Some(of_ids.chain([extended]).collect())
        }
    }
}

/// The state that an error frame tells of, the worst if several.
fn state_after(error: CanErrorFrame) -> Option<State> {
    let error = CanError::from(error);
    if error.is_bus_off() {
        return Some(State::BusOff);
    }
    let passive = ControllerProblems::RX_PASSIVE | ControllerProblems::TX_PASSIVE;
    match error.controller() {
        Some(problems) if problems.intersects(passive) => Some(State::Passive),
        Some(problems) if problems.contains(ControllerProblems::ACTIVE) => Some(State::Active),
        _ => error.is_restarted().then_some(State::Active),
    }
}

/// Is there merely nothing to receive? An interface that is switched off is told once, to whoever
/// receives then.
fn is_nothing(error: &io::Error) -> bool {
    let down = error.raw_os_error() == Some(ENETDOWN);
    down || error.should_retry() || error.kind() == io::ErrorKind::TimedOut
}

fn explain(error: &io::Error, interface: &str) -> String {
    match error.raw_os_error() {
        Some(EAFNOSUPPORT | EPROTONOSUPPORT) => {
            "this kernel has no SocketCAN (AF_CAN); try `modprobe can_raw`, or use --bus hub".into()
        }
        Some(ENODEV | ENXIO) => format!(
            "no such interface; for a virtual one: ip link add {interface} type vcan && ip link set \
             {interface} up"
        ),
        Some(ENETDOWN) => format!("the interface is down: ip link set {interface} up"),
        Some(EPERM) => "not permitted to open CAN sockets".into(),
        _ => error.to_string(),
    }
}

fn from_socketcan(frame: CanAnyFrame) -> Option<Frame> {
    let id = |id: ::socketcan::Id| match id {
        ::socketcan::Id::Standard(id) => Id::Standard(id.as_raw()),
        ::socketcan::Id::Extended(id) => Id::Extended(id.as_raw()),
    };
    match frame {
        CanAnyFrame::Normal(frame) => Frame::classic(id(frame.id()), frame.data()),
        CanAnyFrame::Fd(frame) => Frame::fd(id(frame.id()), frame.data()),
        CanAnyFrame::Remote(_) | CanAnyFrame::Error(_) => None,
    }
}

fn to_socketcan(frame: &Frame) -> Option<CanAnyFrame> {
    let id: ::socketcan::Id = match frame.id() {
        Id::Standard(id) => StandardId::new(id)?.into(),
        Id::Extended(id) => ExtendedId::new(id)?.into(),
    };
    if frame.is_fd() {
        let mut fd = CanFdFrame::new(id, frame.data())?;
        fd.set_brs(true);
        Some(fd.into())
    } else {
        CanDataFrame::new(id, frame.data()).map(CanAnyFrame::from)
    }
}

impl Bus for SocketCan {
    fn send(&mut self, frame: &Frame) -> Result<(), BusError> {
        self.flush()?;
        if self.unsent.is_empty() && self.write(frame)? {
            return Ok(());
        }
        if self.unsent.len() >= QUEUE {
            return Err(BusError::Full {
                bus: self.label.clone(),
            });
        }
        let urgency = frame.id().arbitration();
        let place = self
            .unsent
            .partition_point(|other| other.id().arbitration() <= urgency);
        self.unsent.insert(place, *frame);
        Ok(())
    }

    fn receive(&mut self) -> Result<Option<Received>, BusError> {
        if let Some(waiting) = self.waiting.take() {
            return Ok(Some(waiting));
        }
        self.flush_if_up()?;
        loop {
            match self.socket.read_frame() {
                Ok(frame) => {
                    if let Some(received) = self.take(frame) {
                        return Ok(Some(received));
                    }
                }
                Err(error) if is_nothing(&error) => return Ok(None),
                Err(error) => return Err(self.error(error)),
            }
        }
    }

    fn take_change(&mut self) -> Option<StateChange> {
        let state = self.changes.pop_front()?;
        Some(StateChange {
            bus: self.label.clone(),
            state,
        })
    }

    fn wait(&mut self, deadline: Micros) -> Result<(), BusError> {
        while self.waiting.is_none() {
            self.flush_if_up()?;
            let mut left = until(deadline);
            if left.is_zero() {
                break;
            }
            if !self.unsent.is_empty() {
                left = left.min(LOOK);
            }
            match self.socket.read_frame_timeout(left) {
                Ok(frame) => self.waiting = self.take(frame),
                Err(error) if is_nothing(&error) => {}
                Err(error) => return Err(self.error(error)),
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// With or without SocketCAN in the kernel, the answer is one line that helps.
    #[test]
    fn an_interface_that_is_not_there() {
        let error = SocketCan::open("mrroc-none0", Hears::All)
            .unwrap_err()
            .to_string();
        assert!(error.starts_with("can:mrroc-none0: "), "{error}");
        assert!(
            error.contains("no such interface") || error.contains("AF_CAN"),
            "{error}"
        );
        assert!(!error.contains('\n'));
    }

    /// Required hardware: interface vcan0. Skipped where it does not exist.
    #[test]
    fn two_sockets_on_vcan0() {
        let (Ok(mut a), Ok(mut b)) = (
            SocketCan::open("vcan0", Hears::All),
            SocketCan::open("vcan0", Hears::Extended),
        ) else {
            return;
        };
        let frame = Frame::classic(Id::Extended(0x0123_4567), &[1, 2, 3]).unwrap();
        a.send(&frame).unwrap();
        b.wait(now() + Micros::from_millis(1000)).unwrap();
        assert_eq!(b.receive().unwrap().map(|r| r.frame), Some(frame));
        assert_eq!(a.receive().unwrap(), None);
    }

    /// Error frames as the kernel's drivers make them (linux/can/error.h).
    #[test]
    fn error_frames_tell_the_state() {
        let state = |class: u32, controller: u8| {
            let data = [0, controller, 0, 0, 0, 0, 0, 0];
            state_after(CanErrorFrame::new_error(class, &data).unwrap())
        };
        assert_eq!(state(0x040, 0), Some(State::BusOff));
        // a change of state comes with the counters (0x200); passive and warning may come together
        for passive in [0x10, 0x20, 0x14, 0x28] {
            assert_eq!(state(0x204, passive), Some(State::Passive), "{passive:x}");
        }
        assert_eq!(state(0x004, 0x40), Some(State::Active));
        assert_eq!(state(0x100, 0), Some(State::Active));
        assert_eq!(state(0x044, 0x20), Some(State::BusOff));
        // a warning, an overflow, a lost arbitration, no acknowledge: no change
        for (class, controller) in [(0x004, 0x08), (0x004, 0x01), (0x002, 0), (0x020, 0)] {
            assert_eq!(state(class, controller), None, "{class:x} {controller:x}");
        }
    }

    #[test]
    fn each_state_is_one_line_that_helps() {
        let line = |state| {
            let bus = "can:can0".into();
            StateChange { bus, state }.to_string()
        };
        assert_eq!(line(State::Active), "can:can0: error-active again");
        assert!(line(State::Passive).starts_with("can:can0: error-passive: "));
        let off = line(State::BusOff);
        assert!(off.contains("`ip link set can0 type can restart`"), "{off}");
        assert!(!off.contains('\n') && !off.contains("  "), "{off}");
    }

    proptest! {
        #[test]
        fn frames_survive_the_conversion(
            extended: bool, fd: bool, id in 0u32..=0x1FFF_FFFF,
            data in proptest::collection::vec(any::<u8>(), 0..=8),
        ) {
            let id = if extended { Id::Extended(id) } else { Id::Standard((id % 0x800) as u16) };
            let frame = if fd { Frame::fd(id, &data) } else { Frame::classic(id, &data) }.unwrap();
            prop_assert_eq!(to_socketcan(&frame).and_then(from_socketcan), Some(frame));
        }
    }
}
