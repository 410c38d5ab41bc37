//! The independent observer of set-points.
//!
//! It sees frames only, decodes them by the tables of CiA 301 and CiA 402, and differentiates what
//! the drives really latch at each SYNC (csp), or what the node says it demands (cst, where the
//! drives are sent torques). Nothing of the node's own checks is used.
//!
//! Set-points are integers of one position unit q, so each may be q/2 from the motion it stands for.
//! The coefficients of the differences (1 1, 1 2 1, 1 3 3 1) add that up to q/Ts, 2q/Ts² and 4q/Ts³:
//! so much may a difference exceed its limit, and no more.

mod axis;

pub use axis::{Breach, Quantity, Worst};

use axis::{Axis, History};
use bus::candump::Reader;
use hil_sim::cell::Observer;
use host::mp::arm::arm;
use protocol::frame::{Frame, Id};
use protocol::id::NodeId;
use protocol::link::{Endpoint, Message, Role};
use protocol::message::{DemandTrace, Feedback, NodeState, ServoLaw};
use protocol::time::Micros;
use protocol::transfer::Mtu;
use protocol::units::nearest;
use robots::RobotKind;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

/// CiA 301: the identifiers of SYNC, TPDO1, RPDO1 and RPDO2 (plus the number of the drive).
const SYNC: u16 = 0x080;
const TPDO1: u16 = 0x180;
const RPDO1: u16 = 0x200;
const RPDO2: u16 = 0x300;
/// CiA 402: the controlword that asks for operation, and the statusword that confirms it.
const OPERATE: (u16, u16) = (0x000F, 0x000F);
const OPERATION_ENABLED: (u16, u16) = (0x006F, 0x0027);
/// No more breaches than this are kept; all are counted.
const KEPT: usize = 20;

/// Looks at one robot's set-points.
#[derive(Debug)]
pub struct Watch {
    node: NodeId,
    link: Endpoint<16>,
    /// The number of its first drive bus in the cell.
    first_bus: usize,
    buses: Vec<u8>,
    drive_position: bool,
    axes: Vec<Axis>,
    feedback: Option<Feedback>,
    trace_step: Option<u32>,
    trace: Option<(DemandTrace, Vec<bool>)>,
    /// Servo steps in which a motion could be checked.
    pub steps: u64,
    /// Demands that were published but not received.
    pub gaps: u64,
    /// How many breaches.
    pub breaches: u64,
    /// The first of them.
    pub first: Vec<Breach>,
}

impl Watch {
    /// A robot with effector number `j`, whose drive buses begin at `first_bus` and whose axes hang on
    /// them as `buses` says; `factor` scales the velocity limit.
    ///
    /// # Panics
    /// If `j` is no effector's number.
    #[must_use]
    pub fn new(
        kind: RobotKind,
        j: u8,
        law: ServoLaw,
        factor: f64,
        first_bus: usize,
        buses: &[u8],
    ) -> Self {
        let arm = arm(kind);
        let ts = f64::from(arm.servo_step_us()) * 1e-6;
        Self {
            node: NodeId::effector(j).expect("an effector's number"),
            link: Endpoint::new(NodeId::MP, Role::Observer, Mtu::Fd),
            first_bus,
            buses: buses.to_vec(),
            drive_position: law == ServoLaw::DrivePosition,
            axes: arm
                .axes()
                .iter()
                .map(|axis| Axis::new(axis, factor, ts))
                .collect(),
            feedback: None,
            trace_step: None,
            trace: None,
            steps: 0,
            gaps: 0,
            breaches: 0,
            first: Vec::new(),
        }
    }

    /// The greatest values of every axis since [`Watch::forget_worst`], in multiples of the limits.
    #[must_use]
    pub fn worst(&self) -> Vec<Worst> {
        self.axes.iter().map(|axis| axis.worst).collect()
    }

    /// Begin to look for the greatest values anew.
    pub fn forget_worst(&mut self) {
        self.axes
            .iter_mut()
            .for_each(|axis| axis.worst = Worst::default());
    }

    /// The greatest jerk of an axis that its set-points show, without their resolution, rad/s³.
    #[must_use]
    pub fn jerk_rad_s3(&self, axis: usize) -> f64 {
        self.axes[axis].jerk_rad_s3()
    }

    /// Asserts that something moved and every limit was kept.
    ///
    /// # Panics
    /// If not.
    pub fn assert_kept(&self, what: &str) {
        assert!(
            self.steps > 500,
            "{what}: only {} steps to look at",
            self.steps
        );
        assert_eq!(self.breaches, 0, "{what}: {:#?}", self.first);
        assert!(
            self.gaps * 100 <= self.steps,
            "{what}: {} of {} lost",
            self.gaps,
            self.steps
        );
    }

    fn drive_frame(&mut self, bus: usize, at_ns: u64, id: u16, data: &[u8]) {
        if id == SYNC && data.is_empty() {
            self.sync(bus, at_ns);
            return;
        }
        for (number, (axis, on)) in (1_u16..).zip(self.axes.iter_mut().zip(&self.buses)) {
            if usize::from(*on) != bus {
                continue;
            }
            match (id.checked_sub(number), data) {
                (Some(TPDO1), [a, b, ..]) => axis.statusword = u16::from_le_bytes([*a, *b]),
                (Some(RPDO1), [a, b, p @ ..]) => {
                    axis.controlword = u16::from_le_bytes([*a, *b]);
                    axis.target = p.first_chunk().copied().map(i32::from_le_bytes);
                }
                (Some(RPDO2), [a, b, ..]) => axis.controlword = u16::from_le_bytes([*a, *b]),
                _ => {}
            }
        }
    }

    /// The drives of a bus latch their targets.
    fn sync(&mut self, bus: usize, at_ns: u64) {
        let mut checked = false;
        let mut found = Vec::new();
        for (k, (axis, on)) in self.axes.iter_mut().zip(&self.buses).enumerate() {
            if usize::from(*on) != bus || !self.drive_position {
                continue;
            }
            let torque = axis.has_torque();
            match axis.target.take() {
                Some(target) if torque => {
                    // a drive's 32 bits are modulo 2³²
                    let units = match axis.history.last() {
                        Some(last) => nearest(target, last),
                        None => i64::from(target),
                    };
                    found.extend(axis.push(units));
                    checked = true;
                }
                None if torque => found.push((Quantity::Missing, 1.0, 0.0)),
                _ => axis.history = History::default(),
            }
            self.breaches += found.len() as u64;
            for (quantity, value, limit) in found.drain(..) {
                if self.first.len() < KEPT {
                    self.first.push(Breach {
                        at_ns,
                        axis: k,
                        quantity,
                        value,
                        limit,
                    });
                }
            }
        }
        self.steps += u64::from(checked && bus == 0);
    }

    fn message(&mut self, at_ns: u64, message: Message) {
        match message {
            Message::Feedback(feedback) => {
                for (k, axis) in self.axes.iter_mut().enumerate() {
                    let homed = feedback.synchronised & (1 << k) != 0;
                    if homed && feedback.state == NodeState::Holding && axis.zero.is_none() {
                        // homing ends at motor angle 0
                        axis.zero = if self.drive_position {
                            axis.history.last()
                        } else {
                            Some(0)
                        };
                    }
                }
                self.feedback = Some(feedback);
            }
            Message::DemandTrace(trace) if !self.drive_position => self.traced(at_ns, trace),
            _ => {}
        }
    }

    /// A published demand counts once the next one shows that torque stayed on.
    fn traced(&mut self, at_ns: u64, trace: DemandTrace) {
        let expected = self
            .trace_step
            .replace(trace.step)
            .map(|last| last.wrapping_add(1));
        let whole = expected.is_none_or(|expected| expected == trace.step);
        self.gaps += u64::from(!whole);
        let homing = self
            .feedback
            .as_ref()
            .is_some_and(|f| f.state == NodeState::Synchronising);
        let torque: Vec<bool> = self.axes.iter().map(Axis::has_torque).collect();
        let before = self.trace.replace((trace, torque.clone()));
        let Some((before, had)) = before else { return };
        let mut checked = false;
        let each = self
            .axes
            .iter_mut()
            .zip(&before.demand)
            .zip(had.iter().zip(&torque));
        for (k, ((axis, demand), (had, has))) in each.enumerate() {
            if !(whole && *had && *has) {
                axis.history = History::default();
                continue;
            }
            checked = true;
            let demand = *demand;
            if homing && axis.counts_anew(demand) {
                continue;
            }
            for (quantity, value, limit) in axis.push(demand) {
                self.breaches += 1;
                if self.first.len() < KEPT {
                    self.first.push(Breach {
                        at_ns,
                        axis: k,
                        quantity,
                        value,
                        limit,
                    });
                }
            }
        }
        self.steps += u64::from(checked);
    }
}

impl Observer for Watch {
    fn frame(&mut self, bus: usize, at_ns: u64, frame: &Frame) {
        if bus == 0 {
            let incoming = self.link.receive(frame, Micros(at_ns / 1000));
            if let Some(incoming) = incoming.filter(|incoming| incoming.from == self.node) {
                self.message(at_ns, incoming.message);
            }
        } else if let (Some(bus), Id::Standard(id)) = (bus.checked_sub(self.first_bus), frame.id())
        {
            self.drive_frame(bus, at_ns, id, frame.data());
        }
    }
}

/// Several robots.
#[derive(Debug)]
pub struct Watches(pub Vec<Watch>);

impl Observer for Watches {
    fn frame(&mut self, bus: usize, at_ns: u64, frame: &Frame) {
        for watch in &mut self.0 {
            watch.frame(bus, at_ns, frame);
        }
    }
}

/// Did any drive of a record confirm operation (statusword in TPDO1)? Not if there is no record.
///
/// # Panics
/// If the record is no candump log.
#[must_use]
pub fn ever_had_torque(record: &Path) -> bool {
    let Ok(file) = File::open(record) else {
        return false;
    };
    Reader::new(BufReader::new(file)).any(|entry| {
        let entry = entry.expect("a record is a candump log");
        let Id::Standard(id) = entry.frame.id() else {
            return false;
        };
        let status = match entry.frame.data() {
            [low, high, ..] => u16::from_le_bytes([*low, *high]),
            _ => 0,
        };
        id & 0x780 == TPDO1 && status & OPERATION_ENABLED.0 == OPERATION_ENABLED.1
    })
}

#[cfg(test)]
mod test;
