//! The HIL suite over SocketCAN: `cargo xtask vcan`.
//!
//! The suite is `tests/tests/processes/vcan.rs`. It needs interfaces `vcan0` (CAN FD) and `vcan1` (classical),
//! and the right to take them down. Where this computer's kernel has them and we are root it runs
//! here; else on a kernel of its own: User-mode Linux, which is Linux with its SocketCAN as a process,
//! without emulation and without privileges, on the file system of this computer (read only). Time in
//! there passes only while nobody works (`xtask/vcan/host.c`), so it need not be fast.
//!
//! ```text
//! ip link add vcan0 type vcan; ip link set vcan0 mtu 72 up          to run it here, as root
//! ip link add vcan1 type vcan; ip link set vcan1 mtu 16 up
//! apt-get install user-mode-linux busybox-static can-utils gcc      to run it in a machine (Debian)
//! cargo xtask vcan vcan::two_arms                                        only the tests of this name
//! ```

use crate::bench::built;
use crate::report::Findings;
use crate::shell::root;
use anyhow::{Context, Result, ensure};
use std::fs;
use std::io::Write as _;
use std::os::unix::process::CommandExt as _;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

/// Debian's User-mode Linux, package `user-mode-linux`, and its modules.
const KERNEL: &str = "/usr/bin/linux.uml";
const MODULES: &str = "/usr/lib/uml/modules";
/// What the machine needs besides: its first process runs in this shell.
const SHELL: &str = "/bin/busybox";
/// The tests of the suite, among those of processes.
const SUITE: &str = "vcan::";
/// The bus, FD; the other one is classical.
const INTERFACES: [&str; 2] = ["vcan0", "vcan1"];
/// Where the suite cannot run it is a failure, if this is in the environment: [`required`].
const REQUIRED: &str = "MRROC_VCAN";
/// Tells the suite that it is where the interfaces must be; without it, its tests skip where there are none.
const PRESENT: &str = "MRROC_ON_VCAN";
/// Memory of the machine. It is taken as it is used.
const MEMORY: &str = "mem=1G";
/// The suite takes some two minutes; a machine that hangs is ended.
const PATIENCE: Duration = Duration::from_secs(600);
/// Between two looks at whether it has ended.
const LOOK: Duration = Duration::from_millis(50);

/// Where the suite can run.
enum Place {
    /// On this kernel.
    Here,
    /// On a kernel of its own.
    Machine,
}

/// Must the suite run, or may it be skipped where it cannot?
pub(crate) fn required() -> bool {
    std::env::var_os(REQUIRED).is_some()
}

/// Why the suite cannot run on this computer, if it cannot.
pub(crate) fn obstacle() -> Option<String> {
    place().err()
}

fn place() -> Result<Place, String> {
    let exists = |name: &&str| Path::new("/sys/class/net").join(name).exists();
    if INTERFACES.iter().all(exists) && is_root() {
        return Ok(Place::Here);
    }
    let missing: Vec<&str> = [KERNEL, SHELL, "/usr/bin/candump"]
        .into_iter()
        .filter(|path| !Path::new(path).exists())
        .collect();
    if missing.is_empty() {
        Ok(Place::Machine)
    } else {
        Err(format!(
            "neither interfaces {} here, as root, nor a machine for them: no {} (Debian: apt-get \
             install user-mode-linux busybox-static can-utils)",
            INTERFACES.join(" and "),
            missing.join(", ")
        ))
    }
}

/// By the owner of one's own processes: the standard library has no other way to ask.
fn is_root() -> bool {
    use std::os::unix::fs::MetadataExt as _;
    fs::metadata("/proc/self").is_ok_and(|own| own.uid() == 0)
}

/// Builds the suite and the processes under test, and runs it.
pub(crate) fn run(arguments: &[String]) -> Result<Findings> {
    let place = match place() {
        Ok(place) => place,
        Err(obstacle) => return Ok(vec![format!("not run: {obstacle}")]),
    };
    let bins = ["-p", "mrroc", "-p", "mrroc-node", "-p", "mrroc-hil-sim"];
    let mrroc = built(&[&["build", "--bins"], &bins[..]].concat(), "mrroc")?;
    let suite = built(
        &[
            "test",
            "-p",
            "mrroc-tests",
            "--test",
            "processes",
            "--no-run",
        ],
        "processes",
    )?;
    let binaries = mrroc.parent().context("a binary is in a folder")?;
    let job = Job {
        suite,
        binaries: binaries.to_path_buf(),
        arguments: arguments.to_vec(),
    };
    match place {
        Place::Here => job.here(),
        Place::Machine => job.in_machine(),
    }
}

/// The suite with its surroundings.
struct Job {
    suite: PathBuf,
    binaries: PathBuf,
    arguments: Vec<String>,
}

impl Job {
    fn environment(&self) -> [(&'static str, String); 3] {
        [
            (PRESENT, "1".into()),
            ("MRROC_BINARIES", self.binaries.display().to_string()),
            ("RUST_BACKTRACE", "1".into()),
        ]
    }

    /// Of the test harness: one at a time, since there is one bus, and everything told.
    fn arguments(&self) -> impl Iterator<Item = &str> {
        let always = ["--test-threads=1", "--nocapture"];
        let all = self.arguments.is_empty().then_some(SUITE);
        always
            .into_iter()
            .chain(all)
            .chain(self.arguments.iter().map(String::as_str))
    }

    fn here(&self) -> Result<Findings> {
        println!("on this kernel");
        let status = Command::new(&self.suite)
            .args(self.arguments())
            .envs(self.environment())
            .current_dir(root().join("tests"))
            .status()
            .context("cannot start the suite")?;
        Ok(judge(&status.to_string(), status.success()))
    }

    fn in_machine(&self) -> Result<Findings> {
        let folder = root().join("target/vcan");
        fs::create_dir_all(&folder).context("target/vcan")?;
        let status = folder.join("status");
        if status.exists() {
            fs::remove_file(&status).context("target/vcan/status")?;
        }
        fs::write(folder.join("go"), self.script()).context("target/vcan/go")?;
        let library = host_library(&folder)?;
        println!("on {KERNEL}");
        let mut machine = Command::new(KERNEL)
            .args([MEMORY, "root=/dev/root", "rootfstype=hostfs", "rootflags=/"])
            .args(["ro", "quiet", "con=null", "ssl=null", "con0=fd:0,fd:1"])
            .arg(format!("init={}", root().join("xtask/vcan/init").display()))
            .arg(format!("folder={}", folder.display()))
            .arg(format!("modules={MODULES}"))
            .env("LD_PRELOAD", library)
            .stdin(Stdio::null())
            // a group of its own: it has a process for each of its processes
            .process_group(0)
            .spawn()
            .with_context(|| format!("cannot start {KERNEL}"))?;
        if !wait(&mut machine)? {
            return Ok(vec![format!("ended after {} s", PATIENCE.as_secs())]);
        }
        match fs::read_to_string(&status) {
            Ok(code) => Ok(judge(
                &format!("exit status {}", code.trim()),
                code.trim() == "0",
            )),
            Err(_) => Ok(vec!["the machine ended without running the suite".into()]),
        }
    }

    /// What the machine runs.
    fn script(&self) -> String {
        let mut words = vec!["exec".to_owned(), "env".to_owned()];
        let pairs = self.environment();
        words.extend(
            pairs
                .iter()
                .map(|(name, value)| quoted(&format!("{name}={value}"))),
        );
        words.push(quoted(&self.suite.display().to_string()));
        words.extend(self.arguments().map(quoted));
        let tests = root().join("tests").display().to_string();
        format!("cd {}\n{}\n", quoted(&tests), words.join(" "))
    }
}

fn judge(status: &str, good: bool) -> Findings {
    if good {
        vec![]
    } else {
        vec![format!("the suite: {status}")]
    }
}

/// A word of a shell.
fn quoted(word: &str) -> String {
    format!("'{}'", word.replace('\'', r"'\''"))
}

/// Compiles what lies between the machine and the kernel below.
fn host_library(folder: &Path) -> Result<PathBuf> {
    let library = folder.join("host.so");
    let status = Command::new("cc")
        .args(["-O2", "-Wall", "-Werror", "-shared", "-fPIC", "-o"])
        .arg(&library)
        .arg(root().join("xtask/vcan/host.c"))
        .status()
        .context("cannot start cc")?;
    ensure!(status.success(), "cc xtask/vcan/host.c: {status}");
    Ok(library)
}

/// Waits for the machine's end; `false` if it was ended because it takes too long.
fn wait(machine: &mut Child) -> Result<bool> {
    let begun = Instant::now();
    loop {
        if machine.try_wait().context("the machine")?.is_some() {
            println!("{:.1} s", begun.elapsed().as_secs_f64());
            std::io::stdout().flush()?;
            return Ok(true);
        }
        if begun.elapsed() > PATIENCE {
            let group = format!("-{}", machine.id());
            Command::new("kill")
                .args(["-KILL", "--", &group])
                .status()?;
            machine.wait()?;
            return Ok(false);
        }
        thread::sleep(LOOK);
    }
}

#[cfg(test)]
mod test {
    use super::*;

    #[test]
    fn a_word_stays_one_word_whatever_is_in_it() {
        for word in ["plain", "two words", "it's", "$HOME `x` \\ \"", ""] {
            let output = Command::new("sh")
                .args(["-c", &format!("printf %s {}", quoted(word))])
                .output()
                .unwrap();
            assert_eq!(String::from_utf8(output.stdout).unwrap(), word);
        }
    }

    #[test]
    fn the_script_runs_the_suite_in_its_folder_and_says_that_it_must() {
        let job = Job {
            suite: "/t/deps/vcan-1".into(),
            binaries: "/t".into(),
            arguments: vec!["unplug".into()],
        };
        let script = job.script();
        assert!(script.starts_with("cd '"), "{script}");
        assert!(
            script.contains("'MRROC_ON_VCAN=1' 'MRROC_BINARIES=/t'"),
            "{script}"
        );
        let end = "'/t/deps/vcan-1' '--test-threads=1' '--nocapture' 'unplug'\n";
        assert!(script.ends_with(end), "{script}");
    }

    #[test]
    fn a_bad_end_is_told() {
        assert!(judge("exit status 0", true).is_empty());
        assert_eq!(
            judge("exit status 101", false),
            ["the suite: exit status 101"]
        );
    }
}
