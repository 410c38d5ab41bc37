//! Reading what people write: bounded text files, and one shape for everything wrong with them.
//!
//! An error in a file always reads `path:line:column: error: what (expected …, got …)`, on one
//! line, whatever bytes the file contains.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::fmt;
use std::io::Read;
use std::path::{Path, PathBuf};

/// The largest task, cell or trajectory file, bytes.
pub const MAX_BYTES: u64 = 1 << 20;

/// The longest line of a trajectory file, bytes.
pub const MAX_LINE_BYTES: usize = 4096;

/// The kinds of mistakes in a file, for callers that distinguish them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Problem {
    /// Not the syntax of the format, a duplicate key included.
    Syntax,
    /// A key the format does not know.
    UnknownKey,
    /// A keyword or name that is not one of the known ones.
    UnknownName,
    /// Something required is absent.
    Missing,
    /// A value of another type, or not a number.
    WrongType,
    /// NaN or infinite.
    NotFinite,
    /// A number outside its range.
    OutOfRange,
    /// Too few or too many values.
    WrongCount,
    /// The file goes on after its end.
    Trailing,
    /// Two statements that exclude each other.
    Conflict,
    /// A line, a name or the file is too long.
    TooLong,
    /// A file it names cannot be read.
    Unreadable,
}

/// A mistake in a text file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DataError {
    /// The file, if the text came from one.
    pub path: Option<PathBuf>,
    /// Line from 1.
    pub line: u32,
    /// Column from 1, in characters.
    pub column: u32,
    /// The kind of mistake.
    pub problem: Problem,
    /// What is wrong.
    pub what: String,
    /// What was expected.
    pub expected: String,
    /// What was found.
    pub got: String,
}

impl DataError {
    /// A mistake at a line and column of a text.
    pub(crate) fn at(
        (line, column): (u32, u32),
        problem: Problem,
        what: impl Into<String>,
        expected: impl Into<String>,
        got: impl Into<String>,
    ) -> Self {
        Self {
            path: None,
            line,
            column,
            problem,
            what: what.into(),
            expected: expected.into(),
            got: got.into(),
        }
    }

    /// The same error, said of a file.
    #[must_use]
    pub fn in_file(mut self, path: &Path) -> Self {
        self.path.get_or_insert_with(|| path.to_path_buf());
        self
    }
}

impl fmt::Display for DataError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(path) = &self.path {
            write!(f, "{}:", ShownPath(path))?;
        }
        write!(
            f,
            "{}:{}: error: {} (expected {}, got {})",
            self.line, self.column, self.what, self.expected, self.got
        )
    }
}

impl std::error::Error for DataError {}

/// A file that could not be read as text at all.
#[derive(Debug)]
pub enum InputError {
    /// There is no such file.
    Absent(PathBuf),
    /// A directory, a device or a pipe.
    NotAFile(PathBuf),
    /// The system refuses access.
    Refused(PathBuf),
    /// Longer than so many bytes.
    TooLarge(PathBuf, u64),
    /// Not UTF-8; the offset of the first wrong byte.
    NotText(PathBuf, usize),
    /// Reading failed.
    Io(PathBuf, std::io::Error),
}

impl fmt::Display for InputError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Absent(path) => write!(f, "{}: error: no such file", ShownPath(path)),
            Self::NotAFile(path) => write!(
                f,
                "{}: error: not a file (expected a regular file, got a directory or device)",
                ShownPath(path)
            ),
            Self::Refused(path) => write!(f, "{}: error: access refused", ShownPath(path)),
            Self::TooLarge(path, most) => write!(
                f,
                "{}: error: file too large (expected at most {most} bytes, got more)",
                ShownPath(path)
            ),
            Self::NotText(path, offset) => write!(
                f,
                "{}: error: not a text file (expected UTF-8, got another byte at offset {offset})",
                ShownPath(path)
            ),
            Self::Io(path, error) => write!(f, "{}: error: {error}", ShownPath(path)),
        }
    }
}

impl std::error::Error for InputError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::Io(_, error) => Some(error),
            _ => None,
        }
    }
}

/// Why a task, a cell or a trajectory could not be loaded.
#[derive(Debug, thiserror::Error)]
pub enum LoadError {
    /// The file could not be read.
    #[error(transparent)]
    Input(#[from] InputError),
    /// The file is wrong.
    #[error(transparent)]
    Data(#[from] DataError),
}

/// Where files come from: the disk, or texts that were kept. What was read is remembered, so that a record of
/// a run can hold everything that it was made of.
#[derive(Debug, Default)]
pub struct Files {
    kept: Option<BTreeMap<PathBuf, String>>,
    read: RefCell<BTreeMap<PathBuf, String>>,
}

impl Files {
    /// Those of the disk.
    #[must_use]
    pub fn on_disk() -> Self {
        Self::default()
    }

    /// These texts, by their paths, and no others.
    #[must_use]
    pub fn kept(texts: BTreeMap<PathBuf, String>) -> Self {
        Self {
            kept: Some(texts),
            read: RefCell::default(),
        }
    }

    /// What was read so far, by its path.
    #[must_use]
    pub fn into_read(self) -> BTreeMap<PathBuf, String> {
        self.read.into_inner()
    }

    /// Reads a text file of at most [`MAX_BYTES`].
    ///
    /// # Errors
    /// As [`Self::read_up_to`].
    pub fn read(&self, path: &Path) -> Result<String, InputError> {
        self.read_up_to(path, MAX_BYTES)
    }

    /// Reads a text file of at most so many bytes; a byte order mark is dropped.
    ///
    /// # Errors
    /// The file is absent, not regular (a pipe is never waited for), refused, too large or not UTF-8.
    pub fn read_up_to(&self, path: &Path, most: u64) -> Result<String, InputError> {
        let text = match &self.kept {
            None => from_disk(path, most)?,
            Some(texts) => {
                let text = texts.get(path).cloned();
                text.ok_or_else(|| InputError::Absent(path.to_path_buf()))?
            }
        };
        self.read
            .borrow_mut()
            .insert(path.to_path_buf(), text.clone());
        Ok(text)
    }
}

fn from_disk(path: &Path, most: u64) -> Result<String, InputError> {
    let io = |error: std::io::Error| match error.kind() {
        std::io::ErrorKind::NotFound => InputError::Absent(path.to_path_buf()),
        std::io::ErrorKind::PermissionDenied => InputError::Refused(path.to_path_buf()),
        _ => InputError::Io(path.to_path_buf(), error),
    };
    if !std::fs::metadata(path).map_err(io)?.is_file() {
        return Err(InputError::NotAFile(path.to_path_buf()));
    }
    let mut bytes = Vec::new();
    let file = std::fs::File::open(path).map_err(io)?;
    file.take(most.saturating_add(1))
        .read_to_end(&mut bytes)
        .map_err(io)?;
    if bytes.len() as u64 > most {
        return Err(InputError::TooLarge(path.to_path_buf(), most));
    }
    let text = String::from_utf8(bytes).map_err(|error| {
        InputError::NotText(path.to_path_buf(), error.utf8_error().valid_up_to())
    })?;
    Ok(match text.strip_prefix('\u{feff}') {
        Some(rest) => rest.to_owned(),
        None => text,
    })
}

/// What a file says, fit for a message: quoted, control characters escaped, cut after 40.
#[must_use]
pub fn shown(text: &str) -> String {
    let mut out = String::from("`");
    let mut characters = text.chars();
    for c in characters.by_ref().take(40) {
        out.extend(c.escape_debug());
    }
    out.push_str(if characters.next().is_some() {
        "…`"
    } else {
        "`"
    });
    out
}

/// A path without control characters.
struct ShownPath<'a>(&'a Path);

impl fmt::Display for ShownPath<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for c in self.0.to_string_lossy().chars() {
            if c.is_control() {
                write!(f, "{}", c.escape_default())?;
            } else {
                write!(f, "{c}")?;
            }
        }
        Ok(())
    }
}

/// Line and column (from 1, in characters) of a byte offset.
#[must_use]
pub fn position(text: &str, offset: usize) -> (u32, u32) {
    let mut end = offset.min(text.len());
    while !text.is_char_boundary(end) {
        end -= 1;
    }
    let before = text.get(..end).unwrap_or_default();
    let line = before.matches('\n').count() + 1;
    let column = before
        .rsplit('\n')
        .next()
        .unwrap_or_default()
        .chars()
        .count()
        + 1;
    (
        u32::try_from(line).unwrap_or(u32::MAX),
        u32::try_from(column).unwrap_or(u32::MAX),
    )
}

#[cfg(test)]
mod test {
    use super::*;

    #[test]
    fn positions_count_characters() {
        let text = "ab\nżółw = 1\n";
        assert_eq!(position(text, 0), (1, 1));
        assert_eq!(position(text, 3), (2, 1));
        assert_eq!(position(text, text.find('=').unwrap()), (2, 6));
        assert_eq!(position(text, 999), (3, 1));
    }

    #[test]
    fn what_a_file_says_stays_on_one_line() {
        assert_eq!(shown("a\nb\u{1b}[31m"), "`a\\nb\\u{1b}[31m`");
        assert!(shown(&"x".repeat(1000)).chars().count() < 45);
    }

    #[test]
    fn devices_directories_and_absent_files_are_told_apart() {
        let directory = std::env::temp_dir();
        assert!(matches!(
            Files::on_disk().read(&directory),
            Err(InputError::NotAFile(_))
        ));
        assert!(matches!(
            Files::on_disk().read(&directory.join("mrroc-no-such-file")),
            Err(InputError::Absent(_))
        ));
        #[cfg(unix)]
        assert!(matches!(
            Files::on_disk().read(Path::new("/dev/zero")),
            Err(InputError::NotAFile(_))
        ));
    }

    #[test]
    fn what_was_read_can_be_read_again_without_the_disk_and_nothing_else() {
        let path = std::env::temp_dir().join(format!("mrroc-kept-{}", std::process::id()));
        std::fs::write(&path, "text").unwrap();
        let files = Files::on_disk();
        assert_eq!(files.read(&path).unwrap(), "text");
        std::fs::remove_file(&path).unwrap();
        let kept = Files::kept(files.into_read());
        assert_eq!(kept.read(&path).unwrap(), "text");
        assert!(matches!(
            kept.read(&std::env::temp_dir()),
            Err(InputError::Absent(_))
        ));
        assert_eq!(kept.into_read().len(), 1);
    }

    #[test]
    fn the_size_limit_is_exact() {
        let path = std::env::temp_dir().join(format!("mrroc-size-{}", std::process::id()));
        std::fs::write(&path, vec![b'x'; 1 << 20]).unwrap();
        assert_eq!(Files::on_disk().read(&path).unwrap().len(), 1 << 20);
        std::fs::write(&path, vec![b'x'; (1 << 20) + 1]).unwrap();
        assert!(matches!(
            Files::on_disk().read(&path),
            Err(InputError::TooLarge(_, MAX_BYTES))
        ));
        std::fs::write(&path, b"\xef\xbb\xbfa\xff").unwrap();
        assert!(matches!(
            Files::on_disk().read(&path),
            Err(InputError::NotText(_, 4))
        ));
        std::fs::write(&path, b"\xef\xbb\xbfab").unwrap();
        assert_eq!(Files::on_disk().read(&path).unwrap(), "ab");
        std::fs::remove_file(&path).unwrap();
    }
}
