//! The controller node on an emulated microcontroller, in the loop with the simulated world: started by
//! `cargo xtask hil-qemu`, which builds the image.

use host::task::Task;
use mrroc_tests::emulator::machine::{self, Setup};
use mrroc_tests::emulator::node::{EmulatedNode, Life};
use mrroc_tests::emulator::{tape, traces};
use mrroc_tests::{digest, job, workspace};
use robots::RobotKind;
use std::path::PathBuf;
use std::process::ExitCode;

/// Its node is the emulated one.
const KIND: RobotKind = RobotKind::Irp6Postument;

fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1);
    let (Some(what), Some(image)) = (arguments.next(), arguments.next()) else {
        eprintln!("hil-qemu: expected: traces|task IMAGE [COUNT|TASK]");
        return ExitCode::from(64);
    };
    let image = PathBuf::from(image);
    let Some(image) = image.canonicalize().ok().filter(|i| machine::is_image(i)) else {
        eprintln!("hil-qemu: {}: not an image", image.display());
        return ExitCode::from(66);
    };
    let setup = Setup {
        image,
        plugin: None,
    };
    let done = match what.as_str() {
        "traces" => compare_traces(&setup, arguments.next().and_then(|n| n.parse().ok())),
        "task" => closed_loop(&setup, arguments.next()),
        other => Err(format!("unknown: {other}")),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("hil-qemu: {error}");
            ExitCode::FAILURE
        }
    }
}

/// Lives of the node in this process, replayed into the image.
fn compare_traces(setup: &Setup, count: Option<u64>) -> Result<(), String> {
    let count = count.unwrap_or(100);
    let (mut steps, mut frames) = (0, 0);
    for seed in 0..count {
        let tape = traces::live(KIND, seed);
        frames += tape.steps.iter().map(|step| step.sent.len()).sum::<usize>();
        let life = tape::replay(&tape, setup).map_err(|error| format!("trace {seed}: {error}"))?;
        steps += life.steps;
    }
    println!("{count} traces of 2 s: {steps} steps, {frames} frames sent, every one the same");
    Ok(())
}

/// A task with this node in this process, and with the emulated one, twice: the same record.
fn closed_loop(setup: &Setup, task: Option<String>) -> Result<(), String> {
    let path = task.map_or_else(|| workspace().join("tasks/two-arms.toml"), PathBuf::from);
    let task = Task::load(&path).map_err(|error| error.to_string())?;
    let mut record = digest::Record::default();
    let (error, _) = job::run(task.clone(), &mut record);
    if let Some(error) = error {
        return Err(error.to_string());
    }
    println!("in this process: {} frames, record {:016x}", record.frames, record.value());
    let first = emulated(setup, task.clone(), record.value())?;
    let second = emulated(setup, task, record.value())?;
    if first.cycles != second.cycles || first.ending.log != second.ending.log {
        return Err(format!(
            "the image's own time differs between two runs: {} and {} cycles",
            first.cycles, second.cycles
        ));
    }
    Ok(())
}

fn emulated(setup: &Setup, task: Task, wanted: u64) -> Result<Life, String> {
    let mut record = digest::Record::default();
    let mut handle = Err("the task has no such robot".to_owned());
    let begun = std::time::Instant::now();
    let (error, cell) = job::run_with(task, &mut record, &mut |boot| {
        (boot.kind == KIND).then(|| match EmulatedNode::boot(setup, boot) {
            Ok((node, link)) => {
                handle = Ok(link);
                Box::new(node) as Box<_>
            }
            Err(error) => {
                handle = Err(error.to_string());
                mrroc_tests::emulator::node::in_process(boot).expect("a node").0
            }
        })
    });
    let life = handle?.finish()?;
    println!(
        "emulated: {} steps, {} frames, record {:016x}, {} cycles of its own, {:.1} s simulated in {:.1} s",
        life.steps,
        record.frames,
        record.value(),
        life.cycles,
        cell.now().as_secs_f64(),
        begun.elapsed().as_secs_f64(),
    );
    if let Some(error) = error {
        return Err(error.to_string());
    }
    if record.value() != wanted {
        return Err("the record differs from that of the node in this process".into());
    }
    Ok(life)
}
