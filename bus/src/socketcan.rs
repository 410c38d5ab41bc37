//! Linux CAN interfaces: can0, vcan0, …; classical and FD.

use crate::{Bus, BusError, Received, now, until};
use ::socketcan::{
    CanAnyFrame, CanDataFrame, CanFdFrame, CanFdSocket, EmbeddedFrame as _, ExtendedId,
    ShouldRetry as _, Socket as _, StandardId,
};
use protocol::frame::{Frame, Id};
use protocol::time::Micros;
use std::io;

// Numbers of the generic Linux ABI (x86, ARM, RISC-V).
const EINVAL: i32 = 22;
const ENODEV: i32 = 19;
const ENXIO: i32 = 6;
const EPERM: i32 = 1;
const EPROTONOSUPPORT: i32 = 93;
const EAFNOSUPPORT: i32 = 97;
const ENETDOWN: i32 = 100;
const ENOBUFS: i32 = 105;

/// A raw socket on one interface.
#[derive(Debug)]
pub struct SocketCan {
    label: String,
    socket: CanFdSocket,
    waiting: Option<Received>,
    ignored: u64,
}

impl SocketCan {
    /// Opens an interface that exists and is up.
    ///
    /// # Errors
    /// One line that says what to do: no CAN support in the kernel, no such interface, …
    pub fn open(interface: &str) -> Result<Self, BusError> {
        let label = format!("can:{interface}");
        let opened = CanFdSocket::open(interface)
            .and_then(|socket| socket.set_nonblocking(true).map(|()| socket));
        match opened {
            Ok(socket) => Ok(Self {
                label,
                socket,
                waiting: None,
                ignored: 0,
            }),
            Err(error) => Err(BusError::Open {
                bus: label,
                reason: explain(&error, interface),
            }),
        }
    }

    /// Remote and error frames received so far; they are not handed on.
    #[must_use]
    pub const fn ignored(&self) -> u64 {
        self.ignored
    }

    fn error(&self, source: io::Error) -> BusError {
        let bus = self.label.clone();
        match source.raw_os_error() {
            Some(ENOBUFS) => BusError::Full { bus },
            Some(ENETDOWN | ENODEV | ENXIO) => BusError::Lost {
                bus,
                reason: "the interface is down or gone".into(),
            },
            _ if source.kind() == io::ErrorKind::WouldBlock => BusError::Full { bus },
            _ => BusError::Io { bus, source },
        }
    }

    /// A data frame is kept, anything else counted.
    fn take(&mut self, frame: CanAnyFrame) -> Option<Received> {
        let taken = from_socketcan(frame).map(|frame| Received { frame, at: now() });
        if taken.is_none() {
            self.ignored += 1;
        }
        taken
    }
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
        let Some(any) = to_socketcan(frame) else {
            return Err(self.error(io::Error::new(
                io::ErrorKind::InvalidInput,
                "the identifier is out of range",
            )));
        };
        self.socket
            .write_frame(&any)
            .map_err(|error| match error.raw_os_error() {
                Some(EINVAL) if frame.is_fd() => BusError::FdUnsupported {
                    bus: self.label.clone(),
                },
                _ => self.error(error),
            })
    }

    fn receive(&mut self) -> Result<Option<Received>, BusError> {
        if let Some(waiting) = self.waiting.take() {
            return Ok(Some(waiting));
        }
        loop {
            match self.socket.read_frame() {
                Ok(frame) => {
                    if let Some(received) = self.take(frame) {
                        return Ok(Some(received));
                    }
                }
                Err(error) if error.should_retry() => return Ok(None),
                Err(error) => return Err(self.error(error)),
            }
        }
    }

    fn wait(&mut self, deadline: Micros) -> Result<(), BusError> {
        while self.waiting.is_none() {
            let left = until(deadline);
            if left.is_zero() {
                break;
            }
            match self.socket.read_frame_timeout(left) {
                Ok(frame) => self.waiting = self.take(frame),
                Err(error) if error.should_retry() => {}
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
        let error = SocketCan::open("mrroc-none0").unwrap_err().to_string();
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
        let (Ok(mut a), Ok(mut b)) = (SocketCan::open("vcan0"), SocketCan::open("vcan0")) else {
            return;
        };
        let frame = Frame::classic(Id::Extended(0x0123_4567), &[1, 2, 3]).unwrap();
        a.send(&frame).unwrap();
        b.wait(now() + Micros::from_millis(1000)).unwrap();
        assert_eq!(b.receive().unwrap().map(|r| r.frame), Some(frame));
        assert_eq!(a.receive().unwrap(), None);
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
