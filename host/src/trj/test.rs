use super::*;
use proptest::prelude::*;
use std::fmt::Write as _;

const TWO: &str = "JOINT\n2\nABSOLUTE\n\n\
    0.1 0.1\n0.05 0.05\n1.5 -0.25\n\n\
    0.2 0.3\n0.06 0.07\n-1e-3 +2\n";

#[test]
fn a_file_as_the_original_writes_it() {
    let read = parse(TWO, 2).unwrap();
    assert_eq!(read.space, Space::Joint);
    assert_eq!(read.reference, Reference::Absolute);
    assert_eq!(read.warnings, []);
    assert_eq!(read.nodes.len(), 2);
    assert_eq!(
        read.nodes[1],
        Node {
            velocity: vec![0.2, 0.3],
            acceleration: vec![0.06, 0.07],
            coordinates: vec![-0.001, 2.0],
            line: 11
        }
    );
}

#[test]
fn line_ends_tabs_blanks_and_the_reference_are_free() {
    let crlf = TWO.replace('\n', "\r\n");
    assert_eq!(
        parse(&crlf, 2).unwrap().nodes[0],
        parse(TWO, 2).unwrap().nodes[0]
    );
    let tabs = TWO.replace(' ', "\t \t").replace("\n\n", "\n\t\t\n \n");
    assert_eq!(
        parse(&tabs, 2).unwrap().nodes[0].coordinates,
        parse(TWO, 2).unwrap().nodes[0].coordinates
    );
    let default = TWO.replace("ABSOLUTE\n", "");
    assert_eq!(parse(&default, 2).unwrap().reference, Reference::Absolute);
    let relative = TWO.replace("ABSOLUTE", "RELATIVE");
    assert_eq!(parse(&relative, 2).unwrap().reference, Reference::Relative);
    let one_line = TWO.replace("JOINT\n2\nABSOLUTE\n", "JOINT 2 ABSOLUTE\n");
    assert_eq!(
        parse(&one_line, 2).unwrap().nodes.len(),
        parse(TWO, 2).unwrap().nodes.len()
    );
}

#[test]
fn columns_of_the_old_gripper_are_skipped_and_said() {
    let text = "JOINT\n1\n0.1 0.1 9 9\n0.1 0.1 0 0\n1 2 0.074\n";
    let read = parse(text, 2).unwrap();
    assert_eq!(read.nodes[0].velocity, [0.1, 0.1]);
    assert_eq!(read.nodes[0].coordinates, [1.0, 2.0]);
    assert_eq!(
        read.warnings,
        [Warning::ExtraColumns {
            line: 3,
            used: 2,
            found: 4
        }]
    );
    assert_eq!(
        read.warnings[0].to_string(),
        "line 3: columns 3 to 4 skipped, the robot has 2 (a gripper is a robot of its own)"
    );
}

#[test]
fn only_the_declared_nodes_are_run() {
    let read = parse(&TWO.replace("\n2\n", "\n1\n"), 2).unwrap();
    assert_eq!(read.nodes.len(), 1);
    assert_eq!(
        read.warnings,
        [Warning::ExtraNodes {
            line: 9,
            declared: 1,
            found: 2
        }]
    );
    assert_eq!(
        read.warnings[0].to_string(),
        "line 9: 1 of 2 nodes skipped, 1 declared"
    );
}

#[test]
fn old_nodes_of_five_lines_are_recognised() {
    let text =
        "MOTOR\n2\n\n0 0\n0 0.5\n0.5 0.4\n0.1 0.2\n10 -20\n\n0.5 0\n0 0\n0.3 0.3\n0.1 0.1\n0 0\n";
    let read = parse(text, 2).unwrap();
    assert_eq!(read.nodes.len(), 2);
    assert_eq!(read.nodes[0].velocity, [0.5, 0.4]);
    assert_eq!(read.nodes[0].acceleration, [0.1, 0.2]);
    assert_eq!(read.nodes[0].coordinates, [10.0, -20.0]);
    assert_eq!(read.warnings, [Warning::PassingVelocity { line: 5 }]);
}

#[test]
#[expect(clippy::too_many_lines, reason = "a table of cases")]
fn every_mistake_is_one_line_with_a_place() {
    let xyz = "XYZ_ANGLE_AXIS\n1\n1 1 1 1 1 1\n1 1 1 1 1 1\n0 0 0 0 0\n";
    let long = format!("JOINT\n1\n{}\n", " ".repeat(4097));
    let cases: &[(String, &str)] = &[
        (
            String::new(),
            "1:1: error: no pose specification (expected MOTOR, JOINT, XYZ_ANGLE_AXIS or XYZ_EULER_ZYZ, got end of file)",
        ),
        (
            "joint\n".into(),
            "1:1: error: unknown pose specification (expected MOTOR, JOINT, XYZ_ANGLE_AXIS or XYZ_EULER_ZYZ, got `joint`)",
        ),
        (
            "JOINT\n".into(),
            "1:1: error: no number of nodes (expected a whole number from 1, got end of file)",
        ),
        (
            "JOINT\n  0".into(),
            "2:3: error: no nodes declared (expected a whole number from 1, got `0`)",
        ),
        (
            "JOINT\n-1".into(),
            "2:1: error: the number of nodes is not one (expected a whole number from 1, got `-1`)",
        ),
        (
            "JOINT\n1.5".into(),
            "2:1: error: the number of nodes is not one (expected a whole number from 1, got `1.5`)",
        ),
        (
            TWO.replace("ABSOLUTE", "absolut"),
            "3:1: error: unknown word after the number of nodes (expected ABSOLUTE, RELATIVE or the velocities of node 1, got `absolut`)",
        ),
        (
            TWO.replace("ABSOLUTE", "ABSOLUTE 3"),
            "3:10: error: more words on the last line of the header (expected the end of the line, got `3`)",
        ),
        (
            TWO.replace("\n2\n", "\n3\n"),
            "11:1: error: fewer nodes than declared (expected 3 nodes, got 2)",
        ),
        (
            TWO.replace("-1e-3 +2\n", ""),
            "10:1: error: fewer nodes than declared (expected the coordinate line of node 2 of 2, got end of file)",
        ),
        (
            TWO.replace("0.2 0.3", "0.2"),
            "9:1: error: wrong number of values in the velocity line of node 2 (expected 2 values, got 1)",
        ),
        (
            TWO.replace("0.2 0.3", "1 1 1 1 1 1 1 1 1"),
            "9:1: error: wrong number of values in the velocity line of node 2 (expected 2 values, at most 8, got 9)",
        ),
        (
            xyz.into(),
            "5:1: error: wrong number of values in the coordinate line of node 1 (expected 6 values, got 5)",
        ),
        (
            TWO.replace("-0.25", "nan"),
            "7:5: error: not a finite number in the coordinate line of node 1 (expected a finite number, got `nan`)",
        ),
        (
            TWO.replace("-0.25", "1e400"),
            "7:5: error: not a finite number in the coordinate line of node 1 (expected a finite number, got `1e400`)",
        ),
        (
            TWO.replace("-0.25", "1,5"),
            "7:5: error: not a number in the coordinate line of node 1 (expected a number, got `1,5`)",
        ),
        (
            TWO.replace("0.07", "1.01"),
            "10:6: error: fraction out of range in the acceleration line of node 2 (expected a fraction greater than 0, at most 1, got `1.01`)",
        ),
        (
            TWO.replace("0.3", "0"),
            "9:5: error: fraction out of range in the velocity line of node 2 (expected a fraction greater than 0, at most 1, got `0`)",
        ),
        (
            TWO.replace("0.3", "-0.1"),
            "9:5: error: fraction out of range in the velocity line of node 2 (expected a fraction greater than 0, at most 1, got `-0.1`)",
        ),
        (
            format!("{TWO}# end\n"),
            "12:1: error: the file goes on after its 2 nodes, and not with a node of 3 lines (expected end of file, got `#`)",
        ),
        (
            TWO.replace("1.5 ", "\u{0}\u{1b}x "),
            "7:1: error: not a number in the coordinate line of node 1 (expected a number, got `\\0\\u{1b}x`)",
        ),
        (
            long,
            "3:1: error: line too long (expected at most 4096 bytes, got 4097 bytes)",
        ),
    ];
    for (text, expected) in cases {
        let error = parse(text, 2).expect_err(expected).to_string();
        assert_eq!(error, *expected, "for {text:?}");
    }
}

#[test]
fn an_error_in_a_file_names_it() {
    let error = parse("X", 1)
        .unwrap_err()
        .in_file(Path::new("tasks/a\n.trj"));
    assert!(
        error
            .to_string()
            .starts_with("tasks/a\\n.trj:1:1: error: unknown pose")
    );
}

#[test]
fn both_orientations_name_the_same_pose() {
    let angle_axis = "XYZ_ANGLE_AXIS\n1\n1 1 1 1 1 1\n1 1 1 1 1 1\n1 2 3 0 0.5 0\n";
    let euler = "XYZ_EULER_ZYZ\n1\n1 1 1 1 1 1\n1 1 1 1 1 1\n1 2 3 0.3 0.5 -0.3\n";
    let (a, e) = (parse(angle_axis, 7).unwrap(), parse(euler, 7).unwrap());
    let pose = a.pose(&a.nodes[0]).unwrap();
    assert!((pose.position - Vector3::new(1.0, 2.0, 3.0)).norm() < 1e-15);
    // Rz(φ)·Ry(θ)·Rz(-φ) turns by θ about the y axis turned by φ
    let about = Vector3::new(-libm::sin(0.3), libm::cos(0.3), 0.0) * 0.5;
    let turned = e.pose(&e.nodes[0]).unwrap();
    assert!((turned.rotation - exp(about)).norm() < 1e-12);
    assert!((pose.rotation - exp(Vector3::y() * 0.5)).norm() < 1e-15);
    let joints = parse(TWO, 2).unwrap();
    assert_eq!(joints.pose(&joints.nodes[0]), None);
}

/// Reads every file of a directory of taught trajectories, if the variable names one.
#[test]
fn samples_of_the_original_are_read() {
    let Some(directory) = std::env::var_os("MRROC_TRJ_SAMPLES") else {
        return;
    };
    // robots by how the files are named, and what their headers declare
    let axes = |name: &str| match name {
        name if name.contains("conveyor") => 1,
        name if name.contains("irp6ot") || name.contains("polycrank") => 7,
        name if name.contains("draughts") => 7,
        _ => 6,
    };
    let mut seen = 0;
    for entry in std::fs::read_dir(directory).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let read =
            load(&path, &Files::on_disk(), axes(&name)).unwrap_or_else(|error| panic!("{error}"));
        let text = Files::on_disk().read(&path).unwrap();
        let declared: usize = text.split_whitespace().nth(1).unwrap().parse().unwrap();
        assert_eq!(read.nodes.len(), declared, "{name}");
        let said: Vec<_> = read.warnings.iter().map(ToString::to_string).collect();
        println!("{name}: {} nodes {said:?}", read.nodes.len());
        seen += 1;
    }
    assert!(seen > 0);
}

fn written(space: Space, nodes: &[Vec<(f64, f64, f64)>]) -> String {
    let mut text = format!("{}\n{}\nRELATIVE\n", space.name(), nodes.len());
    for node in nodes {
        for pick in [
            |value: &(f64, f64, f64)| value.0,
            |value: &(f64, f64, f64)| value.1,
            |value: &(f64, f64, f64)| value.2,
        ] {
            for value in node {
                write!(text, "{:?}\t", pick(value)).unwrap();
            }
            text.push('\n');
        }
        text.push('\n');
    }
    text
}

proptest! {
    #[test]
    fn any_text_is_read_or_refused_on_one_line(text in "(MOTOR|JOINT)?\\s?[0-9]?\n(\\PC|\n| |\t|[0-9.]){0,200}", axes in 1usize..=8) {
        if let Err(error) = parse(&text, axes) {
            prop_assert!(!error.to_string().contains('\n'));
            prop_assert!(error.line as usize <= text.lines().count().max(1));
        }
    }

    #[test]
    fn what_is_written_is_read_bit_for_bit(
        nodes in prop::collection::vec(
            prop::collection::vec((1e-6..=1.0f64, 1e-6..=1.0f64, -1e3..1e3f64), 6), 1..8),
        cut in 0usize..4000,
    ) {
        let text = written(Space::XyzAngleAxis, &nodes);
        let read = parse(&text, 7).unwrap();
        prop_assert_eq!(read.nodes.len(), nodes.len());
        for (node, expected) in read.nodes.iter().zip(&nodes) {
            for (i, (v, a, x)) in expected.iter().enumerate() {
                prop_assert_eq!(node.velocity[i].to_bits(), v.to_bits());
                prop_assert_eq!(node.acceleration[i].to_bits(), a.to_bits());
                prop_assert_eq!(node.coordinates[i].to_bits(), x.to_bits());
            }
        }
        // a file cut within a number may still be one, but never with more or other nodes
        let cut = cut.min(text.len());
        if let Ok(part) = parse(&text[..cut], 7) {
            prop_assert_eq!(part.nodes.len(), nodes.len());
        }
    }
}
