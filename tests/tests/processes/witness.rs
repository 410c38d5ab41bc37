//! `candump` of can-utils as the witness: what was on an interface, by a program that is not ours.

use bus::candump::{Entry, parse};
use bus::socketcan::SocketCan;
use bus::{Bus as _, Hears};
use protocol::frame::{Frame, Id};
use std::fs::File;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

/// An identifier that nobody here uses: it shows that the witness listens, and where a story ends.
pub(crate) const MARK: Id = Id::Standard(0x77F);
/// The same as a filter.
const MARKS: &str = "77F:7FF";

/// A recording under way.
pub(crate) struct Witness {
    child: Child,
    file: PathBuf,
    socket: SocketCan,
    marks: u8,
}

impl Witness {
    /// Begins to listen; returns when it does.
    pub(crate) fn of(interface: &str) -> Self {
        Self::of_some(interface, &[])
    }

    /// The same of some frames only, and of marks: identifier and mask as `candump` takes them.
    pub(crate) fn of_some(interface: &str, filters: &[&str]) -> Self {
        let name = format!("mrroc-{interface}-{}.log", std::process::id());
        let file = std::env::temp_dir().join(name);
        let mut what = interface.to_owned();
        let marks = (!filters.is_empty()).then_some(MARKS);
        for filter in filters.iter().copied().chain(marks) {
            what = format!("{what},{filter}");
        }
        let child = Command::new("candump")
            .args(["-L", &what])
            .stdin(Stdio::null())
            .stdout(File::create(&file).unwrap())
            .spawn()
            .expect("can-utils are installed");
        let mut witness = Self {
            child,
            file,
            socket: SocketCan::open(interface, Hears::Extended).unwrap(),
            marks: 0,
        };
        witness.mark();
        witness
    }

    /// Sends marks until the witness has seen one; everything sent before it has been written, too.
    fn mark(&mut self) {
        self.marks += 1;
        let sent = Frame::classic(MARK, &[self.marks]).unwrap();
        let until = Instant::now() + super::child::PATIENCE;
        loop {
            self.socket.send(&sent).unwrap();
            thread::sleep(Duration::from_millis(20));
            let seen = self.read();
            if seen.iter().rev().any(|entry| entry.frame == sent) {
                return;
            }
            assert!(
                Instant::now() < until,
                "candump does not hear mark {}, only {} frames, the last {:?}",
                self.marks,
                seen.len(),
                seen.last()
            );
        }
    }

    /// What it has written until now, without a last line that is not whole.
    pub(crate) fn text(&self) -> String {
        let mut text = std::fs::read_to_string(&self.file).unwrap();
        text.truncate(text.rfind('\n').map_or(0, |end| end + 1));
        text
    }

    /// The same, understood.
    pub(crate) fn read(&self) -> Vec<Entry> {
        let text = self.text();
        text.lines()
            .map(|line| parse(line).unwrap_or_else(|error| panic!("{line}: {error}")))
            .collect()
    }

    /// Everything it has seen until now, without the marks.
    pub(crate) fn seen(&mut self) -> Vec<Entry> {
        self.mark();
        let mut entries = self.read();
        entries.retain(|entry| entry.frame.id() != MARK);
        entries
    }
}

impl Drop for Witness {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
        let _ = std::fs::remove_file(&self.file);
    }
}
