//! Any message survives the wire: encoded, framed, received, it is the same bytes again.

use proptest::collection::vec;
use proptest::prelude::*;
use protocol::codec::{MAX_MESSAGE, Payload, decode, encode};
use protocol::fault::{Cause, Fault, Quantity, Refusal};
use protocol::message::{
    AxisSpeeds, Command, Coordination, Decision, DemandTrace, Event, Feedback, Instruction,
    KnotMessage, NodeState, PoseMessage, Progress, Reply, Request, Space, TimeSync,
};
use protocol::time::Micros;

/// Every bit pattern, NaNs included.
fn float64() -> impl Strategy<Value = f64> {
    any::<u64>().prop_map(f64::from_bits)
}

fn float32() -> impl Strategy<Value = f32> {
    any::<u32>().prop_map(f32::from_bits)
}

fn axes<T: std::fmt::Debug + Clone>(
    item: impl Strategy<Value = T>,
) -> impl Strategy<Value = heapless::Vec<T, 8>> {
    vec(item, 0..=8).prop_map(|items| items.into_iter().collect())
}

fn state() -> impl Strategy<Value = NodeState> {
    prop::sample::select(&[NodeState::Boot, NodeState::Holding, NodeState::Faulted][..])
}

fn micros() -> impl Strategy<Value = Micros> {
    any::<u64>().prop_map(Micros)
}

fn fault() -> impl Strategy<Value = Fault> {
    let cause = prop::sample::select(Cause::ALL);
    (cause, any::<Option<u8>>(), any::<u32>(), state()).prop_map(|(cause, axis, step, during)| {
        Fault {
            cause,
            axis,
            step,
            during,
        }
    })
}

fn refusal() -> impl Strategy<Value = Refusal> {
    prop_oneof![
        any::<u32>().prop_map(|epoch| Refusal::NoLease { epoch }),
        prop::sample::select(Cause::ALL).prop_map(|cause| Refusal::FaultLatched { cause }),
        (any::<u8>(), float32(), float32(), float32()).prop_map(|(index, value, lower, upper)| {
            Refusal::OutOfRange {
                index,
                value,
                lower,
                upper,
            }
        }),
        (any::<u8>(), float64(), float64()).prop_map(|(axis, value, limit)| Refusal::Limit {
            axis,
            quantity: Quantity::Velocity,
            value,
            limit
        }),
        any::<u16>().prop_map(|program| Refusal::UnknownProgram { program }),
        Just(Refusal::NoForce),
    ]
}

fn knot() -> impl Strategy<Value = KnotMessage> {
    (
        micros(),
        any::<bool>(),
        axes(float64()),
        axes(float32()),
        axes(float32()),
    )
        .prop_map(
            |(at, joints, position, velocity, acceleration)| KnotMessage {
                at,
                space: if joints { Space::Joints } else { Space::Motors },
                position,
                velocity,
                acceleration,
            },
        )
}

fn command() -> impl Strategy<Value = Command> {
    let coordination = prop_oneof![
        Just(Coordination::None),
        any::<(u16, i32)>()
            .prop_map(|(label, variant)| Coordination::Loose(Decision { label, variant })),
        knot().prop_map(Coordination::Tight),
    ];
    (any::<u32>(), any::<u16>(), micros(), coordination).prop_map(
        |(epoch, sequence, valid_until, coordination)| Command {
            epoch,
            sequence,
            valid_until,
            coordination,
        },
    )
}

fn feedback() -> impl Strategy<Value = Feedback> {
    let head = (
        any::<[u32; 6]>(),
        micros(),
        state(),
        prop::option::of(fault()),
        any::<u8>(),
    );
    let progress = prop_oneof![
        Just(Progress::Running),
        refusal().prop_map(Progress::Failed)
    ];
    let tail = (
        axes(any::<i64>()),
        axes(any::<i64>()),
        axes(any::<i16>()),
        axes(any::<u32>()),
    );
    (head, progress, tail).prop_map(|(head, progress, tail)| Feedback {
        step: head.0[0],
        sampled_at: head.1,
        state: head.2,
        fault: head.3,
        synchronised: head.4,
        epoch: head.0[1],
        instruction: head.0[2],
        progress,
        horizon_us: head.0[3],
        actual: tail.0,
        demand: tail.1,
        current_ma: tail.2,
        following_error: tail.3,
        limit_violations: head.0[4],
        acceleration_step: f32::from_bits(head.0[4] & 0x3FFF_FFFF),
        lost: head.0[5],
        force_n: None,
    })
}

fn request() -> impl Strategy<Value = Request> {
    let pose = || {
        any::<[u64; 6]>().prop_map(|bits| {
            let [x, y, z, a, b, c] = bits.map(f64::from_bits);
            PoseMessage {
                position_m: [x, y, z],
                rotation_rad: [a, b, c],
            }
        })
    };
    let joints = (
        axes(float64()),
        any::<bool>(),
        axes(float32()),
        axes(float32()),
    )
        .prop_map(
            |(target, relative, velocity, acceleration)| Instruction::MoveJoints {
                target,
                relative,
                speeds: AxisSpeeds {
                    velocity,
                    acceleration,
                },
            },
        );
    let instruction = prop_oneof![
        Just(Instruction::Follow),
        any::<u32>().prop_map(|duration_ms| Instruction::Hold { duration_ms }),
        joints,
        (any::<u16>(), float64())
            .prop_map(|(program, argument)| Instruction::Program { program, argument }),
    ];
    prop_oneof![
        any::<(u32, u16, bool)>().prop_map(|(nonce, lease_ms, takeover)| Request::Acquire {
            nonce,
            lease_ms,
            takeover
        }),
        (any::<u32>(), pose()).prop_map(|(epoch, t_flange_tool)| Request::SetTool {
            epoch,
            t_flange_tool
        }),
        (any::<(u32, u32)>(), micros(), instruction).prop_map(
            |((epoch, id), start_at, instruction)| Request::Execute {
                epoch,
                id,
                start_at,
                instruction
            }
        ),
    ]
}

/// Compared as bytes, since a NaN differs from itself.
fn survives<M: Payload>(message: &M) -> Result<(), TestCaseError> {
    let (mut first, mut second) = ([0; MAX_MESSAGE], [0; MAX_MESSAGE]);
    let sent = encode(message, &mut first).unwrap();
    prop_assert!(sent.len() <= M::MAX);
    let received = decode::<M>(sent).unwrap();
    prop_assert_eq!(encode(&received, &mut second).unwrap(), sent);
    Ok(())
}

proptest! {
    #[test]
    fn commands(message in command()) {
        survives(&message)?;
    }

    #[test]
    fn feedbacks(message in feedback()) {
        survives(&message)?;
    }

    #[test]
    fn requests(message in request()) {
        survives(&message)?;
    }

    #[test]
    fn the_rest(fault in fault(), why in refusal(), at in micros(), step: u32, demand in axes(any::<i64>())) {
        survives(&Event::Fault(fault))?;
        survives(&Reply::Refused(why))?;
        survives(&TimeSync { sequence: 3, previous_sent_at: at })?;
        survives(&DemandTrace { step, demand })?;
    }
}
