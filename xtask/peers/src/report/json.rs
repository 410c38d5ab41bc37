//! The report as one JSON object.

use super::{About, CXX, CXX_FLAGS, RUST_FLAGS, RUSTC, Report};
use crate::goal::goals;
use crate::judge::Amounts;
use crate::planner::Planner;
use crate::tally::{Found, Tally, Worst};
use serde_json::{Map, Value, json};

/// All of it.
#[must_use]
pub fn json(report: &Report) -> Value {
    let About {
        cpu,
        seed,
        cases,
        axes,
    } = &report.about;
    let versions: Map<_, _> = About::versions()
        .map(|(name, version)| (name.to_owned(), version.into()))
        .into_iter()
        .collect();
    json!({
        "cpu": cpu, "versions": versions, "rustc": RUSTC, "rust_flags": RUST_FLAGS,
        "cxx": CXX, "cxx_flags": CXX_FLAGS,
        "seed": seed, "cases": cases, "axes": axes,
        "correctness": report.classes.iter().map(|(class, tallies)| json!({
            "class": class.letter(),
            "planners": each(|planner| tally(tallies.of(planner))),
        })).collect::<Vec<_>>(),
        "plans": report.costs.iter().map(|row| json!({
            "class": row.class.letter(), "axes": row.axes,
            "planners": each(|planner| {
                let cost = &row.costs[planner as usize];
                json!({
                    "ns": cost.ns, "spread": cost.spread, "alone_median_ns": cost.median_ns,
                    "alone_p99_ns": cost.p99_ns, "alone_worst_ns": cost.worst_ns,
                    "instructions": cost.instructions,
                })
            }),
        })).collect::<Vec<_>>(),
        "samples": report.samples.iter().map(|row| json!({
            "class": row.class.letter(), "axes": row.axes,
            "planners": each(|planner| {
                let (ns, spread) = row.ns[planner as usize];
                json!({ "ns": ns, "spread": spread })
            }),
        })).collect::<Vec<_>>(),
        "goals": goals(report).into_iter().map(|goal| json!({
            "goal": goal.name, "wanted": goal.wanted, "got": goal.got, "met": goal.met,
        })).collect::<Vec<_>>(),
    })
}

fn each(of: impl Fn(Planner) -> Value) -> Value {
    let all = Planner::ALL.map(|planner| (planner.name().to_owned(), of(planner)));
    Value::Object(all.into_iter().collect())
}

fn tally(tally: &Tally) -> Value {
    let against = &tally.against;
    let named = |name: &str, cases: &Found| (name.to_owned(), found(cases));
    let worst_of = Amounts::NAMES.iter().zip(&tally.worst);
    json!({
        "planned": tally.planned, "refused": tally.refused, "beyond": tally.beyond,
        "errors": Value::Object(tally.errors.iter().map(|(why, f)| named(why, f)).collect()),
        "faulty": found(&tally.faulty),
        "violations": Value::Object(
            tally.violations.iter().map(|(name, f)| named(name, f)).collect()
        ),
        "off_end": found(&tally.off_end),
        "worst": Value::Object(
            worst_of.map(|(name, w)| ((*name).to_owned(), worst(w))).collect()
        ),
        "duration_sum_s": tally.duration_sum,
        "against_ruckig": {
            "compared": against.compared, "difference_sum_s": against.difference_sum,
            "longer": found(&against.longer), "most_longer_s": worst(&against.most_longer),
            "shorter": found(&against.shorter), "most_shorter_s": worst(&against.most_shorter),
        },
    })
}

fn found(found: &Found) -> Value {
    json!({ "count": found.count, "cases": found.examples })
}

fn worst(worst: &Worst) -> Value {
    json!({ "value": worst.value, "case": worst.case })
}
