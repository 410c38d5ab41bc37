//! What no file of the repository may contain: paths of one machine, notes to oneself, silenced
//! lints; and how long a file may be.

use crate::report::Findings;
use anyhow::{Context, Result};
use std::fs;
use std::path::{Path, PathBuf};

/// More lines than this have more than one reason to change.
const MAX_LINES: usize = 600;

/// Paths that exist on one machine only. Written in halves, here and below, so that this file
/// keeps its own rules.
const MACHINE_PATHS: &[&str] = &[
    concat!("/wo", "rk/"),
    concat!("/ro", "ot/"),
    concat!("/ho", "me/"),
];

/// Notes of unfinished work, whole words.
const NOTES: &[&str] = &[
    concat!("TO", "DO"),
    concat!("FIX", "ME"),
    concat!("X", "XX"),
];

/// Macros of unfinished work, in Rust.
const MACROS: &[&str] = &[
    concat!("to", "do!"),
    concat!("unimple", "mented!"),
    concat!("db", "g!"),
];

/// Attributes that silence a lint; `expect` with a reason is the way.
const ALLOWS: &[&str] = &[concat!("#[al", "low("), concat!("#![al", "low(")];

/// Hidden folders that belong to the repository.
const HIDDEN: &[&str] = &[".cargo", ".ci", ".github"];

/// Checks every text file below a folder.
pub(crate) fn check(root: &Path) -> Result<Findings> {
    let mut paths = vec![];
    collect(root, &mut paths)?;
    paths.sort();
    let mut findings = vec![];
    for path in paths {
        let bytes = fs::read(&path).with_context(|| format!("{}", path.display()))?;
        // What is not text has no rules here.
        let Ok(text) = String::from_utf8(bytes) else {
            continue;
        };
        let name = path
            .strip_prefix(root)
            .unwrap_or(&path)
            .display()
            .to_string();
        findings.extend(check_file(&name, &text));
    }
    Ok(findings)
}

/// Every file that is not a product of a build; links are not followed.
fn collect(folder: &Path, paths: &mut Vec<PathBuf>) -> Result<()> {
    for entry in fs::read_dir(folder).with_context(|| format!("{}", folder.display()))? {
        let entry = entry?;
        let name = entry.file_name();
        let name = name.to_string_lossy();
        let kind = entry.file_type()?;
        let foreign = name == "target" || (name.starts_with('.') && !HIDDEN.contains(&&*name));
        if kind.is_dir() && !foreign {
            collect(&entry.path(), paths)?;
        } else if kind.is_file() {
            paths.push(entry.path());
        }
    }
    Ok(())
}

fn check_file(name: &str, text: &str) -> Findings {
    let extension = Path::new(name)
        .extension()
        .and_then(|e| e.to_str())
        .unwrap_or_default();
    let rust = extension == "rs";
    let mut findings = vec![];
    let lines = text.lines().count();
    if matches!(extension, "rs" | "md" | "toml") && lines > MAX_LINES {
        findings.push(format!("{name}: {lines} lines; more than {MAX_LINES}"));
    }
    for (number, line) in (1..).zip(text.lines()) {
        let mut found = |what: &str| findings.push(format!("{name}:{number}: {what}"));
        for path in MACHINE_PATHS.iter().filter(|p| starts_a_path(line, p)) {
            found(&format!("a path of one machine, {path}"));
        }
        for note in NOTES.iter().filter(|n| word(line, n)) {
            found(&format!("a note of unfinished work, {note}"));
        }
        if rust {
            for name in MACROS.iter().filter(|m| word(line, m)) {
                found(&format!("{name} in the source"));
            }
        }
    }
    if rust {
        findings.extend(bare_allows(name, text));
    }
    findings
}

/// Lints silenced for ever and without a word why.
fn bare_allows(name: &str, text: &str) -> Findings {
    let mut findings = vec![];
    for pattern in ALLOWS {
        for (at, _) in text.match_indices(pattern) {
            let rest = &text[at..];
            let attribute = rest.split_once(")]").map_or(rest, |(inside, _)| inside);
            if !attribute.contains("reason") {
                let number = 1 + text[..at].matches('\n').count();
                findings.push(format!("{name}:{number}: {pattern}…)] without a reason"));
            }
        }
    }
    findings
}

/// Does a path start so in this line? `docs/<such a folder>/` does not.
fn starts_a_path(line: &str, path: &str) -> bool {
    line.match_indices(path)
        .any(|(at, _)| !line[..at].ends_with(is_of_path))
}

fn is_of_path(c: char) -> bool {
    c.is_alphanumeric() || matches!(c, '_' | '-' | '.' | ')' | '}' | '>')
}

/// Does the line contain the word, not as a part of a longer one?
fn word(line: &str, word: &str) -> bool {
    let part = |c: char| c.is_alphanumeric() || c == '_';
    // a macro's name ends with `!`, whatever follows
    let open_end = !word.ends_with(char::is_alphanumeric);
    line.match_indices(word).any(|(at, found)| {
        let after = &line[at + found.len()..];
        !line[..at].ends_with(part) && (open_end || !after.starts_with(part))
    })
}

#[cfg(test)]
mod test {
    use super::*;

    fn of(name: &str, text: &str) -> Findings {
        check_file(name, text)
    }

    #[test]
    fn clean_text_passes() {
        let text = "//! The MP's todo list has XXXL items at docs/home/page.\nfn dbg() {}\n";
        assert_eq!(of("a.rs", text), [""; 0]);
    }

    #[test]
    fn each_rule_finds_its_case_with_the_line() {
        for path in MACHINE_PATHS {
            assert_eq!(of("a.md", &format!("\nsee `{path}x`")).len(), 1, "{path}");
            assert_eq!(of("a.md", &format!("{path}x")).len(), 1, "{path}");
            assert_eq!(
                of("a.md", &format!("https://example.org{path}x")),
                [""; 0],
                "{path}"
            );
        }
        for note in NOTES {
            assert_eq!(
                of("a.toml", &format!("ok\n# {note}: later")),
                [format!("a.toml:2: a note of unfinished work, {note}")]
            );
            assert_eq!(of("a.toml", &format!("{note}_x S{note}")), [""; 0]);
        }
        for name in MACROS {
            assert_eq!(of("a.rs", &format!("    {name}(x);")).len(), 1, "{name}");
            assert_eq!(of("a.md", &format!("    {name}(x);")), [""; 0], "{name}");
        }
    }

    #[test]
    fn a_silenced_lint_needs_a_reason() {
        for allow in ALLOWS {
            let bare = format!("fn a() {{}}\n{allow}dead_code)]\nfn b() {{}}");
            let found = of("a.rs", &bare);
            assert_eq!(found.len(), 1);
            assert!(found[0].starts_with("a.rs:2: "), "{}", found[0]);
            let explained = format!("{allow}\n    dead_code,\n    reason = \"generated\"\n)]");
            assert_eq!(of("a.rs", &explained), [""; 0]);
        }
        assert_eq!(of("a.rs", "#[expect(dead_code, reason = \"…\")]"), [""; 0]);
    }

    #[test]
    fn long_files_are_found() {
        let text = "x\n".repeat(MAX_LINES);
        assert_eq!(of("a.rs", &text), [""; 0]);
        assert_eq!(
            of("a.rs", &(text.clone() + "y\n")),
            ["a.rs: 601 lines; more than 600"]
        );
        assert_eq!(of("a.trj", &(text + "y\n")), [""; 0], "data may be long");
    }
}
