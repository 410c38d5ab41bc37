//! A named channel: who listens, and everyone's queue.

use super::QUEUE;
use crate::{Bus, BusError, Received, now, until};
use protocol::frame::Frame;
use protocol::time::Micros;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, SyncSender, TryRecvError, TrySendError};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{SystemTime, UNIX_EPOCH};

/// A frame on its way to a participant.
#[derive(Clone, Copy, Debug)]
pub(super) struct Item {
    pub(super) frame: Frame,
    /// When it was sent: local, and µs of the Unix epoch.
    pub(super) at: Micros,
    pub(super) epoch_us: u64,
}

#[derive(Debug)]
struct Participant {
    number: u64,
    queue: SyncSender<Item>,
}

/// One bus of the hub.
#[derive(Debug)]
pub(super) struct Channel {
    pub(super) name: String,
    participants: Mutex<Vec<Participant>>,
    next: AtomicU64,
    dropped: AtomicU64,
    frames: AtomicU64,
}

impl Channel {
    pub(super) fn new(name: &str) -> Arc<Self> {
        Arc::new(Self {
            name: name.to_owned(),
            participants: Mutex::default(),
            next: AtomicU64::new(0),
            dropped: AtomicU64::new(0),
            frames: AtomicU64::new(0),
        })
    }

    /// Nothing that can panic runs under the lock, so it cannot be poisoned.
    fn lock(&self) -> MutexGuard<'_, Vec<Participant>> {
        self.participants
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn frames(&self) -> u64 {
        self.frames.load(Ordering::Relaxed)
    }

    pub(super) fn dropped(&self) -> u64 {
        self.dropped.load(Ordering::Relaxed)
    }

    /// Gives a frame to everyone but its sender.
    pub(super) fn publish(&self, sender: u64, frame: &Frame) {
        let since_epoch = SystemTime::now()
            .duration_since(UNIX_EPOCH)
            .unwrap_or_default();
        let epoch_us = u64::try_from(since_epoch.as_micros()).unwrap_or(u64::MAX);
        let item = Item {
            frame: *frame,
            at: now(),
            epoch_us,
        };
        self.frames.fetch_add(1, Ordering::Relaxed);
        // Under one lock, so that all participants see the same order, as on a bus.
        for participant in self.lock().iter().filter(|other| other.number != sender) {
            if let Err(TrySendError::Full(_)) = participant.queue.try_send(item) {
                self.dropped.fetch_add(1, Ordering::Relaxed);
            }
        }
    }
}

/// Membership in a channel; ends when dropped.
#[derive(Debug)]
pub(super) struct Member {
    channel: Arc<Channel>,
    number: u64,
}

impl Member {
    /// Joins; frames sent from now on are in the queue.
    pub(super) fn join(channel: &Arc<Channel>) -> (Self, Receiver<Item>) {
        let (queue, items) = mpsc::sync_channel(QUEUE);
        let number = channel.next.fetch_add(1, Ordering::Relaxed);
        channel.lock().push(Participant { number, queue });
        (
            Self {
                channel: Arc::clone(channel),
                number,
            },
            items,
        )
    }

    pub(super) fn publish(&self, frame: &Frame) {
        self.channel.publish(self.number, frame);
    }

    pub(super) fn name(&self) -> &str {
        &self.channel.name
    }
}

impl Drop for Member {
    fn drop(&mut self) {
        self.channel
            .lock()
            .retain(|other| other.number != self.number);
    }
}

/// A participant of a hub in the hub's own process: no TCP, no delay.
#[derive(Debug)]
pub struct HubTap {
    member: Member,
    items: Receiver<Item>,
    waiting: Option<Item>,
}

impl HubTap {
    pub(super) fn new(channel: &Arc<Channel>) -> Self {
        let (member, items) = Member::join(channel);
        Self {
            member,
            items,
            waiting: None,
        }
    }

    fn lost(&self) -> BusError {
        BusError::Lost {
            bus: self.label(),
            reason: "the hub has ended".into(),
        }
    }

    fn label(&self) -> String {
        format!("hub channel {}", self.member.name())
    }
}

impl Bus for HubTap {
    fn send(&mut self, frame: &Frame) -> Result<(), BusError> {
        if frame.is_fd() {
            return Err(BusError::FdUnsupported { bus: self.label() });
        }
        self.member.publish(frame);
        Ok(())
    }

    fn receive(&mut self) -> Result<Option<Received>, BusError> {
        let item = match self.waiting.take() {
            Some(item) => item,
            None => match self.items.try_recv() {
                Ok(item) => item,
                Err(TryRecvError::Empty) => return Ok(None),
                Err(TryRecvError::Disconnected) => return Err(self.lost()),
            },
        };
        Ok(Some(Received {
            frame: item.frame,
            at: item.at,
        }))
    }

    fn wait(&mut self, deadline: Micros) -> Result<(), BusError> {
        if self.waiting.is_none() {
            match self.items.recv_timeout(until(deadline)) {
                Ok(item) => self.waiting = Some(item),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return Err(self.lost()),
            }
        }
        Ok(())
    }
}
