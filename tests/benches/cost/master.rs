//! A step of the Master Process with two arms, from the handshake to the leases given back.

use crate::capture::{capture, digest, master, task};
use crate::timing::{Cost, Mode, Pieces};
use protocol::message::ServoLaw;
use robots::RobotKind;

const KINDS: [RobotKind; 2] = [RobotKind::Irp6Track, RobotKind::Irp6Postument];
/// More frames than a step sends.
const MOST_FRAMES: usize = 64;

pub(crate) fn cost(mode: Mode) -> Cost {
    let law = ServoLaw::DrivePosition;
    let capture = capture(&KINDS, law);
    let mut pieces = Pieces::default();
    for _ in 0..mode.repeats() {
        pieces.again();
        let mut run = master(task(&KINDS, law));
        for step in &capture.steps {
            let mut sent = Vec::with_capacity(MOST_FRAMES);
            pieces.time(|| {
                run.step(step.now, step.rx.iter().copied(), &mut |frame| {
                    sent.push(frame);
                })
            });
            assert!(
                digest(&sent) == step.sent,
                "other frames than in the run at {:?}",
                step.now
            );
        }
    }
    pieces.cost(1)
}
