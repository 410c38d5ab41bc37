//! The controller node: link, lease, ECP and EDP of one robot, as one pure step function.
//!
//! ```text
//!  t_k          SYNC out: drives latch the targets of cycle k−1 and sample their actual values
//!  t_k + Ts/2   answers are in: supervise, orders and plans of the ECP, EDP; targets out for SYNC k+1
//! ```
//! The age of feedback is one cycle, constantly. [`Node::step`] is called whenever
//! [`Node::next_wake`] has come, or earlier with frames that have arrived; it decides what is due.
//!
//! A node has two halves. The [`Foreground`] has the servo period as its deadline; the [`Ecp`] has eight of the ten
//! servo steps of a macrostep, as an order and a plan ([`Foreground::take_order`], [`Ecp::work`]). [`Node::step`] does
//! both one after the other; a board lets servo steps preempt the ECP ([`Node::halves`]). What comes of it is the
//! same, since a plan is taken when the time of the hand-over has passed and not before.

mod foreground;
mod keep;
mod report;
mod work;

pub use foreground::{FIRMWARE_VERSION, Foreground};
pub use report::FEEDBACK_STEPS;

use crate::capacity::PATH_SAMPLES;
use crate::config::{ConfigError, NodeConfig};
use crate::ecp::{Ecp, NoPrograms, Programs};
use crate::edp::envelopes::envelopes;
use crate::edp::{Edp, EdpSetup};
use crate::io::{Port, Received};
use crate::maintenance::Asked;
use crate::maintenance::black_box::Signals;
use protocol::frame::Frame;
use protocol::maintenance::MaintenanceReply;
use protocol::message::{Identity, NodeState, ServoLaw};
use protocol::time::Micros;
use robots::Robot;

/// One robot's controller, which looks at W samples of a path: see [`PATH_SAMPLES`].
#[derive(Debug)]
pub struct Node<R, const N: usize, P = NoPrograms, const W: usize = PATH_SAMPLES> {
    foreground: Foreground<R, N>,
    ecp: Ecp<R, N, P, W>,
}

/// A robot and a configuration that has been found good: all that can fail before there is a node.
#[derive(Clone, Debug)]
pub struct NodeSetup<R, const N: usize> {
    robot: R,
    config: NodeConfig<N>,
    edp: EdpSetup<N>,
}

impl<R: Robot<N> + Copy, const N: usize> NodeSetup<R, N> {
    /// # Errors
    /// [`ConfigError`]
    pub fn new(robot: R, config: NodeConfig<N>) -> Result<Self, ConfigError> {
        config.validate()?;
        if config.law == ServoLaw::ComputedTorque && robot.chain().is_none() {
            return Err(ConfigError::ServoLaw);
        }
        let edp = EdpSetup::new(&robot, &config);
        edp.validate(envelopes(robot.description(), config.velocity_factor, true))?;
        Ok(Self { robot, config, edp })
    }

    /// One half of its node, for a rim that keeps the halves apart; so nothing as large as a node is ever moved.
    #[expect(
        clippy::inline_always,
        reason = "so that what is large is made where it stays, and not on the stack"
    )]
    #[inline(always)]
    pub fn ecp<P: Programs<N>, const W: usize>(&self, programs: P) -> Ecp<R, N, P, W> {
        let limits = EdpSetup::generator_limits(&self.robot, self.config.velocity_factor);
        let macrostep_s = self.edp.constants.macrostep.as_secs_f64();
        Ecp::new(self.robot, limits, macrostep_s, programs)
    }

    /// The other half, begun at `now`.
    pub fn foreground(self, now: Micros) -> Foreground<R, N> {
        Foreground::new(now, self)
    }
}

impl<R: Robot<N> + Copy, const N: usize> Node<R, N> {
    /// A node with the built-in instructions only.
    ///
    /// # Errors
    /// [`ConfigError`]
    pub fn new(now: Micros, robot: R, config: NodeConfig<N>) -> Result<Self, ConfigError> {
        Self::with_programs(now, robot, config, NoPrograms)
    }
}

impl<R: Robot<N> + Copy, const N: usize, P: Programs<N>> Node<R, N, P> {
    /// A node into which the user's programs are linked.
    ///
    /// # Errors
    /// [`ConfigError`]
    pub fn with_programs(
        now: Micros,
        robot: R,
        config: NodeConfig<N>,
        programs: P,
    ) -> Result<Self, ConfigError> {
        Ok(Self::of(now, NodeSetup::new(robot, config)?, programs))
    }
}

impl<R: Robot<N> + Copy, const N: usize, P: Programs<N>, const W: usize> Node<R, N, P, W> {
    /// The node of a setup; it is large, so this comes last, where it is to stay.
    pub fn of(now: Micros, setup: NodeSetup<R, N>, programs: P) -> Self {
        Self {
            ecp: setup.ecp(programs),
            foreground: setup.foreground(now),
        }
    }

    /// Both halves, for a rim in which servo steps preempt the ECP's work.
    pub const fn halves(&mut self) -> (&mut Foreground<R, N>, &mut Ecp<R, N, P, W>) {
        (&mut self.foreground, &mut self.ecp)
    }

    /// The state as seen from outside.
    pub fn state(&self) -> NodeState {
        self.foreground.state()
    }

    /// The EDP, to look at.
    pub const fn edp(&self) -> &Edp<R, N> {
        self.foreground.edp()
    }

    /// Who it is.
    pub fn identity(&self) -> Identity {
        self.foreground.identity()
    }

    /// When [`Node::step`] must be called next, local time.
    pub fn next_wake(&self) -> Micros {
        self.foreground.next_wake()
    }

    /// Take what has arrived and do what is due, the ECP's work included. Bounded work; no clock, no bus.
    pub fn step(&mut self, now: Micros, rx: &[Received], tx: &mut impl FnMut(Port, Frame)) {
        self.foreground.step(now, rx, Some(&mut self.ecp), tx);
        if self.foreground.take_order() {
            self.ecp.work();
        }
    }

    /// [`Foreground::servo_step`]
    pub const fn servo_step(&self) -> u32 {
        self.foreground.servo_step()
    }

    /// [`Foreground::signals`]
    pub fn signals(&self) -> Signals {
        self.foreground.signals()
    }

    /// [`Foreground::take_asked`]
    pub const fn take_asked(&mut self) -> Option<Asked> {
        self.foreground.take_asked()
    }

    /// [`Foreground::answer`]
    pub fn answer(
        &mut self,
        asked: &Asked,
        reply: &MaintenanceReply,
        tx: &mut impl FnMut(Port, Frame),
    ) {
        self.foreground.answer(asked, reply, tx);
    }
}
