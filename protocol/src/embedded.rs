//! Classical frames for drivers that speak `embedded-can`.

use crate::frame::{Frame, Id};
use embedded_can::{ExtendedId, StandardId};

/// A frame that is classical and whose identifier is in range: what `embedded-can` can say.
///
/// ```
/// use embedded_can::Frame as _;
/// use protocol::embedded::Classic;
/// use protocol::frame::{Frame, Id};
/// let frame = Frame::classic(Id::Standard(0x80), &[1]).unwrap();
/// assert_eq!(Classic::try_from(frame).unwrap().data(), [1]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Classic {
    id: embedded_can::Id,
    frame: Frame,
}

/// The frame is a CAN FD frame, or its identifier is out of range.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotClassic;

impl core::fmt::Display for NotClassic {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("not a classical CAN frame")
    }
}
impl core::error::Error for NotClassic {}

impl TryFrom<Frame> for Classic {
    type Error = NotClassic;

    fn try_from(frame: Frame) -> Result<Self, NotClassic> {
        if frame.is_fd() {
            return Err(NotClassic);
        }
        let id = match frame.id() {
            Id::Standard(id) => StandardId::new(id).map(embedded_can::Id::Standard),
            Id::Extended(id) => ExtendedId::new(id).map(embedded_can::Id::Extended),
        };
        id.map(|id| Self { id, frame }).ok_or(NotClassic)
    }
}

impl From<Classic> for Frame {
    fn from(classic: Classic) -> Self {
        classic.frame
    }
}

impl embedded_can::Frame for Classic {
    fn new(id: impl Into<embedded_can::Id>, data: &[u8]) -> Option<Self> {
        let id = id.into();
        let ours = match id {
            embedded_can::Id::Standard(id) => Id::Standard(id.as_raw()),
            embedded_can::Id::Extended(id) => Id::Extended(id.as_raw()),
        };
        Frame::classic(ours, data).map(|frame| Self { id, frame })
    }

    /// Always `None`: this system uses no remote frames.
    fn new_remote(_: impl Into<embedded_can::Id>, _: usize) -> Option<Self> {
        None
    }

    fn is_extended(&self) -> bool {
        matches!(self.id, embedded_can::Id::Extended(_))
    }

    fn is_remote_frame(&self) -> bool {
        false
    }

    fn id(&self) -> embedded_can::Id {
        self.id
    }

    fn dlc(&self) -> usize {
        self.frame.data().len()
    }

    fn data(&self) -> &[u8] {
        self.frame.data()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use embedded_can::Frame as _;

    #[test]
    fn both_ways() {
        for id in [Id::Standard(0x7FF), Id::Extended(0x1FFF_FFFF)] {
            let frame = Frame::classic(id, &[1, 2, 3]).unwrap();
            let classic = Classic::try_from(frame).unwrap();
            assert_eq!(classic.is_extended(), matches!(id, Id::Extended(_)));
            assert_eq!((classic.dlc(), classic.data()), (3, &[1, 2, 3][..]));
            assert_eq!(Classic::new(classic.id(), classic.data()), Some(classic));
            assert_eq!(Frame::from(classic), frame);
        }
    }

    #[test]
    fn what_is_not_classical() {
        let fd = Frame::fd(Id::Standard(1), &[]).unwrap();
        assert_eq!(Classic::try_from(fd), Err(NotClassic));
        let out_of_range = Frame::classic(Id::Standard(0x800), &[]).unwrap();
        assert_eq!(Classic::try_from(out_of_range), Err(NotClassic));
        let id = StandardId::new(1).unwrap();
        assert_eq!(Classic::new(id, &[0; 9]), None);
        assert_eq!(Classic::new_remote(id, 0), None);
    }
}
