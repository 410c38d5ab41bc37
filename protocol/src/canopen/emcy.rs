//! Emergency messages: error code, error register, five bytes of the maker.

mod history;

pub use history::{History, Producer};

use super::node::{Function, NodeId, frame, standard};
use crate::frame::Frame;

/// An emergency error code (CiA 301 and CiA 402, object 603F).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct ErrorCode(pub u16);

impl ErrorCode {
    /// Error reset or no error.
    pub const NONE: Self = Self(0x0000);
    /// Continuous over-current on the output side of the drive.
    pub const OVER_CURRENT: Self = Self(0x2310);
    /// DC-link over-voltage.
    pub const OVER_VOLTAGE: Self = Self(0x3210);
    /// DC-link under-voltage.
    pub const UNDER_VOLTAGE: Self = Self(0x3220);
    /// Drive temperature too high.
    pub const OVER_TEMPERATURE: Self = Self(0x4310);
    /// Hardware of the drive (power stage).
    pub const HARDWARE: Self = Self(0x5400);
    /// Incremental encoder 1.
    pub const ENCODER: Self = Self(0x7305);
    /// Heartbeat of a watched device lost or never heard.
    pub const HEARTBEAT: Self = Self(0x8130);
    /// The CAN controller is error-passive.
    pub const CAN_PASSIVE: Self = Self(0x8120);
    /// The CAN controller is back from bus-off.
    pub const BUS_OFF_OVER: Self = Self(0x8140);
    /// A received PDO was shorter than its mapping.
    pub const PDO_LENGTH: Self = Self(0x8210);
    /// A SYNC message has another length than object 1019 says.
    pub const SYNC_LENGTH: Self = Self(0x8240);
    /// A received PDO did not come in time.
    pub const RPDO_TIMEOUT: Self = Self(0x8250);
    /// Following error out of its window.
    pub const FOLLOWING_ERROR: Self = Self(0x8611);
    /// Sync controller: SYNC did not come in time.
    pub const SYNC_LOST: Self = Self(0x8700);

    /// Every code the simulated drive uses, with one line each.
    pub const USED: [(Self, &'static str); 15] = [
        (Self::NONE, "no error"),
        (Self::OVER_CURRENT, "over-current at the output"),
        (Self::OVER_VOLTAGE, "DC-link over-voltage"),
        (Self::UNDER_VOLTAGE, "DC-link under-voltage"),
        (Self::OVER_TEMPERATURE, "drive too hot"),
        (Self::HARDWARE, "power stage"),
        (Self::ENCODER, "incremental encoder"),
        (Self::CAN_PASSIVE, "CAN controller error-passive"),
        (Self::HEARTBEAT, "heartbeat lost or never heard"),
        (Self::BUS_OFF_OVER, "back from bus-off"),
        (Self::PDO_LENGTH, "PDO shorter than its mapping"),
        (Self::SYNC_LENGTH, "SYNC with another length"),
        (Self::RPDO_TIMEOUT, "set-point missing"),
        (Self::FOLLOWING_ERROR, "following error"),
        (Self::SYNC_LOST, "SYNC missing"),
    ];

    /// The bits of the error register that belong to the code's class.
    #[must_use]
    pub const fn register(self) -> ErrorRegister {
        ErrorRegister(match self.0 >> 8 {
            0x00 => 0,
            0x20..=0x2F => ErrorRegister::GENERIC | ErrorRegister::CURRENT,
            0x30..=0x3F => ErrorRegister::GENERIC | ErrorRegister::VOLTAGE,
            0x40..=0x4F => ErrorRegister::GENERIC | ErrorRegister::TEMPERATURE,
            0x81 | 0x82 => ErrorRegister::GENERIC | ErrorRegister::COMMUNICATION,
            0x83..=0x87 => ErrorRegister::GENERIC | ErrorRegister::PROFILE,
            _ => ErrorRegister::GENERIC,
        })
    }
}

/// The error register, object 1001.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ErrorRegister(pub u8);

impl ErrorRegister {
    /// Some error is present.
    pub const GENERIC: u8 = 1 << 0;
    /// Current.
    pub const CURRENT: u8 = 1 << 1;
    /// Voltage.
    pub const VOLTAGE: u8 = 1 << 2;
    /// Temperature.
    pub const TEMPERATURE: u8 = 1 << 3;
    /// Communication.
    pub const COMMUNICATION: u8 = 1 << 4;
    /// Device profile.
    pub const PROFILE: u8 = 1 << 5;
}

/// One emergency message.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Emergency {
    /// What happened; [`ErrorCode::NONE`] tells that everything is well again.
    pub code: ErrorCode,
    /// The error register after it happened.
    pub register: ErrorRegister,
    /// Maker-specific detail.
    pub detail: [u8; 5],
}

impl Emergency {
    /// The frame, sent by `node` on its default identifier.
    #[must_use]
    pub fn frame(self, node: NodeId) -> Frame {
        self.frame_on(node.cob(Function::Emergency))
    }

    /// The frame on identifier `cob` (object 1014).
    #[must_use]
    pub fn frame_on(self, cob: u16) -> Frame {
        let [low, high] = self.code.0.to_le_bytes();
        let [a, b, c, d, e] = self.detail;
        frame(cob, [low, high, self.register.0, a, b, c, d, e])
    }

    /// Reads an emergency message on a default identifier.
    #[must_use]
    pub fn decode(frame: &Frame) -> Option<(NodeId, Self)> {
        let node = standard(frame)?.checked_sub(Function::Emergency as u16)?;
        let node = NodeId::new(u8::try_from(node).ok()?)?;
        let [low, high, register, detail @ ..] = frame.data() else {
            return None;
        };
        let detail = <[u8; 5]>::try_from(detail).ok()?;
        let code = ErrorCode(u16::from_le_bytes([*low, *high]));
        let register = ErrorRegister(*register);
        Some((
            node,
            Self {
                code,
                register,
                detail,
            },
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::Id;

    #[test]
    fn golden_frame() {
        let node = NodeId::new(3).unwrap();
        let code = ErrorCode::FOLLOWING_ERROR;
        let emergency = Emergency {
            code,
            register: code.register(),
            detail: [1, 2, 3, 4, 5],
        };
        let frame = emergency.frame(node);
        assert_eq!(frame.id(), Id::Standard(0x083));
        assert_eq!(frame.data(), [0x11, 0x86, 0x21, 1, 2, 3, 4, 5]);
        assert_eq!(Emergency::decode(&frame), Some((node, emergency)));
    }

    #[test]
    fn sync_and_short_frames_are_no_emergencies() {
        assert_eq!(Emergency::decode(&frame(0x80, [0; 8])), None);
        assert_eq!(Emergency::decode(&frame(0x83, [0; 7])), None);
        assert_eq!(Emergency::decode(&frame(0x100, [0; 8])), None);
    }

    #[test]
    fn the_register_tells_the_class() {
        let bits = |code: ErrorCode| code.register().0;
        assert_eq!(bits(ErrorCode::NONE), 0);
        assert_eq!(bits(ErrorCode::OVER_CURRENT), 0b0000_0011);
        assert_eq!(bits(ErrorCode::UNDER_VOLTAGE), 0b0000_0101);
        assert_eq!(bits(ErrorCode::OVER_TEMPERATURE), 0b0000_1001);
        assert_eq!(bits(ErrorCode::HEARTBEAT), 0b0001_0001);
        assert_eq!(bits(ErrorCode::SYNC_LOST), 0b0010_0001);
        assert_eq!(bits(ErrorCode::HARDWARE), 0b0000_0001);
    }
}
