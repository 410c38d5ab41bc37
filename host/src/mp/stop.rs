//! Stops: of everyone at the operator's word, and of a group when one of it fails.

use super::Mp;
use super::event::{Event, What};
use super::failure::Failure;
use super::robot::Link;
use protocol::frame::Frame;
use protocol::message::{StopAll, StopKind};
use protocol::time::Micros;

/// A stop is broadcast so many times …
const STOP_TIMES: u8 = 3;
/// … this far apart at least.
const STOP_GAP: Micros = Micros::from_millis(5);

#[derive(Clone, Copy, Debug)]
pub(super) struct Stopping {
    kind: StopKind,
    left: u8,
    next: Micros,
}

impl Mp {
    /// Stops everyone at once: a broadcast, repeated, and a request to every robot, answered. The
    /// job ends as stopped by the operator.
    pub fn stop(&mut self, kind: StopKind, now: Micros, tx: &mut impl FnMut(Frame)) {
        self.broadcast_stop(kind, now, tx);
        for (transport, image) in self.transports.iter_mut().zip(&mut self.input.e) {
            if *image.link() != Link::Silent {
                transport.stop(image, kind);
                let timing = &self.config.timing;
                transport.send_requests(image, now, timing, &mut self.endpoint, tx);
            }
        }
        self.end_in_error(now, Failure::Stopped { kind });
    }

    fn broadcast_stop(&mut self, kind: StopKind, now: Micros, tx: &mut impl FnMut(Frame)) {
        // cannot fail: the message is a byte long
        let _sent = self.endpoint.send_stop_all(&StopAll { kind }, tx);
        self.stopping = Some(Stopping {
            kind,
            left: STOP_TIMES - 1,
            next: now + STOP_GAP,
        });
        self.events.push(Event {
            at: now,
            what: What::StopAll {
                kind,
                by_other: false,
            },
        });
    }

    pub(super) fn repeat_stop(&mut self, now: Micros, tx: &mut impl FnMut(Frame)) {
        if let Some(stopping) = &mut self.stopping
            && now >= stopping.next
        {
            let _sent = self.endpoint.send_stop_all(
                &StopAll {
                    kind: stopping.kind,
                },
                tx,
            );
            stopping.left = stopping.left.saturating_sub(1);
            stopping.next = now + STOP_GAP;
            if stopping.left == 0 {
                self.stopping = None;
            }
        }
    }

    /// One failed: all robots of the job stop on their paths in this macrostep. Where the job has
    /// every robot we command, one frame says it to all, so that they begin in the same servo step.
    pub(super) fn stop_group(&mut self, now: Micros, tx: &mut impl FnMut(Frame)) {
        let members = self
            .job
            .as_ref()
            .map_or(&[][..], |job| &job.robots)
            .to_vec();
        let ours: Vec<usize> = self
            .input
            .e
            .iter()
            .enumerate()
            .filter(|(_, image)| image.epoch().is_some())
            .map(|(robot, _)| robot)
            .collect();
        if ours.len() > 1 && ours.iter().all(|robot| members.contains(robot)) {
            self.broadcast_stop(StopKind::Path, now, tx);
        }
        for robot in ours.into_iter().filter(|robot| members.contains(robot)) {
            let pair = self
                .transports
                .get_mut(robot)
                .zip(self.input.e.get_mut(robot));
            if let Some((transport, image)) = pair {
                transport.stop(image, StopKind::Path);
            }
        }
    }
}
