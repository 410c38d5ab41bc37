//! The bootloader of an STM32G474, run on an emulated Cortex-M4F with flash at the same address.
//!
//! The emulator has another STM32 (F405), whose flash is a ROM and which has nothing where the G474 has its flash controller and
//! `SYSCFG`: what is written there is told, and has no effect. So what is decided and the jump are real; a
//! record that must be written cannot be, and the banks do not change places.

use super::machine::PROGRAM;
use firmware::update::boot::{self, Phase, Record};
use firmware::update::image::{self, CRC};
use firmware::update::stm32g474::{BANK, FLASH, IMAGE, LAYOUT, PAGE};
use protocol::maintenance::{ImageHeader, Slot};
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;

const MACHINE: &str = "netduinoplus2";
/// An emulator that says nothing for so long hangs: two CRCs of whole slots take less than a second.
const PATIENCE: Duration = Duration::from_secs(60);
/// A bootloader that has decided starts what it decided within microseconds.
const AFTERWARDS: Duration = Duration::from_secs(1);
/// `FB_MODE` is written, to this; in the emulator's words for where SYSCFG is.
const SHOWN: &str = "timer[1]: unimplemented device write (size 4, offset 0x000, value ";
/// The flash is locked: everything is decided and written down.
const DECIDED: &str = "GPIOI: unimplemented device write (size 4, offset 0x014, value 0x80000000)";
/// The right to program is taken: CR.PG.
const PROGRAMMED: &str =
    "GPIOI: unimplemented device write (size 4, offset 0x014, value 0x00000001)";

/// The least program: it tells the emulator to end with success (semihosting, `SYS_EXIT` of application exit).
///
/// ```text
///   movs r0, #0x18
///   ldr  r1, [pc, #4]
///   bkpt 0xAB
///   nop
///   .word 0x20026
/// ```
const PROGRAM_CODE: [u16; 6] = [0x2018, 0x4901, 0xBEAB, 0xBF00, 0x0026, 0x0002];

/// A program as it is in flash: first stack pointer, entry, code, and some bytes so that its CRC takes more than a moment.
fn program(filling: u8) -> Vec<u8> {
    const STACK: u32 = 0x2001_0000;
    const THUMB: u32 = 1;
    let entry = IMAGE + 8 + THUMB;
    let words = [STACK.to_le_bytes(), entry.to_le_bytes()].concat();
    let code = PROGRAM_CODE.iter().flat_map(|half| half.to_le_bytes());
    let filling = std::iter::repeat_n(filling, 10_000);
    words.into_iter().chain(code).chain(filling).collect()
}

/// What is in flash at the start.
struct Flash {
    folder: PathBuf,
    parts: Vec<(u32, PathBuf)>,
}

impl Flash {
    fn new(case: &str) -> Result<Self, String> {
        let name = format!("mrroc-bootloader-{}-{case}", std::process::id());
        let folder = std::env::temp_dir().join(name);
        std::fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
        let parts = vec![];
        Ok(Self { folder, parts })
    }

    fn put(&mut self, offset: u32, bytes: &[u8]) -> Result<(), String> {
        let file = self.folder.join(format!("{offset:x}"));
        std::fs::write(&file, bytes).map_err(|e| format!("{}: {e}", file.display()))?;
        self.parts.push((FLASH + offset, file));
        Ok(())
    }

    /// An image with its header; `damage`: one bit of it is another.
    fn image(&mut self, slot: Slot, damage: bool) -> Result<(), String> {
        let (begin, filling) = match slot {
            Slot::A => (LAYOUT.slot_a, 0xAA),
            Slot::B => (LAYOUT.slot_b, 0xBB),
        };
        let mut bytes = program(filling);
        let name = |text: &str| text.try_into().map_err(|_| "a long name".to_owned());
        let header = ImageHeader {
            robot: "conveyor"
                .try_into()
                .map_err(|_| "a long name".to_owned())?,
            target: name("stm32g474")?,
            version: (1, 0, 0),
            schema_hash: 0,
            length: u32::try_from(bytes.len()).map_err(|e| e.to_string())?,
            crc: CRC.checksum(&bytes),
        };
        if damage && let Some(last) = bytes.last_mut() {
            *last ^= 0x10;
        }
        self.put(begin, &image::write(&header))?;
        self.put(begin + PAGE, &bytes)
    }

    fn record(&mut self, slot: Slot, phase: Phase) -> Result<(), String> {
        let [first, _] = LAYOUT.log;
        self.put(first, &boot::write(7, Record { slot, phase }))
    }
}

impl Drop for Flash {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.folder);
    }
}

/// What a bootloader did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Done {
    /// It tried to write into the log.
    wrote: bool,
    /// The bank it showed before it jumped.
    bank: Option<u32>,
    /// A program that began said that it has ended.
    ran: bool,
}

fn run(bootloader: &Path, flash: &Flash) -> Result<Done, String> {
    let mut command = Command::new(PROGRAM);
    command
        .args(["-M", MACHINE, "-display", "none", "-monitor", "none"])
        .args(["-serial", "none", "-nodefaults", "-d", "unimp"])
        .args(["-semihosting-config", "enable=on,target=native", "-kernel"])
        .arg(bootloader)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::piped());
    for (address, file) in &flash.parts {
        let part = format!(
            "loader,file={},addr={address:#x},force-raw=on",
            file.display()
        );
        command.args(["-device", &part]);
    }
    let child = command.spawn().map_err(|e| format!("{PROGRAM}: {e}"))?;
    let mut child = Emulator(child);
    let lines = child.lines()?;
    let mut done = Done::default();
    let mut patience = PATIENCE;
    loop {
        match lines.recv_timeout(patience) {
            Ok(line) => {
                done.wrote |= line == PROGRAMMED;
                if line == DECIDED {
                    patience = AFTERWARDS;
                }
                if let Some(value) = line.strip_prefix(SHOWN) {
                    let value = value.trim_start_matches("0x").trim_end_matches(')');
                    let value = u32::from_str_radix(value, 16);
                    done.bank = Some(value.map_err(|e| format!("{line}: {e}"))?);
                    patience = PATIENCE;
                }
            }
            Err(RecvTimeoutError::Timeout) if patience == AFTERWARDS => return Ok(done),
            Err(RecvTimeoutError::Timeout) => return Err(format!("it hangs: {done:?}")),
            Err(RecvTimeoutError::Disconnected) => break,
        }
    }
    let status = child.0.wait().map_err(|e| format!("{PROGRAM}: {e}"))?;
    done.ran = status.success();
    Ok(done)
}

/// Killed, at the latest, when it is dropped.
struct Emulator(Child);

impl Emulator {
    fn lines(&mut self) -> Result<Receiver<String>, String> {
        let said = self.0.stderr.take().ok_or("no output")?;
        let (lines, taken) = channel();
        thread::spawn(move || {
            for line in BufReader::new(said).lines().map_while(Result::ok) {
                if lines.send(line).is_err() {
                    break;
                }
            }
        });
        Ok(taken)
    }
}

impl Drop for Emulator {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Runs the bootloader with what it can find in its flash.
///
/// # Errors
/// What it did, and should not have.
pub fn check(bootloader: &Path) -> Result<(), String> {
    const FB_MODE: u32 = 1 << 8;
    type Prepare = fn(&mut Flash) -> Result<(), String>;
    let started = |bank| Done {
        wrote: false,
        bank: Some(bank),
        ran: true,
    };
    let waits = Done::default();
    let cases: [(&str, Prepare, Done); 6] = [
        ("the first image", |f| f.image(Slot::A, false), started(0)),
        (
            "the first is damaged",
            |f| {
                f.image(Slot::A, true)?;
                f.image(Slot::B, false)
            },
            started(FB_MODE),
        ),
        (
            "the second is confirmed",
            |f| {
                f.image(Slot::A, false)?;
                f.image(Slot::B, false)?;
                f.record(Slot::B, Phase::Confirmed)
            },
            started(FB_MODE),
        ),
        (
            "both are damaged",
            |f| {
                f.image(Slot::A, true)?;
                f.image(Slot::B, true)
            },
            waits,
        ),
        ("an empty flash", |_| Ok(()), waits),
        (
            "a trial that cannot be written down",
            |f| {
                f.image(Slot::A, false)?;
                f.image(Slot::B, false)?;
                f.record(Slot::B, Phase::Trial { left: 1 })
            },
            Done {
                wrote: true,
                ..waits
            },
        ),
    ];
    for (case, prepare, expected) in cases {
        let mut flash = Flash::new(&case.replace(' ', "-"))?;
        prepare(&mut flash)?;
        let done = run(bootloader, &flash)?;
        if done != expected {
            return Err(format!("{case}: expected {expected:?}, got {done:?}"));
        }
        println!("{case}: as expected, {done:?}");
    }
    Ok(())
}

const _: () = assert!(BANK == LAYOUT.slot_b - LAYOUT.slot_a);
