//! Bytes of every message: goldens, completeness, greatest sizes, bad input.

use super::{golden, samples};
use proptest::prelude::*;
use protocol::codec::{DecodeError, MAX_MESSAGE, Payload, decode, decode_padded, encode};
use protocol::fault::{Cause, Fault, Quantity, Refusal};
use protocol::message::{
    Command, Coordination, Corner, DemandTrace, Event, Feedback, Identity, Instruction,
    KnotMessage, NodeState, PATH_BATCH, PathElement, PoseMessage, Progress, Reply, Request, Space,
    StopAll, TimeSync,
};
use protocol::time::Micros;
use std::collections::BTreeSet;
use std::fmt::Debug;

pub(super) fn bytes<M: Payload + PartialEq + Debug>(message: &M) -> Vec<u8> {
    let mut buffer = [0; MAX_MESSAGE];
    let bytes = encode(message, &mut buffer).unwrap().to_vec();
    assert_eq!(decode::<M>(&bytes).as_ref(), Ok(message));
    assert!(
        bytes.len() <= M::MAX,
        "{}: {} > {}",
        M::NAME,
        bytes.len(),
        M::MAX
    );
    // One byte less room fails, one byte less input is truncated, one more is trailing.
    if let Some(short) = bytes.len().checked_sub(1) {
        assert!(encode(message, &mut buffer[..short]).is_err());
        assert_eq!(decode::<M>(&bytes[..short]), Err(DecodeError::Truncated));
    }
    let longer = [&bytes[..], &[0]].concat();
    assert_eq!(
        decode::<M>(&longer),
        Err(DecodeError::Trailing { bytes: 1 })
    );
    assert_eq!(decode_padded::<M>(&longer).as_ref(), Ok(message));
    assert!(decode_padded::<M>(&[&bytes[..], &[1]].concat()).is_err());
    assert!(decode_padded::<M>(&[&bytes[..], &[0; 16]].concat()).is_err());
    bytes
}

fn lines<M: Payload + PartialEq + Debug>(samples: Vec<(&str, M)>) -> Vec<(String, Vec<u8>)> {
    let line = |(name, message): (&str, M)| (format!("{}/{name}", M::NAME), bytes(&message));
    samples.into_iter().map(line).collect()
}

#[test]
fn every_message_has_its_golden_bytes() {
    let mut all = lines(samples::commands());
    all.extend(lines(samples::feedbacks()));
    all.extend(lines(samples::traces()));
    all.extend(lines(samples::events()));
    all.extend(lines(samples::stops()));
    all.extend(lines(samples::syncs()));
    all.extend(lines(samples::requests()));
    all.extend(lines(samples::replies()));
    golden::check("messages.hex", &all);
}

/// The variants that decode after `prefix`: the tags for which zeros do not make an invalid value.
fn tags<M: Payload + Debug>(prefix: &[u8]) -> BTreeSet<u8> {
    (0..128)
        .filter(|tag| {
            let input = [prefix, &[*tag], &[0; 300]].concat();
            !matches!(decode::<M>(&input), Err(DecodeError::Invalid))
        })
        .collect()
}

#[test]
fn the_samples_have_every_variant() {
    let first = |all: Vec<Vec<u8>>| all.iter().map(|b| b[0]).collect::<BTreeSet<u8>>();
    let of = |all: Vec<(&str, Request)>| all.iter().map(|s| bytes(&s.1)).collect::<Vec<_>>();
    assert_eq!(first(of(samples::requests())), tags::<Request>(&[]));
    let replies: Vec<_> = samples::replies().iter().map(|s| bytes(&s.1)).collect();
    assert_eq!(first(replies), tags::<Reply>(&[]));
    let events: Vec<_> = samples::events().iter().map(|s| bytes(&s.1)).collect();
    // Fault zeros are invalid, since no cause has the code 0.
    assert_eq!(first(events).len(), tags::<Event>(&[]).len() + 1);
    let stops: Vec<_> = samples::stops().iter().map(|s| bytes(&s.1)).collect();
    assert_eq!(first(stops), tags::<StopAll>(&[]));
    // Instructions: after the tag of Execute, epoch, id, start.
    let execute = [6, 0, 0, 0];
    let request = Request::Execute {
        epoch: 0,
        id: 0,
        start_at: Micros(0),
        instruction: Instruction::Follow,
    };
    assert_eq!(bytes(&request)[..4], execute);
    let instructions: BTreeSet<u8> = samples::instructions()
        .into_iter()
        .map(|(_, instruction)| {
            bytes(&Request::Execute {
                epoch: 0,
                id: 0,
                start_at: Micros(0),
                instruction,
            })[4]
        })
        .collect();
    assert_eq!(instructions, tags::<Request>(&execute));
    // Refusals, of which two carry a cause.
    let refusals: BTreeSet<u8> = samples::refusals()
        .into_iter()
        .map(|(_, why)| bytes(&Reply::Refused(why))[1])
        .collect();
    assert_eq!(refusals.len(), tags::<Reply>(&[3]).len() + 2);
    // Coordination and progress.
    let coordinations: BTreeSet<u8> = samples::commands()
        .into_iter()
        .map(|(_, c)| {
            bytes(&Command {
                epoch: 0,
                sequence: 0,
                valid_until: Micros(0),
                ..c
            })[3]
        })
        .collect();
    assert_eq!(coordinations, tags::<Command>(&[0, 0, 0]));
}

#[test]
fn a_cause_travels_as_its_code() {
    for cause in Cause::ALL {
        let event = Event::Fault(Fault {
            cause: *cause,
            ..samples::fault()
        });
        let code = u8::try_from(cause.code()).unwrap();
        assert!(code < 128, "the goldens assume one byte");
        assert_eq!(bytes(&event)[..2], [2, code]);
    }
    let mut unknown = bytes(&Event::Fault(samples::fault()));
    unknown[1] = 1;
    assert_eq!(decode::<Event>(&unknown), Err(DecodeError::Invalid));
}

fn full<T: Clone>(value: T) -> heapless::Vec<T, 8> {
    std::iter::repeat_n(value, 8).collect()
}

/// The worst case of every message is exactly the arithmetic of its `MAX`.
#[test]
#[expect(clippy::too_many_lines, reason = "a field a line")]
fn the_greatest_sizes_are_reached() {
    let knot = KnotMessage {
        at: Micros(u64::MAX),
        space: Space::Joints,
        position: full(1.0),
        velocity: full(1.0),
        acceleration: full(1.0),
    };
    let command = Command {
        epoch: u32::MAX,
        sequence: u16::MAX,
        valid_until: Micros(u64::MAX),
        coordination: Coordination::Tight(knot),
    };
    assert_eq!(bytes(&command).len(), Command::MAX);

    let limit = Refusal::Limit {
        axis: 1,
        quantity: Quantity::Jerk,
        value: 1.0,
        limit: 1.0,
    };
    let feedback = Feedback {
        step: u32::MAX,
        sampled_at: Micros(u64::MAX),
        state: NodeState::Faulted,
        fault: Some(Fault {
            cause: Cause::HomingForeignSwitch,
            axis: Some(7),
            step: u32::MAX,
            during: NodeState::Moving,
        }),
        synchronised: 255,
        epoch: u32::MAX,
        instruction: u32::MAX,
        progress: Progress::Failed(limit),
        horizon_us: u32::MAX,
        actual: full(i64::MIN),
        demand: full(i64::MIN),
        current_ma: full(i16::MIN),
        following_error: full(u32::MAX),
        limit_violations: u32::MAX,
        acceleration_step: f32::MAX,
        lost: u32::MAX,
        force_n: Some([f32::MAX; 3]),
    };
    // Causes' codes are below 128 now, but may take three bytes one day.
    assert_eq!(bytes(&feedback).len(), Feedback::MAX - 2);

    let trace = DemandTrace {
        step: u32::MAX,
        demand: full(i64::MIN),
    };
    assert_eq!(bytes(&trace).len(), DemandTrace::MAX);
    let identity = Identity {
        robot: "r".repeat(24).as_str().try_into().unwrap(),
        unique_id: u64::MAX,
        protocol: (255, 255),
        schema_hash: u64::MAX,
        config_crc: u32::MAX,
        firmware: (255, 255, 255),
        axes: 255,
        servo_step_us: u32::MAX,
        macrostep: u16::MAX,
    };
    assert_eq!(bytes(&Event::Announce(identity.clone())).len(), Event::MAX);
    assert_eq!(bytes(&Reply::Identity(identity)).len(), Reply::MAX);
    let sync = TimeSync {
        sequence: 255,
        previous_sent_at: Micros(u64::MAX),
    };
    assert_eq!(bytes(&sync).len(), TimeSync::MAX);
    let arc = PathElement::Arc {
        via_m: [1.0; 3],
        to: PoseMessage {
            position_m: [1.0; 3],
            rotation_rad: [1.0; 3],
        },
        corner: Corner {
            metres: 1.0,
            radians: 1.0,
        },
    };
    let path = Request::Path {
        epoch: u32::MAX,
        first: u32::MAX,
        elements: [arc; PATH_BATCH].into_iter().collect(),
    };
    assert_eq!(bytes(&path).len(), Request::MAX);
}

#[test]
fn more_than_eight_axes_are_refused() {
    let mut nine = vec![5, 9];
    nine.extend([0; 9]);
    assert_eq!(decode::<DemandTrace>(&nine), Err(DecodeError::Invalid));
}

proptest! {
    #[test]
    fn any_bytes_decode_or_fail(input in proptest::collection::vec(any::<u8>(), 0..=512)) {
        let _ = decode_padded::<Command>(&input);
        let _ = decode_padded::<Feedback>(&input);
        let _ = decode_padded::<DemandTrace>(&input);
        let _ = decode_padded::<Event>(&input);
        let _ = decode_padded::<StopAll>(&input);
        let _ = decode_padded::<TimeSync>(&input);
        let _ = decode_padded::<Request>(&input);
        let _ = decode_padded::<Reply>(&input);
    }

    /// Near-valid input: a golden with a few bytes changed.
    #[test]
    fn damaged_messages_decode_or_fail(
        which in any::<prop::sample::Index>(),
        damage in proptest::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..4),
    ) {
        let feedbacks = samples::feedbacks();
        let requests = samples::requests();
        let mut feedback = bytes(&which.get(&feedbacks).1);
        let mut request = bytes(&which.get(&requests).1);
        for (place, value) in damage {
            *place.get_mut(&mut feedback) = value;
            *place.get_mut(&mut request) = value;
        }
        let _ = decode_padded::<Feedback>(&feedback);
        let _ = decode_padded::<Request>(&request);
    }
}
