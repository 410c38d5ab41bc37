//! What clap says, as an end: help and version as they are, a mistake in one line like every other.

use crate::{End, exit};

impl From<&clap::Error> for End {
    fn from(error: &clap::Error) -> Self {
        let text = error.to_string();
        if error.use_stderr() {
            Self::usage(one_line(&text))
        } else {
            Self::new(exit::OK, text)
        }
    }
}

impl From<clap::Error> for End {
    fn from(error: clap::Error) -> Self {
        Self::from(&error)
    }
}

/// The message without its label, and without usage and hints that follow it.
fn one_line(text: &str) -> String {
    let text = text.strip_prefix("error: ").unwrap_or(text);
    let message = text.split("\n\nUsage:").next().unwrap_or(text);
    let message = message.split("\n\nFor more").next().unwrap_or(message);
    let words: Vec<&str> = message.split_whitespace().collect();
    words.join(" ") + "; --help tells more"
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::{Arg, ArgAction, Command, value_parser};

    fn end(arguments: &[&str]) -> End {
        let command = Command::new("job")
            .version("1.2.3")
            .arg(Arg::new("robots").required(true).action(ArgAction::Append))
            .arg(
                Arg::new("speed")
                    .long("speed")
                    .value_parser(value_parser!(u8)),
            )
            .arg(Arg::new("law").long("law").value_parser(["csp", "cst"]));
        let error = command.try_get_matches_from(arguments).unwrap_err();
        End::from(error)
    }

    #[test]
    fn a_mistake_is_one_line() {
        for (arguments, line) in [
            (
                &["job"][..],
                "the following required arguments were not provided: <robots>...; --help tells more",
            ),
            (
                &["job", "a", "--speed=x"],
                "invalid value 'x' for '--speed <speed>': invalid digit found in string; --help tells more",
            ),
            (
                &["job", "a", "--law=cspp"],
                "invalid value 'cspp' for '--law <law>' [possible values: csp, cst] tip: a similar value \
                 exists: 'csp'; --help tells more",
            ),
        ] {
            assert_eq!(end(arguments), End::usage(line));
        }
    }

    #[test]
    fn help_and_version_are_no_mistakes() {
        assert_eq!(end(&["job", "--version"]), End::new(0, "job 1.2.3\n"));
        let help = end(&["job", "--help"]);
        assert_eq!(help.code, exit::OK);
        assert!(help.text.contains("\n\nOptions:\n"), "{}", help.text);
    }
}
