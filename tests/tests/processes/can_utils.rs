//! can-utils beside `candump`, the witness: `cansend` asks a drive, `canplayer` is the node of an earlier day,
//! and plays what `mrroc` has recorded.

use super::{CLASSIC, Cell, FD, is_here, system};
use crate::child::{PATIENCE, Process};
use crate::witness::{self, Witness};
use bus::candump::{Entry, Reader, parse};
use protocol::frame::{Frame, Id};
use std::fs::{self, File};
use std::io::{BufReader, Write as _};
use std::path::PathBuf;
use std::thread;
use std::time::{Duration, Instant};

/// One axis: what it says is told in few frames.
const ROBOT: &str = "conveyor";
/// Units of the drive in a radian of its motor: 1000 for each of 4000 increments a turn.
const UNITS_PER_RAD: f64 = 4_000_000.0 / core::f64::consts::TAU;

/// A file that goes with the test.
struct Temporary(PathBuf);

impl Temporary {
    fn new(name: &str) -> Self {
        let name = format!("mrroc-{}-{name}", std::process::id());
        Self(std::env::temp_dir().join(name))
    }

    fn path(&self) -> &str {
        self.0.to_str().unwrap()
    }

    /// A log of these frames.
    fn log<'a>(name: &str, entries: impl IntoIterator<Item = &'a Entry>) -> Self {
        let log = Self::new(name);
        let mut file = File::create(&log.0).unwrap();
        for entry in entries {
            writeln!(file, "{entry}").unwrap();
        }
        log
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        let _ = fs::remove_file(&self.0);
    }
}

/// The drive alone: its simulator, and its number.
fn drive(number: &str) -> Process {
    let place = format!("can:{CLASSIC}");
    let arguments = [ROBOT, "--effector", number, "--bus", &place, "--json"];
    let mut simulator = Process::start("mrroc-hil-sim", &arguments);
    simulator.event("ready", |_| true);
    simulator
}

/// A frame as can-utils write it.
fn frame(text: &str) -> Frame {
    let line = format!("(0.000000) {CLASSIC} {text}");
    parse(&line).unwrap().frame
}

/// Sends a frame by `cansend`; the witness must see it, and after it the answer.
fn exchange(witness: &Witness, request: &str, answer: &str) {
    let before = witness.read().len();
    system("cansend", &[CLASSIC, request]);
    let until = Instant::now() + PATIENCE;
    loop {
        let seen = witness.read();
        let mut later = seen.iter().skip(before).map(|entry| entry.frame);
        if later.any(|seen| seen == frame(request)) && later.any(|seen| seen == frame(answer)) {
            return;
        }
        assert!(Instant::now() < until, "{request}: no {answer} in {seen:?}");
        thread::sleep(Duration::from_millis(20));
    }
}

#[test]
fn a_drive_answers_what_cansend_asks() {
    if !is_here(CLASSIC) {
        return;
    }
    let witness = Witness::of(CLASSIC);
    let simulator = drive("1");
    // NMT, reset of node 1: it boots
    exchange(&witness, "000#8201", "701#00");
    // the heartbeat's period is made 50 ms, and read again (expedited, CiA 301)
    exchange(&witness, "601#2B17100032000000", "581#6017100000000000");
    exchange(&witness, "601#4017100000000000", "581#4B17100032000000");
    // NMT, start: the heartbeat says operational
    exchange(&witness, "000#0101", "701#05");
    // no such object; the statusword is read only
    exchange(&witness, "601#4000500000000000", "581#8000500000000206");
    exchange(&witness, "601#2B41600000000000", "581#8041600002000106");
    // layer setting (CiA 305), all drives: who are you, be 99, store that, go on; after a reset it is
    system("cansend", &[CLASSIC, "7E5#0401000000000000"]);
    exchange(&witness, "7E5#5E00000000000000", "7E4#5E01000000000000");
    exchange(&witness, "7E5#1163000000000000", "7E4#1100000000000000");
    exchange(&witness, "7E5#1700000000000000", "7E4#1700000000000000");
    system("cansend", &[CLASSIC, "7E5#0400000000000000"]);
    exchange(&witness, "000#8201", "763#00");
    exchange(&witness, "663#2B17100032000000", "5E3#6017100000000000");
    drop(simulator);
}

/// What the drive says of itself in a recording, and what it is told.
struct Story {
    /// All that the node sent, from its reset of the drive on.
    node: Vec<Entry>,
    /// The answers to its SDO requests.
    answers: Vec<Vec<u8>>,
    /// Its states one after the other: the statusword's bits that tell them (CiA 402).
    states: Vec<u16>,
    /// Where it was first and last, drive units.
    way: (i32, i32),
}

impl Story {
    fn of(seen: &[Entry]) -> Self {
        let standard = |entry: &Entry| match entry.frame.id() {
            Id::Standard(id) => Some(id),
            Id::Extended(_) => None,
        };
        // the only heartbeat that says 0 is the boot-up
        let booted = |entry: &Entry| {
            let id = standard(entry)?.checked_sub(0x700)?;
            (entry.frame.data() == [0]).then_some(id)
        };
        let number = seen.iter().find_map(booted).expect("a drive boots");
        let reset = Frame::classic(Id::Standard(0), &[0x82, number.to_le_bytes()[0]]);
        let begin = seen.iter().position(|entry| Some(entry.frame) == reset);
        let seen = &seen[begin.expect("the node resets the drive")..];
        let said = [0x080, 0x180, 0x280, 0x380, 0x480, 0x580, 0x700].map(|id| id + number);
        let of = |id: u16| {
            let these = seen.iter().filter(move |e| standard(e) == Some(id));
            these.map(|entry| entry.frame.data().to_vec())
        };
        // TPDO1 begins with statusword and actual position (docs/wire.md)
        let images: Vec<(u16, i32)> = of(0x180 + number)
            .map(|data| {
                let word = u16::from_le_bytes([data[0], data[1]]);
                (
                    word & 0x6F,
                    i32::from_le_bytes(data[2..6].try_into().unwrap()),
                )
            })
            .collect();
        let mut states: Vec<u16> = images.iter().map(|(state, _)| *state).collect();
        states.dedup();
        let node = seen
            .iter()
            .filter(|e| standard(e).is_some_and(|id| !said.contains(&id)));
        Self {
            node: node.cloned().collect(),
            answers: of(0x580 + number).collect(),
            states,
            way: (images.first().unwrap().1, images.last().unwrap().1),
        }
    }

    fn distance(&self) -> i32 {
        self.way.1 - self.way.0
    }
}

#[test]
fn a_recorded_node_played_by_canplayer_brings_a_drive_up_and_moves_it_the_same_way() {
    if !is_here(CLASSIC) {
        return;
    }
    let mut witness = Witness::of(CLASSIC);
    let cell = Cell::start(CLASSIC, &[ROBOT]);
    let place = format!("can:{CLASSIC}");
    let arguments = ["move", ROBOT, "--motors", "5", "--bus", &place, "--quiet"];
    let mut master = Process::start("mrroc", &arguments);
    let (status, said) = master.end();
    assert_eq!(status.code(), Some(0), "{said:#?}");
    cell.end(0);
    let recorded = Story::of(&witness.seen());
    our_reader_reads(&witness);
    drop(witness);
    // a belt is homed where it stands, then 5 rad; an increment for each of the two rests
    let expected = 5.0 * UNITS_PER_RAD;
    println!("recorded: {} units", recorded.distance());
    assert!((f64::from(recorded.distance()) - expected).abs() <= 2000.0);

    let log = Temporary::log("node.log", &recorded.node);
    let mut witness = Witness::of(CLASSIC);
    let simulator = drive("5");
    system("canplayer", &["-I", log.path()]);
    let seen = witness.seen();
    drop(simulator);
    let played = Story::of(&seen);
    println!(
        "played: {} frames, {} answers, states {:X?}, {} units",
        played.node.len(),
        played.answers.len(),
        played.states,
        played.distance()
    );
    let frames = |story: &Story| -> Vec<Frame> { story.node.iter().map(|e| e.frame).collect() };
    assert!(
        frames(&played) == frames(&recorded),
        "canplayer left some out"
    );
    assert_eq!(played.answers, recorded.answers);
    assert_eq!(played.states, recorded.states);
    // an increment for each of both rests: when within a step the drive samples is not the same
    assert!((played.distance() - recorded.distance()).abs() <= 2000);
}

/// Every line that `candump` has written of classical frames is read, and written again it is the same.
fn our_reader_reads(witness: &Witness) {
    let text = witness.text();
    let entries: Result<Vec<Entry>, _> = Reader::new(BufReader::new(text.as_bytes())).collect();
    let again: Vec<String> = entries.unwrap().iter().map(ToString::to_string).collect();
    let lines: Vec<&str> = text.lines().collect();
    assert!(again == lines);
    println!("{} lines of candump read", lines.len());
}

/// A belt that is homed and moved by a task, and an arm whose bus has a longer name than an interface has.
const TASK: &str = r#"
title = "A belt"
seed = 7

[[cell.robot]]
kind = "conveyor"
[[cell.robot]]
kind = "irp6-postument"

[[step]]
name = "home"
home = ["conveyor"]

[[step]]
name = "forward"
move = [{ robot = "conveyor", joints = [0.01] }]
"#;

#[test]
fn canplayer_plays_what_a_run_has_recorded_frame_by_frame() {
    if !is_here(FD) {
        return;
    }
    let (task, log) = (Temporary::new("belt.toml"), Temporary::new("belt.log"));
    fs::write(&task.0, TASK).unwrap();
    let arguments = ["run", task.path(), "--record", log.path(), "--quiet"];
    let mut run = Process::start("mrroc", &arguments);
    let (status, said) = run.end();
    assert_eq!(status.code(), Some(0), "{said:#?}");
    let reader = Reader::new(BufReader::new(File::open(&log.0).unwrap()));
    let recorded: Vec<Entry> = reader.collect::<Result<_, _>>().unwrap();
    let played = ["mp", "conveyor.0"];
    // on a bus of its own the node's heartbeat has the identifier of the witness's marks, which it keeps to itself
    let heard = |entry: &&Entry| {
        played.contains(&entry.channel.as_str()) && entry.frame.id() != witness::MARK
    };
    let expected: Vec<Frame> = recorded.iter().filter(heard).map(|e| e.frame).collect();
    assert!(
        expected
            .iter()
            .any(|frame| frame.is_fd() && frame.data().len() > 8)
    );

    let mut witness = Witness::of(FD);
    let assigned = played.map(|channel| format!("{FD}={channel}"));
    system("canplayer", &["-I", log.path(), &assigned[0], &assigned[1]]);
    let seen: Vec<Frame> = witness.seen().iter().map(|entry| entry.frame).collect();
    println!("{} frames of a run played", expected.len());
    assert!(
        seen == expected,
        "{} of {} frames",
        seen.len(),
        expected.len()
    );
}
