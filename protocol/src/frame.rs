//! One CAN or CAN FD data frame and its identifier.

/// A CAN identifier; the numeric order within a variant is the arbitration order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Id {
    /// 11 bits: CANopen, towards the drives.
    Standard(u16),
    /// 29 bits: Cyphal-compatible, between MP and nodes.
    Extended(u32),
}

impl Id {
    /// A number that orders identifiers as the wire arbitrates them: lower wins.
    ///
    /// A standard frame wins against an extended frame with the same first 11 bits
    /// (its RTR/IDE bits are dominant).
    #[must_use]
    pub const fn arbitration(self) -> u64 {
        match self {
            Self::Standard(id) => ((id as u64) & 0x7FF) << 19,
            Self::Extended(id) => {
                let id = id as u64 & 0x1FFF_FFFF;
                ((id >> 18) << 19) | (1 << 18) | (id & 0x3_FFFF)
            }
        }
    }
}

/// The longest payload: CAN FD.
pub const MAX_DATA: usize = 64;

/// A data frame; remote frames are not used by this system.
#[derive(Clone, Copy)]
pub struct Frame {
    id: Id,
    fd: bool,
    len: u8,
    data: [u8; MAX_DATA],
}

impl Frame {
    /// A classical frame; `None` if `data` is longer than 8 bytes.
    #[must_use]
    pub fn classic(id: Id, data: &[u8]) -> Option<Self> {
        if data.len() > 8 {
            None
        } else {
            Self::build(id, false, data)
        }
    }

    /// A CAN FD frame with bit-rate switch; `None` if the length is not a valid FD length
    /// (0–8, 12, 16, 20, 24, 32, 48, 64).
    #[must_use]
    pub fn fd(id: Id, data: &[u8]) -> Option<Self> {
        if fd_length(data.len()) == Some(data.len()) {
            Self::build(id, true, data)
        } else {
            None
        }
    }

    /// A classical frame of the first `len` of 8 bytes; `len` above 8 counts as 8.
    ///
    /// Unlike [`Self::classic`] it cannot fail: for protocols whose frames are short by construction.
    #[must_use]
    pub fn short(id: Id, bytes: [u8; 8], len: u8) -> Self {
        let mut data = [0; MAX_DATA];
        for (to, from) in data.iter_mut().zip(bytes) {
            *to = from;
        }
        let len = if len > 8 { 8 } else { len };
        Self {
            id,
            fd: false,
            len,
            data,
        }
    }

    fn build(id: Id, fd: bool, payload: &[u8]) -> Option<Self> {
        let mut data = [0; MAX_DATA];
        data.get_mut(..payload.len())?.copy_from_slice(payload);
        let len = u8::try_from(payload.len()).ok()?;
        Some(Self { id, fd, len, data })
    }

    /// The identifier.
    #[must_use]
    pub const fn id(&self) -> Id {
        self.id
    }

    /// Is this a CAN FD frame?
    #[must_use]
    pub const fn is_fd(&self) -> bool {
        self.fd
    }

    /// The payload.
    #[must_use]
    pub fn data(&self) -> &[u8] {
        self.data.get(..usize::from(self.len)).unwrap_or(&[])
    }
}

impl PartialEq for Frame {
    fn eq(&self, other: &Self) -> bool {
        self.id == other.id && self.fd == other.fd && self.data() == other.data()
    }
}
impl Eq for Frame {}

impl core::fmt::Debug for Frame {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(
            f,
            "{:X?}{}#{:02X?}",
            self.id,
            if self.fd { " FD" } else { "" },
            self.data()
        )
    }
}

/// The smallest valid CAN FD payload length that holds `len` bytes.
#[must_use]
pub const fn fd_length(len: usize) -> Option<usize> {
    match len {
        0..=8 => Some(len),
        9..=12 => Some(12),
        13..=16 => Some(16),
        17..=20 => Some(20),
        21..=24 => Some(24),
        25..=32 => Some(32),
        33..=48 => Some(48),
        49..=64 => Some(64),
        _ => None,
    }
}
