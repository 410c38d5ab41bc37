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

/// An ELF file for Arm with these loaded parts (address in flash, bytes).
fn elf(parts: &[(u32, &[u8])]) -> Vec<u8> {
    const HEADER: u32 = 52;
    const PART: u32 = 32;
    const SECTION: u32 = 40;
    const LOAD: u32 = 1;
    const BITS: u32 = 1;
    const ALLOCATED: u32 = 2;
    const RAM: u32 = 0x2000_0000;
    let half = |file: &mut Vec<u8>, halves: &[u16]| {
        file.extend(halves.iter().flat_map(|half| half.to_le_bytes()));
    };
    let word = |file: &mut Vec<u8>, words: &[u32]| {
        file.extend(words.iter().flat_map(|word| word.to_le_bytes()));
    };
    let length = |bytes: &[u8]| u32::try_from(bytes.len()).unwrap();
    // of each part one; and the header's segment, the null section and that of the names
    let [segments, count] = [1, 2].map(|more| u16::try_from(parts.len() + more).unwrap());
    let sections = HEADER + PART * u32::from(segments);
    let data = sections + SECTION * u32::from(count);
    let mut file = b"\x7fELF\x01\x01\x01\0\0\0\0\0\0\0\0\0".to_vec();
    // executable, Arm; version, entry, segments, sections, flags
    half(&mut file, &[2, 40]);
    word(&mut file, &[1, 0, HEADER, sections, 0]);
    half(&mut file, &[52, 32, segments, 40, count, count - 1]);
    let mut at = data;
    for (address, bytes) in parts {
        let length = length(bytes);
        // type, offset, virtual (it runs in RAM), physical, in the file, in memory, flags, alignment
        word(&mut file, &[LOAD, at, RAM, *address, length, length, 5, 4]);
        at += length;
    }
    // the file's own header, as linkers that map whole pages have it
    let below = 0x0800_0000;
    word(&mut file, &[LOAD, 0, below, below, data, data, 4, 4]);
    word(&mut file, &[0; 10]);
    at = data;
    for (_, bytes) in parts {
        let length = length(bytes);
        // name, type, flags, virtual, offset, length, link, information, alignment, entry
        word(
            &mut file,
            &[0, BITS, ALLOCATED, RAM, at, length, 0, 0, 4, 0],
        );
        at += length;
    }
    // one empty name, which is in the file's own header
    word(&mut file, &[0, 3, 0, 0, 7, 1, 0, 0, 1, 0]);
    file.extend(parts.iter().flat_map(|(_, bytes)| bytes.iter()));
    file
}

#[test]
fn an_elf_file_is_packed_as_it_is_in_flash() {
    let (program, packed) = (scratch("elf"), scratch("elf-packed"));
    let pack = |parts: &[(u32, &[u8])]| {
        std::fs::write(&program, elf(parts)).unwrap();
        let line = format!(
            "node pack {} --robot rnt --target stm32g474 --image-version 1.2.3 -o {}",
            program.display(),
            packed.display()
        );
        of(&line).unwrap().run(&mut Vec::new())
    };
    // the second in front of the first, and erased flash between them
    let parts: [(u32, &[u8]); 2] = [(0x0800_4808, &[5, 6, 7]), (0x0800_4800, &[1, 2, 3, 4])];
    pack(&parts).unwrap();
    let image = load(&packed).unwrap();
    assert_eq!(image.bytes, [1, 2, 3, 4, 255, 255, 255, 255, 5, 6, 7]);
    for (parts, word) in [
        (
            &[(0x0800_0000, &[1; 8][..])][..],
            "expected 08004800, got 08000000",
        ),
        (
            &[(0x0800_4800, &[1; 8]), (0x0800_4804, &[2; 8])],
            "at 08004804",
        ),
        (
            &[(0x0800_4800, &[1; 8]), (0x2000_0000, &[2; 8])],
            "longer than",
        ),
    ] {
        let end = pack(parts).unwrap_err();
        assert_eq!(end.code, exit::DATA, "{word}");
        assert!(end.text.contains(word), "{}", end.text);
    }
    let whole = elf(&parts);
    for length in 4..whole.len() {
        std::fs::write(&program, &whole[..length]).unwrap();
        let line = format!(
            "node pack {} --robot rnt --target host --image-version 1.2.3 -o {}",
            program.display(),
            packed.display()
        );
        let end = of(&line).unwrap().run(&mut Vec::new()).unwrap_err();
        assert_eq!(
            (end.code, end.text.lines().count()),
            (exit::DATA, 1),
            "{length}"
        );
    }
    let _ = [program, packed].map(std::fs::remove_file);
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
