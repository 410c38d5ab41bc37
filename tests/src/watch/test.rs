//! The observer sees what it is there to see.

use super::*;

const FIRST: usize = 1;

struct Bench {
    watch: Watch,
    at_ns: u64,
}

impl Bench {
    fn new() -> Self {
        let watch = Watch::new(
            RobotKind::Irp6Postument,
            1,
            ServoLaw::DrivePosition,
            0.2,
            FIRST,
            &[0; 6],
        );
        let mut bench = Self { watch, at_ns: 0 };
        for drive in 1..=6 {
            bench.put(TPDO1 + drive, &[0x37, 0x12, 0, 0, 0, 0, 0, 0]);
        }
        bench
    }

    fn put(&mut self, id: u16, data: &[u8]) {
        let frame = Frame::classic(Id::Standard(id), data).unwrap();
        self.watch.frame(FIRST, self.at_ns, &frame);
    }

    /// One servo step: the first axis is sent to `units`, the others stay.
    fn step(&mut self, units: i32) {
        self.at_ns += 2_000_000;
        for drive in 1..=6 {
            let [a, b, c, d] = if drive == 1 { units } else { 0 }.to_le_bytes();
            self.put(RPDO1 + drive, &[0x1F, 0x00, a, b, c, d]);
        }
        self.put(SYNC, &[]);
    }

    fn found(mut self, positions: impl IntoIterator<Item = i32>) -> Vec<Quantity> {
        for position in positions {
            self.step(position);
        }
        let mut found: Vec<_> = self
            .watch
            .first
            .iter()
            .map(|breach| breach.quantity)
            .collect();
        found.dedup();
        found
    }
}

// One unit is 2π/4e6 rad and Ts is 2 ms: in units, the limits of the column are a step of
// 0.1 rad = 63 662, a second difference of 900·Ts² = 3.6e-3 rad = 2 292, and a third of
// 60000·Ts³ = 4.8e-4 rad = 306.
const JERK: i32 = 305;
const ACCELERATION: i32 = 2291;
const VELOCITY: i32 = 63_661;

/// Positions from jerk (per step), so many steps of each.
fn positions(parts: &[(i32, usize)]) -> Vec<i32> {
    let (mut p, mut v, mut a) = (0, 0, 0);
    let mut out = vec![0; 4];
    for (jerk, steps) in parts {
        for _ in 0..*steps {
            a += jerk;
            v += a;
            p += v;
            out.push(p);
        }
    }
    out
}

#[test]
fn a_motion_at_its_limits_is_kept() {
    // 7 steps of jerk give 2135 of acceleration; 22 steps of it some 47 000 of velocity
    let kept = positions(&[
        (JERK, 7),
        (0, 20),
        (-JERK, 7),
        (0, 50),
        (-JERK, 7),
        (0, 20),
        (JERK, 7),
    ]);
    assert_eq!(Bench::new().found(kept), []);
}

#[test]
fn each_limit_is_seen() {
    let jerk = positions(&[(JERK + 10, 1), (-JERK, 1)]);
    assert_eq!(Bench::new().found(jerk), [Quantity::Jerk]);
    // reached step by step, so that jerk is kept
    let acceleration = positions(&[(JERK, 7), (ACCELERATION - 7 * JERK + 10, 1)]);
    assert_eq!(Bench::new().found(acceleration), [Quantity::Acceleration]);
    let too_fast: Vec<i32> = (0..5).map(|k| k * (VELOCITY + 10)).collect();
    assert!(Bench::new().found(too_fast).contains(&Quantity::Velocity));
    let almost: Vec<i32> = (0..5).map(|k| k * VELOCITY).collect();
    assert_eq!(Bench::new().found(almost), []);
}

#[test]
fn a_missing_set_point_is_seen() {
    let mut bench = Bench::new();
    bench.step(0);
    bench.put(SYNC, &[]);
    assert_eq!(bench.found([0]), [Quantity::Missing]);
}

#[test]
fn a_position_beyond_its_limit_is_seen() {
    let mut bench = Bench::new();
    bench.watch.axes[0].zero = Some(0);
    // the column's upper limit, 450 rad, is 286 478 897.6 units
    let limit = 286_478_897;
    assert_eq!(bench.found([limit]), []);
    let mut bench = Bench::new();
    bench.watch.axes[0].zero = Some(0);
    assert_eq!(bench.found([limit + 2]), [Quantity::Position]);
}

#[test]
fn without_torque_nothing_is_a_set_point() {
    let mut bench = Bench::new();
    for drive in 1..=6 {
        bench.put(TPDO1 + drive, &[0x33, 0x12, 0, 0, 0, 0, 0, 0]); // switched on, not operating
    }
    assert_eq!(bench.found([0, 1_000_000, -1_000_000, 5]), []);
}
