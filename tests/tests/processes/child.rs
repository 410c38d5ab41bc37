//! A process under test: what it says, line by line, and its end.

use serde_json::Value;
use std::io::{BufRead as _, BufReader, Read};
use std::path::PathBuf;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Mutex, OnceLock, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// Far beyond what anything here takes, for a machine that is busy with other tests.
pub(crate) const PATIENCE: Duration = Duration::from_secs(60);

/// The folder with the binaries of this build: named by whoever runs the test where nothing can be
/// built, else they are built once if they are not there or old.
fn binaries() -> &'static PathBuf {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    FOLDER.get_or_init(|| {
        if let Some(folder) = std::env::var_os("MRROC_BINARIES") {
            return folder.into();
        }
        // target/PROFILE/deps/processes-HASH
        let test = std::env::current_exe().unwrap();
        let folder = test.ancestors().nth(2).unwrap().to_path_buf();
        let mut build = Command::new(std::env::var("CARGO").unwrap_or("cargo".into()));
        build.args([
            "build",
            "--quiet",
            "-p",
            "mrroc-node",
            "-p",
            "mrroc-hil-sim",
            "-p",
            "mrroc",
            "--bins",
        ]);
        if folder.ends_with("release") {
            build.arg("--release");
        }
        build.arg("--target-dir").arg(folder.parent().unwrap());
        assert!(
            build.status().unwrap().success(),
            "the binaries do not build"
        );
        folder
    })
}

/// A process that is killed, at the latest, when the test ends.
pub(crate) struct Process {
    child: Child,
    out: Receiver<String>,
    /// Every line of stdout taken so far, as JSON.
    pub(crate) events: Vec<Value>,
    errors: Receiver<String>,
}

fn lines(from: impl Read + Send + 'static) -> Receiver<String> {
    let (lines, taken) = channel();
    thread::spawn(move || {
        for line in BufReader::new(from).lines().map_while(Result::ok) {
            if lines.send(line).is_err() {
                break;
            }
        }
    });
    taken
}

impl Process {
    /// Starts a binary of this build.
    pub(crate) fn start(name: &str, args: &[&str]) -> Self {
        static STARTING: Mutex<()> = Mutex::new(());
        let _one_at_a_time = STARTING.lock().unwrap_or_else(PoisonError::into_inner);
        let path = binaries()
            .join(name)
            .with_extension(std::env::consts::EXE_EXTENSION);
        let mut command = Command::new(&path);
        command
            .args(args)
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped());
        let mut child = command.spawn().unwrap();
        let out = lines(child.stdout.take().unwrap());
        let errors = lines(child.stderr.take().unwrap());
        Self {
            child,
            out,
            events: Vec::new(),
            errors,
        }
    }

    /// The first event of this kind that `is` what is waited for; later ones stay.
    pub(crate) fn event(&mut self, kind: &str, mut is: impl FnMut(&Value) -> bool) -> Value {
        let until = Instant::now() + PATIENCE;
        loop {
            let left = until.saturating_duration_since(Instant::now());
            let Ok(line) = self.out.recv_timeout(left) else {
                panic!("no {kind} in {:#?}\n{:#?}", self.events, self.said());
            };
            let event: Value = serde_json::from_str(&line).unwrap();
            self.events.push(event.clone());
            if event["event"] == kind && is(&event) {
                return event;
            }
        }
    }

    /// The states it has told, in their order.
    pub(crate) fn states(&self) -> Vec<&str> {
        let states = self.events.iter().filter(|event| event["event"] == "state");
        states.filter_map(|event| event["state"].as_str()).collect()
    }

    /// What it said on stderr until now.
    pub(crate) fn said(&self) -> Vec<String> {
        self.errors.try_iter().collect()
    }

    /// As by Ctrl-C.
    #[cfg(unix)]
    pub(crate) fn interrupt(&self) {
        let id = self.child.id().to_string();
        assert!(
            Command::new("kill")
                .args(["-INT", &id])
                .status()
                .unwrap()
                .success()
        );
    }

    /// As by `kill -9`: it can do nothing about it.
    pub(crate) fn kill(&mut self) {
        self.child.kill().unwrap();
        self.child.wait().unwrap();
    }

    /// Has it ended? A test that only waits for this is ended by whoever runs it.
    pub(crate) fn has_ended(&mut self) -> bool {
        self.child.try_wait().unwrap().is_some()
    }

    /// Its end: status, and all that was left on stderr. Events are taken to the last.
    pub(crate) fn end(&mut self) -> (ExitStatus, Vec<String>) {
        self.end_within(PATIENCE)
    }

    /// The same for what takes its time.
    pub(crate) fn end_within(&mut self, patience: Duration) -> (ExitStatus, Vec<String>) {
        let until = Instant::now() + patience;
        let status = loop {
            if let Some(status) = self.child.try_wait().unwrap() {
                break status;
            }
            assert!(
                Instant::now() < until,
                "it does not end: {:#?}",
                self.said()
            );
            thread::sleep(Duration::from_millis(20));
        };
        let events = self
            .out
            .iter()
            .filter_map(|line| serde_json::from_str(&line).ok());
        self.events.extend(events);
        (status, self.errors.iter().collect())
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
