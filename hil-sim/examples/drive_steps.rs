//! How many robots one core simulates in real time at the level of drives: everything on the far side of the
//! drive buses.
//!
//! Every robot has its drives enabled in csp and follows a moving target: each millisecond every drive takes a
//! SYNC and an RPDO (decoded, scaled, latched), answers with its TPDO, and runs its power state machine, its
//! monitoring, interpolation, observer, position and velocity loops every 0.25 ms; the plant behind them moves
//! every 0.25 ms: current loops, rigid bodies, friction, brakes, stops, encoders, switches. Not counted:
//! the timing of frames on a wire, and the node.
//!
//! `cargo run --release -p mrroc-hil-sim --example drive_steps [ROBOTS [MILLISECONDS]]`

use hil_sim::plant::parameters;
use hil_sim::plant::robot::{Sent, SimRobot};
use protocol::canopen::axis::{self, Actual, Target};
use protocol::canopen::cia402::{Goal, Master, Mode, PowerState, Statusword};
use protocol::canopen::nmt;
use protocol::canopen::node::{Function, NodeId, frame, standard};
use protocol::canopen::sdo::{Address, Client};
use protocol::time::Micros;
use robots::RobotKind;

const CYCLE_NS: u64 = 1_000_000;
/// Until all brakes are open: boot, six states, 25 ms.
const WARM_UP: u32 = 300;

/// A robot with what a node knows of its drives.
struct Driven {
    robot: SimRobot,
    buses: u8,
    nodes: Vec<(u8, NodeId)>,
    masters: Vec<Master>,
    actual: Vec<Actual>,
    start: Vec<Option<i32>>,
    now_ns: u64,
}

impl Driven {
    fn new(kind: RobotKind, seed: u64) -> Result<Self, Box<dyn std::error::Error>> {
        let setup = parameters::robot(kind, seed);
        let nodes: Vec<_> = setup
            .axes
            .iter()
            .filter_map(|axis| Some((axis.bus, NodeId::new(axis.node)?)))
            .collect();
        let buses = nodes.iter().map(|(bus, _)| bus + 1).max().unwrap_or(0);
        let count = nodes.len();
        let mut driven = Self {
            robot: SimRobot::new(setup, seed)?,
            buses,
            masters: vec![Master::default(); count],
            actual: vec![
                Actual {
                    statusword: 0,
                    position: 0,
                    torque: 0
                };
                count
            ],
            start: vec![None; count],
            nodes,
            now_ns: 200_000_000,
        };
        let csp = Mode::Csp.code().to_le_bytes();
        // mode; cycle of 1000 µs; interpolation over 1 ms
        let objects: [(u16, u8, &[u8]); 3] = [
            (0x6060, 0, &csp),
            (0x1006, 0, &1000_u32.to_le_bytes()),
            (0x60C2, 1, &[1]),
        ];
        for (bus, node) in driven.nodes.clone() {
            for (index, sub, value) in objects {
                let request =
                    Client::<8>::default().download(Micros(0), Address::new(index, sub), value);
                if let Ok(request) = request {
                    let request = frame(node.cob(Function::SdoRequest), request);
                    driven
                        .robot
                        .on_frame(bus, driven.now_ns, &request, &mut |_| ());
                }
            }
        }
        for bus in 0..buses {
            let start = nmt::command_frame(nmt::Command::Start, nmt::Target::All);
            driven
                .robot
                .on_frame(bus, driven.now_ns, &start, &mut |_| ());
        }
        for master in &mut driven.masters {
            master.set_goal(Goal::Enabled);
        }
        Ok(driven)
    }

    /// SYNC, then the targets the next SYNC latches.
    fn cycle(&mut self, offset: i32) {
        let actual = &mut self.actual;
        let mut out = |sent: Sent| {
            let Some(cob) = standard(&sent.frame) else {
                return;
            };
            // nodes are numbered from 1 in the order of the axes
            let axis = usize::from(cob.wrapping_sub(Function::Tpdo1 as u16 + 1));
            if let (Some(actual), Some(now)) =
                (actual.get_mut(axis), Actual::decode(sent.frame.data()))
            {
                *actual = now;
            }
        };
        for bus in 0..self.buses {
            self.robot
                .on_frame(bus, self.now_ns, &frame(0x80, []), &mut out);
        }
        self.now_ns += CYCLE_NS / 2;
        for (axis, (bus, node)) in self.nodes.iter().enumerate() {
            let actual = self.actual[axis];
            let status = Statusword(actual.statusword);
            let follows = status.has(Statusword::FOLLOWS);
            let target = if follows {
                self.start[axis]
                    .get_or_insert(actual.position)
                    .wrapping_add(offset)
            } else {
                actual.position
            };
            let word = self.masters[axis].next(status);
            let command = axis::command(*node, word.0, Target::Position(target), None);
            self.robot
                .on_frame(*bus, self.now_ns, &command, &mut |_| ());
        }
        self.now_ns += CYCLE_NS / 2;
    }
}

/// To and fro by 100 000 drive units, a tenth of a turn, every 0.4 s.
fn target(k: u32) -> i32 {
    let phase = f64::from(k % 400) / 400.0 * core::f64::consts::TAU;
    #[expect(clippy::cast_possible_truncation, reason = "at most 100 000")]
    let units = (50_000.0 * (1.0 - libm::cos(phase))) as i32;
    units
}

/// How long a processor has worked for this program, so that others on the machine do not count, s. As Linux says it.
fn busy() -> Result<f64, Box<dyn std::error::Error>> {
    let text = std::fs::read_to_string("/proc/self/schedstat")?;
    let ns: f64 = text.split(' ').next().unwrap_or_default().parse()?;
    Ok(1e-9 * ns)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let mut number = |default: u32| match arguments.next() {
        Some(text) => text.parse::<u32>(),
        None => Ok(default),
    };
    let (robots, milliseconds) = (number(200)?, number(2000)?);
    for kind in [RobotKind::Irp6Postument, RobotKind::Polycrank] {
        let mut all = Vec::new();
        for seed in 0..robots {
            all.push(Driven::new(kind, u64::from(seed))?);
        }
        for _ in 0..WARM_UP {
            for driven in &mut all {
                driven.cycle(target(0));
            }
        }
        let since = busy()?;
        for k in 0..milliseconds {
            for driven in &mut all {
                driven.cycle(target(k));
            }
        }
        let seconds = busy()? - since;
        let enabled = all
            .iter()
            .flat_map(|driven| (0..driven.nodes.len()).map(|axis| driven.robot.drive(axis)))
            .flatten()
            .filter(|drive| drive.power_state() == PowerState::OperationEnabled)
            .count();
        let expected: usize = all.iter().map(|driven| driven.nodes.len()).sum();
        let times = f64::from(milliseconds) * 1e-3 / seconds;
        println!(
            "{kind}: {robots} robots at 1 kHz, {times:.2} times real time: {:.0} robots in real time; \
             {enabled} of {expected} drives enabled at the end",
            times * f64::from(robots)
        );
    }
    Ok(())
}
