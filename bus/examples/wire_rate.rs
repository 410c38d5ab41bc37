//! How many frames a second the virtual wire simulates: a node and 6 drives at 500 Hz, each drive
//! answering SYNC with one frame after the node sent one to each.
//!
//! `cargo run --release -p mrroc-bus --example wire_rate`

use bus::wire::{Delivery, Kind, Outbox, Wire};
use protocol::frame::{Frame, Id};
use std::time::Instant;

const DRIVES: u16 = 6;
const PERIOD_NS: u64 = 2_000_000;
const CYCLES: u64 = 100_000;

fn main() {
    let mut wire = Wire::new(Kind::Classic, usize::from(DRIVES) + 1);
    let sync = Frame::classic(Id::Standard(0x80), &[]);
    let began = Instant::now();
    let mut checksum = 0u64;
    for cycle in 0..CYCLES {
        let at = cycle * PERIOD_NS;
        for drive in 1..=DRIVES {
            let data = (cycle * u64::from(drive) * 0x9E37_79B9).to_le_bytes();
            if let Some(target) = Frame::classic(Id::Standard(0x200 + drive), &data[..6]) {
                let _ = wire.post(0, at, target);
            }
        }
        if let Some(sync) = sync {
            let _ = wire.post(0, at, sync);
        }
        wire.advance(
            at + PERIOD_NS,
            &mut |delivery: Delivery<'_>, out: &mut Outbox<'_>| {
                checksum = checksum.wrapping_mul(31).wrapping_add(delivery.at_ns);
                if delivery.frame.id() == Id::Standard(0x80) {
                    for drive in 1..=DRIVES {
                        let data = (cycle ^ (u64::from(drive) * 0x1234_5678_9ABC)).to_le_bytes();
                        if let Some(actual) = Frame::classic(Id::Standard(0x180 + drive), &data) {
                            let _ = out.post(usize::from(drive), actual);
                        }
                    }
                }
            },
        );
    }
    let seconds = began.elapsed().as_secs_f64();
    let statistics = wire.statistics();
    #[expect(clippy::cast_precision_loss, reason = "far below 2^53")]
    let rate = statistics.frames as f64 / seconds;
    println!(
        "{} frames in {seconds:.2} s: {:.2} M frames/s; load {:.3}, checksum {checksum:016x}",
        statistics.frames,
        rate / 1e6,
        statistics.load_max()
    );
}
