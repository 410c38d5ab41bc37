//! The HIL suite over SocketCAN: `cargo xtask vcan`.
//!
//! The suite is `tests/tests/processes/vcan.rs`; after it strangers are on the bus, python-canopen of
//! `tests/strangers`, where there is a Python. It needs interfaces `vcan0` (CAN FD) and `vcan1` (classical),
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
use crate::strangers;
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
/// Tells strangers that time waits for whoever works: also what is slow may then ask for a cycle of 3 ms.
const TIME_WAITS: &str = "MRROC_TIME_WAITS";
/// Memory of the machine. It is taken as it is used.
const MEMORY: &str = "mem=1G";
/// It takes some six minutes; a machine that hangs is ended.
const PATIENCE: Duration = Duration::from_secs(1200);
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

/// Builds the suite and the processes under test, and runs it; all of it with what strangers have to say.
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
    let mut steps = vec![Step::suite(&suite, binaries, arguments)];
    let mut findings = vec![];
    if arguments.is_empty() {
        match strangers::tools() {
            Ok(Some(python)) => steps.push(Step::strangers(&python, binaries, &place)),
            Ok(None) => findings.extend(strangers::not_run(strangers::NO_PYTHON)),
            Err(error) => findings.extend(strangers::not_run(&format!("{error:#}"))),
        }
    }
    findings.extend(match place {
        Place::Here => here(&steps)?,
        Place::Machine => in_machine(&steps)?,
    });
    Ok(findings)
}

/// Something to run where the interfaces are.
struct Step {
    name: &'static str,
    folder: PathBuf,
    environment: Vec<(&'static str, String)>,
    words: Vec<String>,
}

impl Step {
    fn suite(suite: &Path, binaries: &Path, arguments: &[String]) -> Self {
        // of the test harness: one at a time, since there is one bus, and everything told
        let always = ["--test-threads=1", "--nocapture"].map(String::from);
        let all = arguments.is_empty().then(|| SUITE.to_owned());
        Self {
            name: "the suite",
            folder: root().join("tests"),
            environment: vec![
                (PRESENT, "1".into()),
                ("MRROC_BINARIES", binaries.display().to_string()),
                ("RUST_BACKTRACE", "1".into()),
            ],
            words: [suite.display().to_string()]
                .into_iter()
                .chain(always)
                .chain(all)
                .chain(arguments.iter().cloned())
                .collect(),
        }
    }

    fn strangers(python: &Path, binaries: &Path, place: &Place) -> Self {
        let mut environment = vec![
            (PRESENT, "1".into()),
            (strangers::PROGRAMS_IN, binaries.display().to_string()),
            (strangers::NO_BYTECODE, "1".into()),
        ];
        if matches!(place, Place::Machine) {
            environment.push((TIME_WAITS, "1".into()));
        }
        let words = ["-m", "unittest", "--verbose", strangers::ON_VCAN];
        Self {
            name: "strangers",
            folder: root().join(strangers::TESTS),
            environment,
            words: [python.display().to_string()]
                .into_iter()
                .chain(words.map(String::from))
                .collect(),
        }
    }

    fn run(&self) -> Result<bool> {
        let mut words = self.words.iter();
        let program = words.next().context("a step without a program")?;
        let status = Command::new(program)
            .args(words)
            .envs(self.environment.iter().map(|(name, value)| (name, value)))
            .current_dir(&self.folder)
            .status()
            .with_context(|| format!("cannot start {program}"))?;
        Ok(status.success())
    }

    /// The same for a shell.
    fn script(&self) -> String {
        let pairs = self.environment.iter();
        let pairs = pairs.map(|(name, value)| format!("{name}={value}"));
        let words: Vec<String> = pairs
            .chain(self.words.iter().cloned())
            .map(|word| quoted(&word))
            .collect();
        let folder = quoted(&self.folder.display().to_string());
        format!("(cd {folder} && exec env {})", words.join(" "))
    }
}

fn here(steps: &[Step]) -> Result<Findings> {
    println!("on this kernel");
    let mut failed = 0;
    for (k, step) in steps.iter().enumerate() {
        failed |= u32::from(!step.run()?) << k;
    }
    Ok(judge(steps, failed))
}

fn in_machine(steps: &[Step]) -> Result<Findings> {
    let folder = root().join("target/vcan");
    fs::create_dir_all(&folder).context("target/vcan")?;
    let status = folder.join("status");
    if status.exists() {
        fs::remove_file(&status).context("target/vcan/status")?;
    }
    fs::write(folder.join("go"), script(steps)).context("target/vcan/go")?;
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
    let failed = fs::read_to_string(&status).ok();
    Ok(match failed.and_then(|code| code.trim().parse().ok()) {
        Some(failed) => judge(steps, failed),
        None => vec!["the machine ended without running the suite".into()],
    })
}

/// What the machine runs, whatever of it fails; its exit status has a bit for each step that did.
fn script(steps: &[Step]) -> String {
    let all: Vec<String> = (0..)
        .zip(steps)
        .map(|(k, step)| format!("{} || failed=$((failed + {}))\n", step.script(), 1 << k))
        .collect();
    format!("failed=0\n{}exit $failed\n", all.concat())
}

/// `failed`: bit k for step k. Other bits are of a shell that could not go on.
fn judge(steps: &[Step], failed: u32) -> Findings {
    let of_steps = steps
        .iter()
        .enumerate()
        .filter(|(k, _)| failed >> k & 1 == 1);
    let mut findings: Findings = of_steps
        .map(|(_, step)| format!("{} failed", step.name))
        .collect();
    if failed >> steps.len() != 0 {
        findings.push(format!("exit status {failed}"));
    }
    findings
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

    fn steps(arguments: &[&str], place: &Place) -> [Step; 2] {
        let arguments: Vec<String> = arguments.iter().map(ToString::to_string).collect();
        let binaries = Path::new("/t");
        [
            Step::suite(Path::new("/t/deps/vcan-1"), binaries, &arguments),
            Step::strangers(Path::new("/v/python"), binaries, place),
        ]
    }

    #[test]
    fn the_script_runs_the_suite_in_its_folder_and_says_that_it_must() {
        let [suite, _] = steps(&["unplug"], &Place::Machine);
        let script = script(&[suite]);
        assert!(script.starts_with("failed=0\n(cd '"), "{script}");
        assert!(
            script.contains("'MRROC_ON_VCAN=1' 'MRROC_BINARIES=/t'"),
            "{script}"
        );
        let end = "'/t/deps/vcan-1' '--test-threads=1' '--nocapture' 'unplug') || \
                   failed=$((failed + 1))\nexit $failed\n";
        assert!(script.ends_with(end), "{script}");
    }

    #[test]
    fn only_in_the_machine_strangers_hear_that_time_waits() {
        for (place, waits) in [(Place::Here, false), (Place::Machine, true)] {
            let [_, strangers] = steps(&[], &place);
            let script = strangers.script();
            assert!(
                script.contains("'MRROC_ON_VCAN=1' 'MRROC_BIN=/t'"),
                "{script}"
            );
            assert_eq!(script.contains(TIME_WAITS), waits, "{script}");
        }
    }

    #[test]
    fn what_fails_is_told_by_its_name_and_the_rest_runs() {
        let step = |name, word: &str| Step {
            name,
            folder: "/".into(),
            environment: vec![("WORD", word.into())],
            words: ["sh", "-c", "test $WORD = good"].map(String::from).into(),
        };
        for (words, expected) in [
            (["good", "good"], vec![]),
            (["bad", "good"], vec!["a failed"]),
            (["good", "bad"], vec!["b failed"]),
            (["bad", "bad"], vec!["a failed", "b failed"]),
        ] {
            let steps = [step("a", words[0]), step("b", words[1])];
            assert_eq!(here(&steps).unwrap(), expected);
            let shell = Command::new("sh")
                .args(["-c", &script(&steps)])
                .status()
                .unwrap();
            let failed = u32::try_from(shell.code().unwrap()).unwrap();
            assert_eq!(judge(&steps, failed), expected);
        }
        assert_eq!(judge(&[step("a", "good")], 2), ["exit status 2"]);
    }
}
