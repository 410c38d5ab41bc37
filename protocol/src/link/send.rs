//! Typed messages to frames.

use super::Endpoint;
use crate::codec::{EncodeError, Payload, encode};
use crate::cyphal::{Heartbeat, MAX_INFO, NodeInfo};
use crate::e2e;
use crate::frame::Frame;
use crate::id::{CanId, NodeId, Port, Priority, Service, Subject};
use crate::maintenance::{MaintenanceReply, MaintenanceRequest};
use crate::message::{Command, DemandTrace, Event, Feedback, Reply, Request, StopAll, TimeSync};
use crate::time::Micros;
use crate::transfer::{MAX_TRANSFER, Mtu, TransferId, Transmitter, padded_length};

/// The standard demands a heartbeat at least once a second.
const HEARTBEAT_PERIOD: Micros = Micros::from_millis(1000);

/// The counter's value, which is then one further.
fn take(counter: &mut u8) -> u8 {
    let value = *counter;
    *counter = counter.wrapping_add(1);
    value
}

/// Encodes, protects (if `epoch` is given), and splits into frames.
fn transmit<M: Payload>(
    message: &M,
    id: CanId,
    mtu: Mtu,
    counter: u8,
    epoch: Option<u32>,
    out: &mut impl FnMut(Frame),
) -> Result<(), EncodeError> {
    let mut buffer = [0u8; MAX_TRANSFER];
    let header = if epoch.is_some() { e2e::HEADER } else { 0 };
    let len = encode(message, buffer.get_mut(header..).ok_or(EncodeError)?)?.len();
    // The protection covers the padding that the frames will need.
    let len = padded_length(header.saturating_add(len), mtu);
    let bytes = buffer.get_mut(..len).ok_or(EncodeError)?;
    if let Some(epoch) = epoch {
        e2e::protect(e2e::data_id(id, epoch), counter, bytes);
    }
    Transmitter::new(id, TransferId::new(counter), mtu, bytes).for_each(out);
    Ok(())
}

/// # Errors
/// Every `send_…` fails only if the message is longer than a transfer can be, which the types
/// exclude; nothing is sent then.
impl<const SESSIONS: usize> Endpoint<SESSIONS> {
    const fn id(&self, priority: Priority, port: Port) -> CanId {
        CanId {
            priority,
            source: self.node,
            port,
        }
    }

    /// MP → node: the cyclic command. Protected under its own epoch.
    ///
    /// # Errors
    /// Never for messages that the types allow.
    pub fn send_command(
        &mut self,
        to: NodeId,
        command: &Command,
        out: &mut impl FnMut(Frame),
    ) -> Result<(), EncodeError> {
        let id = self.id(Priority::Fast, Port::Message(Subject::command(to)));
        let mut counter = 0;
        if let Some(session) = self.commands.get_mut(usize::from(to.get())) {
            counter = take(session);
        }
        transmit(command, id, self.mtu, counter, Some(command.epoch), out)
    }

    /// Node → everyone: its image.
    ///
    /// # Errors
    /// Never for messages that the types allow.
    pub fn send_feedback(
        &mut self,
        feedback: &Feedback,
        out: &mut impl FnMut(Frame),
    ) -> Result<(), EncodeError> {
        let id = self.id(Priority::High, Port::Message(Subject::FEEDBACK));
        let counter = take(&mut self.broadcasts.feedback);
        transmit(feedback, id, self.mtu, counter, Some(0), out)
    }

    /// Node → everyone: the demand of a servo step. Not protected.
    ///
    /// # Errors
    /// Never for messages that the types allow.
    pub fn send_demand_trace(
        &mut self,
        trace: &DemandTrace,
        out: &mut impl FnMut(Frame),
    ) -> Result<(), EncodeError> {
        let id = self.id(Priority::Optional, Port::Message(Subject::DEMAND_TRACE));
        let counter = take(&mut self.broadcasts.demand_trace);
        transmit(trace, id, self.mtu, counter, None, out)
    }

    /// Node → everyone: what happened. Not protected.
    ///
    /// # Errors
    /// Never for messages that the types allow.
    pub fn send_event(
        &mut self,
        event: &Event,
        out: &mut impl FnMut(Frame),
    ) -> Result<(), EncodeError> {
        let id = self.id(Priority::Low, Port::Message(Subject::EVENT));
        let counter = take(&mut self.broadcasts.event);
        transmit(event, id, self.mtu, counter, None, out)
    }

    /// Anyone → everyone: stop. To be sent three times, 5 ms apart.
    ///
    /// # Errors
    /// Never for messages that the types allow.
    pub fn send_stop_all(
        &mut self,
        stop: &StopAll,
        out: &mut impl FnMut(Frame),
    ) -> Result<(), EncodeError> {
        let id = self.id(Priority::Exceptional, Port::Message(Subject::STOP_ALL));
        let counter = take(&mut self.broadcasts.stop_all);
        transmit(stop, id, self.mtu, counter, Some(0), out)
    }

    /// Master of time → everyone. The caller notes when the first frame left, for the next one:
    /// see [`crate::clock::Master`].
    ///
    /// # Errors
    /// Never for messages that the types allow.
    pub fn send_time_sync(
        &mut self,
        sync: &TimeSync,
        out: &mut impl FnMut(Frame),
    ) -> Result<(), EncodeError> {
        let id = self.id(Priority::Immediate, Port::Message(Subject::TIME_SYNC));
        let counter = take(&mut self.broadcasts.time_sync);
        transmit(sync, id, self.mtu, counter, Some(0), out)
    }

    /// MP → node: a request; its answer will carry the returned transfer-id.
    ///
    /// # Errors
    /// Never for messages that the types allow.
    pub fn send_request(
        &mut self,
        to: NodeId,
        request: &Request,
        out: &mut impl FnMut(Frame),
    ) -> Result<TransferId, EncodeError> {
        let id = self.id(Priority::Nominal, Port::Request(Service::REQUEST, to));
        let counter = self.request_id(to);
        transmit(request, id, self.mtu, counter.get(), Some(0), out)?;
        Ok(counter)
    }

    /// Both of our services count together: a receiver takes any transfer-id but the one just received.
    fn request_id(&mut self, to: NodeId) -> TransferId {
        match self.requests.get_mut(usize::from(to.get())) {
            Some(session) => TransferId::new(take(session)),
            None => TransferId::default(),
        }
    }

    /// Anyone → node: a request to the maintenance service; its answer will carry the returned transfer-id.
    ///
    /// # Errors
    /// Never for messages that the types allow.
    pub fn send_maintenance(
        &mut self,
        to: NodeId,
        request: &MaintenanceRequest,
        out: &mut impl FnMut(Frame),
    ) -> Result<TransferId, EncodeError> {
        let id = self.id(Priority::Slow, Port::Request(Service::MAINTENANCE, to));
        let counter = self.request_id(to);
        transmit(request, id, self.mtu, counter.get(), Some(0), out)?;
        Ok(counter)
    }

    /// Node → whoever asked: the answer to the maintenance request of this transfer-id.
    ///
    /// # Errors
    /// Never for messages that the types allow.
    pub fn send_maintenance_reply(
        &mut self,
        to: NodeId,
        transfer_id: TransferId,
        reply: &MaintenanceReply,
        out: &mut impl FnMut(Frame),
    ) -> Result<(), EncodeError> {
        let id = self.id(Priority::Slow, Port::Response(Service::MAINTENANCE, to));
        transmit(reply, id, self.mtu, transfer_id.get(), Some(0), out)
    }

    /// Node → MP: the answer to the request of this transfer-id.
    ///
    /// # Errors
    /// Never for messages that the types allow.
    pub fn send_reply(
        &mut self,
        to: NodeId,
        transfer_id: TransferId,
        reply: &Reply,
        out: &mut impl FnMut(Frame),
    ) -> Result<(), EncodeError> {
        let id = self.id(Priority::Nominal, Port::Response(Service::REQUEST, to));
        transmit(reply, id, self.mtu, transfer_id.get(), Some(0), out)
    }

    /// The answer to [`super::Message::GetInfo`].
    pub fn send_node_info(
        &mut self,
        to: NodeId,
        transfer_id: TransferId,
        info: &NodeInfo<'_>,
        out: &mut impl FnMut(Frame),
    ) {
        let id = self.id(Priority::Nominal, Port::Response(Service::GET_INFO, to));
        let mut buffer = [0; MAX_INFO];
        Transmitter::new(id, transfer_id, self.mtu, info.emit(&mut buffer)).for_each(out);
    }

    /// Sends the heartbeat if one is due: call it as often as convenient, at least once a second.
    /// `now` counts from boot.
    pub fn poll_heartbeat(
        &mut self,
        now: Micros,
        heartbeat: impl FnOnce(u32) -> Heartbeat,
        out: &mut impl FnMut(Frame),
    ) {
        if now < self.next_heartbeat {
            return;
        }
        // Keeps the rhythm when late by less than a period.
        let next = self.next_heartbeat + HEARTBEAT_PERIOD;
        self.next_heartbeat = if now < next {
            next
        } else {
            now + HEARTBEAT_PERIOD
        };
        let uptime_s = u32::try_from(now.0 / 1_000_000).unwrap_or(u32::MAX);
        let id = self.id(Priority::Low, Port::Message(Subject::HEARTBEAT));
        let counter = TransferId::new(take(&mut self.broadcasts.heartbeat));
        let bytes = heartbeat(uptime_s).emit();
        Transmitter::new(id, counter, self.mtu, &bytes).for_each(out);
    }
}
