//! The maintenance service: bytes of every message, greatest sizes, two endpoints, bad input.

use super::bytes::bytes;
use super::golden::{check, frame_bytes};
use super::samples;
use proptest::collection::vec;
use proptest::prelude::*;
use protocol::codec::{MAX_MESSAGE, Payload, decode, decode_padded, encode};
use protocol::fault::{Cause, Fault};
use protocol::id::NodeId;
use protocol::link::{Endpoint, Message, Role};
use protocol::maintenance::{
    AxisSample, FaultRecord, IMAGE_CHUNK, ImageHeader, ImagePhase, ImageStatus, MaintenanceRefusal,
    MaintenanceReply, MaintenanceRequest, NodeIdentity, ResetCause, ResetReport, RunningImage,
    SAMPLE_BATCH, Sample, Slot, Standing,
};
use protocol::message::NodeState;
use protocol::time::Micros;
use protocol::transfer::Mtu;
use std::collections::BTreeSet;
use std::fmt::Debug;

fn header() -> ImageHeader {
    ImageHeader {
        robot: "irp6-track".try_into().unwrap(),
        target: "stm32g474".try_into().unwrap(),
        version: (0, 2, 1),
        schema_hash: 0x0123_4567_89AB_CDEF,
        length: 200_000,
        crc: 0xDEAD_BEEF,
    }
}

fn requests() -> Vec<(&'static str, MaintenanceRequest)> {
    let (epoch, image) = (77, 0xDEAD_BEEF);
    vec![
        ("identify", MaintenanceRequest::Identify),
        ("reset-cause", MaintenanceRequest::ResetCause),
        ("first-fault", MaintenanceRequest::FirstFault),
        (
            "samples",
            MaintenanceRequest::Samples {
                record: 0xCAFE,
                first: 144,
            },
        ),
        (
            "clear-fault",
            MaintenanceRequest::ClearFault {
                epoch,
                record: 0xCAFE,
            },
        ),
        ("image", MaintenanceRequest::Image),
        (
            "begin-image",
            MaintenanceRequest::BeginImage {
                epoch,
                header: header(),
            },
        ),
        (
            "write-image",
            MaintenanceRequest::WriteImage {
                epoch,
                image,
                offset: 512,
                bytes: [1, 2, 3, 255].into_iter().collect(),
            },
        ),
        (
            "verify-image",
            MaintenanceRequest::VerifyImage { epoch, image },
        ),
        (
            "activate-image",
            MaintenanceRequest::ActivateImage { epoch, image },
        ),
        ("confirm-image", MaintenanceRequest::ConfirmImage { epoch }),
        ("abort-image", MaintenanceRequest::AbortImage { epoch }),
        ("restart", MaintenanceRequest::Restart { epoch }),
    ]
}

fn identity(image: Option<RunningImage>) -> NodeIdentity {
    NodeIdentity {
        robot: "irp6-track".try_into().unwrap(),
        target: "stm32g474".try_into().unwrap(),
        unique_id: 0x1122_3344_5566_7788,
        protocol: (1, 1),
        schema_hash: 0x0123_4567_89AB_CDEF,
        config_crc: 0xDEAD_BEEF,
        firmware: (0, 1, 0),
        image,
    }
}

fn sample(axes: usize) -> Sample {
    let axis = AxisSample {
        actual: -1_000_000,
        error: -3,
        current_ma: 1500,
    };
    Sample {
        step: 70_000,
        state: NodeState::Moving,
        fault: 30,
        axes: std::iter::repeat_n(axis, axes).collect(),
    }
}

fn refusals() -> Vec<(&'static str, MaintenanceRefusal)> {
    use MaintenanceRefusal as R;
    vec![
        ("no-lease", R::NoLease { epoch: 128 }),
        (
            "torque-on",
            R::TorqueOn {
                state: NodeState::Holding,
            },
        ),
        ("no-slots", R::NoSlots),
        ("wrong-robot", R::WrongRobot),
        ("wrong-target", R::WrongTarget),
        ("wrong-length", R::WrongLength { capacity: 243_712 }),
        ("no-transfer", R::NoTransfer),
        ("other-image", R::OtherImage { image: 1 }),
        ("wrong-part", R::WrongPart { next: 256 }),
        ("differs", R::Differs { offset: 512 }),
        ("incomplete", R::Incomplete { next: 768 }),
        ("wrong-crc", R::WrongCrc { got: 2 }),
        ("not-verified", R::NotVerified),
        ("not-on-trial", R::NotOnTrial),
        ("no-record", R::NoRecord),
        ("storage", R::Storage),
        ("unconfirmed", R::Unconfirmed),
    ]
}

fn replies() -> Vec<(&'static str, MaintenanceReply)> {
    let running = |slot, standing| RunningImage {
        slot,
        version: (0, 2, 1),
        crc: 0xDEAD_BEEF,
        standing,
    };
    let mut replies = vec![
        ("done", MaintenanceReply::Done),
        ("identity", MaintenanceReply::Identity(identity(None))),
        ("no-fault", MaintenanceReply::NoFault),
        (
            "first-fault",
            MaintenanceReply::FirstFault(FaultRecord {
                record: 0xCAFE,
                fault: samples::fault(),
                instruction: 12,
                boot: 3,
                later: 1,
                samples: 145,
                servo_step_us: 2000,
            }),
        ),
        (
            "samples",
            MaintenanceReply::Samples {
                record: 0xCAFE,
                first: 144,
                samples: std::iter::once(sample(6)).collect(),
            },
        ),
    ];
    for (name, slot, standing) in [
        ("identity-a", Slot::A, Standing::Confirmed),
        ("identity-b", Slot::B, Standing::Trial),
        ("identity-back", Slot::A, Standing::RolledBack),
    ] {
        let image = Some(running(slot, standing));
        replies.push((name, MaintenanceReply::Identity(identity(image))));
    }
    for (name, cause) in [
        ("reset-unknown", ResetCause::Unknown),
        ("reset-power-on", ResetCause::PowerOn),
        ("reset-pin", ResetCause::Pin),
        ("reset-brown-out", ResetCause::BrownOut),
        ("reset-software", ResetCause::Software),
        ("reset-watchdog", ResetCause::Watchdog),
        ("reset-option", ResetCause::Option),
        ("reset-vanished", ResetCause::Vanished),
    ] {
        let report = ResetReport {
            cause,
            boots: 4,
            steps: 50_000,
            servo_step_us: 2000,
        };
        replies.push((name, MaintenanceReply::Reset(report)));
    }
    for (name, phase) in [
        ("image-none", ImagePhase::None),
        ("image-receiving", ImagePhase::Receiving),
        ("image-verified", ImagePhase::Verified),
        ("image-activated", ImagePhase::Activated),
    ] {
        let status = ImageStatus {
            slot: Slot::B,
            phase,
            image: 0xDEAD_BEEF,
            next: 512,
            capacity: 243_712,
        };
        replies.push((name, MaintenanceReply::Image(status)));
    }
    let refused = |(name, why)| (name, MaintenanceReply::Refused(why));
    replies.extend(refusals().into_iter().map(refused));
    replies
}

fn lines<M: Payload + PartialEq + Debug>(all: Vec<(&str, M)>) -> Vec<(String, Vec<u8>)> {
    let line = |(name, message): (&str, M)| (format!("{}/{name}", M::NAME), bytes(&message));
    all.into_iter().map(line).collect()
}

/// The first bytes that any message can have.
fn tags<M: Payload>(prefix: &[u8]) -> BTreeSet<u8> {
    use protocol::codec::DecodeError;
    let valid = |tag: &u8| {
        let input = [prefix, &[*tag], &[0; 300]].concat();
        !matches!(decode::<M>(&input), Err(DecodeError::Invalid))
    };
    (0..128).filter(valid).collect()
}

#[test]
fn every_maintenance_message_has_its_golden_bytes() {
    let mut all = lines(requests());
    all.extend(lines(replies()));
    check("maintenance.hex", &all);
}

#[test]
fn the_samples_have_every_variant_of_maintenance() {
    let first = |all: Vec<(String, Vec<u8>)>| all.iter().map(|l| l.1[0]).collect::<BTreeSet<_>>();
    assert_eq!(first(lines(requests())), tags::<MaintenanceRequest>(&[]));
    // FirstFault, tag 4, is not among them: zeros are no fault, since no cause has the code 0
    let mut decodable = tags::<MaintenanceReply>(&[]);
    assert!(decodable.insert(4));
    assert_eq!(first(lines(replies())), decodable);
    let refused: BTreeSet<u8> = refusals()
        .into_iter()
        .map(|(_, why)| bytes(&MaintenanceReply::Refused(why))[1])
        .collect();
    assert_eq!(refused, tags::<MaintenanceReply>(&[7]));
    let resets: BTreeSet<u8> = replies()
        .into_iter()
        .filter(|(_, reply)| matches!(reply, MaintenanceReply::Reset(_)))
        .map(|(_, reply)| bytes(&reply)[1])
        .collect();
    assert_eq!(resets, tags::<MaintenanceReply>(&[2]));
}

#[test]
fn the_greatest_sizes_of_maintenance_are_reached() {
    let write = MaintenanceRequest::WriteImage {
        epoch: u32::MAX,
        image: u32::MAX,
        offset: u32::MAX,
        bytes: std::iter::repeat_n(7, IMAGE_CHUNK).collect(),
    };
    assert_eq!(bytes(&write).len(), MaintenanceRequest::MAX);
    let axis = AxisSample {
        actual: i32::MIN,
        error: i16::MIN,
        current_ma: i16::MIN,
    };
    let sample = Sample {
        step: u32::MAX,
        state: NodeState::Faulted,
        fault: u16::MAX,
        axes: std::iter::repeat_n(axis, 8).collect(),
    };
    let reply = MaintenanceReply::Samples {
        record: u32::MAX,
        first: u16::MAX,
        samples: std::iter::repeat_n(sample, SAMPLE_BATCH).collect(),
    };
    assert_eq!(bytes(&reply).len(), MaintenanceReply::MAX);
}

#[test]
fn every_maintenance_message_arrives_at_its_place_and_nowhere_else() {
    let (one, two) = (NodeId::effector(1).unwrap(), NodeId::effector(2).unwrap());
    let client = NodeId::new(3).unwrap();
    let mut frames_of_all = Vec::new();
    for mtu in [Mtu::Classic, Mtu::Fd] {
        let mut host = Endpoint::<8>::new(client, Role::Coordinator, mtu);
        let mut other = Endpoint::<8>::new(NodeId::MP, Role::Coordinator, mtu);
        let mut node = Endpoint::<8>::new(one, Role::Node, mtu);
        let mut foreign = Endpoint::<8>::new(two, Role::Node, mtu);
        for (name, request) in requests() {
            let mut frames = Vec::new();
            let id = host
                .send_maintenance(one, &request, &mut |f| frames.push(f))
                .unwrap();
            let heard: Vec<_> = frames
                .iter()
                .filter_map(|f| node.receive(f, Micros(5)))
                .collect();
            let expected = Message::Maintenance {
                transfer_id: id,
                request,
            };
            assert_eq!(heard.len(), 1, "{name}");
            assert_eq!((heard[0].from, &heard[0].message), (client, &expected));
            for frame in &frames {
                assert_eq!(foreign.receive(frame, Micros(5)), None);
                assert_eq!(other.receive(frame, Micros(5)), None);
            }
            // a damaged one is no message: not even the last bit of a part of an image may be another
            if mtu == Mtu::Classic && name == "write-image" {
                frames_of_all = frames.iter().map(frame_bytes).collect();
            }
        }
        for (number, (name, reply)) in (0_u8..).zip(replies()) {
            let mut frames = Vec::new();
            let id = protocol::transfer::TransferId::new(number);
            node.send_maintenance_reply(client, id, &reply, &mut |f| frames.push(f))
                .unwrap();
            let heard: Vec<_> = frames
                .iter()
                .filter_map(|f| host.receive(f, Micros(6)))
                .collect();
            let expected = Message::MaintenanceReply {
                transfer_id: id,
                reply,
            };
            assert_eq!(heard.len(), 1, "{name}");
            assert_eq!((heard[0].from, &heard[0].message), (one, &expected));
            for frame in &frames {
                assert_eq!(other.receive(frame, Micros(6)), None);
            }
        }
    }
    let named = (0..).zip(frames_of_all);
    let named: Vec<_> = named
        .map(|(k, frame): (u32, _)| (format!("classic/write-image/{k}"), frame))
        .collect();
    check("maintenance-frames.hex", &named);
}

#[test]
fn every_refusal_is_one_line() {
    for (name, why) in refusals() {
        let text = why.to_string();
        assert!(text.len() > 15 && !text.contains('\n'), "{name}: {text}");
    }
}

proptest! {
    #[test]
    fn any_part_of_an_image_survives(
        epoch: u32, image: u32, offset: u32, part in vec(any::<u8>(), 0..=IMAGE_CHUNK),
    ) {
        let request = MaintenanceRequest::WriteImage {
            epoch, image, offset, bytes: part.into_iter().collect(),
        };
        let mut buffer = [0; MAX_MESSAGE];
        let sent = encode(&request, &mut buffer).unwrap();
        prop_assert!(sent.len() <= MaintenanceRequest::MAX);
        prop_assert_eq!(decode::<MaintenanceRequest>(sent), Ok(request));
    }

    #[test]
    fn any_sample_survives(
        step: u32, fault: u16, axes in vec(any::<(i32, i16, i16)>(), 0..=8),
    ) {
        let axes = axes.into_iter().map(|(actual, error, current_ma)| AxisSample { actual, error, current_ma });
        let sample = Sample { step, state: NodeState::Stopping, fault, axes: axes.collect() };
        let reply = MaintenanceReply::Samples {
            record: step, first: fault, samples: std::iter::repeat_n(sample, SAMPLE_BATCH).collect(),
        };
        let mut buffer = [0; MAX_MESSAGE];
        let sent = encode(&reply, &mut buffer).unwrap();
        prop_assert!(sent.len() <= MaintenanceReply::MAX);
        prop_assert_eq!(decode::<MaintenanceReply>(sent), Ok(reply));
    }

    #[test]
    fn any_bytes_are_a_maintenance_message_or_fail(input in vec(any::<u8>(), 0..=512)) {
        let _ = decode_padded::<MaintenanceRequest>(&input);
        let _ = decode_padded::<MaintenanceReply>(&input);
    }

    #[test]
    fn a_record_of_any_cause_survives(
        cause in prop::sample::select(Cause::ALL), axis: Option<u8>, numbers: [u32; 4], few: [u16; 2],
    ) {
        let record = FaultRecord {
            record: numbers[0],
            fault: Fault { cause, axis, step: numbers[1], during: NodeState::Synchronising },
            instruction: numbers[2],
            boot: numbers[3],
            later: few[0],
            samples: few[1],
            servo_step_us: numbers[0],
        };
        let reply = MaintenanceReply::FirstFault(record);
        let mut buffer = [0; MAX_MESSAGE];
        let sent = encode(&reply, &mut buffer).unwrap();
        prop_assert!(sent.len() <= MaintenanceReply::MAX);
        prop_assert_eq!(decode::<MaintenanceReply>(sent), Ok(reply));
    }
}
