//! Every capacity of the node, with its arithmetic.

/// Knots in the EDP's set-point queue: 160 ms at 20 ms macrosteps, one for the segment in hand.
pub const KNOT_QUEUE: usize = 8;

/// Knots of tight coordination that wait to be taken by the ECP: a coordinator streams about five
/// macrosteps ahead; as many again for a burst after a stall.
pub const KNOT_INBOX: usize = 10;

/// Sessions of the MP link: 2 kinds (command, request) for the coordinator and for one more that
/// tries to be it, plus stop and time of either.
pub const LINK_SESSIONS: usize = 8;

/// Drive buses of one node: an STM32G474 has three CAN controllers, one of them towards the MP.
pub const DRIVE_BUSES: usize = 2;

/// Events that wait for transmission: one per axis (drive ready) and as many more.
pub const EVENTS: usize = 16;
