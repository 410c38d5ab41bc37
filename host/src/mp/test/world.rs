//! Virtual time, a wire that may lose frames, peers, and whoever drives them.

use super::peer::{Peer, Script};
use crate::mp::config::{Config, RobotConfig};
use crate::mp::subsystem::BoxedBehaviour;
use crate::mp::watch::Watch;
use crate::mp::{Job, Mp, MpStatus};
use protocol::frame::Frame;
use protocol::time::Micros;
use robots::RobotKind;

/// Time goes on in steps of the servo.
const TICK: Micros = Micros::from_millis(2);

/// Loses every so-many-th frame, in a fixed but irregular order.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Loss {
    seed: u64,
    per_cent: u64,
}

impl Loss {
    pub(crate) const NONE: Self = Self {
        seed: 1,
        per_cent: 0,
    };

    pub(crate) const fn of(per_cent: u64, seed: u64) -> Self {
        Self { seed, per_cent }
    }

    fn loses(&mut self) -> bool {
        // SplitMix64
        self.seed = self.seed.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.seed;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        (z ^ (z >> 31)) % 100 < self.per_cent
    }
}

pub(crate) const KINDS: [RobotKind; 2] = [RobotKind::Irp6Track, RobotKind::Irp6Postument];

/// What drives the peers: the Master Process alone, or a run around it.
pub(crate) trait Driver {
    fn step(&mut self, now: Micros, rx: Vec<(Micros, Frame)>, tx: &mut dyn FnMut(Frame));
}

impl Driver for Mp {
    fn step(&mut self, now: Micros, rx: Vec<(Micros, Frame)>, tx: &mut dyn FnMut(Frame)) {
        Self::step(self, now, rx, &mut |frame| tx(frame));
    }
}

pub(crate) struct World<D> {
    pub(crate) driver: D,
    pub(crate) peers: Vec<Peer>,
    pub(crate) now: Micros,
    pub(crate) loss: Loss,
    to_peers: Vec<Frame>,
    to_driver: Vec<(Micros, Frame)>,
    pub(crate) period: Micros,
    next: Micros,
    pub(crate) sent: u64,
}

pub(crate) fn config() -> Config {
    let mut robots: Vec<RobotConfig> = KINDS
        .iter()
        .zip(1..)
        .map(|(kind, j)| RobotConfig::of(*kind, j).unwrap())
        .collect();
    robots[1].t_world_base.position.y = 2.1;
    Config::new(robots)
}

pub(crate) fn peers(scripts: [Script; 2]) -> Vec<Peer> {
    let config = config();
    scripts
        .into_iter()
        .zip(KINDS)
        .zip(&config.robots)
        .map(|((script, kind), robot)| Peer::new(kind, robot.node, script))
        .collect()
}

impl<D: Driver> World<D> {
    pub(crate) fn around(driver: D, scripts: [Script; 2]) -> Self {
        Self {
            driver,
            peers: peers(scripts),
            now: Micros(0),
            loss: Loss::NONE,
            to_peers: Vec::new(),
            to_driver: Vec::new(),
            period: Micros::from_millis(20),
            next: Micros(0),
            sent: 0,
        }
    }

    pub(crate) fn tick(&mut self) {
        let frames = core::mem::take(&mut self.to_peers);
        for peer in &mut self.peers {
            let (loss, out, now) = (&mut self.loss, &mut self.to_driver, self.now);
            peer.step(self.now, &frames, &mut |frame| {
                if !loss.loses() {
                    out.push((now, frame));
                }
            });
        }
        if self.now >= self.next {
            self.next = self.now + self.period;
            let rx = core::mem::take(&mut self.to_driver);
            let (loss, out, sent) = (&mut self.loss, &mut self.to_peers, &mut self.sent);
            self.driver.step(self.now, rx, &mut |frame| {
                *sent += 1;
                if !loss.loses() {
                    out.push(frame);
                }
            });
        }
        self.now = self.now + TICK;
    }

    /// Until something holds or so many ms have passed; did it?
    pub(crate) fn until(&mut self, ms: u64, mut holds: impl FnMut(&Self) -> bool) -> bool {
        let end = self.now + Micros::from_millis(ms);
        while self.now < end {
            self.tick();
            if holds(self) {
                return true;
            }
        }
        false
    }
}

impl World<Mp> {
    pub(crate) fn new(scripts: [Script; 2]) -> Self {
        Self::around(Mp::new(config(), 1).unwrap(), scripts)
    }

    /// Runs a job to its end.
    pub(crate) fn run(&mut self, behaviour: BoxedBehaviour, watch: Watch) -> MpStatus {
        self.driver.begin(Job::new("test", behaviour, watch));
        assert!(
            self.until(60_000, |world| *world.driver.status() != MpStatus::Running),
            "the job neither ends nor fails"
        );
        self.driver.status().clone()
    }
}

/// A world whose robots are homed and under torque.
pub(crate) fn ready() -> World<Mp> {
    ready_with(config())
}

/// As [`ready`], of a cell of these robots.
pub(crate) fn ready_with(config: Config) -> World<Mp> {
    use crate::mp::behaviour::{get_ready, home, sequence};
    use crate::mp::generator::Readiness;
    let mp = Mp::new(config, 1).unwrap();
    let mut world = World::around(mp, [Script::default(), Script::default()]);
    let timing = world.driver.config().timing;
    let both = sequence(vec![
        get_ready(vec![0, 1], Readiness::Enabled, timing),
        home(vec![0, 1], timing),
    ]);
    assert_eq!(
        world.run(both, Watch::requests(vec![0, 1])),
        MpStatus::Ended
    );
    world
}
