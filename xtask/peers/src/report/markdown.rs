//! The report as tables.

use super::{About, CXX, CXX_FLAGS, RUST_FLAGS, RUSTC, Report};
use crate::goal::goals;
use crate::judge::TOLERANCE;
use crate::planner::Planner;
use crate::tally::{END_GOAL, Found, Tally, Worst};
use crate::timing::{BATCH, CALL_REPEATS, REPEATS, ROUNDS};

/// All of it.
#[must_use]
pub fn markdown(report: &Report) -> String {
    let mut lines = header(&report.about);
    if !report.classes.is_empty() {
        lines.extend(correctness(report));
    }
    if !report.costs.is_empty() {
        lines.extend(costs(report));
    }
    if !report.samples.is_empty() {
        lines.extend(samples(report));
    }
    lines.extend(verdict(report));
    lines.push(String::new());
    lines.join("\n")
}

fn header(about: &About) -> Vec<String> {
    let versions = About::versions().map(|(name, version)| format!("{name} {version}"));
    vec![
        format!(
            "{}; {}. Seed {}.",
            about.cpu,
            versions.join(", "),
            about.seed
        ),
        format!("{RUSTC}: {RUST_FLAGS}. {CXX}: {CXX_FLAGS}."),
    ]
}

fn correctness(report: &Report) -> Vec<String> {
    let About { cases, axes, .. } = report.about;
    let mut lines = vec![
        String::new(),
        format!(
            "Correctness, {cases} cases of {axes} axes per class. Error: not planned though Ruckig's \
             check of the input takes it. Violation: more than {TOLERANCE:.0e} outside a limit, \
             discontinuous, or an end missed. Longer, shorter: than Ruckig by more than \
             {TOLERANCE:.0e} s, where both are without violation."
        ),
        String::new(),
        format!(
            "| class | planner | planned | refused | errors | violations | worst excess | \
             end > {END_GOAL:.0e} | worst end | sum of durations, s | longer | worst, s | shorter | best, s |"
        ),
        "|---|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|".into(),
    ];
    for (class, tallies) in &report.classes {
        for planner in Planner::ALL {
            let tally = tallies.of(planner);
            let against = &tally.against;
            let durations = if planner == Planner::Ruckig {
                "– | – | – | –".into()
            } else {
                format!(
                    "{} | {:.1e} | {} | {:.1e}",
                    against.longer.count,
                    against.most_longer.value,
                    against.shorter.count,
                    against.most_shorter.value
                )
            };
            lines.push(format!(
                "| {class} | {planner} | {} | {} | {} | {} | {:.1e} | {} | {:.1e} | {:.6} | {durations} |",
                tally.planned,
                tally.refused,
                tally.error_count(),
                tally.faulty.count,
                tally.worst_excess(),
                tally.off_end.count,
                tally.worst_end(),
                tally.duration_sum,
            ));
        }
    }
    let mut details = Vec::new();
    for (class, tallies) in &report.classes {
        for planner in Planner::ALL {
            let tally = tallies.of(planner);
            let found = findings(planner, tally);
            details.extend(
                found
                    .iter()
                    .map(|found| format!("- {class} {planner}: {found}")),
            );
        }
    }
    if !details.is_empty() {
        lines.push(String::new());
        lines.extend(details);
    }
    lines
}

/// Everything found about a planner, with the numbers of a few cases.
fn findings(planner: Planner, tally: &Tally) -> Vec<String> {
    let mut found = Vec::new();
    let mut say = |what: &str, cases: &Found, worst: Option<&Worst>| {
        let Found { count, examples } = cases;
        let examples: Vec<_> = examples.iter().map(u64::to_string).collect();
        let worst = worst.map_or_else(String::new, |Worst { value, case }| {
            format!("; worst {value:.1e} in case {case}")
        });
        if *count > 0 {
            let examples = examples.join(", ");
            found.push(format!("{what}: {count} (cases {examples}{worst})"));
        }
    };
    for (why, cases) in &tally.errors {
        say(&format!("error, {why}"), cases, None);
    }
    for (name, worst) in crate::judge::Amounts::NAMES.iter().zip(&tally.worst) {
        if let Some(cases) = tally.violations.get(name) {
            say(&format!("violation, {name}"), cases, Some(worst));
        }
    }
    if planner == Planner::Ours {
        let against = &tally.against;
        say("end off", &tally.off_end, None);
        say("longer", &against.longer, Some(&against.most_longer));
        say("shorter", &against.shorter, Some(&against.most_shorter));
    }
    if tally.beyond > 0 {
        found.push(format!("planned though Ruckig refuses: {}", tally.beyond));
    }
    found
}

fn costs(report: &Report) -> Vec<String> {
    let mut lines = vec![
        String::new(),
        format!(
            "Cost of a plan. Time: CPU time of the thread, {BATCH} cases in a batch, median of \
             {REPEATS}, {ROUNDS} interleaved rounds. p99 and worst: each call alone, the least of \
             {CALL_REPEATS}, monotonic clock. {}.",
            counter(report)
        ),
        String::new(),
        "| class | axes | planner | ns | × Ruckig | spread | median alone | p99 | worst | worst / median | instructions | × Ruckig |"
            .into(),
        "|---|---:|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|".into(),
    ];
    for row in &report.costs {
        let theirs = &row.costs[Planner::Ruckig as usize];
        for own in &row.costs {
            let counted = own.instructions.zip(theirs.instructions);
            let counted = counted.map_or_else(
                || "– | –".into(),
                |(own, theirs)| format!("{own:.0} | {:.3}", own / theirs),
            );
            lines.push(format!(
                "| {} | {} | {} | {:.0} | {:.3} | {:.0} % | {:.0} | {:.0} | {:.0} | {:.2} | {counted} |",
                row.class,
                row.axes,
                own.planner,
                own.ns,
                own.ns / theirs.ns,
                100.0 * own.spread,
                own.median_ns,
                own.p99_ns,
                own.worst_ns,
                own.worst_ns / own.median_ns,
            ));
        }
    }
    lines
}

fn counter(report: &Report) -> &'static str {
    let mut costs = report.costs.iter().flat_map(|row| &row.costs);
    if costs.any(|cost| cost.instructions.is_some()) {
        "Instructions: callgrind, a batch planned once"
    } else {
        "Instructions: not counted (needs valgrind)"
    }
}

fn samples(report: &Report) -> Vec<String> {
    let names = Planner::ALL.map(|planner| format!("{planner}, ns | spread"));
    let mut lines = vec![
        String::new(),
        "Cost of a sample: position, velocity, acceleration and jerk of all axes at one time, \
         times ascending."
            .into(),
        String::new(),
        format!("| class | axes | {} | mrroc × Ruckig |", names.join(" | ")),
        format!("|---|---:{}|---:|", "|---:|---:".repeat(Planner::ALL.len())),
    ];
    for row in &report.samples {
        let each = row
            .ns
            .map(|(ns, spread)| format!("{ns:.1} | {:.0} %", 100.0 * spread));
        let [own, theirs] = [Planner::Ours, Planner::Ruckig].map(|p| row.ns[p as usize].0);
        lines.push(format!(
            "| {} | {} | {} | {:.3} |",
            row.class,
            row.axes,
            each.join(" | "),
            own / theirs
        ));
    }
    lines
}

fn verdict(report: &Report) -> Vec<String> {
    let mut lines = vec![
        String::new(),
        "| goal | wanted | got | verdict |".into(),
        "|---|---|---|---|".into(),
    ];
    lines.extend(goals(report).into_iter().map(|goal| {
        let (got, verdict) = match goal.got {
            None => ("–".into(), "not measured"),
            Some(got) if goal.met => (got, "met"),
            Some(got) => (got, "NOT met"),
        };
        format!("| {} | {} | {got} | {verdict} |", goal.name, goal.wanted)
    }));
    lines
}
