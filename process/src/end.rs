//! Why a process ends.

use crate::exit;
use std::io::{self, Write};
use std::process::ExitCode;

/// Why a process ends, other than as it should.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct End {
    /// The exit code: one of [`exit`].
    pub code: u8,
    /// One line for stderr, or what was asked for (code 0) for stdout.
    pub text: String,
}

impl End {
    /// An error.
    #[must_use]
    pub fn new(code: u8, text: impl Into<String>) -> Self {
        let text = text.into();
        Self { code, text }
    }

    /// Wrong use of the command line.
    #[must_use]
    pub fn usage(text: impl Into<String>) -> Self {
        Self::new(exit::USAGE, text)
    }

    /// Tells it to whoever started the process, in the name of `program`.
    #[must_use]
    pub fn tell(&self, program: &str) -> ExitCode {
        // nobody may be listening any more: nothing can be done about that
        let _ = self.write(program, &mut io::stdout(), &mut io::stderr());
        ExitCode::from(self.code)
    }

    fn write(&self, program: &str, out: &mut impl Write, err: &mut impl Write) -> io::Result<()> {
        if self.code == exit::OK {
            writeln!(out, "{}", self.text.trim_end())
        } else {
            writeln!(err, "{program}: {}", self.text)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(end: &End) -> [String; 2] {
        let (mut out, mut err) = (Vec::new(), Vec::new());
        end.write("mrroc-node", &mut out, &mut err).unwrap();
        [out, err].map(|bytes| String::from_utf8(bytes).unwrap())
    }

    #[test]
    fn an_error_is_a_line_on_stderr_with_the_name_of_the_program() {
        let end = End::new(exit::IO, "can:can0: connection lost");
        assert_eq!(told(&end), ["", "mrroc-node: can:can0: connection lost\n"]);
        assert_eq!(End::usage("x").code, 64);
    }

    #[test]
    fn what_was_asked_for_goes_to_stdout_as_it_is() {
        let end = End::new(exit::OK, "Usage: mrroc-node\n\n");
        assert_eq!(told(&end), ["Usage: mrroc-node\n", ""]);
    }
}
