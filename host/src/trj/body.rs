//! The nodes.

use super::{
    MAX_COLUMNS, Node, Reference, Row, Space, Token, Trajectory, TrjError, Warning, error_at,
};
use crate::input::Problem;

/// The lines of a node.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    StartVelocity,
    EndVelocity,
    Velocity,
    Acceleration,
    Coordinates,
}

impl Kind {
    const NODE: &'static [Self] = &[Self::Velocity, Self::Acceleration, Self::Coordinates];
    const OLD_NODE: &'static [Self] = &[
        Self::StartVelocity,
        Self::EndVelocity,
        Self::Velocity,
        Self::Acceleration,
        Self::Coordinates,
    ];

    const fn name(self) -> &'static str {
        match self {
            Self::StartVelocity => "start velocity",
            Self::EndVelocity => "end velocity",
            Self::Velocity => "velocity",
            Self::Acceleration => "acceleration",
            Self::Coordinates => "coordinate",
        }
    }
}

pub(super) struct Body<'a, 'r> {
    pub(super) rows: &'r [Row<'a>],
    pub(super) width: usize,
    pub(super) end: u32,
    pub(super) declared: usize,
    pub(super) warnings: Vec<Warning>,
}

impl Body<'_, '_> {
    pub(super) fn read(
        mut self,
        space: Space,
        reference: Reference,
    ) -> Result<Trajectory, TrjError> {
        let lines = self.lines_of_a_node();
        // every row is read and judged, also of nodes that will not be run
        let mut nodes = Vec::new();
        for (index, rows) in self.rows.chunks(lines.len()).enumerate() {
            if index >= self.declared && rows.len() < lines.len() {
                return Err(self.incomplete_beyond_the_count(rows, lines.len()));
            }
            nodes.push(self.node(index, rows, lines)?);
        }
        if nodes.len() < self.declared {
            return Err(error_at(
                self.end,
                1,
                Problem::WrongCount,
                "fewer nodes than declared",
                format!("{} nodes", self.declared),
                nodes.len().to_string(),
            ));
        }
        if nodes.len() > self.declared {
            self.warnings.push(Warning::ExtraNodes {
                line: self
                    .rows
                    .get(self.declared * lines.len())
                    .map_or(self.end, |row| row.line),
                declared: self.declared,
                found: nodes.len(),
            });
            nodes.truncate(self.declared);
        }
        Ok(Trajectory {
            space,
            reference,
            nodes,
            warnings: self.warnings,
        })
    }

    fn lines_of_a_node(&self) -> &'static [Kind] {
        let from_rest = self.rows.first().is_some_and(|row| {
            row.tokens.iter().take(self.width).all(
                |token| matches!(token.text.parse::<f64>(), Ok(value) if value.abs() < f64::MIN_POSITIVE),
            )
        });
        let enough = self
            .declared
            .checked_mul(Kind::OLD_NODE.len())
            .is_some_and(|rows| self.rows.len() >= rows);
        if from_rest && enough {
            Kind::OLD_NODE
        } else {
            Kind::NODE
        }
    }

    fn incomplete_beyond_the_count(&self, rows: &[Row<'_>], lines: usize) -> TrjError {
        let (line, text) = rows
            .first()
            .and_then(|row| Some((row.line, row.tokens.first()?.text)))
            .unwrap_or((self.end, ""));
        error_at(
            line,
            1,
            Problem::Trailing,
            format!(
                "the file goes on after its {} nodes, and not with a node of {lines} lines",
                self.declared
            ),
            "end of file",
            crate::input::shown(text),
        )
    }

    fn node(
        &mut self,
        index: usize,
        rows: &[Row<'_>],
        lines: &'static [Kind],
    ) -> Result<Node, TrjError> {
        let mut node = Node {
            velocity: Vec::new(),
            acceleration: Vec::new(),
            coordinates: Vec::new(),
            line: self.end,
        };
        for (position, kind) in lines.iter().copied().enumerate() {
            let row = rows.get(position).ok_or_else(|| {
                error_at(
                    self.end,
                    1,
                    Problem::WrongCount,
                    "fewer nodes than declared",
                    format!(
                        "the {} line of node {} of {}",
                        kind.name(),
                        index + 1,
                        self.declared
                    ),
                    "end of file",
                )
            })?;
            let values = self.values(index, kind, row)?;
            match kind {
                Kind::StartVelocity | Kind::EndVelocity => {
                    if values.iter().any(|value| *value > 0.0)
                        && !self
                            .warnings
                            .iter()
                            .any(|w| matches!(w, Warning::PassingVelocity { .. }))
                    {
                        self.warnings
                            .push(Warning::PassingVelocity { line: row.line });
                    }
                }
                Kind::Velocity => node.velocity = values,
                Kind::Acceleration => node.acceleration = values,
                Kind::Coordinates => {
                    node.coordinates = values;
                    node.line = row.line;
                }
            }
        }
        Ok(node)
    }

    fn values(&mut self, index: usize, kind: Kind, row: &Row<'_>) -> Result<Vec<f64>, TrjError> {
        let found = row.tokens.len();
        if found < self.width || found > self.width.max(MAX_COLUMNS) {
            let expected = if found < self.width {
                format!("{} values", self.width)
            } else {
                format!("{} values, at most {MAX_COLUMNS}", self.width)
            };
            return Err(error_at(
                row.line,
                1,
                Problem::WrongCount,
                format!(
                    "wrong number of values in the {} line of node {}",
                    kind.name(),
                    index + 1
                ),
                expected,
                found.to_string(),
            ));
        }
        let mut values = Vec::with_capacity(self.width);
        for (column, token) in row.tokens.iter().enumerate() {
            let value = number(index, kind, token)?;
            if column < self.width {
                in_range(index, kind, token, value)?;
                values.push(value);
            }
        }
        if found > self.width {
            self.extra_columns(row.line, found);
        }
        Ok(values)
    }

    /// One warning for the file: the first line, and the widest.
    fn extra_columns(&mut self, at: u32, width: usize) {
        for warning in &mut self.warnings {
            if let Warning::ExtraColumns { found, .. } = warning {
                *found = width.max(*found);
                return;
            }
        }
        self.warnings.push(Warning::ExtraColumns {
            line: at,
            used: self.width,
            found: width,
        });
    }
}

fn number(index: usize, kind: Kind, token: &Token<'_>) -> Result<f64, TrjError> {
    let what = |problem: &str| {
        format!(
            "{problem} in the {} line of node {}",
            kind.name(),
            index + 1
        )
    };
    match token.text.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        Ok(_) => Err(token.error(
            Problem::NotFinite,
            what("not a finite number"),
            "a finite number",
        )),
        Err(_) => Err(token.error(Problem::WrongType, what("not a number"), "a number")),
    }
}

fn in_range(index: usize, kind: Kind, token: &Token<'_>, value: f64) -> Result<(), TrjError> {
    let (good, expected) = match kind {
        Kind::Velocity | Kind::Acceleration => (
            value > 0.0 && value <= 1.0,
            "a fraction greater than 0, at most 1",
        ),
        Kind::StartVelocity | Kind::EndVelocity => {
            ((0.0..=1.0).contains(&value), "a fraction from 0 to 1")
        }
        Kind::Coordinates => (true, ""),
    };
    if good {
        Ok(())
    } else {
        Err(token.error(
            Problem::OutOfRange,
            format!(
                "fraction out of range in the {} line of node {}",
                kind.name(),
                index + 1
            ),
            expected,
        ))
    }
}
