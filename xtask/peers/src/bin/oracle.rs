//! What Ruckig says: a line of JSON for each case.
//!
//! ```text
//! cargo run --release --bin oracle -- --class S --count 100000 --seed 1 --axes 1
//! cargo run --release --bin oracle -- --class E --first 4711 --count 1 --phases
//! ```

use clap::Parser;
use clap::builder::PossibleValuesParser;
use clap::builder::TypedValueParser as _;
use peers::apart::{self, Apart};
use peers::case::Case;
use peers::class::Class;
use peers::plan::{Outcome, Phase};
use peers::with_axes;
use serde_json::{Value, json};
use std::io::{self, BufWriter, Write};
use std::path::Path;
use std::process::ExitCode;

/// What Ruckig says, a line of JSON for each case
#[derive(Parser)]
struct Arguments {
    /// Class of the cases: R, T, S, N, H or E
    #[arg(long)]
    class: Class,
    /// How many
    #[arg(long, default_value_t = 1000)]
    count: u64,
    /// The number of the first
    #[arg(long, default_value_t = 0)]
    first: u64,
    /// Seed of the generator
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Number of axes
    #[arg(long, default_value = "1", value_parser = PossibleValuesParser::new(["1", "2", "3", "6", "7"])
        .map(|text| text.parse::<usize>().unwrap_or_default()))]
    axes: usize,
    /// Say the phases too: `[t, j, a0, v0, p0]` of each, for each axis
    #[arg(long)]
    phases: bool,
}

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        // whoever reads has had enough
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("oracle: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run() -> io::Result<()> {
    if apart::serve()? {
        return Ok(());
    }
    let arguments = Arguments::parse();
    let program = std::env::current_exe()?;
    with_axes!(arguments.axes, N => answer::<N>(&program, &arguments))
}

fn answer<const N: usize>(program: &Path, arguments: &Arguments) -> io::Result<()> {
    let Arguments { class, seed, .. } = *arguments;
    let mut out = BufWriter::new(io::stdout().lock());
    let cases = arguments.first..arguments.first.saturating_add(arguments.count);
    let mut ruckig = Apart::new(program, class, seed, N, cases.clone());
    for index in cases {
        let mut line = question::<N>(class, index, &class.case(seed, index));
        line["ruckig"] = said(&ruckig.ask_next()?, arguments.phases);
        writeln!(out, "{line}")?;
    }
    out.flush()
}

fn question<const N: usize>(class: Class, index: u64, case: &Case<N>) -> Value {
    let each = |of: fn(&peers::case::Axis) -> f64| case.iter().map(of).collect::<Vec<_>>();
    json!({
        "class": class.letter(), "index": index,
        "p0": each(|x| x.p0), "v0": each(|x| x.v0), "a0": each(|x| x.a0),
        "p1": each(|x| x.p1), "v1": each(|x| x.v1), "a1": each(|x| x.a1),
        "v_min": each(|x| x.v_min), "v_max": each(|x| x.v_max),
        "a_min": each(|x| x.a_min), "a_max": each(|x| x.a_max), "j_max": each(|x| x.j_max),
    })
}

fn said(outcome: &Outcome, phases: bool) -> Value {
    let list = |phase: &Phase| [phase.t, phase.j, phase.a0, phase.v0, phase.p0];
    match outcome {
        Outcome::Planned(plan) if phases => json!({
            "duration": plan.duration,
            "phases": plan.axes.iter()
                .map(|axis| axis.iter().map(list).collect())
                .collect::<Vec<Vec<_>>>(),
        }),
        Outcome::Planned(plan) => json!({ "duration": plan.duration }),
        Outcome::Refused(why) | Outcome::Failed(why) => json!({ "error": why }),
    }
}
