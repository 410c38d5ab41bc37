use super::faults::Found;
use super::image::{load, version};
use super::*;
use clap::Parser;
use protocol::fault::{Cause, Fault};
use protocol::maintenance::{AxisSample, FaultRecord, Sample};
use protocol::message::NodeState;

#[derive(Parser)]
struct Line {
    #[command(flatten)]
    node: Node,
}

fn of(text: &str) -> Result<Node, clap::Error> {
    Line::try_parse_from(text.split(' ')).map(|line| line.node)
}

#[test]
fn a_node_is_a_robot_or_a_number() {
    let found = target("irp6-postument").unwrap();
    assert_eq!(
        (found.id.get(), found.name.as_str()),
        (12, "irp6-postument")
    );
    assert_eq!(target("12").unwrap().id, found.id);
    for text in ["", "128", "-1", "irp7", "1.5", "256"] {
        let error = target(text).unwrap_err();
        assert!(error.contains("irp6-track"), "{text}: {error}");
    }
}

#[test]
fn the_command_line_is_read() {
    assert!(of("node info --node irp6-track").is_ok());
    assert!(of("node faults --node 12 --bus hub:3000 --plot x.svg --json --clear").is_ok());
    assert!(of("node flash x.img --node 12 --as 4 -q").is_ok());
    for (text, word) in [
        ("node info", "--node"),
        ("node flash --node 12", "<IMAGE>"),
        ("node info --node 12 --bus virtual", "one process"),
        ("node info --node 12 --as 128", "128"),
        (
            "node pack x --robot irp7 --target t --image-version 1.2.3 -o y",
            "irp7",
        ),
        (
            "node pack x --robot rnt --target  --image-version 1.2.3 -o y",
            "1 to 24",
        ),
        (
            "node pack x --robot rnt --target t --image-version 1.2 -o y",
            "three numbers",
        ),
    ] {
        let error = of(text).err().map(|error| error.to_string());
        assert!(
            error.as_ref().is_some_and(|e| e.contains(word)),
            "{text}: {error:?}"
        );
    }
}

#[test]
fn versions_are_three_small_numbers() {
    assert_eq!(version("0.2.255"), Ok((0, 2, 255)));
    for text in [
        "", "1", "1.2", "1.2.3.4", "1.2.256", "-1.2.3", "1.2.x", "1,2,3",
    ] {
        assert!(version(text).is_err(), "{text}");
    }
}

fn scratch(name: &str) -> PathBuf {
    std::env::temp_dir().join(format!("mrroc-{name}-{}", std::process::id()))
}

#[test]
fn a_packed_program_is_loaded_and_any_damage_is_told() {
    let (program, packed) = (scratch("program"), scratch("packed"));
    std::fs::write(&program, [7_u8; 1000]).unwrap();
    let line = format!(
        "node pack {} --robot rnt --target host --image-version 1.2.3 -o {}",
        program.display(),
        packed.display()
    );
    let mut out = Vec::new();
    of(&line).unwrap().run(&mut out).unwrap();
    assert!(
        String::from_utf8(out)
            .unwrap()
            .contains("1.2.3 for host of rnt, 1000 bytes")
    );
    let image = load(&packed).unwrap();
    assert_eq!(image.header.version, (1, 2, 3));
    assert_eq!(image.bytes, [7; 1000]);
    let good = std::fs::read(&packed).unwrap();
    let mut flipped = good.clone();
    flipped[500] ^= 1;
    let longer = [&good[..], &[7]].concat();
    for (bytes, word) in [
        (&[][..], "shorter than the 96 bytes"),
        (&good[..95], "shorter"),
        (
            &good[..96],
            "wrong length (expected 1000 bytes behind the header, got 0)",
        ),
        (&good[..1095], "got 999"),
        (&longer[..], "got 1001"),
        (&flipped[..], "damaged"),
        (&[0; 2000][..], "MRROCIMG"),
    ] {
        std::fs::write(&packed, bytes).unwrap();
        let end = load(&packed).unwrap_err();
        assert_eq!(end.code, exit::DATA, "{word}");
        assert!(
            end.text.contains(word) && !end.text.contains('\n'),
            "{}",
            end.text
        );
    }
    std::fs::write(&program, []).unwrap();
    assert_eq!(
        of(&line).unwrap().run(&mut Vec::new()).unwrap_err().code,
        exit::DATA
    );
    for path in [&program, &packed] {
        std::fs::remove_file(path).unwrap();
        assert_eq!(load(path).unwrap_err().code, exit::NO_INPUT);
    }
    assert_eq!(
        load(&std::env::temp_dir()).unwrap_err().code,
        exit::NO_INPUT
    );
}

fn found(robot: &str, axes: usize) -> Found {
    let sample = |step: u32| Sample {
        step,
        state: NodeState::Moving,
        fault: if step == 100 { 30 } else { 0 },
        axes: (0..axes)
            .map(|k| AxisSample {
                actual: i32::try_from(step).unwrap() * 10,
                error: if k == 1 { -200 } else { 10 },
                current_ma: 1500,
            })
            .collect(),
    };
    let record = FaultRecord {
        record: 0xCAFE,
        fault: Fault {
            cause: Cause::FollowingError,
            axis: Some(1),
            step: 100,
            during: NodeState::Moving,
        },
        instruction: 12,
        boot: 3,
        later: 2,
        samples: 51,
        servo_step_us: 2000,
    };
    Found::new(robot, record, (50..=100).map(sample).collect())
}

#[test]
fn a_fault_is_told_with_who_what_when_and_what_it_interrupted() {
    let text = found("irp6-postument", 6).text("irp6-postument", false);
    for word in [
        "fault 30 on axis 2 while Moving, servo step 100",
        "0.200 s after start 3, it interrupted instruction 12; 51 samples of the last 0.100 s",
        "2 faults later",
        "docs/faults/30.md",
        "actual [rad]",
    ] {
        assert!(text.contains(word), "{word}: {text}");
    }
    let marked: Vec<_> = text.lines().filter(|line| line.contains("<-")).collect();
    assert_eq!(marked.len(), 1);
    // another robot, or another number of axes: increments
    let text = found("irp7", 3).text("node 9", true);
    // −200 tenths are −20 increments
    assert!(
        text.contains("actual [increments]") && text.contains("-20.0000"),
        "{text}"
    );
    assert!(text.contains("cleared"));
}

#[test]
fn the_picture_has_every_axis_and_the_fault_at_zero() {
    let svg = host::plot::svg(&found("irp6-postument", 6).picture());
    for word in [
        "fault 30 on axis 2",
        "following error [rad]",
        "current [A]",
        "time, the fault at 0 [s]",
    ] {
        assert!(svg.contains(word), "{word}");
    }
    let value = found("irp6-postument", 6).json(false);
    assert_eq!(value["fault"]["axis"], 2);
    assert_eq!(value["samples"][50]["t_s"], 0.0);
    assert_eq!(value["samples"][0]["t_s"], -0.1);
    assert_eq!(value["samples"][0]["axes"][1]["error_increments"], -20.0);
}
