//! Network management: commands, states, boot-up, heartbeats produced and consumed.
//!
//! ```text
//!             ResetNode / ResetCommunication (from every state)
//!                       │
//!                       ▼
//!   Initialising ──boot-up──▶ PreOperational ◀──▶ Operational
//!                                  ▲  │               ▲ │
//!                                  │  ▼               │ ▼
//!                                 Stopped ◀────────────▶
//! ```

use super::node::{Function, NodeId, frame, standard};
use crate::frame::Frame;
use crate::time::Micros;

/// The identifier of NMT commands.
pub const COB: u16 = 0x000;

/// What the NMT master commands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Command {
    /// To Operational.
    Start = 0x01,
    /// To Stopped.
    Stop = 0x02,
    /// To Pre-operational.
    EnterPreOperational = 0x80,
    /// Restart the device.
    ResetNode = 0x81,
    /// Restart the communication part.
    ResetCommunication = 0x82,
}

impl Command {
    /// Every command.
    pub const ALL: [Self; 5] = [
        Self::Start,
        Self::Stop,
        Self::EnterPreOperational,
        Self::ResetNode,
        Self::ResetCommunication,
    ];

    /// The command of a specifier byte.
    #[must_use]
    pub const fn from_code(code: u8) -> Option<Self> {
        Some(match code {
            0x01 => Self::Start,
            0x02 => Self::Stop,
            0x80 => Self::EnterPreOperational,
            0x81 => Self::ResetNode,
            0x82 => Self::ResetCommunication,
            _ => return None,
        })
    }
}

/// The NMT state a device reports.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum State {
    /// Booting; on the wire, the boot-up message.
    Initialising = 0x00,
    /// Only NMT and heartbeat.
    Stopped = 0x04,
    /// Everything, process data too.
    Operational = 0x05,
    /// Everything but process data.
    PreOperational = 0x7F,
}

impl State {
    /// Every state.
    pub const ALL: [Self; 4] = [
        Self::Initialising,
        Self::Stopped,
        Self::Operational,
        Self::PreOperational,
    ];

    /// The state of a heartbeat byte.
    #[must_use]
    pub const fn from_code(code: u8) -> Option<Self> {
        Some(match code & 0x7F {
            0x00 => Self::Initialising,
            0x04 => Self::Stopped,
            0x05 => Self::Operational,
            0x7F => Self::PreOperational,
            _ => return None,
        })
    }

    /// The state after `command`.
    ///
    /// While initialising only the resets have an effect: the device is not yet on the wire.
    #[must_use]
    pub const fn on(self, command: Command) -> Self {
        match (self, command) {
            (_, Command::ResetNode | Command::ResetCommunication) | (Self::Initialising, _) => {
                Self::Initialising
            }
            (_, Command::Start) => Self::Operational,
            (_, Command::Stop) => Self::Stopped,
            (_, Command::EnterPreOperational) => Self::PreOperational,
        }
    }
}

/// What a communication error does to the NMT state of an operational device (object 1029).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(u8)]
pub enum ErrorBehaviour {
    /// To Pre-operational: what the standard does without the object.
    #[default]
    PreOperational = 0,
    /// No change: the drive's answers to its own quick stop stay visible.
    Stay = 1,
    /// To Stopped.
    Stopped = 2,
}

impl ErrorBehaviour {
    /// The behaviour of a code.
    #[must_use]
    pub const fn from_code(code: u8) -> Option<Self> {
        Some(match code {
            0 => Self::PreOperational,
            1 => Self::Stay,
            2 => Self::Stopped,
            _ => return None,
        })
    }

    /// The state after a communication error.
    #[must_use]
    pub const fn after(self, state: State) -> State {
        match (self, state) {
            (Self::PreOperational, State::Operational) => State::PreOperational,
            (Self::Stopped, State::Operational | State::PreOperational) => State::Stopped,
            (Self::PreOperational | Self::Stay | Self::Stopped, state) => state,
        }
    }
}

/// Whom an NMT command is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Target {
    /// Every device on the wire.
    All,
    /// One device.
    Node(NodeId),
}

impl Target {
    /// Is `node` meant?
    #[must_use]
    pub fn includes(self, node: NodeId) -> bool {
        match self {
            Self::All => true,
            Self::Node(target) => target == node,
        }
    }
}

/// The frame of an NMT command.
#[must_use]
pub fn command_frame(command: Command, target: Target) -> Frame {
    let node = match target {
        Target::All => 0,
        Target::Node(node) => node.get(),
    };
    frame(COB, [command as u8, node])
}

/// Reads an NMT command.
#[must_use]
pub fn decode_command(frame: &Frame) -> Option<(Command, Target)> {
    if standard(frame) != Some(COB) {
        return None;
    }
    let [code, node] = *frame.data() else {
        return None;
    };
    let target = if node == 0 {
        Target::All
    } else {
        Target::Node(NodeId::new(node)?)
    };
    Some((Command::from_code(code)?, target))
}

/// The heartbeat of `node`; with [`State::Initialising`] it is the boot-up message.
#[must_use]
pub fn heartbeat_frame(node: NodeId, state: State) -> Frame {
    frame(node.cob(Function::Heartbeat), [state as u8])
}

/// Reads a heartbeat or boot-up message.
#[must_use]
pub fn decode_heartbeat(frame: &Frame) -> Option<(NodeId, State)> {
    let node = standard(frame)?.checked_sub(Function::Heartbeat as u16)?;
    let node = NodeId::new(u8::try_from(node).ok()?)?;
    let [code] = *frame.data() else { return None };
    Some((node, State::from_code(code)?))
}

/// Tells when the next heartbeat is due (object 1017).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HeartbeatProducer {
    period: Micros,
    next: Micros,
}

impl HeartbeatProducer {
    /// A producer whose first heartbeat is due one `period` after `now`; a zero period is silent.
    #[must_use]
    pub fn new(now: Micros, period: Micros) -> Self {
        Self {
            period,
            next: now + period,
        }
    }

    /// Is a heartbeat due? Counts it as sent. Late polls do not bunch heartbeats up.
    pub fn due(&mut self, now: Micros) -> bool {
        if self.period == Micros(0) || now < self.next {
            return false;
        }
        self.next = self.next + self.period;
        if self.next <= now {
            self.next = now + self.period;
        }
        true
    }

    /// When the next heartbeat is due, `None` if silent.
    #[must_use]
    pub fn next(&self) -> Option<Micros> {
        (self.period != Micros(0)).then_some(self.next)
    }
}

/// What a heartbeat consumer noticed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Heard {
    /// The device (re)started.
    BootUp,
    /// The first heartbeat, or the first after a loss.
    Appeared(State),
    /// The device changed its state.
    Changed(State),
    /// Nothing new.
    Same,
    /// No heartbeat for a whole window.
    Lost,
    /// Not one heartbeat since monitoring began. It is a fault like a loss: CiA 301 would start to
    /// monitor only with the first heartbeat and so never miss a device that never speaks.
    NeverHeard,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Watch {
    Unheard { since: Micros },
    Alive { last: Micros, state: State },
    Missing,
}

/// Watches the heartbeat of one device (object 1016). Monitoring runs from the start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HeartbeatConsumer {
    node: NodeId,
    window: Micros,
    watch: Watch,
}

impl HeartbeatConsumer {
    /// Watches `node` from `now`; silence longer than `window` is a loss.
    #[must_use]
    pub const fn new(now: Micros, node: NodeId, window: Micros) -> Self {
        Self {
            node,
            window,
            watch: Watch::Unheard { since: now },
        }
    }

    /// The device that is watched.
    #[must_use]
    pub const fn node(&self) -> NodeId {
        self.node
    }

    /// The last state heard, `None` while the device is missing.
    #[must_use]
    pub const fn state(&self) -> Option<State> {
        match self.watch {
            Watch::Alive { state, .. } => Some(state),
            Watch::Unheard { .. } | Watch::Missing => None,
        }
    }

    /// Was a loss told, and nothing heard since?
    #[must_use]
    pub const fn is_missing(&self) -> bool {
        matches!(self.watch, Watch::Missing)
    }

    /// Takes a frame; `None` if it is not a heartbeat of the device.
    pub fn on_frame(&mut self, now: Micros, frame: &Frame) -> Option<Heard> {
        let (node, state) = decode_heartbeat(frame)?;
        if node != self.node {
            return None;
        }
        let before = self.watch;
        self.watch = Watch::Alive { last: now, state };
        Some(match (before, state) {
            (_, State::Initialising) => Heard::BootUp,
            (Watch::Alive { state: last, .. }, _) if last == state => Heard::Same,
            (Watch::Alive { .. }, _) => Heard::Changed(state),
            (Watch::Unheard { .. } | Watch::Missing, _) => Heard::Appeared(state),
        })
    }

    /// Looks at the clock: tells a loss once.
    pub fn poll(&mut self, now: Micros) -> Option<Heard> {
        let (since, verdict) = match self.watch {
            Watch::Unheard { since } => (since, Heard::NeverHeard),
            Watch::Alive { last, .. } => (last, Heard::Lost),
            Watch::Missing => return None,
        };
        if now.since(since) <= self.window {
            return None;
        }
        self.watch = Watch::Missing;
        Some(verdict)
    }
}

#[cfg(test)]
mod tests;
