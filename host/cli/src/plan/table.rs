//! A planned motion as people read it.

use std::io::{self, Write};

use motion::profile::{Phase, State, Synchronisation};

use super::motion::{Asked, Motion};

/// Writes a line on the whole and a table per axis: where every phase begins, and where the last ends.
pub(super) fn write(
    out: &mut dyn Write,
    asked: &Asked,
    motion: &Motion,
    unit: &str,
) -> io::Result<()> {
    writeln!(out, "{}; proved", title(asked, motion))?;
    for (axis, phases) in (1..).zip(&motion.axes) {
        let duration: f64 = phases.iter().map(|phase| phase.t).sum();
        let count = counted(phases.len(), "phase", "phases");
        writeln!(out, "\naxis {axis}: {count}, {} s", short(duration))?;
        row(out, &HEAD.map(|(name, _)| name.into()))?;
        row(
            out,
            &HEAD.map(|(_, per)| per.map_or("[s]".into(), |per| format!("[{unit}{per}]"))),
        )?;
        let rows = rows(phases);
        let column = |k: usize| {
            rows.iter()
                .filter_map(move |row| row.get(k).copied().flatten())
        };
        let scales = [0, 1, 2, 3, 4, 5].map(|k| column(k).fold(0.0, larger));
        for numbers in &rows {
            let mut cells = numbers.iter().zip(scales);
            row(
                out,
                &[(); 6].map(|()| match cells.next() {
                    Some((Some(x), scale)) => cell(*x, scale),
                    _ => String::new(),
                }),
            )?;
        }
    }
    Ok(())
}

/// The columns: what, and per what of the unit of position; times have none.
const HEAD: [(&str, Option<&str>); 6] = [
    ("begins", None),
    ("lasts", None),
    ("position", Some("")),
    ("velocity", Some("/s")),
    ("acceleration", Some("/s²")),
    ("jerk", Some("/s³")),
];

/// A row per phase, and one for the end of the last.
fn rows(phases: &[Phase]) -> Vec<[Option<f64>; 6]> {
    let mut begin = 0.0;
    let mut rows = Vec::new();
    for phase in phases {
        let Phase { t, j, a0, v0, p0 } = *phase;
        rows.push([begin, t, p0, v0, a0, j].map(Some));
        begin += t;
    }
    if let Some(phase) = phases.last() {
        let State { p, v, a, .. } = phase.at(phase.t);
        rows.push([Some(begin), None, Some(p), Some(v), Some(a), None]);
    }
    rows
}

/// The motion in a few words.
pub(super) fn title(asked: &Asked, motion: &Motion) -> String {
    let axes = counted(motion.axes.len(), "axis", "axes");
    let how = match asked.synchronisation {
        _ if motion.axes.len() == 1 => "",
        Synchronisation::None => ", each as early as it can",
        Synchronisation::Time => ", arriving together",
        Synchronisation::Phase => ", on a straight line where there is one",
    };
    format!("Motion of {axes} in {} s{how}", short(motion.duration))
}

fn counted(count: usize, one: &str, more: &str) -> String {
    format!("{count} {}", if count == 1 { one } else { more })
}

fn row(out: &mut dyn Write, cells: &[String; 6]) -> io::Result<()> {
    let [begins, lasts, p, v, a, j] = cells;
    let line = format!("{begins:>14}{lasts:>14}{p:>14}{v:>14}{a:>14}{j:>14}");
    writeln!(out, "{}", line.trim_end())
}

/// The larger of a size and that of a number.
fn larger(size: f64, x: f64) -> f64 {
    if x.abs() > size { x.abs() } else { size }
}

/// A number of a column whose greatest is `scale`: seven digits of that one.
fn cell(x: f64, scale: f64) -> String {
    let digits = (0_u8..=9).find(|digits| scale * libm::pow(10.0, f64::from(*digits)) >= 1e6);
    match digits {
        _ if x == 0.0 || scale == 0.0 => "0".into(),
        Some(digits) if scale < 1e9 => {
            let text = format!("{x:.*}", usize::from(digits));
            let nothing = text.bytes().all(|b| matches!(b, b'0' | b'.' | b'-'));
            if nothing { "0".into() } else { text }
        }
        _ => format!("{x:.6e}"),
    }
}

/// A time without zeros at its end.
fn short(seconds: f64) -> String {
    let text = cell(seconds, seconds);
    if text.contains('.') && !text.contains('e') {
        text.trim_end_matches('0').trim_end_matches('.').into()
    } else {
        text
    }
}

#[cfg(test)]
mod test {
    use super::*;

    #[test]
    fn numbers_of_a_column_have_the_same_decimals() {
        for (x, scale, text) in [
            (1.0, 1.0, "1.000000"),
            (0.05, 10.0, "0.05000"),
            (-1.1e-16, 1.0, "0"),
            (0.0, 0.0, "0"),
            (-2e-3, 2e-3, "-0.002000000"),
            (2e-9, 2e-9, "2.000000e-9"),
            (123_456_789.0, 123_456_789.0, "123456789"),
            (1e12, 1e12, "1.000000e12"),
        ] {
            assert_eq!(cell(x, scale), text);
        }
    }

    #[test]
    fn times_are_short() {
        for (seconds, text) in [
            (2.6, "2.6"),
            (2.600_000_000_000_000_5, "2.6"),
            (0.0, "0"),
            (300.0, "300"),
        ] {
            assert_eq!(short(seconds), text);
        }
    }
}
