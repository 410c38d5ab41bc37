//! `C_0`: the Master Process, which coordinates any number of effectors.
//!
//! [`Mp`] is sans I/O: [`Mp::step`] takes the time, the frames that arrived, and a place to put
//! frames. No clock, bus, thread, log or chance is inside, so the same inputs give the same bytes.
//!
//! | module | one line |
//! |---|---|
//! | [`config`] | robots, and every period and time-out by name |
//! | [`arm`] | a robot whose kind is known only at run time |
//! | [`robot`] | the image of one robot: `e_c` of \[Z1\] (10) |
//! | [`sensor`] | virtual sensors of the coordinator: `v_0` |
//! | [`command`] | what robots are told in one macrostep |
//! | [`subsystem`] | the three together, as the formalism sees them |
//! | [`generator`] | motion generators of the MP level, all five classes of \[Z1\] §VI |
//! | [`condition`] | conditions of the MP level, all four classes of \[Z1\] §VII |
//! | [`mod@census`] | the list of both, counted by a test |
//! | [`behaviour`] | building blocks: handshake, homing, moving together, carrying, releasing |
//! | [`watch`] | `f_E`: what ends a job in error |
//! | [`failure`] | how a job fails, on one line |
//! | [`checklist`] | the handshake, item by item |
//! | [`event`] | what happened to the robots |
//!
//! # One step
//!
//! ```text
//!  frames ─▶ images ─▶ virtual sensors ─▶ f_E ─▶ behaviour ─▶ commands ─▶ requests, cyclic commands ─▶ frames
//!            each call                    └── once per macrostep ──┘
//! ```
//!
//! A behaviour makes one step per macrostep; where calls are late, instants are left out, and
//! generators compute with `i`, not with a count of calls. When `f_E` holds, the robots of the job
//! are told to stop on their paths in that very macrostep.

use self::config::{Config, ConfigError, Grid, ms};
use self::event::{Event, What};
use self::failure::Failure;
use self::robot::{Image, Link};
use self::sensor::{Bundle, Sensors};
use self::stop::Stopping;
use self::subsystem::{BoxedBehaviour, MpSubsystem};
use self::transport::{Lease, SESSIONS, Transport};
use self::watch::{Interoceptors, Watch};
use agent::{Input, Outcome, Process};
use protocol::clock::Master;
use protocol::cyphal::Heartbeat;
use protocol::frame::Frame;
use protocol::link::{Endpoint, Role, Statistics};
use protocol::time::Micros;

pub mod arm;
pub mod behaviour;
pub mod census;
pub mod checklist;
pub mod command;
pub mod condition;
pub mod config;
pub mod event;
pub mod failure;
pub mod generator;
mod receive;
pub mod robot;
pub mod sensor;
mod stop;
pub mod subsystem;
mod transport;
pub mod watch;

#[cfg(test)]
pub(crate) mod test;

/// A behaviour with what may go wrong with it.
pub struct Job {
    name: String,
    process: Process<BoxedBehaviour, Watch, Failure>,
    robots: Vec<usize>,
}

impl Job {
    /// A job. When `watch` or the behaviour itself finds an error, the robots of `watch` stop.
    #[must_use]
    pub fn new(name: impl Into<String>, behaviour: BoxedBehaviour, watch: Watch) -> Self {
        let robots = watch.robots().to_vec();
        Self {
            name: name.into(),
            process: Process::new(behaviour, watch),
            robots,
        }
    }
}

impl core::fmt::Debug for Job {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Job")
            .field("name", &self.name)
            .finish_non_exhaustive()
    }
}

/// What the Master Process does.
#[derive(Clone, Debug, PartialEq)]
pub enum MpStatus {
    /// No job was begun.
    Idle,
    /// The job runs.
    Running,
    /// The job has ended as it should.
    Ended,
    /// The job has ended in error.
    Failed(Failure),
}

/// The Master Process.
#[derive(Debug)]
pub struct Mp {
    config: Config,
    grid: Grid,
    endpoint: Box<Endpoint<SESSIONS>>,
    transports: Vec<Transport>,
    input: Input<MpSubsystem>,
    bundle: Bundle,
    interoceptors: Interoceptors,
    job: Option<Job>,
    status: MpStatus,
    clock: Master,
    next_sync: Micros,
    latest: Option<u32>,
    stopping: Option<Stopping>,
    events: Vec<Event>,
    nonce: u32,
}

impl Mp {
    /// A Master Process that has said and heard nothing. `nonce` distinguishes its leases from
    /// those of earlier runs.
    ///
    /// # Errors
    /// The configuration cannot be used.
    pub fn new(config: Config, nonce: u32) -> Result<Self, ConfigError> {
        config.check()?;
        let timing = &config.timing;
        let images: Vec<Image> = config
            .robots
            .iter()
            .enumerate()
            .map(|(robot, spec)| Image::new(robot, spec.clone(), timing))
            .collect();
        let lifetime = timing.steps(timing.stale_ms);
        Ok(Self {
            grid: Grid::new(timing),
            endpoint: Box::new(Endpoint::new(config.node, Role::Coordinator, config.mtu)),
            transports: images
                .iter()
                .map(|image| Transport::new(image.config().node))
                .collect(),
            bundle: Bundle::new(&images),
            input: Input {
                i: 0,
                c0: (),
                v: Sensors::new(images.len(), lifetime),
                e: images,
                t: (),
            },
            interoceptors: Interoceptors::default(),
            job: None,
            status: MpStatus::Idle,
            clock: Master::default(),
            next_sync: Micros(0),
            latest: None,
            stopping: None,
            events: Vec::new(),
            nonce,
            config,
        })
    }

    /// The configuration.
    #[must_use]
    pub const fn config(&self) -> &Config {
        &self.config
    }

    /// The instants of behaviours.
    #[must_use]
    pub const fn grid(&self) -> Grid {
        self.grid
    }

    /// The latest instant.
    #[must_use]
    pub const fn instant(&self) -> u32 {
        self.input.i
    }

    /// The images of the robots, in the order of the configuration.
    #[must_use]
    pub fn robots(&self) -> &[Image] {
        &self.input.e
    }

    /// The virtual sensors.
    #[must_use]
    pub const fn sensors(&self) -> &Sensors {
        &self.input.v
    }

    /// What the link noticed.
    #[must_use]
    pub fn link_statistics(&self) -> Statistics {
        self.endpoint.statistics()
    }

    /// What it does.
    #[must_use]
    pub const fn status(&self) -> &MpStatus {
        &self.status
    }

    /// What happened since the last call.
    pub fn events(&mut self) -> Vec<Event> {
        core::mem::take(&mut self.events)
    }

    /// Begins a job at the next instant; what ran before is forgotten, but not stopped.
    pub fn begin(&mut self, mut job: Job) {
        job.process.begin::<MpSubsystem>();
        self.interoceptors.failure = None;
        for image in &mut self.input.e {
            image.settle();
        }
        self.job = Some(job);
        self.status = MpStatus::Running;
    }

    /// One step: call it as often as convenient, at least once per macrostep. `rx` are the frames
    /// that arrived since, each with when it arrived; both times are bus time, that is ours.
    pub fn step(
        &mut self,
        now: Micros,
        rx: impl IntoIterator<Item = (Micros, Frame)>,
        tx: &mut impl FnMut(Frame),
    ) -> MpStatus {
        self.send_time(now, tx);
        self.repeat_stop(now, tx);
        let i = self.grid.index(now);
        self.set_instant(i);
        self.interoceptors.now = now;
        for (at, frame) in rx {
            if let Some(incoming) = self.endpoint.receive(&frame, at) {
                self.hear(now, incoming);
            }
        }
        self.check_links(now);
        self.bundle.read(i, &self.input.e, &mut self.input.v);
        let new_instant = self.latest.is_none_or(|latest| i > latest);
        if new_instant {
            self.latest = Some(i);
            self.step_job(now, tx);
        }
        let each = self.transports.iter_mut().zip(&mut self.input.e);
        for (transport, image) in each {
            let timing = &self.config.timing;
            transport.send_requests(image, now, timing, &mut self.endpoint, tx);
            if new_instant {
                transport.send_commands(image, now, timing, &mut self.endpoint, tx);
            }
        }
        self.endpoint.poll_heartbeat(now, Heartbeat::of_mp, tx);
        self.status.clone()
    }

    fn set_instant(&mut self, i: u32) {
        self.input.i = i;
        self.input.v.set_instant(i);
        for image in &mut self.input.e {
            image.set_instant(i);
        }
    }

    fn send_time(&mut self, now: Micros, tx: &mut impl FnMut(Frame)) {
        if now < self.next_sync {
            return;
        }
        let period = ms(self.config.timing.time_sync_ms);
        let next = self.next_sync + period;
        self.next_sync = if now < next { next } else { now + period };
        let message = self.clock.message();
        if self.endpoint.send_time_sync(&message, tx).is_ok() {
            self.clock.sent(now);
        }
    }

    /// Corrects when the last time message really left, where the rim knows better than the time
    /// given to [`Mp::step`].
    pub const fn time_message_left(&mut self, at: Micros) {
        self.clock.sent(at);
    }

    /// Silence for too long ends an exchange.
    fn check_links(&mut self, now: Micros) {
        let silence = ms(self.config.timing.silence_ms);
        for (robot, image) in self.input.e.iter_mut().enumerate() {
            let silent = image.heard_at.is_none_or(|at| now.since(at) > silence);
            if silent && *image.link() != Link::Silent {
                image.link = Link::Silent;
                if let Some(transport) = self.transports.get_mut(robot) {
                    transport.clear();
                }
                self.events.push(Event {
                    at: now,
                    what: What::Lost { robot },
                });
            }
        }
    }

    fn step_job(&mut self, now: Micros, tx: &mut impl FnMut(Frame)) {
        let Some(job) = &mut self.job else { return };
        let failure = match job
            .process
            .step(&self.input, &self.interoceptors, &(), &mut ())
        {
            Outcome::Hold => return,
            Outcome::Ended { .. } => {
                self.job = None;
                self.status = MpStatus::Ended;
                return;
            }
            Outcome::Error { fault, .. } => fault,
            Outcome::Demand(commands) => {
                let Some(failure) = commands.give_up else {
                    self.take(commands.robots);
                    return;
                };
                failure
            }
        };
        self.stop_group(now, tx);
        self.end_in_error(now, failure);
    }

    fn take(&mut self, commands: Vec<(usize, command::RobotCommand)>) {
        let lease = Lease {
            nonce: self.nonce,
            term_ms: self.config.timing.lease_ms,
            takeover: self.config.takeover,
        };
        for (robot, command) in commands {
            let pair = self
                .transports
                .get_mut(robot)
                .zip(self.input.e.get_mut(robot));
            if let Some((transport, image)) = pair {
                transport.take(image, command, &lease);
            }
        }
    }

    fn end_in_error(&mut self, at: Micros, failure: Failure) {
        let Some(job) = self.job.take() else { return };
        let what = What::Failed {
            job: job.name,
            failure: failure.clone(),
        };
        self.events.push(Event { at, what });
        self.status = MpStatus::Failed(failure);
    }

    /// Is nothing waiting for an answer?
    #[must_use]
    pub fn is_quiet(&self) -> bool {
        self.transports.iter().all(Transport::is_idle) && self.stopping.is_none()
    }
}
