//! Why an SDO transfer ended early.

macro_rules! aborts {
    ($( $(#[doc = $doc:literal])+ $name:ident = $code:literal; )+) => {
        /// Why an SDO transfer ended early; the code is the one on the wire.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Abort {
            $( $(#[doc = $doc])+ $name, )+
            /// A code this list does not name.
            Other(u32),
        }

        impl Abort {
            /// Every named abort.
            pub const ALL: &[Self] = &[$( Self::$name ),+];

            /// The code on the wire.
            #[must_use]
            pub const fn code(self) -> u32 {
                match self { $( Self::$name => $code, )+ Self::Other(code) => code }
            }

            /// The abort of a code.
            #[must_use]
            pub const fn from_code(code: u32) -> Self {
                match code { $( $code => Self::$name, )+ other => Self::Other(other) }
            }

            /// What it means, in one line.
            #[must_use]
            pub const fn text(self) -> &'static str {
                match self {
                    $( Self::$name => aborts!(@first $($doc),+), )+
                    Self::Other(_) => "unknown abort code",
                }
            }
        }
    };
    (@first $first:literal $(, $rest:literal)*) => { $first.trim_ascii() };
}

aborts! {
    /// the toggle bit did not alternate
    Toggle = 0x0503_0000;
    /// the other side did not answer in time
    Timeout = 0x0504_0000;
    /// unknown command specifier
    Command = 0x0504_0001;
    /// invalid block size
    BlockSize = 0x0504_0002;
    /// invalid sequence number
    Sequence = 0x0504_0003;
    /// wrong CRC
    Crc = 0x0504_0004;
    /// out of memory
    Memory = 0x0504_0005;
    /// access not supported
    Access = 0x0601_0000;
    /// the object can only be written
    WriteOnly = 0x0601_0001;
    /// the object can only be read
    ReadOnly = 0x0601_0002;
    /// no such object
    NoObject = 0x0602_0000;
    /// the object cannot be mapped into a PDO
    NotMappable = 0x0604_0041;
    /// the mapped objects are longer than a PDO
    PdoLength = 0x0604_0042;
    /// incompatible parameter
    Incompatible = 0x0604_0043;
    /// internal incompatibility in the device
    Internal = 0x0604_0047;
    /// hardware error
    Hardware = 0x0606_0000;
    /// wrong length
    Length = 0x0607_0010;
    /// value too long
    TooLong = 0x0607_0012;
    /// value too short
    TooShort = 0x0607_0013;
    /// no such sub-index
    NoSubIndex = 0x0609_0011;
    /// value out of range
    Range = 0x0609_0030;
    /// value too high
    TooHigh = 0x0609_0031;
    /// value too low
    TooLow = 0x0609_0032;
    /// the maximum is below the minimum
    MaximumBelowMinimum = 0x0609_0036;
    /// a resource is not available
    Resource = 0x060A_0023;
    /// general error
    General = 0x0800_0000;
    /// the data cannot be stored
    Storage = 0x0800_0020;
    /// the data cannot be stored because of local control
    LocalControl = 0x0800_0021;
    /// not in the present device state
    DeviceState = 0x0800_0022;
    /// there is no object dictionary
    NoDictionary = 0x0800_0023;
    /// no data are available
    NoData = 0x0800_0024;
}
