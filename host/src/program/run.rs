//! A task from the handshake to the leases given back. Whatever happens in between, it ends with
//! the robots at rest.

mod status;
mod work;

pub use status::{RunError, RunStatus};

use super::plan::{Motion, Place, Plan, PlanError, Work};
use super::progress::{Progress, Segment};
use crate::mp::behaviour::{self, sequence};
use crate::mp::checklist::Checklist;
use crate::mp::config::{Config, ConfigError, ms};
use crate::mp::event::What;
use crate::mp::failure::{Awaited, Failure};
use crate::mp::generator::Readiness;
use crate::mp::robot::Image;
use crate::mp::watch::Watch;
use crate::mp::{Job, Mp, MpStatus};
use crate::task::Task;
use protocol::frame::Frame;
use protocol::message::{NodeState, StopKind};
use protocol::time::Micros;
use std::path::PathBuf;

/// The label of the decision that tells robots in loose coordination which node is next; its variant
/// is the node's number, from 1.
pub const NEXT_NODE: u16 = 1;

#[derive(Clone, Debug, PartialEq)]
enum Phase {
    /// Who are they, and where?
    Identify,
    /// Leases and torque.
    Ready,
    /// The step of this index.
    Step(usize),
    /// Coming to rest, since.
    Rest(Micros),
    Release,
    Ended,
}

/// A task being run.
#[derive(Debug)]
pub struct Run {
    mp: Mp,
    task: Task,
    path: Option<PathBuf>,
    plan: Option<Plan>,
    places: Vec<Place>,
    phase: Phase,
    /// When every node had said who it is.
    identified_at: Option<Micros>,
    error: Option<RunError>,
    progress: Vec<Progress>,
    /// Per robot: number of the latest instruction before the step, and the motions of the step.
    given: Vec<(u32, Vec<Motion>)>,
    told: Vec<usize>,
    segments: Vec<Segment>,
    group: usize,
    /// Per robot: where on its path it was last, m, and how many tenths were told.
    on_path: Vec<(f64, u32)>,
}

impl Run {
    /// A run of a task on the robots of `config`, which is the task's cell (see
    /// [`super::config_of`]). `path` is the task's file, for messages; `nonce` distinguishes its
    /// leases from those of other runs.
    ///
    /// # Errors
    /// The configuration cannot be used.
    pub fn new(
        task: Task,
        path: Option<PathBuf>,
        config: Config,
        nonce: u32,
    ) -> Result<Self, ConfigError> {
        let mut mp = Mp::new(config, nonce)?;
        let robots: Vec<usize> = (0..mp.robots().len()).collect();
        let timing = mp.config().timing;
        mp.begin(Job::new(
            "identify",
            behaviour::get_ready(robots.clone(), Readiness::Identified, timing),
            Watch::requests(robots.clone()),
        ));
        Ok(Self {
            task,
            path,
            plan: None,
            places: Vec::new(),
            phase: Phase::Identify,
            identified_at: None,
            error: None,
            progress: Vec::new(),
            given: vec![(0, Vec::new()); robots.len()],
            told: vec![0; robots.len()],
            segments: vec![Segment::None; robots.len()],
            group: 0,
            on_path: vec![(0.0, 0); robots.len()],
            mp,
        })
    }

    /// The Master Process.
    #[must_use]
    pub const fn mp(&self) -> &Mp {
        &self.mp
    }

    /// The Master Process, for example to correct [`Mp::time_message_left`].
    pub const fn mp_mut(&mut self) -> &mut Mp {
        &mut self.mp
    }

    /// The plan, once the robots are known.
    #[must_use]
    pub const fn plan(&self) -> Option<&Plan> {
        self.plan.as_ref()
    }

    /// The handshake of every robot, item by item.
    #[must_use]
    pub fn checklists(&self) -> Vec<Checklist> {
        let failure = match &self.error {
            Some(RunError::Failure { failure, .. }) => Some(failure),
            Some(RunError::Plan(_)) | None => None,
        };
        self.mp
            .robots()
            .iter()
            .map(|image| Checklist::of(image, failure))
            .collect()
    }

    /// What a robot is executing.
    #[must_use]
    pub fn segment(&self, robot: usize) -> &Segment {
        self.segments.get(robot).unwrap_or(&Segment::None)
    }

    /// The step that runs, from 1.
    #[must_use]
    pub const fn current_step(&self) -> Option<usize> {
        match self.phase {
            Phase::Step(index) => Some(index + 1),
            _ => None,
        }
    }

    /// What happened since the last call.
    pub fn progress(&mut self) -> Vec<Progress> {
        core::mem::take(&mut self.progress)
    }

    /// One step, as [`Mp::step`].
    pub fn step(
        &mut self,
        now: Micros,
        rx: impl IntoIterator<Item = (Micros, Frame)>,
        tx: &mut impl FnMut(Frame),
    ) -> RunStatus {
        let status = self.mp.step(now, rx, tx);
        let events = self.mp.events();
        for event in &events {
            if let What::LeaseLost { robot, .. } | What::Lost { robot } = event.what {
                self.set_segment(robot, Segment::None);
            }
        }
        self.progress
            .extend(events.into_iter().map(Progress::Robot));
        self.watch_nodes();
        self.watch_paths();
        match status {
            MpStatus::Failed(failure) if !self.is_winding_up() => {
                let step = self.step_name();
                self.fail(now, RunError::Failure { step, failure });
            }
            MpStatus::Ended | MpStatus::Failed(_) | MpStatus::Idle => self.go_on(now),
            MpStatus::Running => {}
        }
        match (&self.phase, &self.error) {
            (Phase::Ended, None) => RunStatus::Done,
            (Phase::Ended, Some(error)) => RunStatus::Failed(error.clone()),
            _ => RunStatus::Running,
        }
    }

    /// Ends the run: everyone stops now, then the leases are given back.
    pub fn stop(&mut self, kind: StopKind, now: Micros, tx: &mut impl FnMut(Frame)) {
        if self.phase == Phase::Ended {
            return;
        }
        self.mp.stop(kind, now, tx);
        if !self.is_winding_up() {
            let step = self.step_name();
            let failure = Failure::Stopped { kind };
            self.fail(now, RunError::Failure { step, failure });
        }
    }

    const fn is_winding_up(&self) -> bool {
        matches!(self.phase, Phase::Rest(_) | Phase::Release | Phase::Ended)
    }

    fn step_name(&self) -> Option<String> {
        match self.phase {
            Phase::Step(index) => Some(self.plan.as_ref()?.steps.get(index)?.name.clone()),
            _ => None,
        }
    }

    fn fail(&mut self, now: Micros, error: RunError) {
        self.error.get_or_insert(error);
        self.segments
            .iter_mut()
            .for_each(|segment| *segment = Segment::None);
        self.phase = Phase::Rest(now);
    }

    /// A job has ended: what comes next?
    fn go_on(&mut self, now: Micros) {
        match self.phase.clone() {
            Phase::Identify => {
                if self
                    .mp
                    .robots()
                    .iter()
                    .all(|image| image.feedback().fresh().is_some())
                {
                    match self.plan_from(now) {
                        Ok(()) => self.begin_ready(),
                        Err(error) => self.fail(now, RunError::Plan(error)),
                    }
                } else if let Some(failure) = self.silent(now) {
                    self.fail(
                        now,
                        RunError::Failure {
                            step: None,
                            failure,
                        },
                    );
                }
            }
            Phase::Ready => {
                // drives that were without torque may have sagged a little
                if let Err(error) = self.plan_from(now) {
                    self.fail(now, RunError::Plan(error));
                    return;
                }
                self.progress.push(Progress::Ready);
                self.begin_step(now, 0);
            }
            Phase::Step(index) => self.end_of_job(now, index),
            Phase::Rest(since) => self.rest(now, since),
            Phase::Release => {
                self.progress.push(Progress::Released);
                self.phase = Phase::Ended;
            }
            Phase::Ended => {}
        }
    }

    /// A node that answered but sends no feedback.
    fn silent(&mut self, now: Micros) -> Option<Failure> {
        let since = *self.identified_at.get_or_insert(now);
        let span_ms = self.mp.config().timing.identify_ms;
        let silent = |image: &&Image| image.feedback().fresh().is_none();
        let image = self.mp.robots().iter().find(silent)?;
        (now.since(since) > ms(span_ms)).then(|| Failure::Lost {
            who: image.who(),
            span_ms,
        })
    }

    fn plan_from(&mut self, _: Micros) -> Result<(), PlanError> {
        let places: Vec<Place> = self.mp.robots().iter().map(place).collect();
        let same = self.places.len() == places.len()
            && self
                .places
                .iter()
                .zip(&places)
                .zip(self.mp.robots())
                .all(|((a, b), image)| a.is_near(b, image.arm()));
        if self.plan.is_none() || !same {
            let config = self.mp.config();
            let plan = Plan::new(&self.task, self.path.as_deref(), config, places.clone())?;
            self.plan = Some(plan);
            self.places = places;
        }
        Ok(())
    }

    fn begin_ready(&mut self) {
        let robots: Vec<usize> = (0..self.mp.robots().len()).collect();
        let timing = self.mp.config().timing;
        let mut parts = vec![behaviour::get_ready(
            robots.clone(),
            Readiness::Enabled,
            timing,
        )];
        if self.mp.config().trace_every > 0 {
            parts.push(behaviour::trace(&robots, self.mp.config().trace_every));
        }
        let ready = sequence(parts);
        self.mp
            .begin(Job::new("get ready", ready, Watch::requests(robots)));
        self.phase = Phase::Ready;
    }

    fn begin_step(&mut self, now: Micros, index: usize) {
        let Some(plan) = &self.plan else { return };
        let Some(step) = plan.steps.get(index).cloned() else {
            self.phase = Phase::Rest(now);
            return;
        };
        self.progress.push(Progress::StepBegan {
            step: index + 1,
            of: plan.steps.len(),
            name: step.name.clone(),
        });
        self.phase = Phase::Step(index);
        self.group = 0;
        self.on_path.fill((0.0, 0));
        self.give(&step.work);
        self.begin_work(now, &step.name, &step.work);
    }

    fn end_of_job(&mut self, now: Micros, index: usize) {
        let step = self
            .plan
            .as_ref()
            .and_then(|plan| plan.steps.get(index))
            .cloned();
        if let Some(step) = step
            && let Work::Groups(groups) = &step.work
            && self.group + 1 < groups.len()
        {
            self.group += 1;
            self.begin_work(now, &step.name, &step.work);
            return;
        }
        self.segments
            .iter_mut()
            .for_each(|segment| *segment = Segment::None);
        self.progress.push(Progress::StepEnded { step: index + 1 });
        self.begin_step(now, index + 1);
    }

    fn rest(&mut self, now: Micros, since: Micros) {
        let ours = || {
            self.mp
                .robots()
                .iter()
                .filter(|image| image.epoch().is_some())
        };
        let late = now.since(since) > ms(self.mp.config().timing.rest_ms);
        let moving = ours().find(|image| !image.is_at_rest());
        // a stop takes a moment to show in the images
        let settled = self.mp.is_quiet() && now.since(since) > ms(self.mp.config().timing.stale_ms);
        match moving {
            None if !settled && !late => return,
            None => self.progress.push(Progress::AtRest),
            Some(_) if !late => return,
            Some(image) => {
                let seen = image
                    .state()
                    .map_or("no fresh feedback".to_owned(), |s| format!("{s:?}"));
                let span_ms = self.mp.config().timing.rest_ms;
                let failure = Failure::TimedOut {
                    who: image.who(),
                    awaited: Awaited::Rest,
                    span_ms,
                    seen,
                };
                self.error.get_or_insert(RunError::Failure {
                    step: None,
                    failure,
                });
            }
        }
        let robots: Vec<usize> = (0..self.mp.robots().len()).collect();
        let torque_off = self.mp.config().torque_off_at_end;
        let release = behaviour::release(self.mp.robots(), torque_off);
        self.mp
            .begin(Job::new("release", release, Watch::requests(robots)));
        self.phase = Phase::Release;
    }

    fn set_segment(&mut self, robot: usize, segment: Segment) {
        if let Some(slot) = self.segments.get_mut(robot) {
            *slot = segment;
        }
    }
}

/// Where a robot is: its set-points under torque, else what it measures.
fn place(image: &Image) -> Place {
    let motors = match image.state() {
        Some(NodeState::Holding) => image.demanded_motors(),
        _ => image.actual_motors(),
    };
    match motors {
        Some(motors) => Place {
            motors,
            homed: image.is_homed(),
            guessed: false,
        },
        None => Place::unknown(image.arm()),
    }
}
