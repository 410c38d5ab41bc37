//! Exit codes, and errors of one line.
//!
//! The numbers above 63 are those of BSD `sysexits.h`, as in every command of this project.

use std::io::Write as _;
use std::process::ExitCode;

/// Wrong use of the command line.
pub(crate) const USAGE: u8 = 64;
/// A bus is not there.
pub(crate) const UNAVAILABLE: u8 = 69;
/// An error of this program.
pub(crate) const INTERNAL: u8 = 70;
/// A bus failed on the way.
pub(crate) const IO: u8 = 74;

/// For `--help`.
pub(crate) const HELP: &str = "\
Exit codes:
   0  done: ended by Ctrl-C or SIGTERM, at rest, torque off
  64  wrong use of the command line (unknown robot, bad bus, bad value)
  69  the bus cannot be opened: no hub, no interface, no CAN in this system
  70  an error of this program
  74  the bus failed on the way";

/// Why the process ends, other than as it should.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct End {
    /// The exit code.
    pub(crate) code: u8,
    /// One line for stderr, or the text of `--help` for stdout (code 0).
    pub(crate) text: String,
}

impl End {
    /// An error.
    pub(crate) fn new(code: u8, text: impl Into<String>) -> Self {
        let text = text.into();
        Self { code, text }
    }

    /// Tells it to whoever started the process.
    pub(crate) fn tell(&self) -> ExitCode {
        // nobody may be listening any more: nothing can be done about that
        if self.code == 0 {
            let _ = writeln!(std::io::stdout(), "{}", self.text.trim_end());
        } else {
            let _ = writeln!(std::io::stderr(), "mrroc-node: error: {}", self.text);
        }
        ExitCode::from(self.code)
    }
}
