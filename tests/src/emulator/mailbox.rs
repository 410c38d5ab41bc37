//! The emulated node in real time: the image runs by its own timer, and the cell as far as the image's clock has
//! come. Where this computer does not keep up, the image's time is held, and for how long is told. When frames come is
//! not repeatable here, and no deadline is promised.

use super::machine::PROGRAM;
use board::boot::Boot;
use board::mailbox::{self, FROM_IMAGE, Memory, TO_IMAGE, Told};
use firmware::process::NodeProcess;
use firmware::{Port, Received};
use protocol::frame::Frame;
use protocol::message::{Identity, NodeState};
use protocol::time::Micros;
use std::fs::{File, OpenOptions};
use std::io;
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// The image's clock counts these.
const TICK: Micros = Micros(500);
/// An image whose clock stands still for so long hangs.
const PATIENCE: Duration = Duration::from_secs(10);
/// The machine's PSRAM.
const PSRAM: u64 = 16 << 20;

/// The host's side of the shared memory, as a file.
#[derive(Debug)]
struct Shared(File);

impl Memory for Shared {
    fn read(&mut self, at: u32, bytes: &mut [u8]) {
        // the file is as long as the machine's memory: tested by the first reading
        let _ = self.0.read_exact_at(bytes, u64::from(at));
    }

    fn write(&mut self, at: u32, bytes: &[u8]) {
        let _ = self.0.write_all_at(bytes, u64::from(at));
    }
}

/// How a node in real time did.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// Time of the image's clock, s.
    pub image_s: f64,
    /// Time of the wall's, s.
    pub wall_s: f64,
    /// Frames that found no room, to the image and from it.
    pub lost: [u64; 2],
    /// Time for which the image's clock was held, s, since the cell was behind it.
    pub held_s: f64,
    /// What went wrong.
    pub problem: Option<String>,
}

/// The emulated node in real time.
#[derive(Debug)]
pub struct RealTimeNode {
    child: Child,
    file: PathBuf,
    memory: Shared,
    identity: Identity,
    state: NodeState,
    next: Micros,
    origin: Micros,
    begun: Instant,
    outcome: Arc<Mutex<Outcome>>,
}

impl RealTimeNode {
    /// Starts the emulator; `identity` is that of the same node in this process.
    ///
    /// # Errors
    /// If there is no emulator, or no node comes of it.
    pub fn boot(
        image: &Path,
        boot: &Boot,
        identity: Identity,
    ) -> io::Result<(Self, Arc<Mutex<Outcome>>)> {
        let shared = Path::new("/dev/shm");
        let folder = if shared.is_dir() {
            shared.to_owned()
        } else {
            std::env::temp_dir()
        };
        let file = folder.join(format!("mrroc-mailbox-{}", std::process::id()));
        let memory = OpenOptions::new()
            .read(true)
            .write(true)
            .create(true)
            .truncate(true)
            .open(&file)?;
        memory.set_len(PSRAM)?;
        let mut memory = Shared(memory);
        if !mailbox::offer(&mut memory, boot) {
            return Err(io::Error::other("no boot message"));
        }
        let backend = format!(
            "memory-backend-file,id=psram,mem-path={},size={PSRAM},share=on",
            file.display()
        );
        let child = Command::new(PROGRAM)
            .args(["-object", &backend])
            .args(["-M", "mps2-an386,memory-backend=psram", "-display", "none"])
            .args(["-monitor", "none", "-serial", "none", "-nodefaults"])
            .args(["-semihosting-config", "enable=on,target=native", "-kernel"])
            .arg(image)
            .current_dir(std::env::temp_dir())
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .spawn()?;
        let outcome = Arc::new(Mutex::new(Outcome::default()));
        let mut node = Self {
            child,
            file,
            memory,
            identity,
            state: NodeState::Boot,
            next: boot.now,
            origin: boot.now,
            begun: Instant::now(),
            outcome: outcome.clone(),
        };
        while node.begun.elapsed() < PATIENCE {
            match mailbox::accepted(&mut node.memory) {
                Some(true) => {
                    node.begun = Instant::now();
                    return Ok((node, outcome));
                }
                Some(false) => break,
                None => std::thread::sleep(Duration::from_millis(1)),
            }
        }
        Err(io::Error::other("the image makes no such node"))
    }

    /// Says that the cell has come so far, and waits until the image's clock has.
    fn wait(&mut self, now: Micros) -> Result<Told, String> {
        let wanted = now.since(self.origin).0 / TICK.0;
        // no run is as long as 2³² half milliseconds
        mailbox::reached(&mut self.memory, u32::try_from(wanted).unwrap_or(u32::MAX));
        let begun = Instant::now();
        loop {
            let told @ Told { ticks, .. } = mailbox::told(&mut self.memory);
            if u64::from(ticks) >= wanted {
                return Ok(told);
            }
            if begun.elapsed() > PATIENCE {
                return Err(format!("the image's clock stands still at {ticks}"));
            }
            std::thread::sleep(Duration::from_micros(20));
        }
    }
}

impl NodeProcess for RealTimeNode {
    fn step(&mut self, now: Micros, rx: &[Received], tx: &mut dyn FnMut(Port, Frame)) {
        let mut lost = 0;
        for frame in rx {
            lost += u64::from(!TO_IMAGE.push(&mut self.memory, frame));
        }
        let waited = self.wait(now);
        while let Some(sent) = FROM_IMAGE.pop(&mut self.memory) {
            tx(sent.port, sent.frame);
        }
        self.next = now + TICK;
        let mut outcome = self.outcome.lock().unwrap_or_else(PoisonError::into_inner);
        let [to_image, from_image] = &mut outcome.lost;
        *to_image += lost;
        match waited {
            Ok(told) => {
                *from_image = u64::from(told.lost);
                outcome.held_s = Micros(u64::from(told.held) * TICK.0).as_secs_f64();
            }
            Err(problem) => {
                outcome.problem.get_or_insert(problem);
                // never again
                self.next = Micros(u64::MAX / 2000);
            }
        }
        outcome.image_s = now.since(self.origin).as_secs_f64();
        outcome.wall_s = self.begun.elapsed().as_secs_f64();
    }

    fn next_wake(&self) -> Micros {
        self.next
    }

    fn state(&self) -> NodeState {
        self.state
    }

    fn identity(&self) -> Identity {
        self.identity.clone()
    }
}

impl Drop for RealTimeNode {
    fn drop(&mut self) {
        mailbox::leave(&mut self.memory);
        let begun = Instant::now();
        while matches!(self.child.try_wait(), Ok(None)) && begun.elapsed() < Duration::from_secs(1)
        {
            std::thread::sleep(Duration::from_millis(5));
        }
        let _ = self.child.kill();
        let _ = self.child.wait();
        let _ = std::fs::remove_file(&self.file);
    }
}
