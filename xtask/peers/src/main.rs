//! Compares the planners: `cargo xtask bench-motion` builds and runs this.

use clap::builder::{PossibleValuesParser, TypedValueParser as _};
use clap::{Parser, ValueEnum};
use peers::class::Class;
use peers::planner::Planner;
use peers::report::{About, CostRow, Report, SampleRow, cpu, json::json, markdown::markdown};
use peers::{apart, correctness, count, goal, timing, with_axes};
use std::error::Error;
use std::path::Path;
use std::process::ExitCode;

/// Numbers of axes for which cost is measured in the classes R and T; only 7 in the others.
const COST_AXES: [usize; 4] = [1, 3, 6, goal::AXES];

/// The motion planner beside Ruckig and rsruckig: correctness and cost
#[derive(Parser)]
#[command(name = "bench-motion")]
struct Arguments {
    /// Cases of each class whose plans are judged
    #[arg(long, default_value_t = 20_000)]
    cases: u64,
    /// Which classes: R rest to rest, T any state to rest, S any to any, N near the target, H high
    /// limits, E exact and degenerate
    #[arg(long, value_delimiter = ',', default_values_t = Class::ALL)]
    classes: Vec<Class>,
    /// Seed of the generator
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Number of axes of the cases that are judged
    #[arg(long, default_value = "7", value_parser = PossibleValuesParser::new(["1", "2", "3", "6", "7"])
        .map(|text| text.parse::<usize>().unwrap_or_default()))]
    axes: usize,
    /// Only one part
    #[arg(long)]
    only: Option<Part>,
    /// Print one JSON object instead of Markdown tables
    #[arg(long)]
    json: bool,
    /// Plan a batch of the class with a planner, once: what an instrument around this looks at
    #[arg(long, hide = true)]
    once: Option<Planner>,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Part {
    /// The plans of very many cases, judged
    Correctness,
    /// Time and instructions
    Cost,
}

fn main() -> ExitCode {
    match apart::serve() {
        Ok(true) => return ExitCode::SUCCESS,
        Ok(false) => {}
        Err(_) => return ExitCode::FAILURE,
    }
    match run(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("bench-motion: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    let program = std::env::current_exe()?;
    if let (Some(planner), [class, ..]) = (arguments.once, arguments.classes.as_slice()) {
        let Arguments { axes, seed, .. } = *arguments;
        with_axes!(axes, N => count::once::<N>(&program, *class, seed, planner))?;
        return Ok(());
    }
    let report = measure(&program, arguments)?;
    if arguments.json {
        println!("{:#}", json(&report));
    } else {
        print!("{}", markdown(&report));
    }
    Ok(())
}

fn measure(program: &Path, arguments: &Arguments) -> Result<Report, Box<dyn Error>> {
    let Arguments {
        cases, seed, axes, ..
    } = *arguments;
    let mut report = Report {
        about: About {
            cpu: cpu(),
            seed,
            cases,
            axes,
        },
        classes: Vec::new(),
        costs: Vec::new(),
        samples: Vec::new(),
    };
    for class in &arguments.classes {
        if arguments.only != Some(Part::Cost) {
            let tallies =
                with_axes!(axes, N => correctness::run::<N>(program, *class, seed, cases))?;
            report.classes.push((*class, tallies));
        }
        if arguments.only != Some(Part::Correctness) {
            cost(program, *class, seed, &mut report)?;
        }
    }
    Ok(report)
}

fn cost(
    program: &Path,
    class: Class,
    seed: u64,
    report: &mut Report,
) -> Result<(), Box<dyn Error>> {
    let small_too = matches!(class, Class::R | Class::T);
    for axes in COST_AXES {
        if axes != goal::AXES && !small_too {
            continue;
        }
        eprintln!("   {class}: cost of {axes} axes");
        let mut costs = with_axes!(axes, N => timing::plans::<N>(program, class, seed))?;
        if axes == goal::AXES {
            for cost in &mut costs {
                eprintln!("   {class}: instructions of {}", cost.planner);
                cost.instructions = count::instructions(program, class, seed, axes, cost.planner)?;
            }
        }
        report.costs.push(CostRow { class, axes, costs });
        if small_too {
            let ns = with_axes!(axes, N => timing::samples::<N>(program, class, seed))?;
            report.samples.push(SampleRow { class, axes, ns });
        }
    }
    Ok(())
}
