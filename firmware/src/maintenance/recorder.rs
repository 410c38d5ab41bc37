//! Why the node started, and the signals before its first fault: memory that is as quick as any.

use super::black_box::{BlackBox, Memory, Signals};
use super::{Asked, Start};
use protocol::maintenance::{
    MaintenanceRefusal, MaintenanceReply, MaintenanceRequest, ResetReport,
};
use protocol::message::Identity;

/// Records servo steps, and answers what is asked about them; `M` is the memory of the black box.
#[derive(Debug)]
pub struct Recorder<M> {
    start: Start,
    black_box: BlackBox<M>,
}

impl<M: Memory> Recorder<M> {
    /// Of a node that has just started.
    pub const fn new(start: Start, black_box: BlackBox<M>) -> Self {
        Self { start, black_box }
    }

    /// The signals of a servo step; short, for the step itself.
    pub fn record(&mut self, signals: &Signals, servo_step_us: u32) {
        self.black_box
            .record(signals, self.start.boots, servo_step_us);
    }

    /// Once behind the first fault: the CRC of all of the record, which is longer than a servo step should be.
    pub fn seal(&mut self) {
        self.black_box.seal();
    }

    /// The answer to a request, or none if it is for the [`Librarian`](super::Librarian). Bounded by a batch of samples.
    pub fn answer(
        &mut self,
        asked: &Asked,
        identity: &Identity,
        step: u32,
    ) -> Option<MaintenanceReply> {
        Some(match &asked.request {
            MaintenanceRequest::ResetCause => MaintenanceReply::Reset(ResetReport {
                cause: self.start.cause,
                boots: self.start.boots,
                steps: step,
                servo_step_us: identity.servo_step_us,
            }),
            MaintenanceRequest::FirstFault => self
                .black_box
                .first_fault()
                .map_or(MaintenanceReply::NoFault, MaintenanceReply::FirstFault),
            MaintenanceRequest::Samples { record, first } => {
                let (record, first) = (*record, *first);
                self.black_box.samples(record, first).map_or(
                    MaintenanceReply::Refused(MaintenanceRefusal::NoRecord),
                    |samples| MaintenanceReply::Samples {
                        record,
                        first,
                        samples,
                    },
                )
            }
            MaintenanceRequest::ClearFault { record, .. } => match asked.permitted() {
                Ok(()) if self.black_box.clear(*record) => MaintenanceReply::Done,
                Ok(()) => MaintenanceReply::Refused(MaintenanceRefusal::NoRecord),
                Err(refusal) => MaintenanceReply::Refused(refusal),
            },
            _ => return None,
        })
    }
}
