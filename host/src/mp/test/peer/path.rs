//! How the peer takes a path: element by element, with little room.

use super::{Doing, Peer, pose};
use protocol::fault::{PathProblem, Refusal};
use protocol::message::{PathElement, Progress, Reply, Request};
use protocol::time::Micros;

/// What a test makes the peer do on a path.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PathScript {
    /// Elements it has room for.
    pub(crate) capacity: usize,
    /// How long it takes for each, ms.
    pub(crate) element_ms: u64,
    /// It refuses the element of this number.
    pub(crate) refuse: Option<u32>,
    /// It wants nothing from the element of this number on.
    pub(crate) closed_from: Option<usize>,
}

impl Default for PathScript {
    fn default() -> Self {
        Self {
            capacity: 6,
            element_ms: 4,
            refuse: None,
            closed_from: None,
        }
    }
}

/// What the peer has of a path.
#[derive(Clone, Debug, Default)]
pub(crate) struct Taken {
    pub(crate) elements: Vec<PathElement>,
    /// How many it has passed.
    pub(crate) passed: usize,
    /// The number and the count of every request.
    pub(crate) requests: Vec<(u32, usize)>,
    /// Elements that came where there was no room for them.
    pub(crate) unwelcome: usize,
    /// What it was told of its feed, and when.
    pub(crate) overrides: Vec<(Micros, f32)>,
}

impl Peer {
    fn room(&self) -> usize {
        let kept = self.path.elements.len() - self.path.passed;
        let free = self.script.path.capacity.saturating_sub(kept);
        let open = self.script.path.closed_from.map_or(free, |from| {
            from.saturating_sub(self.path.elements.len()).min(free)
        });
        match self.path.elements.last() {
            Some(PathElement::End) => 0,
            _ => open,
        }
    }

    /// A request that concerns a path, and no other.
    pub(super) fn path_request(
        &mut self,
        now: Micros,
        from: u8,
        request: &Request,
    ) -> Result<Reply, Refusal> {
        if let Request::Path {
            epoch,
            first,
            elements,
        } = request
        {
            self.authorise(from, *epoch)?;
            return self.take_path(*first, elements);
        }
        if let Request::FeedOverride { epoch, share } = request {
            self.authorise(from, *epoch)?;
            self.path.overrides.push((now, *share));
        }
        Ok(Reply::Accepted)
    }

    fn take_path(&mut self, first: u32, elements: &[PathElement]) -> Result<Reply, Refusal> {
        if !matches!(self.doing, Doing::Path { .. }) {
            return Err(Refusal::WrongState { state: self.state });
        }
        self.path.requests.push((first, elements.len()));
        for (number, element) in (first..).zip(elements) {
            let known = u32::try_from(self.path.elements.len()).unwrap();
            if number < known {
                continue;
            }
            if number > known || self.room() == 0 {
                self.path.unwelcome += 1;
                break;
            }
            if self.script.path.refuse == Some(number) {
                let problem = PathProblem::NoLength;
                self.done();
                self.progress = Progress::Failed(Refusal::Path {
                    element: number,
                    problem,
                });
                break;
            }
            self.path.elements.push(*element);
        }
        Ok(Reply::Path {
            next: u32::try_from(self.path.elements.len()).unwrap(),
            room: u16::try_from(self.room()).unwrap(),
        })
    }

    /// Time passes on the path.
    pub(super) fn pass(&mut self, now: Micros, next: Option<Micros>) {
        let Some(element) = self.path.elements.get(self.path.passed).copied() else {
            return;
        };
        let held = self
            .path
            .overrides
            .last()
            .is_some_and(|(_, share)| *share <= 0.0);
        let due = next.unwrap_or(now);
        if now < due || held {
            return;
        }
        self.path.passed += 1;
        self.doing = Doing::Path {
            next: Some(now + Micros::from_millis(self.script.path.element_ms)),
        };
        match element {
            PathElement::Through(to)
            | PathElement::Line { to, .. }
            | PathElement::Arc { to, .. } => self.motors = self.straight_to(pose(&to)),
            PathElement::End => self.done(),
            PathElement::Feed { .. } => {}
        }
    }
}
