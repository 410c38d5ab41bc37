//! Output that never blocks the servo loop: a thread writes, and what it cannot take is dropped.

use serde_json::Value;
use std::io::Write as _;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread;
use std::time::Duration;

/// Lines that wait for the thread.
const QUEUE: usize = 1024;
/// How long the end waits for lines to be written.
const FLUSH: Duration = Duration::from_secs(2);

enum Line {
    Out(String),
    Err(String),
}

/// Lines for stdout and stderr.
#[derive(Debug)]
pub(crate) struct Printer {
    json: bool,
    lines: Option<SyncSender<Line>>,
    done: Receiver<()>,
}

impl Printer {
    /// A printer; JSON goes to stdout if it is wanted.
    pub(crate) fn new(json: bool) -> Self {
        let (lines, waiting) = sync_channel::<Line>(QUEUE);
        let (end, done) = sync_channel(1);
        thread::spawn(move || {
            // somebody who does not read any more is no reason to stop a robot's controller
            for line in waiting {
                let _ = match line {
                    Line::Out(text) => writeln!(std::io::stdout(), "{text}"),
                    Line::Err(text) => writeln!(std::io::stderr(), "{text}"),
                };
            }
            let _ = end.send(());
        });
        Self {
            json,
            lines: Some(lines),
            done,
        }
    }

    /// For people, while it runs.
    pub(crate) fn tell(&self, text: String) {
        self.put(Line::Err(text));
    }

    /// For people, the result: only where no JSON is wanted.
    pub(crate) fn result(&self, text: String) {
        if !self.json {
            self.put(Line::Out(text));
        }
    }

    /// For machines, if JSON is wanted.
    pub(crate) fn json(&self, value: &Value) {
        if self.json {
            self.put(Line::Out(value.to_string()));
        }
    }

    fn put(&self, line: Line) {
        if let Some(lines) = &self.lines {
            let _ = lines.try_send(line);
        }
    }
}

impl Drop for Printer {
    fn drop(&mut self) {
        self.lines = None;
        let _ = self.done.recv_timeout(FLUSH);
    }
}
