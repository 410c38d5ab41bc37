//! Every fault code has its page in `docs/faults/`, every page its code, and both say the same.

use crate::report::Findings;
use crate::shell::root;
use anyhow::{Context, Result, ensure};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

const SOURCE: &str = "protocol/src/fault.rs";
const PAGES: &str = "docs/faults";
const SECTIONS: &[&str] = &[
    "## What it means",
    "## What the node does",
    "## Usual reasons",
    "## What to do",
];

/// One row of the `causes!` table.
#[derive(Debug, PartialEq)]
struct Cause {
    code: u16,
    name: String,
    class: String,
    /// `R1`, `R2` or `R3`.
    reaction: &'static str,
    text: String,
}

/// Checks the pages of the repository.
pub(crate) fn check() -> Result<Findings> {
    let root = root();
    let source = root.join(SOURCE);
    let source = fs::read_to_string(&source).with_context(|| format!("{}", source.display()))?;
    compare(&causes(&source)?, &pages(&root.join(PAGES))?)
}

/// The files of the folder, by name.
fn pages(folder: &Path) -> Result<BTreeMap<String, String>> {
    let mut pages = BTreeMap::new();
    for entry in fs::read_dir(folder).with_context(|| format!("{}", folder.display()))? {
        let path = entry?.path();
        let text = fs::read_to_string(&path).with_context(|| format!("{}", path.display()))?;
        let name = path
            .file_name()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned();
        pages.insert(name, text);
    }
    Ok(pages)
}

/// Reads the table `causes! { /// text \n Name = code, Class, Reaction; … }`. Whatever else stands
/// inside is an error, so that no row is overlooked.
fn causes(source: &str) -> Result<Vec<Cause>> {
    let (_, table) = source
        .split_once("\ncauses! {")
        .context("no table `causes!`")?;
    let (table, _) = table
        .split_once("\n}")
        .context("the table `causes!` does not end")?;
    let mut causes: Vec<Cause> = vec![];
    let mut text: Option<String> = None;
    for line in table.lines().map(str::trim).filter(|l| !l.is_empty()) {
        if let Some(doc) = line.strip_prefix("///") {
            // the first line of the doc comment is the text
            text.get_or_insert_with(|| doc.trim().to_owned());
            continue;
        }
        let cause = row(line, text.take()).with_context(|| format!("not a row: {line}"))?;
        ensure!(
            causes.last().is_none_or(|last| last.code < cause.code),
            "code {} is not in order",
            cause.code
        );
        causes.push(cause);
    }
    ensure!(!causes.is_empty(), "the table `causes!` is empty");
    Ok(causes)
}

fn row(line: &str, text: Option<String>) -> Option<Cause> {
    let (name, rest) = line.strip_suffix(';')?.split_once('=')?;
    let mut fields = rest.split(',').map(str::trim);
    let code = fields.next()?.parse().ok()?;
    let class = fields.next()?.to_owned();
    let reaction = match fields.next()? {
        "PathStop" => "R1",
        "QuickStop" => "R2",
        "TorqueOff" => "R3",
        _ => return None,
    };
    let cause = Cause {
        code,
        name: name.trim().to_owned(),
        class,
        reaction,
        text: text?,
    };
    fields.next().is_none().then_some(cause)
}

fn compare(causes: &[Cause], pages: &BTreeMap<String, String>) -> Result<Findings> {
    let mut findings = vec![];
    let index = pages
        .get("README.md")
        .context("docs/faults/README.md is missing")?;
    for cause in causes {
        let Cause {
            code,
            name,
            class,
            reaction,
            text,
        } = cause;
        let file = format!("{code}.md");
        let Some(page) = pages.get(&file) else {
            findings.push(format!("{PAGES}/{file} is missing ({name})"));
            continue;
        };
        let heading = format!("# {code} {name}: {text}");
        if page.lines().next() != Some(heading.as_str()) {
            findings.push(format!("{PAGES}/{file} must begin with: {heading}"));
        }
        let sections: Vec<&str> = page.lines().filter(|l| l.starts_with("## ")).collect();
        if sections != SECTIONS {
            findings.push(format!("{PAGES}/{file} must have: {}", SECTIONS.join(", ")));
        }
        if !page.contains(&format!("**{reaction}**")) {
            findings.push(format!(
                "{PAGES}/{file} must name the reaction **{reaction}**"
            ));
        }
        let line = format!("| [{code}]({file}) | {name} | {class} | {reaction} | {text} |");
        if !index.lines().any(|l| l == line) {
            findings.push(format!("{PAGES}/README.md lacks the row: {line}"));
        }
    }
    for file in pages.keys().filter(|f| f.as_str() != "README.md") {
        if !causes.iter().any(|c| format!("{}.md", c.code) == *file) {
            findings.push(format!("{PAGES}/{file} belongs to no fault code"));
        }
    }
    for line in index.lines().filter(|l| l.starts_with("| [")) {
        if !causes
            .iter()
            .any(|c| line.starts_with(&format!("| [{}](", c.code)))
        {
            findings.push(format!(
                "{PAGES}/README.md has a row without a fault code: {line}"
            ));
        }
    }
    Ok(findings)
}

#[cfg(test)]
mod test {
    use super::*;

    const TABLE: &str = "macro_rules! causes {\n}\n\ncauses! {\n    /// the lease expired\n    \
        Lease = 10, Fatal, PathStop;\n    /// no power\n    ///\n    /// more of it\n    \
        Power = 43, System, TorqueOff;\n}\n";

    fn page(heading: &str, reaction: &str) -> String {
        format!("{heading}\n\n{}\n**{reaction}**\n", SECTIONS.join("\n"))
    }

    fn good() -> BTreeMap<String, String> {
        let index = "| [10](10.md) | Lease | Fatal | R1 | the lease expired |\n\
                     | [43](43.md) | Power | System | R3 | no power |\n";
        BTreeMap::from([
            ("README.md".to_owned(), index.to_owned()),
            (
                "10.md".to_owned(),
                page("# 10 Lease: the lease expired", "R1"),
            ),
            ("43.md".to_owned(), page("# 43 Power: no power", "R3")),
        ])
    }

    fn findings(pages: &BTreeMap<String, String>) -> Findings {
        compare(&causes(TABLE).unwrap(), pages).unwrap()
    }

    #[test]
    fn the_table_is_read_whole() {
        let read = causes(TABLE).unwrap();
        assert_eq!(read.len(), 2);
        let power = Cause {
            code: 43,
            name: "Power".into(),
            class: "System".into(),
            reaction: "R3",
            text: "no power".into(),
        };
        assert_eq!(read[1], power);
    }

    #[test]
    fn what_is_not_a_row_is_an_error() {
        for bad in [
            "causes! {\n}\n",
            "\ncauses! {\n}\n",
            "\ncauses! {\n    Lease = 10, Fatal, PathStop;\n}\n",
            "\ncauses! {\n    /// a\n    Lease = 10, Fatal, Jump;\n}\n",
            "\ncauses! {\n    /// a\n    Lease = 10, Fatal;\n}\n",
            "\ncauses! {\n    /// a\n    B = 11, Fatal, PathStop;\n    /// a\n    A = 10, Fatal, \
             PathStop;\n}\n",
        ] {
            assert!(causes(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn agreeing_pages_pass() {
        assert_eq!(findings(&good()), [""; 0]);
    }

    #[test]
    fn every_disagreement_is_found() {
        let broken = |change: &dyn Fn(&mut BTreeMap<String, String>)| {
            let mut pages = good();
            change(&mut pages);
            findings(&pages)
        };
        let edit = |file: &'static str, from: &'static str, to: &'static str| {
            broken(&|pages| {
                let page = pages.get_mut(file).unwrap();
                assert!(page.contains(from));
                *page = page.replace(from, to);
            })
        };
        assert_eq!(
            broken(&|p| drop(p.remove("43.md"))),
            ["docs/faults/43.md is missing (Power)"]
        );
        assert_eq!(
            broken(&|p| drop(p.insert("44.md".into(), String::new()))),
            ["docs/faults/44.md belongs to no fault code"]
        );
        assert_eq!(
            edit("10.md", "the lease expired", "it expired"),
            ["docs/faults/10.md must begin with: # 10 Lease: the lease expired"]
        );
        assert_eq!(
            edit("10.md", "**R1**", "**R2**"),
            ["docs/faults/10.md must name the reaction **R1**"]
        );
        assert_eq!(edit("43.md", "## Usual reasons", "## Reasons").len(), 1);
        assert_eq!(edit("README.md", "| R3 |", "| R2 |").len(), 1);
        assert_eq!(edit("README.md", "| [43](43.md)", "| [44](44.md)").len(), 2);
    }
}
