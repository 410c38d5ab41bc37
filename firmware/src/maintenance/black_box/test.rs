#![expect(
    clippy::cast_possible_truncation,
    clippy::cast_possible_wrap,
    reason = "signals that fit"
)]

extern crate std;
use super::*;
use proptest::prelude::*;
use std::vec;
use std::vec::Vec;

/// Memory that survives, and counts how often it was kept.
#[derive(Clone, Debug)]
struct Kept {
    bytes: Vec<u8>,
    times: u32,
}

impl Memory for Kept {
    fn bytes(&self) -> &[u8] {
        &self.bytes
    }
    fn bytes_mut(&mut self) -> &mut [u8] {
        &mut self.bytes
    }
    fn keep(&mut self) {
        self.times += 1;
    }
}

fn memory(axes: usize, fill: u8) -> Kept {
    Kept {
        bytes: vec![fill; bytes(axes)],
        times: 0,
    }
}

fn fault_at(step: u32) -> Fault {
    Fault {
        cause: Cause::FollowingError,
        axis: Some(2),
        step,
        during: NodeState::Moving,
    }
}

fn signals(step: u32, axes: usize, fault: Option<Fault>) -> Signals {
    let axis = |k: usize| AxisSample {
        actual: step as i32 * 10 + k as i32,
        error: -(k as i16),
        current_ma: step as i16,
    };
    Signals {
        step,
        state: if fault.is_some() {
            NodeState::Stopping
        } else {
            NodeState::Moving
        },
        fault,
        instruction: 7,
        axes: (0..axes).map(axis).collect(),
    }
}

fn run(black_box: &mut BlackBox<Kept>, axes: usize, steps: core::ops::RangeInclusive<u32>) {
    for step in steps {
        black_box.record(&signals(step, axes, None), 3, 2000);
        assert!(!black_box.seal());
    }
}

fn fail(black_box: &mut BlackBox<Kept>, axes: usize, step: u32) {
    black_box.record(&signals(step, axes, Some(fault_at(step))), 3, 2000);
    assert_eq!(black_box.first_fault(), None, "not complete yet");
    assert!(black_box.seal());
}

fn read(black_box: &BlackBox<Kept>) -> Vec<Sample> {
    let record = black_box.first_fault().unwrap().record;
    let mut samples = Vec::new();
    loop {
        let first = u16::try_from(samples.len()).unwrap();
        let more = black_box.samples(record, first).unwrap();
        if more.is_empty() {
            return samples;
        }
        samples.extend(more);
    }
}

#[test]
fn the_last_fifty_steps_are_all_there_and_every_tenth_before() {
    let mut black_box = BlackBox::open(memory(6, 0xA5), 6).unwrap();
    assert_eq!(black_box.first_fault(), None, "any bytes are no record");
    run(&mut black_box, 6, 1..=5000);
    fail(&mut black_box, 6, 5001);
    let record = black_box.first_fault().unwrap();
    assert_eq!(record.fault, fault_at(5001));
    assert_eq!((record.instruction, record.boot, record.later), (7, 3, 0));
    assert_eq!((record.samples, record.servo_step_us), (145, 2000));
    let samples = read(&black_box);
    let steps: Vec<u32> = samples.iter().map(|sample| sample.step).collect();
    // by hand: 4952 … 5001 all, before them 4950, 4940, … 4010: 95 of them
    let coarse = (401..=495).map(|k| k * 10);
    let expected: Vec<u32> = coarse.chain(4952..=5001).collect();
    assert_eq!(steps, expected);
    for sample in &samples {
        let fault = (sample.step == 5001).then(|| fault_at(5001));
        let whole = signals(sample.step, 6, fault);
        assert_eq!(sample.axes, whole.axes);
        assert_eq!(sample.state, whole.state);
        assert_eq!(sample.fault, if fault.is_some() { 30 } else { 0 });
    }
}

#[test]
fn a_fault_soon_after_the_start_has_what_there_is() {
    for steps in [0, 1, 49, 50, 51, 60, 61, 70, 995, 1000, 1010] {
        let mut black_box = BlackBox::open(memory(2, 0), 2).unwrap();
        run(&mut black_box, 2, 1..=steps);
        fail(&mut black_box, 2, steps + 1);
        let samples = read(&black_box);
        let found: Vec<u32> = samples.iter().map(|sample| sample.step).collect();
        let fine = (steps + 1).saturating_sub(49).max(1);
        let mut expected: Vec<u32> = (1..fine).filter(|step| step % 10 == 0).collect();
        let surplus = expected.len().saturating_sub(COARSE);
        expected.drain(..surplus);
        expected.extend(fine..=steps + 1);
        assert_eq!(found, expected, "{steps}");
    }
}

#[test]
fn a_record_survives_a_reset_and_nothing_is_recorded_over_it() {
    let mut black_box = BlackBox::open(memory(6, 0), 6).unwrap();
    run(&mut black_box, 6, 1..=700);
    fail(&mut black_box, 6, 701);
    let (before, samples) = (black_box.first_fault(), read(&black_box));
    assert_eq!(black_box.memory().times, 1);
    let mut after = BlackBox::open(black_box.memory().clone(), 6).unwrap();
    assert_eq!(
        (after.first_fault(), read(&after)),
        (before, samples.clone())
    );
    // a new life, with a fault of its own that is acknowledged, and motion
    run(&mut after, 6, 1..=100);
    after.record(&signals(101, 6, Some(fault_at(101))), 4, 2000);
    run(&mut after, 6, 102..=300);
    let found = after.first_fault().unwrap();
    assert_eq!(found.later, 1);
    assert_eq!(Some(FaultRecord { later: 0, ..found }), before);
    assert_eq!(read(&after), samples);
    // also what was counted since survives
    let mut again = BlackBox::open(after.memory().clone(), 6).unwrap();
    assert_eq!(again.first_fault().unwrap().later, 1);
    assert!(!again.clear(found.record ^ 1), "another record");
    assert!(again.clear(found.record));
    assert_eq!(again.first_fault(), None);
    let empty = BlackBox::open(again.memory().clone(), 6).unwrap();
    assert_eq!(empty.first_fault(), None);
}

#[test]
fn an_acknowledged_record_can_be_read_until_the_robot_moves_again() {
    let mut black_box = BlackBox::open(memory(1, 0), 1).unwrap();
    run(&mut black_box, 1, 1..=20);
    fail(&mut black_box, 1, 21);
    let record = black_box.first_fault();
    let still = |step, state| Signals {
        state,
        ..signals(step, 1, None)
    };
    for (step, state) in (22..).zip([NodeState::Disabled, NodeState::Enabling, NodeState::Holding])
    {
        black_box.record(&still(step, state), 3, 2000);
        assert_eq!(black_box.first_fault(), record, "{state:?}");
    }
    black_box.record(&still(30, NodeState::Moving), 3, 2000);
    assert_eq!(black_box.first_fault(), None);
    fail(&mut black_box, 1, 31);
    let steps: Vec<u32> = read(&black_box).iter().map(|sample| sample.step).collect();
    assert_eq!(steps, [30, 31], "only of the time since");
}

#[test]
fn a_second_fault_of_the_same_trouble_is_counted_and_not_recorded() {
    let mut black_box = BlackBox::open(memory(1, 0), 1).unwrap();
    fail(&mut black_box, 1, 5);
    // latched for a while: not a new one every step
    for step in 6..20 {
        black_box.record(&signals(step, 1, Some(fault_at(5))), 3, 2000);
    }
    assert_eq!(black_box.first_fault().unwrap().later, 0);
    assert_eq!(black_box.first_fault().unwrap().fault.step, 5);
}

#[test]
fn a_step_is_recorded_once_however_often_it_is_told() {
    let mut black_box = BlackBox::open(memory(1, 0), 1).unwrap();
    for _ in 0..3 {
        black_box.record(&signals(1, 1, None), 1, 1000);
    }
    fail(&mut black_box, 1, 2);
    assert_eq!(black_box.first_fault().unwrap().samples, 2);
}

#[test]
fn a_record_of_another_robot_or_a_short_memory_is_none() {
    assert!(BlackBox::open(memory(5, 0), 6).is_none());
    assert!(BlackBox::open(memory(9, 0), 9).is_none());
    let mut black_box = BlackBox::open(memory(6, 0), 5).unwrap();
    fail(&mut black_box, 5, 1);
    let other = BlackBox::open(black_box.memory().clone(), 6).unwrap();
    assert_eq!(other.first_fault(), None);
}

#[test]
fn the_states_are_in_the_order_of_the_wire() {
    for (number, state) in NodeState::ALL.into_iter().enumerate() {
        assert_eq!(usize::from(state_number(state)), number);
        let sent = protocol::codec::encode(
            &protocol::maintenance::MaintenanceReply::Refused(
                protocol::maintenance::MaintenanceRefusal::TorqueOn { state },
            ),
            &mut [0; 8],
        )
        .unwrap()[2];
        assert_eq!(usize::from(sent), number);
    }
}

#[test]
fn damage_of_any_bit_is_found() {
    let mut black_box = BlackBox::open(memory(1, 0), 1).unwrap();
    run(&mut black_box, 1, 1..=600);
    fail(&mut black_box, 1, 601);
    let good = black_box.memory().clone();
    for bit in 0..LATER_AT * 8 {
        let mut damaged = good.clone();
        damaged.bytes[bit / 8] ^= 1 << (bit % 8);
        assert_eq!(
            BlackBox::open(damaged, 1).unwrap().first_fault(),
            None,
            "{bit}"
        );
    }
    for bit in (HEADER * 8..good.bytes.len() * 8).step_by(11) {
        let mut damaged = good.clone();
        damaged.bytes[bit / 8] ^= 1 << (bit % 8);
        assert_eq!(
            BlackBox::open(damaged, 1).unwrap().first_fault(),
            None,
            "{bit}"
        );
    }
}

proptest! {
    /// What is in memory that was never written, or written by others, does no harm.
    #[test]
    fn any_memory_is_a_record_or_none(
        start in proptest::collection::vec(any::<u8>(), HEADER), fill: u8, axes in 0_usize..=8, steps in 1_u32..200,
    ) {
        let mut before = memory(axes, fill);
        before.bytes[..HEADER].copy_from_slice(&start);
        before.bytes[..4].copy_from_slice(&MAGIC);
        let mut black_box = BlackBox::open(before, axes).unwrap();
        for step in 1..=steps {
            black_box.record(&signals(step, axes, None), 1, 1000);
        }
        black_box.record(&signals(steps + 1, axes, Some(fault_at(steps + 1))), 1, 1000);
        prop_assert!(black_box.seal());
        prop_assert_eq!(read(&black_box).last().unwrap().step, steps + 1);
    }
}
