use super::*;
use crate::frame::Id;

fn node(id: u8) -> NodeId {
    NodeId::new(id).unwrap()
}

#[test]
fn golden_frames() {
    let start = command_frame(Command::Start, Target::All);
    assert_eq!(
        (start.id(), start.data()),
        (Id::Standard(0), &[0x01, 0x00][..])
    );
    let reset = command_frame(Command::ResetNode, Target::Node(node(5)));
    assert_eq!(reset.data(), [0x81, 0x05]);
    let boot = heartbeat_frame(node(5), State::Initialising);
    assert_eq!((boot.id(), boot.data()), (Id::Standard(0x705), &[0x00][..]));
    assert_eq!(heartbeat_frame(node(5), State::Operational).data(), [0x05]);
}

#[test]
fn commands_and_states_survive_the_wire() {
    for command in Command::ALL {
        for target in [Target::All, Target::Node(node(127))] {
            let frame = command_frame(command, target);
            assert_eq!(decode_command(&frame), Some((command, target)));
        }
    }
    for state in State::ALL {
        let frame = heartbeat_frame(node(9), state);
        assert_eq!(decode_heartbeat(&frame), Some((node(9), state)));
    }
}

#[test]
fn every_state_and_command() {
    use Command::{EnterPreOperational, ResetCommunication, ResetNode, Start, Stop};
    use State::{Initialising, Operational, PreOperational, Stopped};
    for state in State::ALL {
        for command in Command::ALL {
            let expected = match (state, command) {
                (_, ResetNode | ResetCommunication) | (Initialising, _) => Initialising,
                (_, Start) => Operational,
                (_, Stop) => Stopped,
                (_, EnterPreOperational) => PreOperational,
            };
            assert_eq!(state.on(command), expected, "{state:?} {command:?}");
        }
    }
}

#[test]
fn other_frames_are_not_network_management() {
    assert_eq!(decode_command(&frame(0x000, [0x01])), None);
    assert_eq!(decode_command(&frame(0x000, [0x33, 1])), None);
    assert_eq!(decode_command(&frame(0x000, [0x01, 200])), None);
    assert_eq!(decode_heartbeat(&frame(0x700, [5])), None);
    assert_eq!(decode_heartbeat(&frame(0x781, [5])), None);
    assert_eq!(decode_heartbeat(&frame(0x701, [5, 5])), None);
    assert_eq!(decode_heartbeat(&frame(0x701, [0x42])), None);
}

#[test]
fn a_producer_keeps_its_period_and_does_not_bunch() {
    let mut producer = HeartbeatProducer::new(Micros(0), Micros(100));
    assert!(!producer.due(Micros(99)));
    assert!(producer.due(Micros(100)));
    assert!(!producer.due(Micros(199)));
    assert!(producer.due(Micros(1000)));
    assert!(!producer.due(Micros(1099)));
    assert!(producer.due(Micros(1100)));
    assert!(!HeartbeatProducer::new(Micros(0), Micros(0)).due(Micros(5)));
}

#[test]
fn never_heard_is_told_once_and_a_late_device_appears() {
    let mut watch = HeartbeatConsumer::new(Micros(0), node(3), Micros(100));
    assert_eq!(watch.poll(Micros(100)), None);
    assert_eq!(watch.poll(Micros(101)), Some(Heard::NeverHeard));
    assert_eq!(watch.poll(Micros(500)), None);
    let beat = heartbeat_frame(node(3), State::PreOperational);
    let seen = watch.on_frame(Micros(600), &beat);
    assert_eq!(seen, Some(Heard::Appeared(State::PreOperational)));
}

#[test]
fn loss_change_and_boot_up_are_told_apart() {
    let mut watch = HeartbeatConsumer::new(Micros(0), node(3), Micros(100));
    let mut hear = |at, state| watch.on_frame(Micros(at), &heartbeat_frame(node(3), state));
    assert_eq!(hear(10, State::Initialising), Some(Heard::BootUp));
    assert_eq!(
        hear(20, State::Operational),
        Some(Heard::Changed(State::Operational))
    );
    assert_eq!(hear(30, State::Operational), Some(Heard::Same));
    assert_eq!(
        watch.on_frame(Micros(40), &heartbeat_frame(node(4), State::Stopped)),
        None
    );
    assert_eq!(watch.poll(Micros(130)), None);
    assert_eq!(watch.poll(Micros(131)), Some(Heard::Lost));
    assert_eq!((watch.state(), watch.is_missing()), (None, true));
}

#[test]
fn error_behaviours() {
    use State::{Initialising, Operational, PreOperational, Stopped};
    let row = |code| State::ALL.map(|state| ErrorBehaviour::from_code(code).unwrap().after(state));
    // in the order of State::ALL
    assert_eq!(
        State::ALL,
        [Initialising, Stopped, Operational, PreOperational]
    );
    assert_eq!(
        row(0),
        [Initialising, Stopped, PreOperational, PreOperational]
    );
    assert_eq!(row(1), State::ALL);
    assert_eq!(row(2), [Initialising, Stopped, Stopped, Stopped]);
    assert_eq!(ErrorBehaviour::from_code(3), None);
}
