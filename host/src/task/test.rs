use super::*;
use crate::error::{Error, exit};
use proptest::prelude::*;
use protocol::budget::Rates;
use robots::TrackRule;

const CELL: &str =
    "[[cell.robot]]\nkind = \"irp6-track\"\n[[cell.robot]]\nkind = \"irp6-postument\"\n";

/// A task of one step.
fn task(step: &str) -> String {
    format!("title = \"t\"\n{CELL}[[step]]\n{step}\n")
}

fn action(step: &str) -> Action {
    match Task::parse(&task(step)) {
        Ok(task) => task.steps[0].action.clone(),
        Err(error) => panic!("{error}"),
    }
}

/// The error of a step, from its line on.
fn refused(step: &str) -> String {
    let error = Task::parse(&task(step)).expect_err(step);
    let shifted = DataError {
        line: error.line - 6,
        ..error
    };
    shifted.to_string()
}

#[test]
fn defaults_make_a_whole_cell() {
    let cell = Task::parse(&task("wait = { seconds = 1 }")).unwrap().cell;
    assert_eq!(
        cell,
        Cell::of(&[RobotKind::Irp6Track, RobotKind::Irp6Postument])
    );
    let names: Vec<_> = cell.buses.iter().map(|bus| bus.name.as_str()).collect();
    assert_eq!(
        names,
        ["mp", "irp6-track.0", "irp6-track.1", "irp6-postument.0"]
    );
    assert_eq!(cell.buses[0], BusSpec::fd("mp"));
    assert_eq!(cell.buses[1].kind, BusKind::Classic);
    let track = &cell.robots[0];
    assert_eq!(track.axes(), 7);
    assert_eq!(track.servo, ServoLaw::DrivePosition);
    assert!((track.velocity_factor - 0.2).abs() < 1e-15);
    assert_eq!(
        track.drives,
        [
            DriveGroup {
                bus: 1,
                axes: vec![0, 1, 2, 3]
            },
            DriveGroup {
                bus: 2,
                axes: vec![4, 5, 6]
            }
        ]
    );
    assert!((cell.robots[1].t_world_base.position.y - 2.1063).abs() < 1e-12);
}

#[test]
fn a_cell_says_where_the_track_goes_and_every_kind_has_its_defaults() {
    let of = |kind: RobotKind, line: &str| {
        Cell::parse(&format!("[[robot]]\nkind = \"{kind}\"\n{line}\n"))
    };
    for kind in RobotKind::ALL {
        let cell = of(kind, "").unwrap();
        assert_eq!(cell, Cell::of(&[kind]));
        assert_eq!(cell.robots[0].track, TrackRule::Keep);
        let mut axes: Vec<usize> = cell.robots[0]
            .drives
            .iter()
            .flat_map(|g| g.axes.clone())
            .collect();
        axes.sort_unstable();
        assert!(axes.into_iter().eq(0..kind.axes()), "{kind}");
        // more than six axes do not fit one classical bus
        assert!(
            cell.robots[0].drives.iter().all(|g| g.axes.len() <= 6),
            "{kind}"
        );
        let ruled = of(kind, "track = \"in-front\"");
        if kind == RobotKind::Irp6Track {
            assert_eq!(ruled.unwrap().robots[0].track, TrackRule::InFront);
        } else {
            let text = ruled.unwrap_err().to_string();
            assert!(
                text.contains("track") && text.contains(kind.name()),
                "{text}"
            );
        }
    }
    let text = of(RobotKind::Irp6Track, "track = \"behind\"")
        .unwrap_err()
        .to_string();
    assert!(text.contains("in-front") && text.contains("keep"), "{text}");
}

#[test]
fn a_cell_file_says_everything() {
    let cell = Cell::parse(
        r#"
        bus = [
            { name = "wire", kind = "fd", bit_rate_kbit_s = 500, data_bit_rate_kbit_s = 2000 },
            { name = "arm", kind = "classic", bit_rate_kbit_s = 800 },
        ]
        [[robot]]
        kind = "irp6-postument"
        name = "left"
        servo = "original"
        velocity_factor = 1
        base = { position_m = [0, 1.5, 0], rotation_rad = [0, 0, 1.0] }
        mp_bus = "wire"
        drives = [{ bus = "arm", axes = [6, 1, 2] }, { bus = "wire", axes = [3, 4, 5] }]
    "#,
    )
    .unwrap();
    assert_eq!(cell.buses.len(), 2);
    assert_eq!(
        cell.buses[0].kind,
        BusKind::Fd {
            data_bit_rate: 2_000_000
        }
    );
    assert_eq!(cell.buses[1].bit_rate, 800_000);
    let rates = cell.buses.iter().map(BusSpec::rates);
    let expected = [(500_000, 2_000_000), (800_000, 800_000)];
    assert!(rates.eq(expected.map(|(nominal, data)| Rates { nominal, data })));
    let robot = &cell.robots[cell.robot("left").unwrap()];
    assert_eq!(robot.servo, ServoLaw::Original);
    assert_eq!(robot.mp_bus, 0);
    assert_eq!(robot.drives[0].axes, [5, 0, 1]);
    assert!((robot.t_world_base.rotation_vector().z - 1.0).abs() < 1e-12);
}

#[test]
fn every_kind_of_step_is_read() {
    assert_eq!(
        action(r#"home = ["irp6-postument", "irp6-track"]"#),
        Action::Home { robots: vec![1, 0] }
    );
    assert_eq!(
        action("wait = { seconds = 0.5 }"),
        Action::Wait { seconds: 0.5 }
    );
    assert_eq!(
        action(r#"regulator = { robot = "irp6-track", law = "feed-forward" }"#),
        Action::Regulator {
            robot: 0,
            law: ServoLaw::FeedForward
        }
    );
    let Action::Move { moves } = action(
        r#"move = [{ robot = "irp6-postument", joints = [0, -1.57, 0, 1.56, 1.57, -1.57], speed = 0.3 },
                   { robot = "irp6-track", motors = [0, 0, 0, 0, 0, 0, 1], relative = true, acceleration = 0.5 }]"#,
    ) else {
        panic!("not a move");
    };
    assert_eq!(moves[0].robot, 1);
    assert!((moves[0].velocity - 0.3).abs() < 1e-15);
    assert!((moves[0].acceleration - 0.02).abs() < 1e-15);
    assert_eq!(
        moves[1].target,
        Target::Motors {
            values: vec![0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0],
            relative: true
        }
    );
    let Action::Move { moves } = action(
        r#"move = { robot = "irp6-track", pose = { position_m = [0.7, 0.5, 0.2], rotation_rad = [0, 3.1, 0] }, path = "joint" }"#,
    ) else {
        panic!("not a move");
    };
    let Target::Pose {
        pose,
        reference,
        path,
    } = &moves[0].target
    else {
        panic!("not a pose");
    };
    assert_eq!((*reference, *path), (PoseReference::Base, PosePath::Joint));
    assert!((pose.rotation_vector().y - 3.1).abs() < 1e-9);
}

#[test]
fn a_carried_object_turns_about_its_centre() {
    let Action::Tight(tight) = action(
        r#"tight = { robots = ["irp6-track", "irp6-postument"], displacement_m = [0, 0, 0.1],
                     axis = [0, 0, 2], angle_rad = 1.0, centre_m = [0.7, 1.0, 0.2], duration_s = 4 }"#,
    ) else {
        panic!("not tight");
    };
    assert!((tight.rotation_rad[2] - 1.0).abs() < 1e-15);
    assert_eq!(tight.displacement(0.0), Pose::identity());
    for s in [0.25, 0.5, 1.0] {
        let moved = tight.displacement(s);
        let centre = Vector3::new(0.7, 1.0, 0.2);
        let image = moved.rotation * centre + moved.position;
        assert!((image - centre - Vector3::new(0.0, 0.0, 0.1 * s)).norm() < 1e-12);
        assert!((moved.rotation_vector().z - s).abs() < 1e-12);
    }
}

#[test]
#[expect(clippy::too_many_lines, reason = "a table of cases")]
fn every_mistake_in_a_step_has_its_place() {
    let cases = [
        (
            "",
            "0:1: error: a step that says nothing (expected exactly one of `home`, `trj`, `move`, `wait`, `tight`, `path`, `engrave` or `regulator`, got none)",
        ),
        (
            "hme = []",
            "1:1: error: unknown key in a step (expected `name`, `home`, `trj`, `coordination`, `move`, `wait`, `tight`, `path`, `engrave` or `regulator`, got `hme`)",
        ),
        (
            "home = []",
            "1:8: error: too few robots (expected at least 1, got 0)",
        ),
        (
            "home = [\"irp6\"]",
            "1:9: error: unknown robot (expected `irp6-track` or `irp6-postument`, got `irp6`)",
        ),
        (
            "home = [\"irp6-track\", \"irp6-track\"]",
            "1:23: error: a robot twice in one step (expected every robot once, got the same again)",
        ),
        (
            "home = \"irp6-track\"",
            "1:8: error: `home` of the wrong type (expected a list, got the text `irp6-track`)",
        ),
        (
            "wait = { seconds = 1 }\nhome = [\"irp6-track\"]",
            "1:8: error: a step that says two things (expected exactly one of `home`, `trj`, `move`, `wait`, `tight`, `path`, `engrave` or `regulator`, got `home` and `wait`)",
        ),
        (
            "wait = { seconds = 0 }",
            "1:20: error: `seconds` out of range (expected greater than 0, at most 3600, got `0`)",
        ),
        (
            "wait = { seconds = nan }",
            "1:20: error: `seconds` is not finite (expected greater than 0, at most 3600, got `nan`)",
        ),
        (
            "wait = { seconds = -inf }",
            "1:20: error: `seconds` is not finite (expected greater than 0, at most 3600, got `-inf`)",
        ),
        (
            "wait = { seconds = \"1\" }",
            "1:20: error: `seconds` of the wrong type (expected greater than 0, at most 3600, got the text `1`)",
        ),
        (
            "wait = { seconds = 1 }\ncoordination = \"loose\"",
            "2:16: error: `coordination` of a step that replays nothing (expected a step with `trj`, got `wait`)",
        ),
        (
            "move = { robot = \"irp6-track\", joints = [1, 2] }",
            "1:41: error: wrong number of values in `joints` (expected 7 numbers, got 2)",
        ),
        (
            "move = { robot = \"irp6-track\", joints = [0, 0, 0, 0, 0, 0, nan] }",
            "1:60: error: `joints` is not finite (expected a finite number, got `nan`)",
        ),
        (
            "move = { robot = \"irp6-postument\", joints = [0, 0, 0, 0, 0, 0], speed = 1.5 }",
            "1:73: error: `speed` out of range (expected greater than 0, at most 1, got `1.5`)",
        ),
        (
            "move = { robot = \"irp6-postument\", joints = [0, 0, 0, 0, 0, 0], path = \"line\" }",
            "1:72: error: `path` of a motion of the axes (expected a motion to a `pose`, got `joints`)",
        ),
        (
            "move = { robot = \"irp6-track\", pose = { position_m = [0, 0, 0] } }",
            "1:39: error: a pose without `rotation_rad` (expected `rotation_rad`, got none)",
        ),
        (
            "tight = { robots = [\"irp6-track\"], displacement_m = [0, 0, 1], duration_s = 1 }",
            "1:20: error: too few robots (expected at least 2, got 1)",
        ),
        (
            "tight = { robots = [\"irp6-track\", \"irp6-postument\"], duration_s = 1 }",
            "1:9: error: a carried object that stays (expected `displacement_m` or `angle_rad` other than zero, got none)",
        ),
        (
            "tight = { robots = [\"irp6-track\", \"irp6-postument\"], displacement_m = [0, 0, 1], axis = [0, 0, 1], duration_s = 1 }",
            "1:89: error: `axis` without `angle_rad` (expected `angle_rad`, got none)",
        ),
        (
            "regulator = { robot = \"irp6-track\", law = \"pid\" }",
            "1:43: error: unknown servo law (expected `drive-position`, `original`, `feed-forward` or `computed-torque`, got `pid`)",
        ),
        (
            "trj = {}",
            "1:7: error: a step that replays nothing (expected a robot and its trajectory, got none)",
        ),
        (
            "trj = { irp6-track = \"no-such-file.trj\" }",
            "1:22: error: cannot read the trajectory (expected a .trj file, got no-such-file.trj: error: no such file)",
        ),
    ];
    for (step, expected) in cases {
        assert_eq!(refused(step), expected, "for {step}");
    }
}

#[test]
#[expect(clippy::too_many_lines, reason = "a table of cases")]
fn every_mistake_elsewhere_has_its_place() {
    let step = "[[step]]\nwait = { seconds = 1 }\n";
    let robot = "[[cell.robot]]\nkind = \"irp6-track\"\n";
    let deep = format!("title = {}", "[".repeat(100));
    let cases = [
        (String::new(), "1:1: error: a task without `title`"),
        (
            "title = \"a\"\ntitle = \"b\"".into(),
            "2:1: error: duplicate key (expected TOML, got `title` again)",
        ),
        ("title = \"a".into(), "1:11: error: "),
        (
            "title = \"a\"\nsteps = []".into(),
            "2:1: error: unknown key in a task (expected `title`, `seed`, `cell` or `step`, got `steps`)",
        ),
        (
            "title = \"a\\u0000\"".into(),
            "1:9: error: `title` is not a line of text",
        ),
        (
            format!("title = \"a\"\n{robot}"),
            "1:1: error: a task without `step`",
        ),
        (
            format!("title = \"a\"\nseed = -1\n{robot}{step}"),
            "2:8: error: `seed` out of range (expected a whole number from 0, got `-1`)",
        ),
        (
            format!("title = \"a\"\nseed = 1.5\n{robot}{step}"),
            "2:8: error: `seed` of the wrong type (expected a whole number from 0, got `1.5`)",
        ),
        (
            format!("title = \"a\"\nstep = []\n{robot}"),
            "2:8: error: a task without steps",
        ),
        (
            format!("title = \"a\"\ncell = \"none.toml\"\n{step}"),
            "2:8: error: cannot read the cell (expected a cell file, got none.toml: error: no such file)",
        ),
        (
            format!("title = \"a\"\n[[cell.robot]]\nkind = \"irb\"\n{step}"),
            "3:8: error: unknown kind of robot (expected `irp6-track`, `irp6-postument`, `polycrank`, `irp6-arm`, \
             `conveyor`, `irp6-track-gripper`, `irp6-postument-gripper` or `rnt`, got `irb`)",
        ),
        (
            format!("title = \"a\"\n{robot}velocity_factor = 0\n{step}"),
            "4:19: error: `velocity_factor` out of range",
        ),
        (
            format!("title = \"a\"\n{robot}{robot}{step}"),
            "4:1: error: two robots of one name (expected unique names, got `irp6-track` again)",
        ),
        (
            format!("title = \"a\"\n{robot}mp_bus = \"x\"\n{step}"),
            "4:10: error: unknown bus (expected a [[bus]] of that name, got `x`)",
        ),
        (
            format!(
                "title = \"a\"\n{robot}drives = [{{ bus = \"b\", axes = [1, 1] }}]\n[[cell.bus]]\nname = \"b\"\nkind = \"classic\"\n{step}"
            ),
            "4:35: error: an axis on two buses (expected every axis once, got axis 1 again)",
        ),
        (
            format!("title = \"a\"\n{robot}fast_drives = true\n{step}"),
            "4:15: error: the fast profile on a classical bus (expected every bus of its drives to be FD, got irp6-track.0)",
        ),
        (
            format!(
                "title = \"a\"\n{robot}drives = [{{ bus = \"b\", axes = [1, 2] }}]\n[[cell.bus]]\nname = \"b\"\nkind = \"classic\"\n{step}"
            ),
            "4:10: error: an axis on no bus (expected axes 1 to 7, every one once, got no axis 3)",
        ),
        (
            format!(
                "title = \"a\"\n{robot}drives = [{{ bus = \"b\", axes = [8] }}]\n[[cell.bus]]\nname = \"b\"\nkind = \"classic\"\n{step}"
            ),
            "4:32: error: `axes` out of range (expected 1 to 7, got `8`)",
        ),
        (
            format!(
                "title = \"a\"\n{robot}drives = [{{ bus = \"b\", axes = [] }}]\n[[cell.bus]]\nname = \"b\"\nkind = \"classic\"\n{step}"
            ),
            "4:31: error: a group of drives without axes (expected at least one, got none)",
        ),
        (
            format!(
                "title = \"a\"\n{robot}[[cell.bus]]\nname = \"b\"\nkind = \"classic\"\nbit_rate_kbit_s = 2000\n{step}"
            ),
            "7:19: error: `bit_rate_kbit_s` out of range (expected 10 to 1000 kbit/s, got `2000`)",
        ),
        (
            format!(
                "title = \"a\"\n{robot}[[cell.bus]]\nname = \"b\"\nkind = \"classic\"\ndata_bit_rate_kbit_s = 2000\n{step}"
            ),
            "7:24: error: a data bit rate on classical CAN",
        ),
        (deep, "1:"),
    ];
    for (text, expected) in cases {
        let error = Task::parse(&text).expect_err(&text).to_string();
        assert!(
            error.starts_with(expected) && !error.contains('\n'),
            "{error}\n{expected}"
        );
    }
}

/// A folder of its own for a test.
fn folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("mrroc-task-{}-{name}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

#[test]
fn files_are_found_beside_the_task_and_judged() {
    let folder = folder("files");
    let write = |name: &str, text: &str| {
        let path = folder.join(name);
        std::fs::write(&path, text).unwrap();
        path
    };
    let node = "0.1 0.1 0.1 0.1 0.1 0.1 0.1\n0.1 0.1 0.1 0.1 0.1 0.1 0.1\n0 0 0 0 0 0 0\n";
    write("a.trj", &format!("JOINT\n1\n{node}"));
    write("b.trj", &format!("JOINT\n2\n{node}{node}"));
    write("bad.trj", "JOINT\n1\n0.1 x\n");
    write(
        "cell.toml",
        "[[robot]]\nkind = \"irp6-track\"\n[[robot]]\nkind = \"irp6-postument\"\n",
    );
    let text = "title = \"t\"\ncell = \"cell.toml\"\n[[step]]\ntrj = { irp6-postument = \"b.trj\", irp6-track = \"a.trj\" }\n";
    let path = write("task.toml", text);
    let cell = Cell::load_any(&path, &Files::on_disk()).unwrap();
    let own = Cell::load_any(&folder.join("cell.toml"), &Files::on_disk()).unwrap();
    assert_eq!(cell, own);
    let task = Task::load(&path, &Files::on_disk()).unwrap();
    assert_eq!(task.cell, cell);
    let Action::Replay { replays, .. } = &task.steps[0].action else {
        panic!("not a replay");
    };
    assert_eq!(replays[0].robot, 1);
    assert_eq!(replays[1].path, folder.join("a.trj"));
    assert_eq!(task.steps[0].name, "replay irp6-postument, irp6-track");
    assert_eq!(task.steps[0].line, 3);
    // seven columns for six axes
    assert_eq!(task.warnings().len(), 1);
    assert!(task.warnings()[0].contains("b.trj: line 3: column 7 skipped"));

    let loose = write("loose.toml", &format!("{text}coordination = \"loose\"\n"));
    let error = Task::load(&loose, &Files::on_disk())
        .unwrap_err()
        .to_string();
    assert!(error.ends_with("loose.toml:4:7: error: trajectories of different lengths in loose coordination (expected 2 nodes each, got 1)"), "{error}");

    let bad = write("bad.toml", &text.replace("a.trj", "bad.trj"));
    let error = Error::from(Task::load(&bad, &Files::on_disk()).unwrap_err());
    assert!(
        error
            .to_string()
            .contains("bad.trj:3:1: error: wrong number of values"),
        "{error}"
    );
    assert_eq!(error.exit_code(), exit::DATA);
    let gone = write("gone.toml", &text.replace("a.trj", "gone.trj"));
    let error = Error::from(Task::load(&gone, &Files::on_disk()).unwrap_err());
    assert!(error.to_string().contains("gone.toml:4:"), "{error}");
    assert_eq!(error.exit_code(), exit::NO_INPUT);

    let task = Task::replay(
        &folder.join("a.trj"),
        &Files::on_disk(),
        RobotKind::Irp6Track,
    )
    .unwrap();
    assert_eq!(task.title, "a.trj");
    assert_eq!(task.steps.len(), 2);
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn byte_order_marks_and_windows_line_ends_are_read() {
    let folder = folder("crlf");
    let path = folder.join("t.toml");
    let text = task("wait = { seconds = 1 }").replace('\n', "\r\n");
    std::fs::write(&path, format!("\u{feff}{text}")).unwrap();
    assert!(Task::load(&path, &Files::on_disk()).is_ok());
    std::fs::remove_dir_all(&folder).unwrap();
}

proptest! {
    #[test]
    fn any_text_is_a_task_or_one_line(text in "(title|seed|cell|step|\\[\\[|\\]\\]|=|\"|[a-z]|\n| |[0-9.]|\\PC){0,60}") {
        if let Err(error) = Task::parse(&text) {
            prop_assert!(!error.to_string().contains('\n'), "{}", error);
        }
    }

    #[test]
    fn any_value_anywhere_is_judged_without_panic(
        key in "(home|trj|move|wait|tight|regulator)",
        value in "(1|-1|1e999|nan|\"x\"|true|\\[\\]|\\[1, 2\\]|\\{\\}|\\[\\{\\}\\]|1979-05-27)",
    ) {
        let text = task(&format!("{key} = {value}"));
        prop_assert!(Task::parse(&text).is_err());
    }
}

#[test]
fn drives_are_named_once_each() {
    let cell = |identities: &str| {
        Cell::parse(&format!(
            "[[robot]]\nkind = \"irp6-postument\"\nfind_drives = true\nstored_setup = true\nidentities = [{identities}]"
        ))
    };
    let one = |axis: u8, serial: u32| {
        format!(
            "{{ axis = {axis}, vendor = 1, product = 402, revision = 0x10000, serial = {serial} }},"
        )
    };
    let robot = &cell(&(one(3, 17) + &one(1, 18))).unwrap().robots[0];
    let serials: Vec<_> = robot
        .identities
        .iter()
        .map(|(axis, who)| (*axis, who.serial))
        .collect();
    assert_eq!(serials, [(2, 17), (0, 18)]);
    assert!(robot.find_drives && robot.stored_setup);
    for (wrong, word) in [
        (one(0, 17), "1 to 6"),
        (one(7, 17), "1 to 6"),
        (one(3, 17) + &one(3, 18), "each once"),
        (one(3, 17) + &one(4, 17), "each once"),
        (
            "{ axis = 3, vendor = 1, product = 402, revision = 1 }".into(),
            "serial",
        ),
        (
            "{ axis = 3, vendor = 1, product = 402, revision = 1, serial = 4294967296 }".into(),
            "0xFFFFFFFF",
        ),
        (
            "{ axis = 3, vendor = 1, product = 402, revision = 1, serial = -1 }".into(),
            "0xFFFFFFFF",
        ),
    ] {
        let text = cell(&wrong).unwrap_err().to_string();
        assert!(text.contains(word), "{wrong}: {text}");
    }
}
