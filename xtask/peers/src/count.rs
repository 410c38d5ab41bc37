//! Instructions, counted by callgrind around a copy of this program.

use crate::class::Class;
use crate::planner::Planner;
use crate::timing;
use std::io::{self, ErrorKind};
use std::path::Path;
use std::process::{Command, Stdio};

/// What the copy is asked for: one batch, planned once.
pub const ONCE: &str = "--once";

/// Instructions a call takes in a batch; nothing without valgrind.
///
/// # Errors
/// In words: valgrind failed, or counted nothing.
pub fn instructions(
    program: &Path,
    class: Class,
    seed: u64,
    axes: usize,
    planner: Planner,
) -> Result<Option<f64>, String> {
    let name = format!("mrroc-peers-{}-{planner}.callgrind", std::process::id());
    let file = std::env::temp_dir().join(name);
    let mut valgrind = Command::new("valgrind");
    valgrind
        .args(["-q", "--tool=callgrind", "--collect-atstart=no"])
        // the one function of each planner inside which measured work happens
        .arg("--toggle-collect=*measured_work*")
        .arg(format!("--callgrind-out-file={}", file.display()))
        .arg(program)
        .args([ONCE, planner.name(), "--classes", class.letter()])
        .args(["--seed", &seed.to_string(), "--axes", &axes.to_string()])
        .stdout(Stdio::null())
        .stderr(Stdio::null());
    match valgrind.status() {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(format!("valgrind: {error}")),
        Ok(status) if !status.success() => return Err(format!("valgrind: {status}")),
        Ok(_) => {}
    }
    let text = std::fs::read_to_string(&file).map_err(|e| format!("callgrind's file: {e}"))?;
    let _ = std::fs::remove_file(&file);
    let total = total(&text).ok_or("callgrind counted nothing")?;
    #[expect(clippy::cast_precision_loss, reason = "counts far below 2^53")]
    Ok(Some(total as f64 / timing::BATCH as f64))
}

/// The work to be counted: a batch planned once.
///
/// # Errors
/// As [`timing::cases`].
pub fn once<const N: usize>(
    program: &Path,
    class: Class,
    seed: u64,
    planner: Planner,
) -> io::Result<()> {
    let cases = timing::cases::<N>(program, class, seed)?;
    planner.batch(&cases).run();
    Ok(())
}

/// Instructions in a file of callgrind.
fn total(text: &str) -> Option<u64> {
    let line = text
        .lines()
        .find_map(|line| line.strip_prefix("totals: "))?;
    line.trim().parse().ok().filter(|count| *count > 0)
}

#[cfg(test)]
mod test {
    use super::total;

    #[test]
    fn the_count_is_the_total_of_the_file() {
        assert_eq!(
            total("summary: 1\nfn=x\n1 2\ntotals: 25094409\n"),
            Some(25_094_409)
        );
        assert_eq!(total("summary: 1\n"), None);
        assert_eq!(total("totals: 0\n"), None);
    }
}
