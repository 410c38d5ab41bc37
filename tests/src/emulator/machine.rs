//! The emulator as a process: two named pipes to the image, its log, and no way to hang.

use std::fs::{File, OpenOptions};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

/// The emulator.
pub const PROGRAM: &str = "qemu-system-arm";
/// An image that says nothing for so long hangs; the longest step of all takes a millisecond.
const PATIENCE: Duration = Duration::from_secs(30);
/// How often somebody looks whether the emulator still runs.
const LOOK: Duration = Duration::from_millis(20);
/// To the image, as it calls it.
const TO_IMAGE: &str = "to-image";
/// From the image.
const FROM_IMAGE: &str = "from-image";

/// What to emulate, and how.
#[derive(Clone, Debug)]
pub struct Setup {
    /// The image.
    pub image: PathBuf,
    /// Plugin that counts instructions, with its arguments.
    pub plugin: Option<String>,
}

/// How an emulator ended, and what it said.
#[derive(Clone, Debug)]
pub struct Ending {
    /// It ended by itself, as an image that was told to.
    pub good: bool,
    /// defmt frames.
    pub log: Vec<u8>,
    /// What the emulator itself said.
    pub messages: String,
}

/// A running emulator.
#[derive(Debug)]
pub struct Machine {
    child: Arc<Mutex<Child>>,
    folder: PathBuf,
    to_image: File,
    from_image: File,
    /// Milliseconds since the start when the image last said something.
    heard: Arc<AtomicU64>,
    begun: Instant,
    watchdog: Option<JoinHandle<bool>>,
    log: Option<JoinHandle<Vec<u8>>>,
    messages: Option<JoinHandle<Vec<u8>>>,
}

impl Machine {
    /// Starts it in a folder of its own.
    ///
    /// # Errors
    /// If the emulator is missing, or its pipes cannot be made.
    pub fn start(setup: &Setup) -> io::Result<Self> {
        static NUMBER: AtomicU64 = AtomicU64::new(0);
        let number = NUMBER.fetch_add(1, Ordering::Relaxed);
        let folder =
            std::env::temp_dir().join(format!("mrroc-qemu-{}-{number}", std::process::id()));
        std::fs::create_dir_all(&folder)?;
        for pipe in [TO_IMAGE, FROM_IMAGE] {
            let made = Command::new("mkfifo").arg(folder.join(pipe)).status()?;
            if !made.success() {
                return Err(io::Error::other(format!("mkfifo: {made}")));
            }
        }
        let mut command = Command::new(PROGRAM);
        command
            .args(["-M", "mps2-an386", "-display", "none", "-monitor", "none"])
            .args(["-serial", "none", "-nodefaults"])
            .args(["-semihosting-config", "enable=on,target=native"])
            .arg("-kernel")
            .arg(&setup.image);
        // 8 ns an instruction: 125 million a second, nearest to a Cortex-M4 at 170 MHz
        command.args(["-icount", "shift=3,sleep=off"]);
        if let Some(plugin) = &setup.plugin {
            command.args(["-plugin", plugin]);
        }
        let mut child = command
            .current_dir(&folder)
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()?;
        let log = child.stdout.take().map(collect);
        let messages = child.stderr.take().map(collect);
        let child = Arc::new(Mutex::new(child));
        let heard = Arc::new(AtomicU64::new(1));
        let begun = Instant::now();
        let watchdog = watch(child.clone(), heard.clone(), begun, folder.clone());
        // whoever opens a pipe waits for the other side: the image, or the watchdog when it has ended
        let to_image = OpenOptions::new()
            .read(true)
            .write(true)
            .open(folder.join(TO_IMAGE))?;
        let from_image = File::open(folder.join(FROM_IMAGE))?;
        Ok(Self {
            child,
            folder,
            to_image,
            from_image,
            heard,
            begun,
            watchdog: Some(watchdog),
            log,
            messages,
        })
    }

    /// Sends a message, and reads the answer to it, without its length, into `answer`.
    ///
    /// # Errors
    /// If the emulator has ended, or what it says has no valid length.
    pub fn exchange(&mut self, message: &[u8], answer: &mut Vec<u8>) -> io::Result<()> {
        self.to_image.write_all(message)?;
        let mut length = [0; board::channel::LENGTH];
        self.from_image.read_exact(&mut length)?;
        let length = board::channel::length(length)
            .ok_or_else(|| io::Error::other("an answer that is none"))?;
        answer.resize(length, 0);
        self.from_image.read_exact(answer)?;
        let now = u64::try_from(self.begun.elapsed().as_millis()).unwrap_or(u64::MAX);
        self.heard.store(now.max(1), Ordering::Relaxed);
        Ok(())
    }

    /// Ends it.
    #[must_use]
    pub fn finish(mut self, message: &[u8]) -> Ending {
        // an emulator that has ended needs no message
        let _ = self.to_image.write_all(message);
        let good = self
            .watchdog
            .take()
            .is_some_and(|w| w.join().unwrap_or(false));
        let text = |reader: Option<JoinHandle<Vec<u8>>>| {
            reader.and_then(|r| r.join().ok()).unwrap_or_default()
        };
        Ending {
            good,
            log: text(self.log.take()),
            messages: String::from_utf8_lossy(&text(self.messages.take())).into_owned(),
        }
    }
}

impl Drop for Machine {
    fn drop(&mut self) {
        if let Ok(mut child) = self.child.lock() {
            let _ = child.kill();
        }
        if let Some(watchdog) = self.watchdog.take() {
            let _ = watchdog.join();
        }
        let _ = std::fs::remove_dir_all(&self.folder);
    }
}

/// Waits for the end; ends what hangs. Whoever still waits for the image then finds the end of a file.
fn watch(
    child: Arc<Mutex<Child>>,
    heard: Arc<AtomicU64>,
    begun: Instant,
    folder: PathBuf,
) -> JoinHandle<bool> {
    thread::spawn(move || {
        loop {
            thread::sleep(LOOK);
            let Ok(mut child) = child.lock() else {
                return false;
            };
            match child.try_wait() {
                Ok(None) => {}
                Ok(Some(status)) => {
                    drop(child);
                    let _ = OpenOptions::new()
                        .read(true)
                        .write(true)
                        .open(folder.join(FROM_IMAGE));
                    return status.success();
                }
                Err(_) => return false,
            }
            let last = Duration::from_millis(heard.load(Ordering::Relaxed));
            let silent = begun.elapsed().saturating_sub(last);
            if silent > PATIENCE {
                let _ = child.kill();
            }
        }
    })
}

fn collect(mut pipe: impl Read + Send + 'static) -> JoinHandle<Vec<u8>> {
    thread::spawn(move || {
        let mut bytes = Vec::new();
        let _ = pipe.read_to_end(&mut bytes);
        bytes
    })
}

/// Is the emulator installed?
#[must_use]
pub fn installed() -> bool {
    Command::new(PROGRAM)
        .arg("--version")
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status()
        .is_ok_and(|status| status.success())
}

/// Is this an image at all?
#[must_use]
pub fn is_image(path: &Path) -> bool {
    let mut magic = [0; 4];
    File::open(path)
        .and_then(|mut file| file.read_exact(&mut magic))
        .is_ok()
        && magic == *b"\x7fELF"
}
