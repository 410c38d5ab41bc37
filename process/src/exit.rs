//! Exit codes, by name.
//!
//! | code | meaning |
//! |---:|---|
//! | 0 | done |
//! | 10 | a fault ended the motion; the robots stopped and the fault is latched |
//! | 11 | a target was refused or cannot be reached; nothing moved for it |
//! | 12 | stopped by the operator |
//! | 13 | a replay differs from its record |
//! | 64 | wrong use of the command line |
//! | 65 | a file has wrong contents |
//! | 66 | a file cannot be opened for reading |
//! | 69 | a node does not answer, or a bus cannot be opened or has gone |
//! | 70 | an error of this program |
//! | 73 | a file cannot be created |
//! | 74 | reading, writing or a bus failed on the way |
//! | 75 | another MP holds the command lease: try again later |
//! | 76 | a node does not speak this version of the protocol |
//! | 77 | the system refuses access |
//! | 78 | the robots that answer are not those of the cell |
//!
//! 64 to 78 are those of BSD `sysexits.h`; 10 to 13 are ours.

/// Done.
pub const OK: u8 = 0;
/// A fault ended the motion.
pub const FAULT: u8 = 10;
/// A target was refused or cannot be reached.
pub const REFUSED: u8 = 11;
/// Stopped by the operator.
pub const STOPPED: u8 = 12;
/// A replay differs from its record.
pub const DIFFERENT: u8 = 13;
/// Wrong use of the command line.
pub const USAGE: u8 = 64;
/// A file has wrong contents.
pub const DATA: u8 = 65;
/// A file cannot be opened for reading.
pub const NO_INPUT: u8 = 66;
/// A node or a bus is not there.
pub const UNAVAILABLE: u8 = 69;
/// An error of this program.
pub const INTERNAL: u8 = 70;
/// A file cannot be created.
pub const CANNOT_CREATE: u8 = 73;
/// Input or output failed.
pub const IO: u8 = 74;
/// The lease is held.
pub const TEMPORARY: u8 = 75;
/// Another protocol.
pub const PROTOCOL: u8 = 76;
/// Access refused.
pub const PERMISSION: u8 = 77;
/// Another cell.
pub const CONFIG: u8 = 78;

/// Every code and what it means.
pub const ALL: [(u8, &str); 16] = [
    (OK, "done"),
    (FAULT, "a fault ended the motion"),
    (REFUSED, "a target was refused or cannot be reached"),
    (STOPPED, "stopped by the operator"),
    (DIFFERENT, "a replay differs from its record"),
    (USAGE, "wrong use of the command line"),
    (DATA, "a file has wrong contents"),
    (NO_INPUT, "a file cannot be opened for reading"),
    (UNAVAILABLE, "a node or a bus is not there"),
    (INTERNAL, "an error of this program"),
    (CANNOT_CREATE, "a file cannot be created"),
    (IO, "reading, writing or a bus failed on the way"),
    (TEMPORARY, "another MP holds the command lease"),
    (PROTOCOL, "a node speaks another protocol"),
    (PERMISSION, "the system refuses access"),
    (CONFIG, "the robots that answer are not those of the cell"),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_code_is_documented() {
        let rows = include_str!("exit.rs").lines();
        let documented: Vec<u8> = rows
            .filter_map(|line| line.strip_prefix("//! | ")?.split(' ').next()?.parse().ok())
            .collect();
        assert_eq!(documented, ALL.map(|(code, _)| code));
    }
}
