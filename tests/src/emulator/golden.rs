//! Measured numbers beside those that were accepted, each within its band.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

/// A measured number.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// Its name.
    pub name: String,
    /// Its value.
    pub value: u64,
    /// By how many per cent it may differ from the accepted one: compilers do.
    pub band: u64,
    /// What it should be at most.
    pub target: Option<u64>,
}

impl Figure {
    /// A number without a target.
    pub fn new(name: impl Into<String>, value: u64, band: u64) -> Self {
        Self {
            name: name.into(),
            value,
            band,
            target: None,
        }
    }

    /// With a target.
    #[must_use]
    pub fn at_most(mut self, target: u64) -> Self {
        self.target = Some(target);
        self
    }
}

/// Prints the figures beside those of a file that were accepted, and compares, or accepts them.
///
/// # Errors
/// Which are outside their bands, or why the file cannot be written.
pub fn judge(figures: &[Figure], compiler: &str, file: &Path, accept: bool) -> Result<(), String> {
    let text = std::fs::read_to_string(file).unwrap_or_default();
    let accepted = read(&text);
    print!("{}", table(figures, &accepted));
    if accept {
        return bless(figures, compiler, file).map_err(|error| error.to_string());
    }
    let outside = outside(figures, &accepted);
    if outside.is_empty() {
        return Ok(());
    }
    Err(format!(
        "{} (made by {compiler}, accepted of {}; --bless accepts what is meant)",
        outside.join("; "),
        self::compiler(&text).unwrap_or("nobody")
    ))
}

/// The figures as a table, with what was accepted and whether the target is met.
#[must_use]
fn table(figures: &[Figure], accepted: &BTreeMap<String, u64>) -> String {
    let mut out = String::new();
    for figure in figures {
        let was = accepted
            .get(&figure.name)
            .map_or("-".into(), u64::to_string);
        let target = figure.target.map_or(String::new(), |target| {
            let word = if figure.value <= target {
                "met"
            } else {
                "MISSED"
            };
            format!("target {target} {word}")
        });
        // writing to a string cannot fail
        let _ = writeln!(
            out,
            "{:48} {:>9} accepted {was:>9} {target}",
            figure.name, figure.value
        );
    }
    out
}

/// What a golden file says: a name and a number a line, below the compiler.
#[must_use]
fn read(text: &str) -> BTreeMap<String, u64> {
    text.lines()
        .filter_map(|line| line.split_once(' '))
        .filter_map(|(name, value)| Some((name.to_owned(), value.trim().parse().ok()?)))
        .collect()
}

/// The compiler whose figures a golden file has.
#[must_use]
fn compiler(text: &str) -> Option<&str> {
    text.lines().find_map(|line| line.strip_prefix("# "))
}

/// Those that left their band, and those that nobody accepted.
#[must_use]
fn outside(figures: &[Figure], accepted: &BTreeMap<String, u64>) -> Vec<String> {
    let mut out: Vec<String> = figures
        .iter()
        .filter_map(|figure| match accepted.get(&figure.name) {
            None => Some(format!(
                "{}: {} was never accepted",
                figure.name, figure.value
            )),
            Some(was) => {
                let off = figure.value.abs_diff(*was).saturating_mul(100);
                (off > was.saturating_mul(figure.band)).then(|| {
                    format!(
                        "{}: {}, accepted were {was} within {} %",
                        figure.name, figure.value, figure.band
                    )
                })
            }
        })
        .collect();
    let gone = accepted
        .keys()
        .filter(|name| !figures.iter().any(|figure| figure.name == **name));
    out.extend(gone.map(|name| format!("{name}: accepted, and not measured")));
    out
}

/// Accepts all of them, with the compiler that made the image.
///
/// # Errors
/// If the file cannot be written.
fn bless(figures: &[Figure], compiler: &str, path: &Path) -> std::io::Result<()> {
    let mut text = format!("# {compiler}\n");
    for figure in figures {
        let _ = writeln!(text, "{} {}", figure.name, figure.value);
    }
    std::fs::write(path, text)
}

#[cfg(test)]
mod test {
    use super::*;

    #[test]
    fn a_figure_leaves_its_band_on_either_side() {
        let accepted = read("a 1000\nb 7\n");
        let figures = |a, b| vec![Figure::new("a", a, 3), Figure::new("b", b, 0)];
        for a in [970, 1000, 1030] {
            assert_eq!(outside(&figures(a, 7), &accepted), [""; 0]);
        }
        for (a, b) in [(969, 7), (1031, 7), (1000, 8)] {
            assert_eq!(outside(&figures(a, b), &accepted).len(), 1, "{a} {b}");
        }
    }

    #[test]
    fn the_compiler_is_no_figure() {
        let text = "# rustc version 1.95.0 (59807616e 2026-04-14)\na 7\n";
        assert_eq!(
            compiler(text),
            Some("rustc version 1.95.0 (59807616e 2026-04-14)")
        );
        assert_eq!(read(text), BTreeMap::from([("a".to_owned(), 7)]));
        assert_eq!(compiler("a 7\n"), None);
    }

    #[test]
    fn what_is_new_and_what_is_gone_is_told() {
        let accepted = read("old 5\n");
        let found = outside(&[Figure::new("new", 5, 100)], &accepted);
        assert_eq!(
            found,
            [
                "new: 5 was never accepted",
                "old: accepted, and not measured"
            ]
        );
    }
}
