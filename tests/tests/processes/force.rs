//! An arm that feels: simulator, node and `mrroc` as processes, and a task that ends at a force.

use super::child::Process;
use super::coordinator::Coordinator;
use bus::Bus;
use host::mp::arm::{arm, motor_angles};
use mrroc_tests::binary::Scratch;
use mrroc_tests::stalls::in_real_time;
use protocol::message::Feedback;
use protocol::transfer::Mtu;
use robots::RobotKind;
use std::time::Duration;

/// The face of the surface of the task, m above the base.
const SURFACE_M: f64 = 0.261;
/// The surface of the task, for the simulator.
const SURFACE: &str = "irp6-postument:0.92,0,0.261:0,0,1:0.1:1e4";
/// Homing, and some seconds.
const TASK: Duration = Duration::from_secs(300);

/// The task as far as the surface: it ends where it touches.
fn task(scratch: &Scratch) -> std::path::PathBuf {
    let text =
        std::fs::read_to_string(mrroc_tests::workspace().join("tests/data/until-force.toml"));
    let text = text.unwrap();
    let (until, _) = text.split_once("[[step]]\nname = \"up\"").unwrap();
    let file = scratch.path("task.toml");
    std::fs::write(&file, until).unwrap();
    file
}

/// How high the tip of the tool is, m above the base.
fn tip_m(feedback: &Feedback) -> f64 {
    let arm = arm(RobotKind::Irp6Postument);
    let motors = motor_angles(arm.axes(), &feedback.actual).unwrap();
    let joints = arm.joints(&motors).unwrap();
    let tool = arm.forward(&joints).unwrap() * arm.default_tool();
    tool.position.z
}

/// Runs the task against robots at this place, whose sensor is on this drive bus; `join` is another way there.
pub(crate) fn a_task_ends_at_the_surface(
    place: &str,
    bus: &str,
    join: impl FnOnce(&str) -> (Box<dyn Bus>, Mtu),
) {
    let (kind, sensor) = ("irp6-postument", format!("irp6-postument.{bus}"));
    let arguments = [
        kind,
        "--bus",
        place,
        "--json",
        "--force-bus",
        &sensor,
        "--surface",
        SURFACE,
    ];
    let mut simulator = Process::start("mrroc-hil-sim", &arguments);
    let ready = simulator.event("ready", |_| true);
    assert_eq!(ready["robots"][0]["force_bus"].to_string(), bus);
    let place = ready["bus"].as_str().unwrap();
    let arguments = [kind, "--bus", place, "--json", "--force-bus", bus];
    let mut node = Process::start("mrroc-node", &arguments);
    node.event("ready", |_| true);
    let scratch = Scratch::new(&format!("force-between-{bus}"));
    let task = task(&scratch);
    let arguments = [
        "run",
        task.to_str().unwrap(),
        "--bus",
        place,
        "--json",
        "-q",
    ];
    let mut master = Process::start("mrroc", &arguments);
    let (status, said) = master.end_within(TASK);
    assert_eq!(status.code(), Some(0), "{said:#?} {:#?}", node.said());
    let watched = place.strip_prefix("can:").unwrap_or(&sensor);
    let arguments = [
        "monitor",
        "--bus",
        place,
        "--json",
        "--seconds",
        "2",
        "--force-bus",
        watched,
    ];
    let mut monitor = Process::start("mrroc", &arguments);
    let (status, said) = monitor.end();
    assert_eq!(status.code(), Some(0), "{said:#?}");
    let told = |key: &str| {
        monitor
            .events
            .iter()
            .rev()
            .find(|told| !told[key].is_null())
    };
    let read = |told: &serde_json::Value, key: &str| -> f64 {
        let values = told[key].as_array().unwrap().iter();
        libm::sqrt(values.map(|x| x.as_f64().unwrap()).map(|x| x * x).sum())
    };
    let (of_node, of_sensor) = (told("joints").unwrap(), told("moment_nm").unwrap());
    // weight and bias, and what presses: the same by both ways, but for the noise of two samples
    let (node_n, sensor_n) = (read(of_node, "force_n"), read(of_sensor, "force_n"));
    assert!((node_n - sensor_n).abs() < 0.5, "{node_n} {sensor_n}");
    assert!(read(of_sensor, "moment_nm") > 0.1, "{of_sensor}");
    let (bus, mtu) = join(place);
    let mut looks = Coordinator::on(bus, mtu, &[(2, 6)]);
    looks.wait("felt", |robot| {
        robot.feedback.as_ref().is_some_and(|f| f.force_n.is_some())
    });
    let tip = tip_m(looks.robots[0].feedback.as_ref().unwrap());
    // 10 N in 1e4 N/m are 1 mm; as much again until it rests, and what 5 N of its own weight let the arm give when
    // brakes take over. Without the force it would be 34 mm below
    assert!(
        (SURFACE_M - 0.003..SURFACE_M - 0.0005).contains(&tip),
        "{tip} m"
    );
}

#[test]
fn an_arm_on_a_hub_stops_at_a_force() {
    in_real_time(|| {
        a_task_ends_at_the_surface("hub:0", "1", |hub| {
            let port = hub.rsplit(':').next().unwrap().parse().unwrap();
            (Coordinator::hub(port), Mtu::Classic)
        });
    });
}

#[test]
fn a_node_says_in_one_line_where_a_force_sensor_cannot_be() {
    for (arguments, word) in [
        (
            ["conveyor", "--bus", "hub", "--force-bus", "0"],
            "irp6-track",
        ),
        (
            ["irp6-postument", "--bus", "hub", "--force-bus", "0"],
            "5 drives",
        ),
        (
            ["irp6-track", "--bus", "hub", "--force-bus", "2"],
            "below 2",
        ),
        (
            ["irp6-track", "--bus", "can:can0", "--force-bus", "1"],
            "one wire",
        ),
    ] {
        let (status, said) = Process::start("mrroc-node", &arguments).end();
        assert_eq!(status.code(), Some(64), "{said:#?}");
        assert!(said.len() == 1 && said[0].contains(word), "{said:#?}");
    }
}
