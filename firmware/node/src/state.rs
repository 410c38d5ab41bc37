//! What a node on a host keeps in files, where a microcontroller has flash and memory that survives a reset.
//!
//! ```text
//! DIR/ROBOT.starts       how often it was started, and whether the last process ended as it should
//! DIR/ROBOT.black-box    the record of the first fault
//! DIR/ROBOT.flash        512 KiB as an STM32G474 has them: log and both slots
//! ```
//! The images are kept, checked and chosen as on a microcontroller; the program that runs is always this one. Its
//! version, length and CRC are those of the image that was chosen.

use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash,
};
use firmware::maintenance::black_box::{self, BlackBox, Memory};
use firmware::maintenance::{Keeper, Start};
use firmware::node::FIRMWARE_VERSION;
use firmware::update::image::{self, CRC, HEADER};
use firmware::update::slots::Slots;
use firmware::update::stm32g474::{BANK, LAYOUT, PAGE, WRITE};
use firmware::update::{Updater, slots::LayoutError};
use process::{End, exit};
use protocol::maintenance::{ImageHeader, MaintenanceRefusal, ResetCause};
use protocol::schema::SCHEMA_HASH;
use robots::RobotKind;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Read as _, Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};

/// What images for this program are made for.
pub(crate) const TARGET: &str = "host";

/// The flash of a host: two banks.
const FLASH: usize = 2 * BANK as usize;

/// A name that is short enough: those of robots and targets are, which is tested.
fn name(text: &str) -> heapless::String<24> {
    heapless::String::try_from(text).unwrap_or_default()
}

/// Where files are kept, if anywhere.
#[derive(Debug)]
pub(crate) struct State {
    files: Option<Files>,
    pub(crate) boots: u32,
    pub(crate) cause: ResetCause,
}

#[derive(Debug)]
struct Files {
    folder: PathBuf,
    robot: RobotKind,
}

impl Files {
    fn path(&self, what: &str) -> PathBuf {
        self.folder.join(format!("{}.{what}", self.robot))
    }

    /// One start more, under way or ended.
    fn write_starts(&self, boots: u32, running: bool) -> Result<(), End> {
        let path = self.path("starts");
        let word = if running { "running" } else { "ended" };
        let written = replace(&path, format!("{boots} {word}\n").as_bytes());
        written.map_err(|error| cannot_create(&path, &error))
    }
}

fn cannot_create(path: &Path, error: &io::Error) -> End {
    let code = match error.kind() {
        io::ErrorKind::PermissionDenied => exit::PERMISSION,
        _ => exit::CANNOT_CREATE,
    };
    End::new(code, format!("{}: cannot write: {error}", path.display()))
}

fn wrong(path: &Path, what: &str) -> End {
    let path = path.display();
    End::new(
        exit::DATA,
        format!("{path}: {what}; remove it to begin anew"),
    )
}

/// Whole or not at all.
fn replace(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut part = path.as_os_str().to_os_string();
    part.push(".part");
    fs::write(&part, bytes)?;
    fs::rename(&part, path)
}

/// A file of at most so many bytes; `None` if there is none.
fn read(path: &Path, most: usize) -> Result<Option<Vec<u8>>, End> {
    let failed = |error: &io::Error| {
        End::new(
            exit::NO_INPUT,
            format!("{}: cannot read: {error}", path.display()),
        )
    };
    let file = match File::open(path) {
        Ok(file) => file,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(failed(&error)),
    };
    let mut bytes = Vec::new();
    let most = u64::try_from(most).unwrap_or(u64::MAX);
    file.take(most.saturating_add(1))
        .read_to_end(&mut bytes)
        .map_err(|error| failed(&error))?;
    Ok(Some(bytes))
}

impl State {
    /// The state of this robot's node in a folder, which is made if need be; without one nothing is kept.
    ///
    /// # Errors
    /// Files cannot be read or written, or are not of a node.
    pub(crate) fn open(folder: Option<&Path>, robot: RobotKind) -> Result<Self, End> {
        let Some(folder) = folder else {
            return Ok(Self {
                files: None,
                boots: 1,
                cause: ResetCause::Unknown,
            });
        };
        fs::create_dir_all(folder).map_err(|error| cannot_create(folder, &error))?;
        let files = Files {
            folder: folder.to_path_buf(),
            robot,
        };
        let path = files.path("starts");
        let (boots, cause) = match read(&path, 64)? {
            None => (1, ResetCause::PowerOn),
            Some(bytes) => {
                let text = String::from_utf8_lossy(&bytes);
                let (number, word) = text.trim().split_once(' ').unwrap_or_default();
                let number: u32 = number
                    .parse()
                    .map_err(|_| wrong(&path, "not a number of starts"))?;
                let cause = match word {
                    "running" => ResetCause::Vanished,
                    "ended" => ResetCause::Software,
                    _ => return Err(wrong(&path, "neither running nor ended")),
                };
                (number.saturating_add(1), cause)
            }
        };
        files.write_starts(boots, true)?;
        Ok(Self {
            files: Some(files),
            boots,
            cause,
        })
    }

    /// The process ends as it should.
    ///
    /// # Errors
    /// That cannot be written down.
    pub(crate) fn end(&self) -> Result<(), End> {
        match &self.files {
            Some(files) => files.write_starts(self.boots, false),
            None => Ok(()),
        }
    }

    /// Whoever answers for a node of so many axes.
    ///
    /// # Errors
    /// Files cannot be read or written, or are not of a node.
    pub(crate) fn keeper(&self, axes: usize) -> Result<Keeper<BoxFile, FileFlash>, End> {
        let start = Start {
            target: name(TARGET),
            cause: self.cause,
            boots: self.boots,
        };
        let mut memory = BoxFile {
            bytes: vec![0; black_box::bytes(axes)],
            path: None,
        };
        let mut updater = None;
        if let Some(files) = &self.files {
            let path = files.path("black-box");
            if let Some(found) = read(&path, memory.bytes.len())? {
                // of another length it is not of this node: then it is no record
                if found.len() == memory.bytes.len() {
                    memory.bytes = found;
                }
            }
            memory.path = Some(path);
            updater = Some(open_flash(&files.path("flash"), files.robot)?);
        }
        let black_box = BlackBox::open(memory, axes)
            .ok_or_else(|| End::new(exit::INTERNAL, "the black box has too little memory"))?;
        Ok(Keeper::new(start, black_box, updater))
    }
}

fn open_flash(path: &Path, robot: RobotKind) -> Result<Updater<FileFlash>, End> {
    let bytes = match read(path, FLASH)? {
        Some(bytes) if bytes.len() == FLASH => bytes,
        Some(_) => return Err(wrong(path, "not the flash of a node")),
        None => {
            let bytes = factory(robot);
            replace(path, &bytes).map_err(|error| cannot_create(path, &error))?;
            bytes
        }
    };
    let file = OpenOptions::new()
        .write(true)
        .open(path)
        .map_err(|error| cannot_create(path, &error))?;
    let internal = |error: LayoutError| End::new(exit::INTERNAL, error.to_string());
    let mut slots = Slots::new(FileFlash { file, bytes }, LAYOUT).map_err(internal)?;
    let choice = slots.start().map_err(|error: MaintenanceRefusal| {
        End::new(exit::IO, format!("{}: {error}", path.display()))
    })?;
    Updater::new(slots, choice).ok_or_else(|| wrong(path, "neither slot has a whole image"))
}

/// As it comes from the factory: this program in slot A, by its name.
fn factory(robot: RobotKind) -> Vec<u8> {
    let (major, minor, patch) = FIRMWARE_VERSION;
    let program = format!("mrroc-node {major}.{minor}.{patch}\n");
    let header = ImageHeader {
        robot: name(robot.name()),
        target: name(TARGET),
        version: FIRMWARE_VERSION,
        schema_hash: SCHEMA_HASH,
        length: u32::try_from(program.len()).unwrap_or(0),
        crc: CRC.checksum(program.as_bytes()),
    };
    let mut bytes = vec![0xFF; FLASH];
    let begin = LAYOUT.slot_a as usize;
    let image = begin + PAGE as usize;
    let parts = [
        (begin, HEADER, &image::write(&header)[..]),
        (image, program.len(), program.as_bytes()),
    ];
    for (at, length, part) in parts {
        if let Some(place) = bytes.get_mut(at..at + length) {
            place.copy_from_slice(part);
        }
    }
    bytes
}

/// The memory of a black box, and the file it is kept in.
#[derive(Debug)]
pub(crate) struct BoxFile {
    bytes: Vec<u8>,
    path: Option<PathBuf>,
}

impl Memory for BoxFile {
    fn bytes(&self) -> &[u8] {
        &self.bytes
    }
    fn bytes_mut(&mut self) -> &mut [u8] {
        &mut self.bytes
    }
    fn keep(&mut self) {
        if let Some(path) = &self.path {
            // a full disk is no reason to stop a robot; the record is still in memory
            let _ = replace(path, &self.bytes);
        }
    }
}

/// A flash in a file.
#[derive(Debug)]
pub(crate) struct FileFlash {
    file: File,
    bytes: Vec<u8>,
}

/// Why it does not do what it should.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FlashError {
    /// Beyond its end.
    Bounds,
    /// The system says no.
    Io,
}

impl NorFlashError for FlashError {
    fn kind(&self) -> NorFlashErrorKind {
        match self {
            Self::Bounds => NorFlashErrorKind::OutOfBounds,
            Self::Io => NorFlashErrorKind::Other,
        }
    }
}

impl ErrorType for FileFlash {
    type Error = FlashError;
}

impl FileFlash {
    fn change(
        &mut self,
        from: u32,
        length: usize,
        with: impl Fn(usize, u8) -> u8,
    ) -> Result<(), FlashError> {
        let begin = usize::try_from(from).map_err(|_| FlashError::Bounds)?;
        let end = begin.checked_add(length).ok_or(FlashError::Bounds)?;
        let place = self.bytes.get_mut(begin..end).ok_or(FlashError::Bounds)?;
        for (k, byte) in place.iter_mut().enumerate() {
            *byte = with(k, *byte);
        }
        let file = &mut self.file;
        file.seek(SeekFrom::Start(u64::from(from)))
            .and_then(|_| file.write_all(place))
            .map_err(|_| FlashError::Io)
    }
}

impl ReadNorFlash for FileFlash {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), FlashError> {
        let begin = usize::try_from(offset).map_err(|_| FlashError::Bounds)?;
        let from = self
            .bytes
            .get(begin..)
            .and_then(|rest| rest.get(..bytes.len()));
        bytes.copy_from_slice(from.ok_or(FlashError::Bounds)?);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.bytes.len()
    }
}

impl NorFlash for FileFlash {
    const WRITE_SIZE: usize = WRITE as usize;
    const ERASE_SIZE: usize = PAGE as usize;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), FlashError> {
        let length = to.checked_sub(from).ok_or(FlashError::Bounds)?;
        let length = usize::try_from(length).map_err(|_| FlashError::Bounds)?;
        self.change(from, length, |_, _| 0xFF)
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), FlashError> {
        // as any NOR flash: bits are cleared, never set
        self.change(offset, bytes.len(), |k, old| {
            old & bytes.get(k).copied().unwrap_or(0xFF)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Folder(PathBuf);

    impl Folder {
        fn new(name: &str) -> Self {
            let path =
                std::env::temp_dir().join(format!("mrroc-node-{name}-{}", std::process::id()));
            let _ = fs::remove_dir_all(&path);
            Self(path)
        }
    }

    impl Drop for Folder {
        fn drop(&mut self) {
            let _ = fs::remove_dir_all(&self.0);
        }
    }

    const ROBOT: RobotKind = RobotKind::Conveyor;

    #[test]
    fn names_of_robots_and_targets_fit() {
        for kind in RobotKind::ALL {
            assert_eq!(name(kind.name()), kind.name());
        }
        assert_eq!(name(TARGET), TARGET);
    }

    #[test]
    fn starts_are_counted_and_an_end_that_was_none_is_told() {
        let folder = Folder::new("starts");
        let open = || State::open(Some(&folder.0), ROBOT).unwrap();
        let first = open();
        assert_eq!((first.boots, first.cause), (1, ResetCause::PowerOn));
        let second = open();
        assert_eq!((second.boots, second.cause), (2, ResetCause::Vanished));
        second.end().unwrap();
        let third = open();
        assert_eq!((third.boots, third.cause), (3, ResetCause::Software));
        // another robot in the same folder has files of its own
        let other = State::open(Some(&folder.0), RobotKind::Polycrank).unwrap();
        assert_eq!((other.boots, other.cause), (1, ResetCause::PowerOn));
    }

    #[test]
    fn without_a_folder_there_are_no_slots() {
        let state = State::open(None, ROBOT).unwrap();
        assert_eq!(state.cause, ResetCause::Unknown);
        state.keeper(1).unwrap();
        state.end().unwrap();
    }

    #[test]
    fn the_flash_comes_with_this_program_in_it() {
        let folder = Folder::new("flash");
        fs::create_dir_all(&folder.0).unwrap();
        let path = folder.0.join("f");
        for _ in 0..2 {
            let mut updater = open_flash(&path, ROBOT).unwrap();
            let running = updater.running().unwrap();
            assert_eq!(running.version, FIRMWARE_VERSION);
            assert_eq!(fs::metadata(&path).unwrap().len(), 524_288);
        }
    }

    #[test]
    fn what_is_not_of_a_node_is_told_in_one_line() {
        let folder = Folder::new("wrong");
        fs::create_dir_all(&folder.0).unwrap();
        let path = folder.0.join("f");
        for bytes in [
            vec![],
            vec![0xFF; FLASH - 1],
            vec![0xFF; FLASH + 1],
            vec![0xFF; FLASH],
        ] {
            fs::write(&path, bytes).unwrap();
            let end = open_flash(&path, ROBOT).unwrap_err();
            assert_eq!(end.code, exit::DATA);
            assert!(end.text.contains("remove it") && !end.text.contains('\n'));
        }
        for text in ["", "x running", "1 sleeping", "4294967296 ended"] {
            fs::write(folder.0.join("conveyor.starts"), text).unwrap();
            let end = State::open(Some(&folder.0), ROBOT).unwrap_err();
            assert_eq!(end.code, exit::DATA, "{text:?}");
        }
        let file = folder.0.join("f");
        let end = State::open(Some(&file), ROBOT).unwrap_err();
        assert_eq!(end.code, exit::CANNOT_CREATE, "{}", end.text);
    }
}
