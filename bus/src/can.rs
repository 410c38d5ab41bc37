//! A CAN interface of this system, whatever this system is.

use crate::{Bus, BusError};
use protocol::transfer::Mtu;

/// Which frames a participant of an interface takes. The others do not wake it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Hears<'a> {
    /// All.
    All,
    /// Those of 29 bits: MP and nodes.
    Extended,
    /// Those of 11 bits: drives, whose node ids may change (CiA 305).
    Standard,
    /// Those of 29 bits, and those of 11 bits whose last seven are one of these, a `CANopen` node id or 0
    /// for all nodes; at most [`MAX_IDS`].
    Node(&'a [u8]),
}

/// Node ids that can be listened to at once; with more, everything is heard.
pub const MAX_IDS: usize = 64;

/// Opens a CAN interface that exists and is up, and says how long its frames may be: everybody on
/// the interface goes by that.
///
/// # Errors
/// One line that says what to do: no such interface, no CAN in this system, …
#[cfg(target_os = "linux")]
pub fn open_can(interface: &str, hears: Hears<'_>) -> Result<(Box<dyn Bus + Send>, Mtu), BusError> {
    let bus = crate::socketcan::SocketCan::open(interface, hears)?;
    Ok((Box::new(bus), linux::mtu(interface)))
}

/// Fails: only Linux has CAN interfaces.
///
/// # Errors
/// Always, in one line that says so.
#[cfg(not(target_os = "linux"))]
pub fn open_can(interface: &str, _: Hears<'_>) -> Result<(Box<dyn Bus + Send>, Mtu), BusError> {
    Err(BusError::Open {
        bus: format!("can:{interface}"),
        reason: "only Linux has CAN interfaces (SocketCAN); use --bus hub".into(),
    })
}

#[cfg(target_os = "linux")]
mod linux {
    use protocol::transfer::Mtu;
    use std::path::Path;

    /// Bytes of an FD frame as the kernel keeps it (`CANFD_MTU` of linux/can.h); 16 of a classical
    /// one.
    const CANFD_MTU: u32 = 72;

    /// How long the frames of an interface may be.
    pub(super) fn mtu(interface: &str) -> Mtu {
        told_in(Path::new("/sys/class/net"), interface)
    }

    /// The same, from the folder in which the kernel tells it. What cannot be read may not carry FD.
    fn told_in(folder: &Path, interface: &str) -> Mtu {
        let unit = std::fs::read_to_string(folder.join(interface).join("mtu"));
        let fd =
            unit.is_ok_and(|text| text.trim().parse().is_ok_and(|unit: u32| unit >= CANFD_MTU));
        if fd { Mtu::Fd } else { Mtu::Classic }
    }

    #[cfg(test)]
    mod tests {
        use super::*;

        #[test]
        fn an_interface_carries_fd_if_the_kernel_says_so() {
            let folder = std::env::temp_dir().join(format!("mrroc-net-{}", std::process::id()));
            for (interface, unit, mtu) in [
                ("can0", "16\n", Mtu::Classic),
                ("can1", "71\n", Mtu::Classic),
                ("can2", "72\n", Mtu::Fd),
                ("can3", "2060\n", Mtu::Fd), // CAN XL
                ("can4", "-72\n", Mtu::Classic),
                ("can5", "", Mtu::Classic),
                ("can6", "many\n", Mtu::Classic),
            ] {
                std::fs::create_dir_all(folder.join(interface)).unwrap();
                std::fs::write(folder.join(interface).join("mtu"), unit).unwrap();
                assert_eq!(told_in(&folder, interface), mtu, "{unit:?}");
            }
            assert_eq!(told_in(&folder, "none"), Mtu::Classic);
            std::fs::remove_dir_all(folder).unwrap();
        }
    }
}
