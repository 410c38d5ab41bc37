//! Drives and mechanics in real time, on buses between processes.
//!
//! The simulated robot is the one of the lock-step [`crate::cell`]; here is only its rim: a clock
//! and the buses. A simulator that is late says so in its [`Statistics`] instead of pretending.

mod broken;
pub mod clock;

use crate::fault::Schedule;
use crate::plant::robot::{Sent, SimRobot};
use broken::BrokenBuses;
use bus::{Bus, BusError, StateChange, now};
use clock::{Clock, Held};
use process::Lateness;
use protocol::frame::{Frame, Id};
use protocol::time::Micros;
use std::fmt;
use std::thread;
use std::time::Duration;

/// Frames are looked for at least this often; what drives send by themselves is no later.
const TURN: Micros = Micros(1000);
/// The same with several buses: only one can be waited for, and SYNC is on all of them.
const SHORT_TURN: Micros = Micros(250);
/// Buses that cannot be waited for are looked at this often.
const LOOK: Duration = Duration::from_micros(250);

/// How a robot's buses are waited for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Waiting {
    /// [`Bus::wait`] on the first bus: the node sends SYNC on all of them at once.
    Wake,
    /// By looking every now and then: where `wait` is coarser than that.
    Look,
}

/// What happened so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Statistics {
    /// Simulated time, ns.
    pub simulated_ns: u64,
    /// Frames received.
    pub received: u64,
    /// Frames sent.
    pub sent: u64,
    /// Frames for which the transport had no room.
    pub dropped: u64,
    /// How often the simulator was late by more than a servo period.
    pub late: u64,
    /// The worst lateness.
    pub late_worst: Duration,
    /// How often and how long simulated time waited for a SYNC.
    pub held: Held,
}

/// One robot on its drive buses.
pub struct LiveRobot {
    robot: SimRobot,
    buses: Vec<Box<dyn Bus + Send>>,
    waiting: Waiting,
    clock: Clock,
    lateness: Lateness,
    origin: Micros,
    arrived: Vec<(u8, Micros, Frame)>,
    outgoing: Vec<Sent>,
    statistics: Statistics,
    faults: Schedule,
    broken: BrokenBuses,
}

impl fmt::Debug for LiveRobot {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("LiveRobot")
            .field("robot", &self.robot)
            .field("statistics", &self.statistics())
            .finish_non_exhaustive()
    }
}

impl LiveRobot {
    /// A robot that is switched on now; `buses` are its drive buses in their order, `period` its
    /// servo step.
    #[must_use]
    pub fn new(
        robot: SimRobot,
        buses: Vec<Box<dyn Bus + Send>>,
        waiting: Waiting,
        clock: Clock,
        period: Micros,
    ) -> Self {
        Self {
            broken: BrokenBuses::new(&robot, buses.len()),
            faults: Schedule::default(),
            robot,
            buses,
            waiting,
            clock,
            lateness: Lateness::new(period.into()),
            origin: now(),
            arrived: Vec::new(),
            outgoing: Vec::new(),
            statistics: Statistics::default(),
        }
    }

    /// These break when they are due, and no others any more; all are of this robot.
    #[must_use]
    pub fn with_faults(mut self, faults: Schedule) -> Self {
        self.faults = faults;
        self
    }

    /// Breaks what is due at `sim_ns`.
    fn break_due(&mut self, sim_ns: u64) {
        while let Some((_, broken)) = self.faults.take(sim_ns) {
            self.broken.apply(broken, &mut self.robot);
        }
    }

    /// What happened so far.
    #[must_use]
    pub fn statistics(&self) -> Statistics {
        Statistics {
            simulated_ns: self.robot.now_ns(),
            held: self.clock.held(),
            late: self.lateness.overruns(),
            late_worst: self.lateness.worst(),
            ..self.statistics
        }
    }

    /// How late it looked at frames, beside when the first of them came or it had wanted to be called.
    #[must_use]
    pub const fn lateness(&self) -> &Lateness {
        &self.lateness
    }

    /// A CAN controller of its buses whose state has changed: each change is told once.
    pub fn take_change(&mut self) -> Option<StateChange> {
        self.buses.iter_mut().find_map(Bus::take_change)
    }

    /// Waits for frames, a millisecond at most, and runs drives and mechanics up to now.
    ///
    /// # Errors
    /// When a bus has failed.
    pub fn turn(&mut self) -> Result<(), BusError> {
        let turn = if self.buses.len() > 1 {
            SHORT_TURN
        } else {
            TURN
        };
        let deadline = now() + turn;
        match (self.waiting, self.buses.first_mut()) {
            (Waiting::Wake, Some(first)) => first.wait(deadline)?,
            (Waiting::Wake | Waiting::Look, _) => thread::sleep(LOOK),
        }
        for (number, bus) in (0_u8..).zip(&mut self.buses) {
            while let Some(received) = bus.receive()? {
                if matches!(received.frame.id(), Id::Standard(_)) {
                    self.arrived.push((number, received.at, received.frame));
                }
            }
        }
        self.arrived.sort_by_key(|(_, at, _)| *at);
        let woken = now();
        let oldest = self.arrived.first().map_or(woken, |(_, at, _)| *at);
        self.lateness
            .record(woken.since(oldest.min(deadline)).into());
        let mut arrived = std::mem::take(&mut self.arrived);
        for (bus, at, frame) in arrived.drain(..) {
            self.statistics.received += 1;
            let wall_ns = self.wall_ns(at);
            // of all frames to the drives only SYNC carries nothing
            if frame.data().is_empty() {
                self.clock.synced(wall_ns);
            }
            let sim_ns = self.clock.at(wall_ns);
            self.break_due(sim_ns);
            let (outgoing, broken) = (&mut self.outgoing, &self.broken);
            self.robot.deliver(
                bus,
                sim_ns,
                &frame,
                &|axis| broken.hears(bus, axis),
                &mut |sent| outgoing.push(sent),
            );
            self.send()?;
        }
        self.arrived = arrived;
        let sim_ns = self.clock.at(self.wall_ns(now()));
        self.break_due(sim_ns);
        let outgoing = &mut self.outgoing;
        self.robot.advance(sim_ns, &mut |sent| outgoing.push(sent));
        self.send()
    }

    fn wall_ns(&self, at: Micros) -> u64 {
        at.since(self.origin).0.saturating_mul(1000)
    }

    fn send(&mut self) -> Result<(), BusError> {
        for sent in self.outgoing.drain(..) {
            if !self.broken.passes(&sent) {
                continue;
            }
            let Some(bus) = self.buses.get_mut(usize::from(sent.bus)) else {
                continue;
            };
            match bus.send(&sent.frame) {
                Ok(()) => self.statistics.sent += 1,
                // as on any bus: the frame is lost, and whoever misses it notices
                Err(BusError::Full { .. } | BusError::Down { .. }) => self.statistics.dropped += 1,
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }
}
