//! A whole task in this process: the Master Process and the cell, coupled without the operator's
//! command, while somebody looks on.

use crate::emulator::node::in_process;
use board::boot::Boot;
use bus::wire::Kind;
use firmware::Station;
use firmware::process::NodeProcess;
use hil_sim::cell::{Cell, Observer};
use host::program::{Run, RunError, RunStatus, config_of};
use host::task::{BusKind, Task};
use protocol::id::NodeId;
use protocol::time::Micros;
use protocol::transfer::Mtu;

/// The MP makes a step this often.
const MACROSTEP: Micros = Micros::from_millis(20);
/// A task that takes longer than this, of virtual time, hangs.
const LONGEST: Micros = Micros::from_millis(1_000_000);

/// Two observers at once.
#[derive(Debug)]
pub struct Both<A, B>(pub A, pub B);

impl<A: Observer, B: Observer> Observer for Both<A, B> {
    fn frame(&mut self, bus: usize, at_ns: u64, frame: &protocol::frame::Frame) {
        self.0.frame(bus, at_ns, frame);
        self.1.frame(bus, at_ns, frame);
    }

    fn motors(&mut self, station: usize, at_ns: u64, motor_rad: &[f64]) {
        self.0.motors(station, at_ns, motor_rad);
        self.1.motors(station, at_ns, motor_rad);
    }
}

/// Runs a task to its end; the error it ended with, if any, and the cell afterwards.
///
/// # Panics
/// If the task's cell cannot be simulated, a frame found no room, or the task hangs.
pub fn run(task: Task, observer: &mut impl Observer) -> (Option<RunError>, Cell) {
    run_with(task, observer, &mut |_| None)
}

/// The same, with nodes of one's own for some of the robots.
///
/// # Panics
/// As [`run`].
pub fn run_with(
    task: Task,
    observer: &mut impl Observer,
    own: &mut impl FnMut(&Boot) -> Option<Box<dyn NodeProcess + Send>>,
) -> (Option<RunError>, Cell) {
    let mut config = config_of(&task.cell).expect("a cell that tasks can describe");
    config.trace_every = 1;
    let classic = task.cell.buses.iter().zip(0..).any(|(bus, index)| {
        bus.kind == BusKind::Classic && task.cell.robots.iter().any(|r| r.mp_bus == index)
    });
    assert!(
        !classic,
        "tasks of the tests have a CAN FD bus towards the MP"
    );
    let mut cell = Cell::new(Kind::Fd);
    for (spec, known) in task.cell.robots.iter().zip(&config.robots) {
        let station = Station {
            effector: known.node.get() - NodeId::EFFECTOR_BASE,
            unique_id: task.seed,
            mtu: Mtu::Fd,
            law: spec.servo,
            velocity_factor: spec.velocity_factor,
            one_wire: false,
            track: spec.track,
        };
        let mut buses = vec![0_u8; spec.axes()];
        for (number, group) in (0_u8..).zip(&spec.drives) {
            for axis in &group.axes {
                buses[*axis] = number;
            }
        }
        let boot = Boot {
            now: cell.now(),
            kind: spec.kind,
            station,
            buses: buses.into_iter().collect(),
        };
        let (node, drives) = in_process(&boot).expect("a node that can be built");
        let node = own(&boot).unwrap_or(node);
        cell.add_node(spec.kind, node, &drives, task.seed)
            .expect("a cell that can be built");
    }
    let mut run = Run::new(task, None, config, 1).expect("a configuration that can be used");
    let mut tx = Vec::new();
    loop {
        let now = cell.now();
        assert!(
            now < LONGEST,
            "the task hangs in step {:?}",
            run.current_step()
        );
        let rx: Vec<_> = cell.receive().collect();
        let status = run.step(now, rx, &mut |frame| tx.push(frame));
        for frame in tx.drain(..) {
            cell.send(frame);
        }
        let _ = run.progress();
        match status {
            RunStatus::Running => cell.advance(now + MACROSTEP, observer),
            RunStatus::Done => break assert_sent(cell, None),
            RunStatus::Failed(error) => break assert_sent(cell, Some(error)),
        }
    }
}

fn assert_sent(cell: Cell, error: Option<RunError>) -> (Option<RunError>, Cell) {
    assert_eq!(cell.refused(), [], "frames without room");
    (error, cell)
}
