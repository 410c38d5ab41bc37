//! What arrives, and what it changes in the images.

use super::Mp;
use super::event::{DriveFound, Event, What};
use super::failure::Failure;
use super::robot::{Image, Link};
use protocol::link::{Incoming, Message};
use protocol::message::{Event as NodeEvent, Feedback, Identity};
use protocol::time::Micros;

impl Mp {
    pub(super) fn hear(&mut self, now: Micros, incoming: Incoming) {
        if let Message::StopAll(stop) = incoming.message {
            // somebody else stops everyone, us included
            let what = What::StopAll {
                kind: stop.kind,
                by_other: true,
            };
            self.events.push(Event { at: now, what });
            self.interoceptors
                .failure
                .get_or_insert(Failure::Stopped { kind: stop.kind });
            return;
        }
        let Some(robot) = self
            .input
            .e
            .iter()
            .position(|r| r.config().node == incoming.from)
        else {
            return;
        };
        match incoming.message {
            Message::Feedback(feedback) => self.feedback(now, robot, feedback),
            Message::Event(event) => self.node_event(now, robot, event),
            Message::Reply { transfer_id, reply } => {
                let pair = self
                    .transports
                    .get_mut(robot)
                    .zip(self.input.e.get_mut(robot));
                if let Some((transport, image)) = pair {
                    let before = summary(image);
                    transport.reply(image, now, transfer_id, reply);
                    self.events.extend(link_event(now, robot, before, image));
                }
            }
            Message::Heartbeat(_)
            | Message::DemandTrace(_)
            | Message::Command(_)
            | Message::StopAll(_)
            | Message::TimeSync(_)
            | Message::Request { .. }
            | Message::Maintenance { .. }
            | Message::MaintenanceReply { .. }
            | Message::GetInfo { .. } => {}
        }
    }

    fn feedback(&mut self, now: Micros, robot: usize, feedback: Feedback) {
        let i = self.input.i;
        let grace = super::ms(self.config.timing.stale_ms);
        let Some(image) = self.input.e.get_mut(robot) else {
            return;
        };
        let before = image.last().map(|f| (f.state, f.fault));
        if before.map(|(state, _)| state) != Some(feedback.state) {
            let from = before.map(|(state, _)| state);
            let what = What::State {
                robot,
                from,
                to: feedback.state,
            };
            self.events.push(Event { at: now, what });
        }
        if let Some(fault) = feedback.fault
            && before.and_then(|(_, fault)| fault) != Some(fault)
        {
            self.events.push(Event {
                at: now,
                what: What::Fault { robot, fault },
            });
        }
        let (theirs, link) = (feedback.epoch, &image.link);
        if let Link::Leased {
            identity,
            epoch,
            since,
        } = link
            && theirs != *epoch
            && now.since(*since) > grace
        {
            let identity = identity.clone();
            image.lease_lost = Some(theirs);
            image.link = Link::Identified { identity };
            self.events.push(Event {
                at: now,
                what: What::LeaseLost {
                    robot,
                    epoch: theirs,
                },
            });
        }
        image.receive(i, now, feedback);
    }

    fn node_event(&mut self, now: Micros, robot: usize, event: NodeEvent) {
        let Some(image) = self.input.e.get_mut(robot) else {
            return;
        };
        image.heard_at = Some(now);
        let what = match event {
            NodeEvent::Announce(identity) => {
                image.drives_ready = 0;
                image.homing = None;
                if image.epoch().is_some() {
                    image.lease_lost = Some(0);
                }
                booted(image, identity);
                What::Booted { robot }
            }
            NodeEvent::Homing { axis, phase } => {
                image.homing = Some((axis, phase));
                What::Homing { robot, axis, phase }
            }
            NodeEvent::DriveReady { axis } => {
                image.drives_ready |= 1_u8.checked_shl(u32::from(axis)).unwrap_or(0);
                What::DriveReady { robot, axis }
            }
            NodeEvent::DriveFound {
                bus,
                axis,
                finding,
                expected,
                got,
            } => What::DriveFound {
                robot,
                found: DriveFound {
                    bus,
                    axis,
                    finding,
                    expected,
                    got,
                },
            },
            // told by the feedback as well, and reported when that arrives
            NodeEvent::Fault(_) => return,
        };
        self.events.push(Event { at: now, what });
    }
}

/// A node that boots has forgotten our lease, and may be another one than before.
fn booted(image: &mut Image, identity: Identity) {
    if *image.link() != Link::Silent {
        image.link = Link::Identified { identity };
    }
}

/// The kind of a link and its epoch.
const fn summary(image: &Image) -> (bool, Option<u32>) {
    (image.identity().is_some(), image.epoch())
}

fn link_event(
    at: Micros,
    robot: usize,
    before: (bool, Option<u32>),
    image: &Image,
) -> Option<Event> {
    let after = summary(image);
    let what = match (before, after) {
        ((false, _), (true, None)) => What::Identified { robot },
        ((_, old), (_, Some(epoch))) if old != Some(epoch) => What::Leased { robot, epoch },
        _ => return None,
    };
    Some(Event { at, what })
}
