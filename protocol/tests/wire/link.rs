//! Two and more endpoints talking over frames.

use super::golden::{check, frame_bytes};
use super::samples;
use proptest::prelude::*;
use protocol::codec::EncodeError;
use protocol::cyphal::{Heartbeat, NodeInfo};
use protocol::e2e::RESYNC;
use protocol::frame::{Frame, Id};
use protocol::id::NodeId;
use protocol::link::{Endpoint, Incoming, Message, Role};
use protocol::message::{Command, NodeState};
use protocol::time::Micros;
use protocol::transfer::{Mtu, TransferId};

const MTUS: [Mtu; 2] = [Mtu::Classic, Mtu::Fd];

fn robot(j: u8) -> NodeId {
    NodeId::effector(j).unwrap()
}

fn mp(mtu: Mtu) -> Endpoint<16> {
    Endpoint::new(NodeId::MP, Role::Coordinator, mtu)
}

fn node(j: u8, mtu: Mtu) -> Endpoint<8> {
    let mut node = Endpoint::new(robot(j), Role::Node, mtu);
    node.set_lease(samples::commands()[0].1.epoch);
    node
}

fn sent<T>(send: impl FnOnce(&mut dyn FnMut(Frame)) -> Result<T, EncodeError>) -> Vec<Frame> {
    let mut frames = Vec::new();
    send(&mut |frame| frames.push(frame)).unwrap();
    frames
}

fn heard<const N: usize>(
    endpoint: &mut Endpoint<N>,
    frames: &[Frame],
    at: u64,
) -> Option<Incoming> {
    let mut all = frames
        .iter()
        .filter_map(|frame| endpoint.receive(frame, Micros(at)));
    let first = all.next();
    assert_eq!(all.next(), None, "one message in {frames:?}");
    first
}

#[test]
fn every_message_arrives_at_its_place_and_nowhere_else() {
    for mtu in MTUS {
        let (mut mp, mut a, mut b) = (mp(mtu), node(1, mtu), node(2, mtu));
        for (_, command) in samples::commands() {
            let frames = sent(|mut out| mp.send_command(robot(1), &command, &mut out));
            let incoming = heard(&mut a, &frames, 7).unwrap();
            assert_eq!(incoming.from, NodeId::MP);
            assert_eq!(incoming.received_at, Micros(7));
            assert_eq!(incoming.message, Message::Command(command));
            assert_eq!(heard(&mut b, &frames, 7), None);
        }
        for (_, feedback) in samples::feedbacks() {
            let frames = sent(|mut out| a.send_feedback(&feedback, &mut out));
            assert_eq!(heard(&mut b, &frames, 7), None);
            let incoming = heard(&mut mp, &frames, 7).unwrap();
            assert_eq!((incoming.from, incoming.lost), (robot(1), 0));
            assert_eq!(incoming.message, Message::Feedback(feedback));
        }
        for (_, event) in samples::events() {
            let frames = sent(|mut out| b.send_event(&event, &mut out));
            assert_eq!(
                heard(&mut mp, &frames, 7).unwrap().message,
                Message::Event(event)
            );
        }
        let (_, trace) = samples::traces().remove(0);
        let frames = sent(|mut out| b.send_demand_trace(&trace, &mut out));
        assert_eq!(
            heard(&mut mp, &frames, 7).unwrap().message,
            Message::DemandTrace(trace)
        );
        for (_, stop) in samples::stops() {
            let frames = sent(|mut out| mp.send_stop_all(&stop, &mut out));
            for node in [&mut a, &mut b] {
                let incoming = heard(node, &frames, 7).unwrap();
                assert_eq!(incoming.message, Message::StopAll(stop));
            }
        }
        let (_, sync) = samples::syncs().remove(0);
        let frames = sent(|mut out| mp.send_time_sync(&sync, &mut out));
        assert_eq!(
            heard(&mut a, &frames, 7).unwrap().message,
            Message::TimeSync(sync)
        );
        assert_eq!(mp.statistics().transfer.malformed, 0);
        assert_eq!(a.statistics().e2e.wrong_crc, 0);
    }
}

#[test]
fn every_request_is_answered_under_its_transfer_id() {
    for mtu in MTUS {
        let (mut mp, mut a, mut b) = (mp(mtu), node(1, mtu), node(2, mtu));
        let replies = samples::replies();
        for (k, (_, request)) in samples::requests().into_iter().enumerate() {
            let mut frames = Vec::new();
            let id = mp
                .send_request(robot(1), &request, &mut |f| frames.push(f))
                .unwrap();
            assert_eq!(heard(&mut b, &frames, 7), None);
            let incoming = heard(&mut a, &frames, 7).unwrap();
            assert_eq!(
                incoming.message,
                Message::Request {
                    transfer_id: id,
                    request
                }
            );
            let reply = replies[k % replies.len()].1.clone();
            let frames = sent(|mut out| a.send_reply(incoming.from, id, &reply, &mut out));
            let answer = heard(&mut mp, &frames, 8).unwrap();
            assert_eq!(answer.from, robot(1));
            assert_eq!(
                answer.message,
                Message::Reply {
                    transfer_id: id,
                    reply
                }
            );
        }
    }
}

#[test]
fn an_observer_hears_everything_of_any_lease() {
    let (mut mp, mut watch) = (
        mp(Mtu::Fd),
        Endpoint::<16>::new(NodeId::new(120).unwrap(), Role::Observer, Mtu::Fd),
    );
    for epoch in [3, 4] {
        let command = Command {
            epoch,
            ..samples::commands()[1].1.clone()
        };
        let frames = sent(|mut out| mp.send_command(robot(3), &command, &mut out));
        assert_eq!(
            heard(&mut watch, &frames, 1).unwrap().message,
            Message::Command(command)
        );
    }
    let request = samples::requests()[0].1.clone();
    let frames = sent(|mut out| mp.send_request(robot(1), &request, &mut out));
    assert!(heard(&mut watch, &frames, 1).is_some());
}

#[test]
fn a_command_of_another_lease_is_stale_and_a_damaged_one_is_not() {
    let (mut mp, mut a) = (mp(Mtu::Fd), node(1, Mtu::Fd));
    let command = samples::commands()[1].1.clone();
    let old = Command {
        epoch: command.epoch - 1,
        ..command.clone()
    };
    let frames = sent(|mut out| mp.send_command(robot(1), &old, &mut out));
    assert_eq!(heard(&mut a, &frames, 1), None);
    assert_eq!(
        (a.statistics().e2e.stale, a.statistics().e2e.wrong_crc),
        (1, 0)
    );

    let frames = sent(|mut out| mp.send_command(robot(1), &command, &mut out));
    let mut data = frames[0].data().to_vec();
    data[6] ^= 4;
    assert_eq!(
        a.receive(&Frame::fd(frames[0].id(), &data).unwrap(), Micros(1)),
        None
    );
    assert_eq!(
        (a.statistics().e2e.stale, a.statistics().e2e.wrong_crc),
        (1, 1)
    );
    // Without a lease nothing is heard.
    a.set_lease(0);
    let frames = sent(|mut out| mp.send_command(robot(1), &command, &mut out));
    assert_eq!(heard(&mut a, &frames, 1), None);
}

#[test]
fn lost_and_old_commands_are_told() {
    let (mut mp, mut a) = (mp(Mtu::Fd), node(1, Mtu::Fd));
    let command = samples::commands()[0].1.clone();
    let mut next = || sent(|mut out| mp.send_command(robot(1), &command, &mut out));
    let first = next();
    assert_eq!(heard(&mut a, &first, 0).unwrap().lost, 0);
    let (second, _third, fourth) = (next(), next(), next());
    assert_eq!(heard(&mut a, &fourth, 1).unwrap().lost, 2);
    // From a queue that was held up: the transfer-id is new, but the counter is old.
    assert_eq!(heard(&mut a, &second, 2), None);
    assert_eq!(a.statistics().e2e.stale, 1);
    assert_eq!(a.statistics().e2e.lost, 2);
}

#[test]
fn a_rebooted_sender_is_heard_again_after_the_silence() {
    let mut a = node(1, Mtu::Fd);
    let command = samples::commands()[0].1.clone();
    let mut before = mp(Mtu::Fd);
    for k in 0..40 {
        let frames = sent(|mut out| before.send_command(robot(1), &command, &mut out));
        assert!(heard(&mut a, &frames, k).is_some());
    }
    let mut after = mp(Mtu::Fd);
    let frames = sent(|mut out| after.send_command(robot(1), &command, &mut out));
    assert_eq!(heard(&mut a, &frames, 41), None);
    let frames = sent(|mut out| after.send_command(robot(1), &command, &mut out));
    assert!(heard(&mut a, &frames, 41 + RESYNC.0).is_some());
}

#[test]
fn a_second_node_with_our_id_is_noticed() {
    let (mut a, mut twin) = (node(1, Mtu::Fd), node(1, Mtu::Fd));
    let frames = sent(|mut out| twin.send_feedback(&samples::feedbacks()[0].1, &mut out));
    assert_eq!(heard(&mut a, &frames, 0), None);
    assert_eq!(a.statistics().own_id, 1);
}

#[test]
fn heartbeats_once_a_second() {
    let (mut mp, mut a) = (mp(Mtu::Classic), node(1, Mtu::Classic));
    let mut times = Vec::new();
    for ms in (0..3500).step_by(2) {
        let mut frames = Vec::new();
        let now = Micros::from_millis(ms);
        let of = |uptime| Heartbeat::of_node(uptime, NodeState::Holding);
        a.poll_heartbeat(now, of, &mut |frame| frames.push(frame));
        if let Some(incoming) = heard(&mut mp, &frames, now.0) {
            assert_eq!(incoming.from, robot(1));
            let Message::Heartbeat(heartbeat) = incoming.message else {
                panic!()
            };
            assert_eq!(u64::from(heartbeat.uptime_s), ms / 1000);
            assert_eq!(heartbeat.status, NodeState::Holding as u8);
            times.push(ms);
        }
    }
    assert_eq!(times, [0, 1000, 2000, 3000]);
}

#[test]
fn node_information_is_answered() {
    let mut a = node(1, Mtu::Classic);
    // A GetInfo request 1 -> 11 as any Cyphal tool sends it.
    let request = Frame::classic(Id::Extended(0x136B_8581), &[0xE5]).unwrap();
    let incoming = heard(&mut a, &[request], 0).unwrap();
    let Message::GetInfo { transfer_id } = incoming.message else {
        panic!()
    };
    assert_eq!(transfer_id, TransferId::new(5));
    let identity = samples::identity();
    let info = NodeInfo::of(&identity);
    let mut frames = Vec::new();
    a.send_node_info(incoming.from, transfer_id, &info, &mut |frame| {
        frames.push(frame);
    });
    let lines: Vec<_> = frames
        .iter()
        .map(|f| ("GetInfo".into(), frame_bytes(f)))
        .collect();
    check("node-info.hex", &lines);
}

#[test]
fn frames_have_their_golden_bytes() {
    let mut lines = Vec::new();
    for (mtu, name) in [(Mtu::Classic, "classic"), (Mtu::Fd, "fd")] {
        let (mut mp, mut a) = (mp(mtu), node(1, mtu));
        let mut add = |what: &str, frames: Vec<Frame>| {
            for frame in frames {
                lines.push((format!("{name}/{what}"), frame_bytes(&frame)));
            }
        };
        let command = &samples::commands()[2].1;
        add(
            "Command",
            sent(|mut out| mp.send_command(robot(1), command, &mut out)),
        );
        let feedback = &samples::feedbacks()[3].1;
        add(
            "Feedback",
            sent(|mut out| a.send_feedback(feedback, &mut out)),
        );
        let trace = &samples::traces()[0].1;
        add(
            "DemandTrace",
            sent(|mut out| a.send_demand_trace(trace, &mut out)),
        );
        let event = &samples::events()[0].1;
        add("Event", sent(|mut out| a.send_event(event, &mut out)));
        let stop = &samples::stops()[1].1;
        add("StopAll", sent(|mut out| mp.send_stop_all(stop, &mut out)));
        let sync = &samples::syncs()[0].1;
        add(
            "TimeSync",
            sent(|mut out| mp.send_time_sync(sync, &mut out)),
        );
        let request = &samples::requests()[1].1;
        add(
            "Request",
            sent(|mut out| mp.send_request(robot(1), request, &mut out)),
        );
        let reply = &samples::replies()[1].1;
        let id = TransferId::new(0);
        add(
            "Reply",
            sent(|mut out| a.send_reply(NodeId::MP, id, reply, &mut out)),
        );
        let mut heartbeat = Vec::new();
        a.poll_heartbeat(
            Micros(0),
            |uptime| Heartbeat::of_node(uptime, NodeState::Boot),
            &mut |frame| heartbeat.push(frame),
        );
        add("Heartbeat", heartbeat);
    }
    check("frames.hex", &lines);
}

#[test]
fn one_bit_wrong_anywhere_in_a_command_is_no_command() {
    for mtu in MTUS {
        let mut mp = mp(mtu);
        let command = samples::commands()[2].1.clone();
        let frames = sent(|mut out| mp.send_command(robot(1), &command, &mut out));
        for (k, frame) in frames.iter().enumerate() {
            for bit in 0..frame.data().len() * 8 {
                let mut data = frame.data().to_vec();
                data[bit / 8] ^= 1 << (bit % 8);
                let mut damaged = frames.clone();
                damaged[k] = match mtu {
                    Mtu::Classic => Frame::classic(frame.id(), &data).unwrap(),
                    Mtu::Fd => Frame::fd(frame.id(), &data).unwrap(),
                };
                let mut a = node(1, mtu);
                let all: Vec<_> = damaged
                    .iter()
                    .filter_map(|f| a.receive(f, Micros(0)))
                    .collect();
                // A wrong transfer-id alone leaves a single-frame message whole, and is harmless.
                for incoming in all {
                    assert_eq!(frames.len(), 1);
                    assert_eq!(incoming.message, Message::Command(command.clone()));
                }
            }
        }
    }
}

proptest! {
    #[test]
    fn no_sequence_of_frames_upsets_an_endpoint(
        input in proptest::collection::vec(
            (0u32..=0x1FFF_FFFF, 0u8..12, proptest::collection::vec(any::<u8>(), 0..=64), 0u64..50_000),
            0..60,
        ),
        role in prop::sample::select(&[Role::Node, Role::Coordinator, Role::Observer][..]),
    ) {
        let mut endpoint = Endpoint::<3>::new(robot(1), role, Mtu::Fd);
        // Ports of ours, so that the input gets past the filter.
        let ports: [u32; 11] = [
            0x0070_0B01, 0x0070_CC0C, 0x0070_CD0C, 0x0070_CE0C, 0x0070_CF0C, 0x0070_D001,
            0x007D_5502, 0x0319_0581, 0x0219_0581, 0x036B_8581, 0x026B_8581,
        ];
        let mut now = 0;
        for (any_id, port, mut data, after) in input {
            now += after;
            let bits = ports.get(usize::from(port)).copied().unwrap_or(any_id);
            let len = protocol::frame::fd_length(data.len()).unwrap();
            data.resize(len, 0);
            let frame = Frame::fd(Id::Extended(bits), &data).unwrap();
            let _ = endpoint.receive(&frame, Micros(now));
        }
    }
}
