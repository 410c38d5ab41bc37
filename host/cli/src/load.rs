//! `mrroc bus load`: what the buses of a cell carry at worst, beside what a run measured.

pub(crate) mod traffic;

use crate::run::{Finished, Options, run};
use bus::spec::BusSpec;
use clap::{Args, Subcommand};
use host::error::Error;
use host::input::{Files, LoadError};
use host::program::config_of;
use host::summary::BusSummary;
use host::task::{Action, BusKind, Cell, Step, Task};
use process::exit;
use serde_json::{Value, json};
use std::io::Write;
use std::path::PathBuf;
use traffic::{LIMIT, Traffic};

/// The buses of a cell.
#[derive(Args, Debug)]
pub(crate) struct Bus {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand, Debug)]
enum Command {
    /// What every bus carries at worst, beside what a simulated homing of all robots measured.
    ///
    /// The worst case is the sum over all cyclic frames of their greatest length by their rate. A bus above
    /// 82 % of its capacity is refused when a task begins on simulated buses. The demands of the servo steps, which an FD bus carries
    /// besides, give way to everything else and do not count.
    Load(Load),
}

#[derive(Args, Debug)]
struct Load {
    /// A cell, or a task and its cell (.toml).
    file: PathBuf,
    /// Arithmetic only: run nothing.
    #[arg(long)]
    no_run: bool,
    /// Print one JSON value.
    #[arg(long)]
    json: bool,
}

impl Bus {
    /// Carries it out; the exit code: [`exit::OK`] if every bus has room for its traffic.
    pub(crate) fn run(&self, out: &mut impl Write) -> Result<u8, Error> {
        let Command::Load(load) = &self.command;
        let cell = Cell::load_any(&load.file, &Files::on_disk()).map_err(|error| match error {
            LoadError::Input(error) => Error::from(error),
            LoadError::Data(error) => Error::from(error),
        })?;
        let traffic = of(&cell)?;
        let measured = if load.no_run || !traffic.iter().all(Traffic::fits) {
            None
        } else {
            Some(measure(cell)?)
        };
        // a reader that has gone away changes nothing
        let _ = if load.json {
            writeln!(out, "{}", value(&traffic, measured.as_deref()))
        } else {
            print(out, &traffic, measured.as_deref())
        };
        Ok(if traffic.iter().all(Traffic::fits) {
            exit::OK
        } else {
            exit::DATA
        })
    }
}

fn of(cell: &Cell) -> Result<Vec<Traffic>, Error> {
    let config = config_of(cell)
        .ok_or_else(|| Error::Internal("the cell has more robots than numbers".into()))?;
    Ok(traffic::of(cell, &config))
}

/// Refuses a cell with a bus that has not enough room.
///
/// # Errors
/// Names the first such bus.
pub(crate) fn check(cell: &Cell) -> Result<(), Error> {
    match of(cell)?.iter().find(|traffic| !traffic.fits()) {
        None => Ok(()),
        Some(traffic) => Err(Error::Usage {
            what: format!("bus {}: its cyclic traffic at worst", traffic.bus.name),
            expected: format!("at most {:.0} % of it", LIMIT * 100.0),
            got: format!("{:.1} %; see mrroc bus load", traffic.worst() * 100.0),
        }),
    }
}

/// What a homing of all robots in a simulated cell makes of the buses.
fn measure(cell: Cell) -> Result<Vec<BusSummary>, Error> {
    let action = Action::Home {
        robots: (0..cell.robots.len()).collect(),
    };
    let name = action.describe(&cell);
    let step = Step {
        name: name.clone(),
        line: 0,
        action,
    };
    let task = Task {
        title: name,
        seed: 0,
        cell,
        steps: vec![step],
    };
    let options = Options {
        bus: BusSpec::Virtual,
        realtime: false,
        record: None,
        plots: Vec::new(),
        json: true,
        quiet: true,
        faults: Vec::new(),
    };
    let Finished { summary, .. } = run(task, None, &options)?;
    Ok(summary.buses)
}

/// What a run measured of a bus.
fn of_bus<'a>(measured: Option<&'a [BusSummary]>, name: &str) -> Option<&'a BusSummary> {
    measured?.iter().find(|bus| bus.name == name)
}

fn value(traffic: &[Traffic], measured: Option<&[BusSummary]>) -> Value {
    let buses = traffic.iter().map(|traffic| {
        let entries: Vec<Value> = traffic
            .entries
            .iter()
            .map(|entry| {
                json!({
                    "what": entry.what, "frames": entry.frames, "worst_ns": entry.worst_ns,
                    "period_ns": entry.period_ns, "share": entry.share(),
                    "gives_way": entry.gives_way,
                })
            })
            .collect();
        let run = of_bus(measured, &traffic.bus.name).map(|bus| {
            json!({
                "load_mean": bus.load_mean, "load_max": bus.load_max,
                "load_window_s": bus.load_window_s, "latency_max_s": bus.latency_max_s,
            })
        });
        json!({
            "name": traffic.bus.name, "bit_rate": traffic.bus.bit_rate,
            "data_bit_rate": data_bit_rate(traffic), "worst": traffic.worst(),
            "worst_of_all": traffic.whole(),
            "fits": traffic.fits(), "entries": entries, "measured": run,
        })
    });
    json!({"limit": LIMIT, "buses": buses.collect::<Vec<Value>>()})
}

fn data_bit_rate(traffic: &Traffic) -> Option<u32> {
    match traffic.bus.kind {
        BusKind::Classic => None,
        BusKind::Fd { data_bit_rate } => Some(data_bit_rate),
    }
}

#[expect(clippy::cast_precision_loss, reason = "nanoseconds of a cycle")]
fn print(
    out: &mut impl Write,
    traffic: &[Traffic],
    measured: Option<&[BusSummary]>,
) -> std::io::Result<()> {
    for traffic in traffic {
        let kind = match data_bit_rate(traffic) {
            None => "classical".to_owned(),
            Some(rate) => format!("FD, data {} kbit/s", rate / 1000),
        };
        writeln!(
            out,
            "{} ({kind}, {} kbit/s): {:.1} % at worst, {:.1} % with what gives way{}",
            traffic.bus.name,
            traffic.bus.bit_rate / 1000,
            traffic.worst() * 100.0,
            traffic.whole() * 100.0,
            if traffic.fits() {
                String::new()
            } else {
                format!(": more than {:.0} %", LIMIT * 100.0)
            }
        )?;
        for entry in &traffic.entries {
            writeln!(
                out,
                "  {:5.1} %  {:3} frames, {:7.1} us in {:6.1} ms  {}",
                entry.share() * 100.0,
                entry.frames,
                entry.worst_ns as f64 * 1e-3,
                entry.period_ns as f64 * 1e-6,
                entry.what
            )?;
        }
        if let Some(bus) = of_bus(measured, &traffic.bus.name)
            && let (Some(mean), Some(most), Some(latency)) =
                (bus.load_mean, bus.load_max, bus.latency_max_s)
        {
            writeln!(
                out,
                "  measured while homing: {:.1} % in the mean, {:.1} % in the busiest {:.0} ms, \
                 longest latency {:.0} us",
                mean * 100.0,
                most * 100.0,
                bus.load_window_s * 1e3,
                latency * 1e6
            )?;
        }
    }
    Ok(())
}
