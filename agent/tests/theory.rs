//! `docs/theory.md` and the sources agree, in both directions.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// A paper, 1 or 2, and the number of an equation in it.
type Equation = (u8, u32);

/// How many numbered equations the papers have.
const EQUATIONS: [(u8, u32); 2] = [(1, 13), (2, 22)];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn theory() -> String {
    fs::read_to_string(root().join("docs/theory.md")).unwrap()
}

/// The sources below a folder, in the order of their paths; not the products of a build.
fn sources(below: &Path) -> BTreeMap<PathBuf, String> {
    let mut found = BTreeMap::new();
    let mut folders = vec![below.to_path_buf()];
    while let Some(folder) = folders.pop() {
        let Ok(entries) = fs::read_dir(&folder) else {
            continue;
        };
        for path in entries.map(|entry| entry.unwrap().path()) {
            if path.is_dir() {
                let name = path.file_name().unwrap().to_string_lossy().into_owned();
                if name != "target" && !name.starts_with('.') {
                    folders.push(path);
                }
            } else if path.extension().is_some_and(|e| e == "rs")
                && let Ok(text) = fs::read_to_string(&path)
            {
                found.insert(path, text);
            }
        }
    }
    found
}

/// Every `[Z1] (n)` and `[Z2] (n), (m)` in a text, with or without rustdoc's backslashes.
fn mentions(text: &str) -> BTreeSet<Equation> {
    let text = text.replace("\\[", "[").replace("\\]", "]");
    let mut found = BTreeSet::new();
    for (paper, mark) in [(1, "[Z1] ("), (2, "[Z2] (")] {
        for (at, _) in text.match_indices(mark) {
            let mut rest = &text[at + mark.len() - 1..];
            while let Some((n, after)) = rest.strip_prefix('(').and_then(|r| r.split_once(')')) {
                let Ok(n) = n.parse() else { break };
                found.insert((paper, n));
                rest = after.strip_prefix(", ").unwrap_or("");
            }
        }
    }
    found
}

/// The paths `crate::…::item` in backticks.
fn items(text: &str) -> BTreeSet<String> {
    let crates = [
        "agent", "motion", "robots", "protocol", "bus", "firmware", "host", "hil_sim",
    ];
    text.split('`')
        .skip(1)
        .step_by(2)
        .filter(|code| {
            code.split_once("::")
                .is_some_and(|(first, _)| crates.contains(&first))
        })
        .map(str::to_owned)
        .collect()
}

/// The rows of the equations: what each one is implemented by.
fn rows() -> BTreeMap<Equation, BTreeSet<String>> {
    let mut rows = BTreeMap::new();
    for line in theory().lines() {
        let Some(first) = line.strip_prefix("| ").and_then(|l| l.split(" | ").next()) else {
            continue;
        };
        if let [equation] = mentions(first).into_iter().collect::<Vec<_>>()[..]
            && first.len() <= "[Z2] (22)".len()
        {
            let before = rows.insert(equation, items(line));
            assert!(before.is_none(), "two rows for {equation:?}");
        }
    }
    rows
}

/// Is `name` declared in this text: an item, a variant, an associated item?
fn declares(text: &str, name: &str) -> bool {
    const KEYWORDS: [&str; 7] = ["struct", "enum", "trait", "type", "fn", "const", "mod"];
    let word = |c: char| c.is_alphanumeric() || c == '_';
    text.lines().any(|line| {
        let line = line.trim_start();
        if line.starts_with("//") {
            return false;
        }
        let words: Vec<_> = line.split(|c| !word(c)).filter(|w| !w.is_empty()).collect();
        let item = words
            .windows(2)
            .any(|w| KEYWORDS.contains(&w[0]) && w[1] == name);
        let variant = line.strip_prefix(name).is_some_and(|rest| {
            ["", " {", "(", ","].iter().any(|end| match *end {
                "" => rest.is_empty(),
                end => rest.starts_with(end),
            })
        });
        item || variant && name.starts_with(char::is_uppercase)
    })
}

/// The files of the crate that declare the last segment of a path, and any segment before it.
fn declared_in<'f>(path: &str, files: &'f BTreeMap<PathBuf, String>) -> Vec<&'f PathBuf> {
    let segments: Vec<_> = path.split("::").skip(1).collect();
    let (last, owners) = segments.split_last().unwrap();
    let owned = owners
        .iter()
        .all(|owner| files.values().any(|text| declares(text, owner)));
    let owner = owners
        .last()
        .filter(|owner| owner.starts_with(char::is_uppercase));
    files
        .iter()
        .filter(|(_, text)| {
            owned && declares(text, last) && owner.is_none_or(|owner| declares(text, owner))
        })
        .map(|(path, _)| path)
        .collect()
}

#[test]
fn every_equation_has_a_row_that_names_an_item() {
    let rows = rows();
    let expected: BTreeSet<_> = EQUATIONS
        .iter()
        .flat_map(|&(paper, last)| (1..=last).map(move |n| (paper, n)))
        .collect();
    assert_eq!(rows.keys().copied().collect::<BTreeSet<_>>(), expected);
    for (equation, items) in rows {
        assert!(
            items.iter().any(|item| item.starts_with("agent::")),
            "{equation:?}: {items:?}"
        );
    }
}

#[test]
fn every_item_exists() {
    for item in items(&theory()) {
        let (package, _) = item.split_once("::").unwrap();
        let files = sources(&root().join(package.replace('_', "-")).join("src"));
        assert!(
            !declared_in(&item, &files).is_empty(),
            "docs/theory.md names `{item}`"
        );
    }
}

#[test]
fn every_equation_mentioned_in_a_source_is_listed() {
    let rows = rows();
    let this = Path::new(file!()).file_name().unwrap();
    for (path, text) in sources(&root()) {
        for equation in mentions(&text) {
            assert!(
                path.file_name() == Some(this) || rows.contains_key(&equation),
                "{} mentions {equation:?}, which no paper has",
                path.display()
            );
        }
    }
}

#[test]
fn every_equation_mentioned_in_this_crate_is_listed_with_an_item_of_that_file() {
    let rows = rows();
    let files = sources(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src"));
    for (path, text) in files.iter().filter(|(path, _)| !path.ends_with("lib.rs")) {
        for equation in mentions(text) {
            let here = rows[&equation]
                .iter()
                .filter(|item| item.starts_with("agent::"))
                .any(|item| declared_in(item, &files).contains(&path));
            assert!(
                here,
                "{}: {equation:?} is listed without an item of this file",
                path.display()
            );
        }
    }
}

#[test]
fn the_readers_read() {
    let text = "as [Z1] (3), (13) and \\[Z2\\] (7) say; [Z2] §3 and (99) do not; [Z1] (x)";
    assert_eq!(mentions(text), BTreeSet::from([(1, 3), (1, 13), (2, 7)]));
    assert!(declares("    pub const fn new(of: P) -> Self {", "new"));
    assert!(declares("    Threshold {", "Threshold") && declares("    Hold,", "Hold"));
    assert!(!declares("// struct Ghost", "Ghost") && !declares("use a::Ghost;", "Ghost"));
    assert!(!declares("struct Ghosts;", "Ghost"));
}
