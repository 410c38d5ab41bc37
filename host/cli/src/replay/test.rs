use super::*;
use crate::commands::robot;
use crate::run::{self, Options};
use bus::spec::BusSpec;
use host::record::Writer;
use host::task::{MoveTarget, Task};
use protocol::canopen::node::standard;
use protocol::frame::{Frame, Id};
use std::collections::BTreeMap;
use std::io::Cursor;

type Events = Vec<(u64, Event)>;

/// The record of a move of a conveyor, which is short.
fn moved(name: &str) -> (About, Events) {
    let path = std::env::temp_dir().join(format!("mrroc-{name}-{}.mcap", std::process::id()));
    let options = Options {
        bus: BusSpec::Virtual,
        realtime: false,
        record: Some(run::Record {
            path: path.clone(),
            arguments: ["move", "conveyor", "--joints", "0.2"]
                .map(String::from)
                .to_vec(),
            files: BTreeMap::new(),
        }),
        plots: vec![],
        json: false,
        quiet: true,
        faults: Vec::new(),
    };
    let (kind, target) = (robot("conveyor").unwrap(), MoveTarget::Joints(vec![0.2]));
    let task = Task::single_move(kind, target, false, None).unwrap();
    assert_eq!(run::run(task, None, &options).unwrap().exit_code, exit::OK);
    let bytes = std::fs::read(&path).unwrap();
    std::fs::remove_file(&path).unwrap();
    let mut reader = Reader::open(&*bytes).unwrap();
    let mut events = Vec::new();
    while let Some(event) = reader.next_event().unwrap() {
        events.push(event);
    }
    assert!(reader.is_complete());
    (reader.about().clone(), events)
}

fn replayed(about: &About, events: &[(u64, Event)]) -> Result<Outcome, End> {
    let mut writer = Writer::new(Cursor::new(Vec::new()), about, &[]).unwrap();
    for (at_ns, event) in events {
        writer.event(*at_ns, event).unwrap();
    }
    let bytes = writer.finish().unwrap().into_inner();
    let replay = Replay {
        file: "a.mcap".into(),
        json: false,
        quiet: true,
    };
    replay.replay(Reader::open(&*bytes).unwrap())
}

/// The first frame of an identifier after 1 s, to be changed.
fn frame_of(events: &mut Events, bus: usize, cob: u16) -> (u64, &mut Frame) {
    let found = events.iter_mut().find_map(|(at_ns, event)| match event {
        Event::Frame(of, frame) => {
            (*of == bus && *at_ns > 1_000_000_000 && standard(frame) == Some(cob))
                .then_some((*at_ns, frame))
        }
        Event::Step(_) => None,
    });
    found.unwrap()
}

/// The part that differs, and where first.
fn differing(outcome: &Outcome) -> Vec<(&str, u64, usize)> {
    outcome
        .rows()
        .filter_map(|(name, _, comparison)| {
            let difference = comparison.difference()?;
            Some((name, difference.at_ns, difference.bus))
        })
        .collect()
}

#[test]
fn what_was_recorded_happens_again() {
    let (about, events) = moved("again");
    let outcome = replayed(&about, &events).unwrap();
    assert!(outcome.same(), "{}", outcome.to_text());
    assert!(outcome.unseen.is_empty());
    let frames = events.iter().filter(|(_, e)| matches!(e, Event::Frame(..)));
    let (all, sent) = (
        frames.count() as u64,
        outcome.rows().map(|(.., c)| c.same()).sum::<u64>(),
    );
    // the rest is the drive's
    assert!(sent > all / 3 && sent < all, "{sent} of {all}");
    let json = outcome.to_json();
    assert_eq!(json["same"], true);
    assert_eq!(json["parts"][1]["part"], "conveyor");
}

#[test]
fn a_set_point_that_was_another_is_found_where_it_was() {
    let (about, mut events) = moved("set-point");
    let (at_ns, frame) = frame_of(&mut events, 1, 0x201);
    let mut data = frame.data().to_vec();
    data[2] ^= 1;
    *frame = Frame::classic(Id::Standard(0x201), &data).unwrap();
    let outcome = replayed(&about, &events).unwrap();
    assert_eq!(differing(&outcome), [("conveyor", at_ns, 1)]);
    assert!(outcome.to_text().contains("recorded 201#"));
}

#[test]
fn a_drive_that_said_something_else_makes_a_node_do_something_else_later() {
    let (about, mut events) = moved("drive");
    // its statusword says fault
    let (at_ns, frame) = frame_of(&mut events, 1, 0x181);
    let mut data = frame.data().to_vec();
    data[0] |= 0x08;
    *frame = Frame::classic(Id::Standard(0x181), &data).unwrap();
    let outcome = replayed(&about, &events).unwrap();
    let differing = differing(&outcome);
    assert_eq!(differing.len(), 1, "{}", outcome.to_text());
    let (name, differs_ns, _) = differing[0];
    assert_eq!(name, "conveyor");
    // a servo step later at most, and the time of the frames
    assert!(differs_ns > at_ns && differs_ns < at_ns + 10_000_000);
}

#[test]
fn a_frame_that_nobody_sends_now_and_one_that_was_never_recorded_are_found() {
    let (about, events) = moved("lost");
    for twice in [true, false] {
        let mut events = events.clone();
        let (at_ns, _) = frame_of(&mut events, 1, 0x201);
        let place = events.iter().position(|(at, _)| *at == at_ns).unwrap();
        if twice {
            events.insert(place, events[place].clone());
        } else {
            events.remove(place);
        }
        let outcome = replayed(&about, &events).unwrap();
        let differing = differing(&outcome);
        assert_eq!(differing.len(), 1, "{}", outcome.to_text());
        assert_eq!(differing[0].2, 1);
    }
}

#[test]
fn another_command_and_missing_frames_are_told() {
    let (mut about, mut events) = moved("other");
    events.retain(|(_, event)| !matches!(event, Event::Frame(0, _)));
    let error = replayed(&about, &events).map(drop).unwrap_err();
    assert_eq!(error.code, exit::DATA);
    assert!(error.text.contains("lacks frames"), "{error:?}");
    about.arguments = vec!["man".into()];
    let error = replayed(&about, &[]).map(drop).unwrap_err();
    assert_eq!(error.code, exit::USAGE);
    assert!(error.text.contains("run, home or move"), "{error:?}");
}

#[test]
fn a_record_of_the_masters_bus_alone_replays_the_master() {
    let (mut about, mut events) = moved("master");
    about.buses.truncate(1);
    events.retain(|(_, event)| !matches!(event, Event::Frame(1.., _)));
    let outcome = replayed(&about, &events).unwrap();
    assert!(outcome.same());
    assert_eq!(outcome.unseen, ["conveyor"]);
    assert_eq!(outcome.rows().count(), 1);
}
