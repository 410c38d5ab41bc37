//! Reads the data files: a head of label, axes, number and duration, then a line for each axis.
use super::cases::{at, symmetric};
use motion::profile::{AxisBounds, Boundary, Request, Synchronisation};

/// Inputs of another planner, and how long it took.
pub(crate) struct Case<'a> {
    pub(crate) label: &'a str,
    pub(crate) number: u32,
    /// Nothing where the other planner failed.
    pub(crate) duration: Option<f64>,
    axes: Vec<(Boundary, Boundary, AxisBounds)>,
}

impl Case<'_> {
    pub(crate) fn axes(&self) -> usize {
        self.axes.len()
    }

    pub(crate) fn request<const N: usize>(&self) -> Request<N> {
        assert_eq!(self.axes.len(), N);
        Request {
            start: core::array::from_fn(|i| self.axes[i].0),
            end: core::array::from_fn(|i| self.axes[i].1),
            bounds: core::array::from_fn(|i| self.axes[i].2),
            synchronisation: Synchronisation::Time,
            minimum_duration: 0.0,
        }
    }
}

/// All cases of a file; lines that begin with # are for its reader.
pub(crate) fn cases(text: &str) -> Vec<Case<'_>> {
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    let mut cases = Vec::new();
    while let Some(head) = lines.next() {
        let [label, axes, number, duration] = head
            .split(' ')
            .collect::<Vec<_>>()
            .try_into()
            .expect("label, axes, number, duration");
        let count = axes.parse().unwrap();
        let axes = lines.by_ref().take(count).map(axis).collect::<Vec<_>>();
        assert_eq!(axes.len(), count);
        cases.push(Case {
            label,
            number: number.parse().unwrap(),
            duration: (duration != "-").then(|| duration.parse().unwrap()),
            axes,
        });
    }
    cases
}

/// p v a of start and end, then v a j of the limits, then the lower limits of v and a where they differ.
fn axis(line: &str) -> (Boundary, Boundary, AxisBounds) {
    let x: Vec<f64> = line.split(' ').map(|x| x.parse().unwrap()).collect();
    let mut bounds = symmetric(x[6], x[7], x[8]);
    if let [v_min, a_min] = x[9..] {
        (bounds.v_min, bounds.a_min) = (v_min, a_min);
    }
    (at(x[0], x[1], x[2]), at(x[3], x[4], x[5]), bounds)
}
