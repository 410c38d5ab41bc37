//! Short lives of nodes, each unlike the others: what the coordinator asks for, when it falls silent,
//! which drive breaks, and what nonsense is on the wire is drawn from a seed.

use super::node::in_process;
use super::tape::{Recorder, Tape};
use crate::coordinator::{Coordinator, speeds};
use board::boot::Boot;
use firmware::Station;
use firmware::process::drive_buses;
use hil_sim::drive::DriveFault;
use hil_sim::plant::axis::EncoderFault;
use hil_sim::plant::random::SplitMix64;
use protocol::frame::{Frame, Id};
use protocol::message::{Instruction, NodeState, Request, ServoLaw, StopKind};
use protocol::time::Micros;
use protocol::transfer::Mtu;
use robots::{RobotKind, TrackRule};

/// How long each lives.
pub const LENGTH: Micros = Micros::from_millis(2000);

const LAWS: [ServoLaw; 4] = [
    ServoLaw::DrivePosition,
    ServoLaw::Original,
    ServoLaw::FeedForward,
    ServoLaw::ComputedTorque,
];

/// The boot of a trace.
#[must_use]
pub fn boot(kind: RobotKind, seed: u64) -> Boot {
    let law = LAWS[usize::try_from(seed % 4).unwrap_or(0)];
    Boot {
        now: Micros(0),
        kind,
        station: Station {
            effector: 1,
            unique_id: seed,
            mtu: Mtu::Fd,
            law,
            velocity_factor: 0.2,
            one_wire: false,
            track: TrackRule::Keep,
        },
        buses: drive_buses(kind),
    }
}

/// The life of this seed, in this process.
///
/// # Panics
/// If the cell cannot be built.
#[must_use]
pub fn live(kind: RobotKind, seed: u64) -> Tape {
    let boot = boot(kind, seed);
    let (node, drives) = in_process(&boot).expect("a node");
    let (recorder, recording) = Recorder::new(node, boot.clone());
    let mut c = Coordinator::with_node(&boot, Box::new(recorder), &drives);
    let mut draw = SplitMix64::new(seed);
    // asks for torque as soon as it can
    let mut enabled = false;
    while c.cell.now() < LENGTH {
        c.macrostep();
        if c.state() == Some(NodeState::Disabled) && !enabled {
            enabled = true;
            c.acquire();
            ask(&mut c, |epoch| Request::Enable { epoch });
        } else if enabled {
            act(&mut c, &mut draw, kind);
        }
    }
    recording.tape()
}

fn ask(c: &mut Coordinator, request: impl FnOnce(u32) -> Request) {
    let request = request(c.epoch());
    let _ = c.try_request(&request);
}

/// What a coordinator, a drive or a disturbance does in one macrostep.
fn act(c: &mut Coordinator, draw: &mut SplitMix64, kind: RobotKind) {
    let axes = kind.axes();
    let axis = usize::try_from(draw.below(axes as u64)).unwrap_or(0);
    match draw.below(40) {
        0 => ask(c, |epoch| Request::Enable { epoch }),
        1 => ask(c, |epoch| Request::Synchronise { epoch }),
        2 => ask(c, |epoch| Request::Acknowledge { epoch }),
        3 => ask(c, |epoch| Request::Disable { epoch }),
        4 => {
            let kinds = [StopKind::Path, StopKind::Quick, StopKind::TorqueOff];
            let kind = kinds[usize::try_from(draw.below(3)).unwrap_or(0)];
            ask(c, |_| Request::Stop { kind });
        }
        5 => {
            let law = LAWS[usize::try_from(draw.below(4)).unwrap_or(0)];
            ask(c, |epoch| Request::SelectServo { epoch, law });
        }
        6 if draw.below(3) == 0 => c.talks = !c.talks,
        7 if draw.below(3) == 0 => {
            let faults = [
                DriveFault::Silent,
                DriveFault::Encoder(EncoderFault::Frozen),
                DriveFault::SwitchStuck(true),
                DriveFault::IndexMissing,
            ];
            let fault = faults[usize::try_from(draw.below(4)).unwrap_or(0)];
            if let Some(robot) = c.cell.robot_mut(0) {
                robot.inject(axis, Some(fault));
            }
        }
        8..=11 => {
            let bytes = draw.next_u64().to_le_bytes();
            let length = usize::try_from(draw.below(9)).unwrap_or(0);
            let id = u32::try_from(draw.below(1 << 29)).unwrap_or(0);
            if let Some(frame) = Frame::classic(Id::Extended(id), &bytes[..length]) {
                c.cell.send(frame);
            }
        }
        12..=19 => {
            let target = (0..axes).map(|_| 20.0 * draw.between(-1.0, 1.0)).collect();
            #[expect(clippy::cast_possible_truncation, reason = "a speed")]
            let (v, a) = (
                draw.between(-1.0, 1.0).abs() as f32,
                draw.between(-1.0, 1.0).abs() as f32,
            );
            let _ = c.try_begin(Instruction::MoveMotors {
                target,
                relative: true,
                speeds: speeds(axes, 0.05 + 0.95 * v, 0.05 + 0.95 * a),
            });
        }
        _ => {}
    }
}
