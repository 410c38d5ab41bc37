//! Runs a task: the loop that couples the Master Process with the world, and the report.

use crate::observe::{Engraving, Following, Observers};
use crate::record::Recorder;
use crate::report::Reporter;
use crate::world::{Remote, Virtual, World};
use bus::spec::BusSpec;
use hil_sim::fault::FaultSpec;
use host::error::{Error, exit};
use host::mp::config::Config;
use host::plot::{self, Picture, StepMark};
use host::program::{Progress, Run, RunError, RunStatus, config_of};
use host::record::{About, MasterStep};
use host::summary::{BusSummary, Called, MachinePart, RobotSummary, StepSummary, Summary};
use host::task::{Cell, Task};
use protocol::id::NodeId;
use protocol::message::{ServoLaw, StopKind};
use protocol::time::Micros;
use protocol::transfer::Mtu;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// Set by Ctrl-C and by a request to end.
static INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// Make Ctrl-C a request to stop on the path instead of the end of this process.
pub(crate) fn catch_interrupt() -> Result<(), Error> {
    ctrlc::set_handler(|| INTERRUPTED.store(true, Ordering::Relaxed))
        .map_err(|e| Error::Internal(format!("cannot catch Ctrl-C: {e}")))
}

/// Was Ctrl-C pressed?
pub(crate) fn interrupted() -> bool {
    INTERRUPTED.load(Ordering::Relaxed)
}

/// How a task is run and reported.
#[derive(Debug)]
pub(crate) struct Options {
    pub(crate) bus: BusSpec,
    pub(crate) realtime: bool,
    pub(crate) record: Option<Record>,
    pub(crate) plots: Vec<PathBuf>,
    pub(crate) json: bool,
    pub(crate) quiet: bool,
    /// What breaks when, in a simulation.
    pub(crate) faults: Vec<FaultSpec>,
}

/// A record that is asked for.
#[derive(Debug)]
pub(crate) struct Record {
    pub(crate) path: PathBuf,
    /// The arguments of this process.
    pub(crate) arguments: Vec<String>,
    /// What was read for them.
    pub(crate) files: BTreeMap<PathBuf, String>,
}

/// A run that ended by itself, as it should or not.
#[derive(Debug)]
pub(crate) struct Finished {
    pub(crate) summary: Summary,
    pub(crate) exit_code: u8,
}

/// The MP's step: one macrostep of 20 ms under tight coordination, and simply always.
pub(crate) const MACROSTEP: Micros = Micros::from_millis(20);

/// Connect to the robots of a cell.
fn connect(
    cell: &Cell,
    nodes: &[NodeId],
    seed: u64,
    options: &Options,
) -> Result<Box<dyn World>, Error> {
    Ok(match &options.bus {
        BusSpec::Virtual => {
            crate::load::check(cell)?;
            let mut world = Virtual::new(cell, nodes, seed, options.realtime)?;
            world.plan_faults(cell, &options.faults)?;
            Box::new(world)
        }
        BusSpec::Place(_) if !options.faults.is_empty() => {
            return Err(Error::Usage {
                what: "--fault breaks what is simulated in this process".into(),
                expected: "--bus virtual, or --fault of mrroc-hil-sim".into(),
                got: "robots at the other end of a bus".into(),
            });
        }
        BusSpec::Place(place) => Box::new(Remote::connect(place)?),
    })
}

/// Run a task to its end. `path` is its file, for messages.
pub(crate) fn run(task: Task, path: Option<&Path>, options: &Options) -> Result<Finished, Error> {
    for plot in &options.plots {
        plot::check_name(plot)?;
        check_directory(plot)?;
    }
    let (cell, seed, title) = (task.cell.clone(), task.seed, task.title.clone());
    let config = config_of(&cell)
        .ok_or_else(|| Error::Internal("the cell has more robots than numbers".into()))?;
    let nodes: Vec<NodeId> = config.robots.iter().map(|robot| robot.node).collect();
    let mut world = connect(&cell, &nodes, seed, options)?;
    let mtu = world.mtu();
    let mut run = coordinated(task, path, config, mtu)?;
    let recorder = options.record.as_ref().map(|record| {
        let names = world.buses().into_iter().map(|(name, _)| name);
        record.begin(names.collect(), mtu, &cell)
    });
    let plot = !options.plots.is_empty();
    let mut observers = Observers::new(run.mp().robots(), recorder.transpose()?, plot);
    if world.knows_mechanics() {
        observers.watch_board(&cell)?;
    }
    let mut reporter = Reporter::new(options.quiet || options.json);
    let started = Instant::now();
    let begun = world.now();
    let mut log = StepLog::default();
    let mut faults = vec![0_u64; run.mp().robots().len()];
    let outcome = couple(
        &mut *world,
        &mut run,
        &mut observers,
        |run, now, progress| {
            log.note(now, progress);
            reporter.progress(run, now, progress);
            if let Progress::Robot(event) = progress
                && let host::mp::event::What::Fault { robot, .. } = event.what
                && let Some(count) = faults.get_mut(robot)
            {
                *count += 1;
            }
        },
    );
    observers.close()?;
    let failure = outcome?;
    let duration_s = world.now().since(begun).as_secs_f64();
    if !options.plots.is_empty() {
        let picture = match &observers.engraving {
            Some(engraving) => engraving.picture(&title),
            None => Picture::from(&observers.plot(title.clone(), log.marks())),
        };
        for plot in &options.plots {
            plot::save(&picture, plot)?;
        }
    }
    let summary = Summary {
        ok: failure.is_none(),
        error: failure.as_ref().map(ToString::to_string),
        title,
        duration_s,
        machine: MachinePart {
            called: world.lateness().cloned().map(Called),
            ..MachinePart::measured(duration_s, started.elapsed().as_secs_f64())
        },
        seed,
        robots: robots(&cell, &observers, &faults, world.knows_mechanics()),
        buses: buses(&*world, world.now().since(begun)),
        steps: log.finish(world.now(), failure.is_none(), &observers),
        engraving: observers.engraving.as_ref().map(Engraving::summary),
    };
    Ok(Finished {
        summary,
        exit_code: failure.map_or(exit::OK, |e| e.exit_code()),
    })
}

impl Record {
    fn begin(&self, buses: Vec<String>, mtu: Mtu, cell: &Cell) -> Result<Recorder, Error> {
        let about = About {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            arguments: self.arguments.clone(),
            mtu,
            buses,
            files: self.files.clone(),
        };
        let robots = cell.robots.iter();
        let robots: Vec<_> = robots
            .map(|robot| (robot.name.clone(), robot.axes()))
            .collect();
        Recorder::create(&self.path, about, &robots)
    }
}

/// The Master Process of a task on a bus whose frames are at most so long.
pub(crate) fn coordinated(
    task: Task,
    path: Option<&Path>,
    mut config: Config,
    mtu: Mtu,
) -> Result<Run, Error> {
    fit(&mut config, mtu);
    let nonce = u32::try_from(task.seed & 0xFFFF_FFFF).unwrap_or(0);
    Run::new(task, path.map(Path::to_owned), config, nonce)
        .map_err(|e| Error::Internal(e.to_string()))
}

/// Frames no longer than the bus carries, and as much traffic as it has room for.
fn fit(config: &mut Config, bus: Mtu) {
    if bus == Mtu::Classic {
        config.mtu = Mtu::Classic;
    }
    config.trace_every = u16::from(config.mtu == Mtu::Fd);
}

/// A picture is written when everything is over; that its directory is missing is told before.
fn check_directory(path: &Path) -> Result<(), Error> {
    let directory = path.parent().filter(|d| !d.as_os_str().is_empty());
    match directory {
        Some(directory) if !directory.is_dir() => {
            Err(Error::create(path, std::io::ErrorKind::NotFound.into()))
        }
        _ => Ok(()),
    }
}

/// Couple the run with the world until it ends; Ctrl-C stops it on the path.
fn couple(
    world: &mut dyn World,
    run: &mut Run,
    observers: &mut Observers,
    mut tell: impl FnMut(&Run, Micros, &Progress),
) -> Result<Option<RunError>, Error> {
    let mut rx = Vec::new();
    let mut tx = Vec::new();
    let mut stopped = false;
    loop {
        let now = world.now();
        let stop = interrupted() && !stopped;
        let received = u32::try_from(rx.len()).unwrap_or(u32::MAX);
        observers.master_steps(now, MasterStep { received, stop });
        if stop {
            stopped = true;
            run.stop(StopKind::Path, now, &mut |frame| tx.push(frame));
        }
        let status = run.step(now, rx.drain(..), &mut |frame| tx.push(frame));
        for frame in tx.drain(..) {
            world.send(&frame)?;
        }
        for robot in 0..run.mp().robots().len() {
            observers.set_segment(robot, run.segment(robot));
        }
        for progress in run.progress() {
            tell(run, now, &progress);
        }
        match status {
            RunStatus::Running => {}
            RunStatus::Done => return Ok(None),
            RunStatus::Failed(error) => return Ok(Some(error)),
        }
        world.pass(now + MACROSTEP, observers, &mut rx)?;
    }
}

/// When the steps began and ended.
#[derive(Debug, Default)]
struct StepLog {
    steps: Vec<(String, Micros, Option<Micros>)>,
}

impl StepLog {
    fn note(&mut self, now: Micros, progress: &Progress) {
        match progress {
            Progress::StepBegan { name, .. } => self.steps.push((name.clone(), now, None)),
            Progress::StepEnded { .. } => {
                if let Some((_, _, end)) = self.steps.last_mut() {
                    *end = Some(now);
                }
            }
            _ => {}
        }
    }

    fn marks(&self) -> Vec<StepMark> {
        let mark = |(name, begin, _): &(String, Micros, _)| StepMark {
            time_s: begin.as_secs_f64(),
            name: name.clone(),
        };
        self.steps.iter().map(mark).collect()
    }

    fn finish(self, now: Micros, ok: bool, observers: &Observers) -> Vec<StepSummary> {
        let paths = || observers.robots.iter().flat_map(|robot| &robot.paths);
        let summary = |(name, begin, end): (String, Micros, Option<Micros>)| StepSummary {
            name,
            start_s: begin.as_secs_f64(),
            duration_s: end.unwrap_or(now).since(begin).as_secs_f64(),
            ok: end.is_some() || ok,
            path: paths()
                .find(|path| {
                    let within = |at| begin <= at && at <= end.unwrap_or(now);
                    path.begun.is_some_and(within)
                })
                .map(Following::summary),
        };
        self.steps.into_iter().map(summary).collect()
    }
}

fn robots(
    cell: &Cell,
    observers: &Observers,
    faults: &[u64],
    mechanics: bool,
) -> Vec<RobotSummary> {
    let each = observers.robots.iter().zip(&cell.robots).zip(faults);
    each.map(|((watched, spec), faults)| {
        let errors = &watched.following_error_rad;
        let worst = (1..).zip(errors.iter().copied());
        let worst = worst.fold((0, 0.0), |a, b| if b.1 > a.1 { b } else { a });
        let feedback = watched.feedback.as_ref();
        RobotSummary {
            name: spec.name.clone(),
            kind: spec.kind.name().into(),
            servo: servo_name(spec.servo).into(),
            servo_step_s: f64::from(watched.arm.servo_step_us()) * 1e-6,
            servo_steps: feedback.map_or(0, |f| u64::from(f.step)),
            limit_violations: feedback.map_or(0, |f| u64::from(f.limit_violations)),
            faults: *faults,
            following_error_max: worst.1,
            following_error_axis: worst.0,
            following_error_max_rad: errors.clone(),
            setpoint_path_error_max_m: watched.setpoint_error_m,
            actual_path_error_max_m: watched.actual_error_m.filter(|_| mechanics),
        }
    })
    .collect()
}

/// The name of a servo law in task files.
pub(crate) const fn servo_name(law: ServoLaw) -> &'static str {
    match law {
        ServoLaw::DrivePosition => "drive-position",
        ServoLaw::Original => "original",
        ServoLaw::FeedForward => "feed-forward",
        ServoLaw::ComputedTorque => "computed-torque",
    }
}

#[expect(clippy::cast_precision_loss, reason = "nanoseconds of a run")]
fn buses(world: &dyn World, span: Micros) -> Vec<BusSummary> {
    let span_ns = span.0.saturating_mul(1000);
    let whole = world.sees_whole_buses();
    let each = world.buses().into_iter();
    each.map(|(name, s)| BusSummary {
        name,
        frames: s.frames,
        load_mean: whole.then(|| s.load_mean(span_ns)),
        load_max: whole.then(|| s.load_max()),
        load_window_s: bus::wire::LOAD_WINDOW_NS as f64 * 1e-9,
        latency_max_s: whole.then_some(s.worst_latency_ns as f64 * 1e-9),
    })
    .collect()
}

#[cfg(test)]
mod test {
    use super::*;
    use host::task::BusSpec as CellBus;
    use robots::RobotKind;

    #[test]
    fn frames_are_as_long_as_both_the_cell_and_its_bus_allow() {
        let (fd, classic) = (CellBus::fd("mp"), CellBus::classic("mp"));
        for (described, real, mtu) in [
            (&fd, Mtu::Fd, Mtu::Fd),
            (&fd, Mtu::Classic, Mtu::Classic),
            (&classic, Mtu::Fd, Mtu::Classic),
            (&classic, Mtu::Classic, Mtu::Classic),
        ] {
            let mut cell = Cell::of(&[RobotKind::Irp6Postument]);
            let number = cell.robots[0].mp_bus;
            cell.buses[number] = described.clone();
            let mut config = config_of(&cell).unwrap();
            fit(&mut config, real);
            assert_eq!(config.mtu, mtu, "{described:?} {real:?}");
            // a classical bus has no room for every demand
            assert_eq!(config.trace_every, u16::from(mtu == Mtu::Fd));
        }
    }
}
