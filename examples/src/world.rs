//! The world: arms, their drives and mechanics, the buses, and the Master Process.

use anyhow::{Context as _, Result, bail};
use bus::wire::Kind;
use core::fmt::Debug;
use firmware::ecp::Programs;
use firmware::{DriveAddress, Node, NodeProcess, Station};
use hil_sim::cell::Cell as SimCell;
use host::mp::behaviour::{get_ready, home, sequence};
use host::mp::event::What;
use host::mp::generator::Readiness;
use host::mp::subsystem::BoxedBehaviour;
use host::mp::watch::Watch;
use host::mp::{Job, Mp, MpStatus};
use host::program::config_of;
use host::task::Cell;
use motion::Pose;
use protocol::message::ServoLaw;
use protocol::time::Micros;
use protocol::transfer::Mtu;
use protocol::units::PerAxis;
use robots::{Irp6Postument, Irp6Track, Robot, RobotKind, TrackRule};

/// A servo step of the IRp-6: the world is looked at this often.
const SERVO_STEP: Micros = Micros(2000);
/// No example takes longer; what does has got stuck.
const PATIENCE: Micros = Micros::from_millis(300_000);
/// Seed of the friction, offsets and starting places of the simulated arms.
const SEED: u64 = 1;

/// An arm whose node has programs of the user linked in.
#[derive(Debug)]
pub struct Arm {
    kind: RobotKind,
    node: Box<dyn NodeProcess + Send>,
    drives: Vec<DriveAddress>,
}

impl Arm {
    /// The IRp-6 on its postument: six axes.
    ///
    /// # Errors
    /// None: its configuration is right.
    pub fn postument(programs: impl Programs<6> + Debug + Send + 'static) -> Result<Self> {
        let kind = RobotKind::Irp6Postument;
        Self::new(kind, Irp6Postument, programs)
    }

    /// The IRp-6 on its track: seven axes.
    ///
    /// # Errors
    /// None: its configuration is right.
    pub fn track(programs: impl Programs<7> + Debug + Send + 'static) -> Result<Self> {
        Self::new(RobotKind::Irp6Track, Irp6Track::KEEP, programs)
    }

    fn new<R, P, const N: usize>(kind: RobotKind, robot: R, programs: P) -> Result<Self>
    where
        R: Robot<N> + Copy + Debug + Send + 'static,
        P: Programs<N> + Debug + Send + 'static,
    {
        let station = Station {
            effector: kind.effector(),
            unique_id: SEED,
            mtu: Mtu::Fd,
            law: ServoLaw::DrivePosition,
            velocity_factor: 0.2,
            one_wire: false,
            track: TrackRule::Keep,
        };
        let config = station.config(robot.description().drive_buses())?;
        let node = Node::with_programs(Micros(0), robot, config, programs)?;
        Ok(Self {
            kind,
            node: Box::new(node),
            drives: config.drives.to_vec(),
        })
    }
}

/// Arms with their drives, mechanics and buses, and the Master Process, on one virtual clock.
#[derive(Debug)]
pub struct World {
    /// The Master Process; robots are numbered as the arms were given, from 0.
    pub mp: Mp,
    cell: SimCell,
    faults: usize,
}

impl World {
    /// Arms that have just been switched on, somewhere. They share one CAN FD bus with the Master
    /// Process, and stand where the original laboratory has them.
    ///
    /// # Errors
    /// The same kind of arm twice, or an arm that cannot be simulated.
    pub fn new(arms: Vec<Arm>) -> Result<Self> {
        let kinds: Vec<RobotKind> = arms.iter().map(|arm| arm.kind).collect();
        let config = config_of(&Cell::of(&kinds)).context("too many arms")?;
        let mut cell = SimCell::new(Kind::Fd);
        for arm in arms {
            cell.add_node(arm.kind, arm.node, &arm.drives, SEED)?;
        }
        Ok(Self {
            mp: Mp::new(config, 1)?,
            cell,
            faults: 0,
        })
    }

    /// Handshake, torque on, homing: every arm holds, and knows where it is.
    ///
    /// # Errors
    /// As [`World::run`].
    pub fn get_ready(&mut self) -> Result<()> {
        let (robots, timing) = (self.all(), self.mp.config().timing);
        let enabled = get_ready(robots.clone(), Readiness::Enabled, timing);
        let job = sequence(vec![enabled, home(robots.clone(), timing)]);
        self.go("get ready", job, Watch::requests(robots), |_| {})
    }

    /// Run a behaviour of the Master Process to its end.
    ///
    /// # Errors
    /// It ended in error, or never.
    pub fn run(&mut self, behaviour: BoxedBehaviour) -> Result<()> {
        self.watch(behaviour, |_| {})
    }

    /// The same, and look on at every servo step.
    ///
    /// # Errors
    /// As [`World::run`].
    pub fn watch(&mut self, behaviour: BoxedBehaviour, look: impl FnMut(&Self)) -> Result<()> {
        let silence_ms = self.mp.config().timing.silence_ms;
        self.go(
            "example",
            behaviour,
            Watch::work(self.all(), silence_ms),
            look,
        )
    }

    fn go(
        &mut self,
        name: &str,
        behaviour: BoxedBehaviour,
        watch: Watch,
        mut look: impl FnMut(&Self),
    ) -> Result<()> {
        self.mp.begin(Job::new(name, behaviour, watch));
        let until = self.cell.now() + PATIENCE;
        while self.cell.now() < until {
            let Self { mp, cell, faults } = self;
            let (now, rx) = (cell.now(), cell.receive().collect::<Vec<_>>());
            let status = mp.step(now, rx, &mut |frame| cell.send(frame));
            let fault = |what: &What| matches!(what, What::Fault { .. });
            *faults += mp
                .events()
                .iter()
                .filter(|event| fault(&event.what))
                .count();
            look(self);
            match status {
                MpStatus::Running => self.cell.advance(now + SERVO_STEP, &mut ()),
                MpStatus::Idle | MpStatus::Ended => return Ok(()),
                MpStatus::Failed(failure) => return Err(failure.into()),
            }
        }
        bail!("{name}: still running after {} s", PATIENCE.as_secs_f64())
    }

    fn all(&self) -> Vec<usize> {
        (0..self.mp.robots().len()).collect()
    }

    /// Virtual time, s.
    #[must_use]
    pub fn now_s(&self) -> f64 {
        self.cell.now().as_secs_f64()
    }

    /// How many faults the nodes have latched.
    #[must_use]
    pub const fn faults(&self) -> usize {
        self.faults
    }

    /// Where the joints of a robot really are (rad or m), which no process of the controller knows.
    ///
    /// # Errors
    /// There is no such robot.
    pub fn joints(&self, robot: usize) -> Result<PerAxis<f64>> {
        let image = self.mp.robots().get(robot).context("no such robot")?;
        let (_, mechanics) = self.cell.robots().nth(robot).context("no such robot")?;
        Ok(image.arm().joints(mechanics.motor_rad())?)
    }

    /// Where the tool of a robot really is: `t_world_tool`.
    ///
    /// # Errors
    /// There is no such robot.
    pub fn tool(&self, robot: usize) -> Result<Pose> {
        let image = self.mp.robots().get(robot).context("no such robot")?;
        let flange = image.arm().forward(&self.joints(robot)?)?;
        Ok(image.config().t_world_base * flange * image.config().t_flange_tool)
    }
}
