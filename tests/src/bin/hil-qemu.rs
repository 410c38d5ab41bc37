//! The controller node on an emulated microcontroller, in the loop with the simulated world: started by
//! `cargo xtask hil-qemu`, which builds the image and the plugin.

use clap::Parser;
use host::input::Files;
use host::task::Task;
use mrroc_tests::emulator::elf::Image;
use mrroc_tests::emulator::golden::{self, Figure};
use mrroc_tests::emulator::machine::{self, Setup};
use mrroc_tests::emulator::mailbox::RealTimeNode;
use mrroc_tests::emulator::node::{EmulatedNode, Life, in_process};
use mrroc_tests::emulator::{cost, log, tape, traces};
use mrroc_tests::{digest, job, workspace};
use protocol::message::{NodeState, ServoLaw};
use robots::RobotKind;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Its node is the emulated one.
const KIND: RobotKind = RobotKind::Irp6Postument;
/// The laws whose cost is measured: position in the drive, and the loop closed on the node.
const LAWS: [(&str, ServoLaw); 3] = [
    ("csp", ServoLaw::DrivePosition),
    ("cst", ServoLaw::FeedForward),
    ("torque", ServoLaw::ComputedTorque),
];
/// What is carried out in real time each time: 42 s of it.
const EXCERPT: &str = "tests/data/two-arms-short.toml";
/// Flash and RAM that an image may take, and the stack of a servo step.
const FLASH: u64 = 256 * 1024;
const RAM: u64 = 64 * 1024;
const STACK: u64 = 4 * 1024;

/// Compares the emulated node with the one in this process, and measures it.
#[derive(Debug, Parser)]
struct Args {
    /// The image
    image: PathBuf,
    /// The plugin that counts instructions
    #[arg(long)]
    plugin: PathBuf,
    /// The accepted figures
    #[arg(long)]
    golden: PathBuf,
    /// Accept the figures
    #[arg(long)]
    bless: bool,
    /// How many traces of 2 s
    #[arg(long, default_value_t = 100)]
    traces: u64,
    /// The task that is carried out
    #[arg(long)]
    task: Option<PathBuf>,
    /// The task in real time by the mailbox, and nothing else
    #[arg(long)]
    real_time: bool,
    /// Print the log of the image
    #[arg(long)]
    log: bool,
}

fn main() -> ExitCode {
    match run(&Args::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("hil-qemu: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(args: &Args) -> Result<(), String> {
    let image = args
        .image
        .canonicalize()
        .ok()
        .filter(|i| machine::is_image(i));
    let image = image.ok_or_else(|| format!("{}: not an image", args.image.display()))?;
    let setup = Setup {
        image,
        plugin: None,
    };
    if args.real_time {
        return real_time(&setup, task(args)?);
    }
    real_time(&setup, load(&workspace().join(EXCERPT))?)?;
    let made_of = Image::read(&setup.image)?;
    made_of.examine()?;
    compare_traces(&setup, args.traces)?;
    let life = closed_loop(&setup, args)?;
    let mut figures = vec![
        Figure::new("flash_bytes", made_of.flash, 3).at_most(FLASH),
        Figure::new("ram_bytes_without_stack", made_of.ram, 0).at_most(RAM),
    ];
    if let Some((largest, _)) = made_of.frames.first() {
        figures.push(Figure::new("largest_frame_bytes", *largest, 10));
    }
    let lines = log::lines(&setup.image, &life.ending.log)?;
    if args.log {
        for line in &lines {
            println!("image: {line}");
        }
    }
    let stacks = lines.iter().rev().find_map(|line| stacks_used(line));
    let (servo, rest) = stacks.ok_or("the image did not say how much stack it used")?;
    figures.push(Figure::new("stack_used_bytes", servo, 10).at_most(STACK));
    figures.push(Figure::new("stack_used_below_bytes", rest, 10));
    let stood = lines.iter().rev().find_map(|line| stood_still(line));
    let stood = stood.ok_or("the image did not say how long its time stood still")?;
    figures.push(Figure::new("ticks_stood_still", stood, 10).at_most(0));
    for law in LAWS {
        let (of_law, _) = cost::measure(KIND, law, &setup.image, &args.plugin)?;
        figures.extend(of_law);
    }
    figures.extend(cost::plans(KIND, &setup.image, &args.plugin)?);
    figures.extend(cost::interpolation(KIND, &setup.image, &args.plugin)?);
    golden::judge(&figures, &made_of.compiler, &args.golden, args.bless)
}

/// `stacks: 123 bytes for servo steps, 456 for the rest`
fn stacks_used(line: &str) -> Option<(u64, u64)> {
    let (servo, rest) = line
        .strip_prefix("stacks: ")?
        .split_once(" bytes for servo steps, ")?;
    let rest = rest.strip_suffix(" for the rest")?;
    Some((servo.parse().ok()?, rest.parse().ok()?))
}

/// `time stood still for 123 ticks`
fn stood_still(line: &str) -> Option<u64> {
    let ticks = line.strip_prefix("time stood still for ")?;
    ticks.strip_suffix(" ticks")?.parse().ok()
}

/// Lives of the node in this process, replayed into the image.
fn compare_traces(setup: &Setup, count: u64) -> Result<(), String> {
    let (mut steps, mut frames) = (0, 0);
    let mut states = BTreeMap::<String, u64>::new();
    for seed in 0..count {
        let tape = traces::live(KIND, seed);
        frames += tape.steps.iter().map(|step| step.sent.len()).sum::<usize>();
        for step in &tape.steps {
            *states.entry(format!("{:?}", step.state)).or_default() += 1;
        }
        let life = tape::replay(&tape, setup).map_err(|error| format!("trace {seed}: {error}"))?;
        steps += life.steps;
    }
    println!("{count} traces of 2 s: {steps} steps, {frames} frames sent, every one the same");
    println!("steps in each state: {states:?}");
    let missing = [NodeState::Moving, NodeState::Stopping, NodeState::Faulted]
        .into_iter()
        .find(|state| !states.contains_key(&format!("{state:?}")));
    match missing {
        Some(state) if count >= 50 => Err(format!("no trace was ever {state:?}")),
        _ => Ok(()),
    }
}

fn task(args: &Args) -> Result<Task, String> {
    let path = args.task.clone();
    load(&path.unwrap_or_else(|| workspace().join("tasks/two-arms.toml")))
}

fn load(path: &Path) -> Result<Task, String> {
    Task::load(path, &Files::on_disk()).map_err(|error| error.to_string())
}

/// The task with the emulated node in real time.
fn real_time(setup: &Setup, task: Task) -> Result<(), String> {
    let mut record = digest::Record::default();
    let mut outcome = Err("the task has no such robot".to_owned());
    let (error, _) = job::run_with(task, &mut record, &mut |boot| {
        (boot.kind == KIND).then(|| {
            let own = in_process(boot).expect("it was made before").0;
            match RealTimeNode::boot(&setup.image, boot, own.identity()) {
                Ok((node, of_node)) => {
                    outcome = Ok(of_node);
                    Box::new(node) as Box<_>
                }
                Err(error) => {
                    outcome = Err(error.to_string());
                    own
                }
            }
        })
    });
    let outcome = outcome?;
    let outcome = outcome.lock().map_err(|error| error.to_string())?.clone();
    println!(
        "real time: {} frames, {:.1} s of the image's clock in {:.1} s of the wall's, held for {:.1} s, frames lost to and from it: {:?}",
        record.frames, outcome.image_s, outcome.wall_s, outcome.held_s, outcome.lost
    );
    match (outcome.problem, error) {
        (Some(problem), _) => Err(problem),
        (None, Some(error)) => Err(error.to_string()),
        (None, None) if outcome.lost != [0, 0] => Err("frames were lost".into()),
        (None, None) => Ok(()),
    }
}

/// A task with this node in this process, and with the emulated one, twice: the same record.
fn closed_loop(setup: &Setup, args: &Args) -> Result<Life, String> {
    let task = task(args)?;
    let mut record = digest::Record::default();
    // with the capacities of the board
    let (error, _) = job::run_with(task.clone(), &mut record, &mut |boot| {
        (boot.kind == KIND).then(|| in_process(boot).expect("it was made before").0)
    });
    if let Some(error) = error {
        return Err(error.to_string());
    }
    println!(
        "in this process: {} frames, record {:016x}",
        record.frames,
        record.value()
    );
    let first = emulated(setup, task.clone(), record.value())?;
    let second = emulated(setup, task, record.value())?;
    if first.cycles != second.cycles || first.ending.log != second.ending.log {
        return Err(format!(
            "the image's own time differs between two runs: {} and {} cycles",
            first.cycles, second.cycles
        ));
    }
    Ok(first)
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
                in_process(boot).expect("it was made before").0
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
