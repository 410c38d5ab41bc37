//! One value of every variant of every message.

use protocol::fault::{Cause, Fault, PathProblem, Quantity, Refusal};
use protocol::message::{
    AxisSpeeds, Command, Coordination, Corner, Decision, DemandTrace, DriveFinding, DriveIdentity,
    Event, Feedback, HomingPhase, Identity, Instruction, KnotMessage, NodeState, OUTPUT_SPINDLE,
    PATH_BATCH, PathElement, PoseMessage, PosePath, PoseReference, PoseSpeeds, Progress, Reply,
    Request, ServoLaw, Space, StopAll, StopKind, TimeSync, WireCondition,
};
use protocol::time::Micros;

type Named<T> = Vec<(&'static str, T)>;

fn each<T: Clone>(values: &[T]) -> heapless::Vec<T, 8> {
    values.iter().cloned().collect()
}

pub(super) fn knot(axes: usize) -> KnotMessage {
    let k = |n: usize| f32::from(u8::try_from(n).unwrap());
    KnotMessage {
        at: Micros(12_345_678),
        space: Space::Joints,
        position: (0..axes).map(|n| f64::from(k(n)) * 0.25 - 0.5).collect(),
        velocity: (0..axes).map(|n| k(n) * 0.125).collect(),
        acceleration: (0..axes).map(|n| -k(n)).collect(),
    }
}

pub(super) fn commands() -> Named<Command> {
    let command = |coordination| Command {
        epoch: 0x0102_0304,
        sequence: 515,
        valid_until: Micros(1_000_000),
        coordination,
    };
    let decision = Decision {
        label: 7,
        variant: -3,
    };
    vec![
        ("none", command(Coordination::None)),
        ("loose", command(Coordination::Loose(decision))),
        ("tight-6", command(Coordination::Tight(knot(6)))),
        ("tight-8", command(Coordination::Tight(knot(8)))),
        (
            "tight-motors-cubic",
            command(Coordination::Tight(KnotMessage {
                space: Space::Motors,
                acceleration: each(&[]),
                ..knot(1)
            })),
        ),
    ]
}

pub(super) fn fault() -> Fault {
    Fault {
        cause: Cause::FollowingError,
        axis: Some(2),
        step: 70_000,
        during: NodeState::Moving,
    }
}

pub(super) fn identity() -> Identity {
    Identity {
        robot: "irp6-track".try_into().unwrap(),
        unique_id: 0x1122_3344_5566_7788,
        protocol: (1, 0),
        schema_hash: 0x0123_4567_89AB_CDEF,
        config_crc: 0xDEAD_BEEF,
        firmware: (0, 1, 0),
        axes: 7,
        servo_step_us: 2000,
        macrostep: 10,
    }
}

pub(super) fn feedbacks() -> Named<Feedback> {
    let at_rest = Feedback {
        step: 0,
        sampled_at: Micros(0),
        state: NodeState::Boot,
        fault: None,
        synchronised: 0,
        epoch: 0,
        instruction: 0,
        progress: Progress::Idle,
        horizon_us: 0,
        actual: each(&[]),
        demand: each(&[]),
        current_ma: each(&[]),
        following_error: each(&[]),
        limit_violations: 0,
        acceleration_step: 0.0,
        lost: 0,
        force_n: None,
    };
    let moving = Feedback {
        step: 123_456,
        sampled_at: Micros(246_912_000),
        state: NodeState::Moving,
        synchronised: 0x7F,
        epoch: 9,
        instruction: 12,
        progress: Progress::Running,
        horizon_us: 20_000,
        actual: each(&[1_000_000, -2_000_000, 3, 4, 5, 6, 2_000_000_000]),
        demand: each(&[1_000_100, -2_000_100, 3, 4, 5, 6, 2_000_000_000]),
        current_ma: each(&[100, -2_000, 30, 4, 5, 6, 7]),
        following_error: each(&[100, 100, 0, 0, 0, 0, 0]),
        ..at_rest.clone()
    };
    let faulted = Feedback {
        state: NodeState::Faulted,
        fault: Some(fault()),
        progress: Progress::Failed(Refusal::Aborted),
        lost: 3,
        force_n: Some([0.5, -2.0, 10.25]),
        ..moving.clone()
    };
    vec![
        ("boot", at_rest.clone()),
        (
            "pending",
            Feedback {
                progress: Progress::Pending,
                ..at_rest.clone()
            },
        ),
        (
            "done",
            Feedback {
                progress: Progress::Done,
                ..at_rest
            },
        ),
        ("moving", moving),
        ("faulted", faulted),
    ]
}

pub(super) fn traces() -> Named<DemandTrace> {
    vec![(
        "seven",
        DemandTrace {
            step: 5,
            demand: each(&[0, 1, -1, 63, -64, 64, i64::from(i32::MIN)]),
        },
    )]
}

pub(super) fn events() -> Named<Event> {
    let mut events = vec![
        ("announce", Event::Announce(identity())),
        ("fault", Event::Fault(fault())),
        ("drive-ready", Event::DriveReady { axis: 6 }),
    ];
    let identity = |serial| DriveIdentity {
        vendor: 0xFFFF_FFFF,
        product: 402,
        revision: 0x0001_0000,
        serial,
    };
    for (name, finding) in [
        ("drive-found-given", DriveFinding::Given),
        ("drive-found-not-stored", DriveFinding::NotStored),
        ("drive-found-missing", DriveFinding::Missing),
        ("drive-found-collision", DriveFinding::Collision),
        ("drive-found-refused", DriveFinding::Refused { error: 1 }),
        ("drive-found-elsewhere", DriveFinding::Elsewhere { node: 9 }),
        ("drive-found-unnamed", DriveFinding::Unnamed),
        ("drive-found-other", DriveFinding::Other),
        ("drive-found-setup", DriveFinding::SetupNotStored),
    ] {
        events.push((
            name,
            Event::DriveFound {
                bus: 1,
                axis: (finding != DriveFinding::Unnamed).then_some(2),
                finding,
                expected: Some(identity(17)),
                got: (finding == DriveFinding::Other).then_some(identity(18)),
            },
        ));
    }
    for (name, phase) in [
        ("homing-coarse", HomingPhase::Coarse),
        ("homing-settle", HomingPhase::Settle),
        ("homing-back-off", HomingPhase::BackOff),
        ("homing-index", HomingPhase::Index),
        ("homing-done", HomingPhase::Done),
    ] {
        events.push((name, Event::Homing { axis: 1, phase }));
    }
    events
}

pub(super) fn stops() -> Named<StopAll> {
    vec![
        (
            "path",
            StopAll {
                kind: StopKind::Path,
            },
        ),
        (
            "quick",
            StopAll {
                kind: StopKind::Quick,
            },
        ),
        (
            "torque-off",
            StopAll {
                kind: StopKind::TorqueOff,
            },
        ),
    ]
}

pub(super) fn syncs() -> Named<TimeSync> {
    vec![(
        "later",
        TimeSync {
            sequence: 200,
            previous_sent_at: Micros(0x0123_4567_89AB),
        },
    )]
}

fn speeds(axes: usize) -> AxisSpeeds {
    AxisSpeeds {
        velocity: std::iter::repeat_n(0.5, axes).collect(),
        acceleration: std::iter::repeat_n(0.25, axes).collect(),
    }
}

pub(super) fn pose() -> PoseMessage {
    PoseMessage {
        position_m: [0.5, -0.25, 1.0],
        rotation_rad: [0.0, 3.0, -0.125],
    }
}

pub(super) fn instructions() -> Named<Instruction> {
    let wait = |until| Instruction::Wait {
        until,
        timeout_ms: 300,
    };
    vec![
        ("hold", Instruction::Hold { duration_ms: 1500 }),
        (
            "move-motors",
            Instruction::MoveMotors {
                target: each(&[1.0, -2.0]),
                relative: true,
                speeds: speeds(2),
            },
        ),
        (
            "move-joints",
            Instruction::MoveJoints {
                target: each(&[0.0; 6]),
                relative: false,
                speeds: speeds(6),
            },
        ),
        (
            "move-pose",
            Instruction::MovePose {
                target: pose(),
                reference: PoseReference::Tool,
                path: PosePath::Line,
                speeds: PoseSpeeds {
                    velocity_m_s: 0.25,
                    angular_velocity_rad_s: 0.5,
                    acceleration_m_s2: 1.0,
                    angular_acceleration_rad_s2: 2.0,
                },
            },
        ),
        ("follow", Instruction::Follow),
        ("wait-decided", wait(WireCondition::Decided { label: 300 })),
        (
            "wait-joint",
            wait(WireCondition::Joint {
                axis: 3,
                value: -0.5,
                above: true,
            }),
        ),
        (
            "wait-settled",
            wait(WireCondition::Settled { window_rad: 0.0625 }),
        ),
        (
            "program",
            Instruction::Program {
                program: 2,
                argument: -1.5,
            },
        ),
        (
            "move-until-force",
            Instruction::MoveUntilForce {
                target: pose(),
                reference: PoseReference::Tool,
                speeds: SLOWLY,
                newtons: 10.0,
            },
        ),
        ("follow-path", Instruction::FollowPath { speeds: SLOWLY }),
    ]
}

const SLOWLY: PoseSpeeds = PoseSpeeds {
    velocity_m_s: 0.125,
    angular_velocity_rad_s: 1.5,
    acceleration_m_s2: 0.5,
    angular_acceleration_rad_s2: 4.0,
};

fn path_elements() -> Named<PathElement> {
    let corner = Corner {
        metres: 0.000_976_562_5,
        radians: 0.125,
    };
    vec![
        ("path-through", PathElement::Through(pose())),
        ("path-line", PathElement::Line { to: pose(), corner }),
        (
            "path-arc",
            PathElement::Arc {
                via_m: [0.25, 0.5, -0.75],
                to: pose(),
                corner,
            },
        ),
        ("path-end", PathElement::End),
        (
            "path-feed",
            PathElement::Feed {
                metres_per_second: 0.0625,
            },
        ),
    ]
}

/// What is asked while a path is followed, and around it.
fn path_requests(epoch: u32) -> Named<Request> {
    let path = |elements: &[PathElement]| Request::Path {
        epoch,
        first: 300,
        elements: elements.iter().copied().collect(),
    };
    let all = path_elements().into_iter().map(|(_, e)| e);
    let all: Vec<PathElement> = all.take(PATH_BATCH).collect();
    let mut requests = vec![(
        "feed-override",
        Request::FeedOverride {
            epoch,
            share: -0.25,
        },
    )];
    requests.extend(
        path_elements()
            .into_iter()
            .map(|(name, e)| (name, path(&[e]))),
    );
    requests.push((
        "outputs",
        Request::Outputs {
            epoch,
            mask: 0x0103,
            on: OUTPUT_SPINDLE,
        },
    ));
    requests.push(("path-full", path(&all)));
    requests
}

pub(super) fn requests() -> Named<Request> {
    let epoch = 77;
    let mut requests = vec![
        ("identify", Request::Identify),
        (
            "acquire",
            Request::Acquire {
                nonce: 0xCAFE,
                lease_ms: 100,
                takeover: false,
            },
        ),
        ("release", Request::Release { epoch }),
        ("enable", Request::Enable { epoch }),
        ("disable", Request::Disable { epoch }),
        ("synchronise", Request::Synchronise { epoch }),
        ("end-motion", Request::EndMotion { epoch }),
        (
            "stop",
            Request::Stop {
                kind: StopKind::Quick,
            },
        ),
        ("acknowledge", Request::Acknowledge { epoch }),
        (
            "servo-drive",
            Request::SelectServo {
                epoch,
                law: ServoLaw::DrivePosition,
            },
        ),
        (
            "servo-original",
            Request::SelectServo {
                epoch,
                law: ServoLaw::Original,
            },
        ),
        (
            "servo-feed-forward",
            Request::SelectServo {
                epoch,
                law: ServoLaw::FeedForward,
            },
        ),
        (
            "servo-computed-torque",
            Request::SelectServo {
                epoch,
                law: ServoLaw::ComputedTorque,
            },
        ),
        (
            "set-tool",
            Request::SetTool {
                epoch,
                t_flange_tool: pose(),
            },
        ),
        ("trace", Request::Trace { epoch, every: 10 }),
    ];
    requests.extend(path_requests(epoch));
    for (name, instruction) in instructions() {
        let start_at = Micros(1_000_000);
        requests.push((
            name,
            Request::Execute {
                epoch,
                id: 4,
                start_at,
                instruction,
            },
        ));
    }
    requests
}

pub(super) fn refusals() -> Named<Refusal> {
    vec![
        ("lease-held", Refusal::LeaseHeld { holder: 1 }),
        ("no-lease", Refusal::NoLease { epoch: 128 }),
        (
            "wrong-state",
            Refusal::WrongState {
                state: NodeState::Disabled,
            },
        ),
        ("not-synchronised", Refusal::NotSynchronised),
        (
            "fault-latched",
            Refusal::FaultLatched {
                cause: Cause::DriveFault,
            },
        ),
        (
            "cause-present",
            Refusal::CausePresent {
                cause: Cause::DriveSilent,
            },
        ),
        (
            "axis-count",
            Refusal::AxisCount {
                expected: 7,
                got: 6,
            },
        ),
        ("not-finite", Refusal::NotFinite { index: 2 }),
        (
            "out-of-range",
            Refusal::OutOfRange {
                index: 1,
                value: 2.0,
                lower: 0.0,
                upper: 1.0,
            },
        ),
        (
            "limit",
            Refusal::Limit {
                axis: 4,
                quantity: Quantity::Jerk,
                value: 2.0,
                limit: 1.0,
            },
        ),
        ("unreachable", Refusal::Unreachable),
        ("singular", Refusal::Singular),
        ("stale", Refusal::Stale { last: 3 }),
        ("late", Refusal::Late),
        ("queue-full", Refusal::QueueFull),
        ("not-monotone", Refusal::NotMonotone),
        ("discontinuous", Refusal::Discontinuous { axis: 5 }),
        ("unknown-program", Refusal::UnknownProgram { program: 999 }),
        ("unknown-servo-law", Refusal::UnknownServoLaw),
        ("aborted", Refusal::Aborted),
        (
            "path",
            Refusal::Path {
                element: 70_000,
                problem: PathProblem::NotAnArc,
            },
        ),
        ("no-force", Refusal::NoForce),
    ]
}

pub(super) fn replies() -> Named<Reply> {
    let mut replies = vec![
        ("accepted", Reply::Accepted),
        ("lease", Reply::Lease { epoch: 77 }),
        ("identity", Reply::Identity(identity())),
        (
            "path",
            Reply::Path {
                next: 70_001,
                room: 12,
            },
        ),
    ];
    replies.extend(
        refusals()
            .into_iter()
            .map(|(name, why)| (name, Reply::Refused(why))),
    );
    replies
}
