//! The operator's command `mrroc`, built once in the profile of the tests, run as a process.

use crate::workspace;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::OnceLock;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// What hangs is ended after this time; nothing here measures speed.
const PATIENCE: Duration = Duration::from_secs(120);

/// The executable. The first call builds it beside the running test, in the same profile.
///
/// # Panics
/// If cargo cannot build it.
#[must_use]
pub fn mrroc() -> &'static Path {
    static MRROC: OnceLock<PathBuf> = OnceLock::new();
    MRROC.get_or_init(|| {
        let exe = std::env::current_exe().expect("a test knows its own file");
        // <target>/<profile>/deps/<test>
        let profile = exe
            .ancestors()
            .nth(2)
            .expect("tests run from a target directory");
        let target = profile
            .parent()
            .expect("a profile is inside a target directory");
        let name = match profile.file_name().and_then(|name| name.to_str()) {
            Some("debug") | None => "dev",
            Some(name) => name,
        };
        let status = Command::new(env!("CARGO"))
            .args([
                "build",
                "--quiet",
                "--package",
                "mrroc",
                "--bin",
                "mrroc",
                "--profile",
                name,
            ])
            .arg("--target-dir")
            .arg(target)
            .current_dir(workspace())
            .status()
            .expect("cargo runs");
        assert!(status.success(), "cargo build -p mrroc: {status}");
        profile.join(format!("mrroc{}", std::env::consts::EXE_SUFFIX))
    })
}

/// How a process ended.
#[derive(Clone, Debug)]
pub struct Output {
    /// Its exit code; nothing if a signal ended it.
    pub code: Option<i32>,
    /// All of its standard output.
    pub stdout: String,
    /// All of its standard error.
    pub stderr: String,
}

impl Output {
    /// Standard output as one JSON value.
    ///
    /// # Panics
    /// If it is none.
    #[must_use]
    pub fn json(&self) -> serde_json::Value {
        serde_json::from_str(&self.stdout)
            .unwrap_or_else(|error| panic!("no JSON ({error}): {self:?}"))
    }
}

/// A process under way.
#[derive(Debug)]
pub struct Running {
    child: Child,
    stdout: JoinHandle<String>,
    stderr: JoinHandle<String>,
}

/// Starts `mrroc` in the root of the workspace.
///
/// # Panics
/// If it cannot be started.
#[must_use]
pub fn start<S: AsRef<std::ffi::OsStr>>(args: impl IntoIterator<Item = S>) -> Running {
    let mut child = Command::new(mrroc())
        .args(args)
        .current_dir(workspace())
        .env("RUST_BACKTRACE", "1") // a panic would show itself at length
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("mrroc starts");
    let stdout = collect(child.stdout.take().expect("piped"));
    let stderr = collect(child.stderr.take().expect("piped"));
    Running {
        child,
        stdout,
        stderr,
    }
}

/// Runs `mrroc` to its end.
///
/// # Panics
/// If it cannot be started, or hangs.
#[must_use]
pub fn run<S: AsRef<std::ffi::OsStr>>(args: impl IntoIterator<Item = S>) -> Output {
    start(args).finish()
}

impl Running {
    /// The number of the process.
    #[must_use]
    pub fn id(&self) -> u32 {
        self.child.id()
    }

    /// Has it ended?
    ///
    /// # Panics
    /// If the system does not say.
    pub fn has_ended(&mut self) -> bool {
        self.child
            .try_wait()
            .expect("a child can be asked")
            .is_some()
    }

    /// Waits for its end.
    ///
    /// # Panics
    /// If it hangs; it is ended then.
    #[must_use]
    pub fn finish(mut self) -> Output {
        let begun = Instant::now();
        while !self.has_ended() {
            if begun.elapsed() > PATIENCE {
                let _ = self.child.kill();
                let _ = self.child.wait();
                panic!("mrroc did not end: {:?}", self.stderr.join());
            }
            std::thread::sleep(Duration::from_millis(2));
        }
        let code = self.child.wait().expect("it has ended").code();
        let stdout = self.stdout.join().expect("its output was read");
        let stderr = self.stderr.join().expect("its errors were read");
        Output {
            code,
            stdout,
            stderr,
        }
    }
}

/// Reads a pipe to its end, so that the writer never waits.
fn collect(mut pipe: impl Read + Send + 'static) -> JoinHandle<String> {
    std::thread::spawn(move || {
        let mut bytes = Vec::new();
        let _ = pipe.read_to_end(&mut bytes);
        String::from_utf8_lossy(&bytes).into_owned()
    })
}

/// A directory of its own for the files of one test, removed in the end.
#[derive(Debug)]
pub struct Scratch(PathBuf);

impl Scratch {
    /// An empty directory.
    ///
    /// # Panics
    /// If the system gives none.
    #[must_use]
    pub fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("mrroc-{name}-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&path);
        std::fs::create_dir_all(&path).expect("a directory for the test");
        Self(path)
    }

    /// A file in it.
    #[must_use]
    pub fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    /// A new file in it.
    ///
    /// # Panics
    /// If it cannot be written.
    #[must_use]
    pub fn file(&self, name: &str, text: &str) -> PathBuf {
        let path = self.path(name);
        std::fs::write(&path, text).expect("a file for the test");
        path
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}
