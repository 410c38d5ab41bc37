//! Every capacity of the node, with its arithmetic.

/// Knots in the EDP's set-point queue: 160 ms at 20 ms macrosteps, one for the segment in hand.
pub const KNOT_QUEUE: usize = 8;

/// Knots of tight coordination that wait to be taken by the ECP: a coordinator streams about five
/// macrosteps ahead; as many again for a burst after a stall.
pub const KNOT_INBOX: usize = 10;

/// Knots of one plan of the ECP. A path has two a macrostep; of tight coordination it takes up to two in the time
/// until the hand-over, where a coordinator sends one in a macrostep.
pub const KNOTS_PER_PLAN: usize = 2;

/// Sessions of the MP link: 2 kinds (command, request) for the coordinator and for one more that
/// tries to be it, plus stop and time of either.
pub const LINK_SESSIONS: usize = 8;

/// Drive buses of one node: an STM32G474 has three CAN controllers, one of them towards the MP.
pub const DRIVE_BUSES: usize = 2;

/// Events that wait for transmission: one per axis (drive ready) and as many more.
pub const EVENTS: usize = 16;

/// Elements of a path that wait to be made pieces of: four requests.
pub const PATH_INBOX: usize = 16;

/// Elements made pieces of in one macrostep: 200 points a second at 20 ms.
pub const PATH_ELEMENTS_PER_MACROSTEP: usize = 4;

/// The same on a microcontroller, where an element with a rounded corner takes up to 600 000 instructions of the 1.36 million
/// that a macrostep has for it.
pub const PATH_ELEMENTS_PER_MACROSTEP_SMALL: usize = 1;

/// Samples of a path that the choice of speed looks at: a quarter behind, the rest ahead. At the
/// longest distance of samples, 1.5 mm, it brakes within 100 mm: from 0.4 m/s at 1 m/s².
///
/// There are as many places for pieces, so that points as far apart as the samples fill the window; of closer
/// ones it sees less, and below a quarter of that distance it may have to refuse. And as many for changes of
/// the feed, of which there is one a piece.
pub const PATH_SAMPLES: usize = 96;

/// The same on a microcontroller with 64 KiB for everything, where a sample and its piece take 0.7 kB. It brakes within
/// 33 mm, from 0.25 m/s at 1 m/s². A step must not pass more than a quarter of the window, 12 mm, in a macrostep and
/// the time of smoothing, 80 ms here: so a path is followed with at most 0.15 m/s, where [`PATH_SAMPLES`] allow 0.45.
pub const PATH_SAMPLES_SMALL: usize = 32;

/// Samples taken of a path in one macrostep, each an inverse kinematics with its derivatives: at 1.5 mm and 20 ms enough
/// for 0.6 m/s.
pub const PATH_SAMPLES_PER_MACROSTEP: usize = 8;

/// The same on a microcontroller, where a sample takes up to 160 000 instructions: enough for 0.15 m/s.
pub const PATH_SAMPLES_PER_MACROSTEP_SMALL: usize = 2;

/// How many elements and how many samples a macrostep takes of a path, where the choice of speed looks at so many
/// samples.
#[must_use]
pub const fn path_per_macrostep(window: usize) -> (usize, usize) {
    if window < PATH_SAMPLES {
        (
            PATH_ELEMENTS_PER_MACROSTEP_SMALL,
            PATH_SAMPLES_PER_MACROSTEP_SMALL,
        )
    } else {
        (PATH_ELEMENTS_PER_MACROSTEP, PATH_SAMPLES_PER_MACROSTEP)
    }
}

/// Macrosteps over which the motion along a path is averaged: 160 ms at 20 ms; the robots here need 60 ms.
pub const PATH_AVERAGED: usize = 8;
