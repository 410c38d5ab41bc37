//! `mrroc node` against a node that is a process of its own: update, trial, confirmation, rollback; the first fault
//! over a restart.

use super::child::Process;
use mrroc_tests::binary::Scratch;
use serde_json::Value;

const ROBOT: &str = "conveyor";

/// The command to its end: exit code, the JSON it said, its last line on stderr.
fn mrroc(args: &[&str]) -> (Option<i32>, Value, String) {
    let mut process = Process::start("mrroc", args);
    let (status, said) = process.end();
    let value = process.events.last().cloned().unwrap_or_default();
    (
        status.code(),
        value,
        said.last().cloned().unwrap_or_default(),
    )
}

struct Bench {
    hub: String,
    state: String,
    _simulator: Process,
}

impl Bench {
    fn node(&self) -> Process {
        let args = [ROBOT, "--bus", &self.hub, "--state", &self.state, "--json"];
        let mut node = Process::start("mrroc-node", &args);
        node.event("ready", |_| true);
        node
    }

    /// `mrroc node …` as JSON, to be successful.
    fn ask(&self, args: &[&str]) -> Value {
        let tail = ["--bus", &self.hub, "--node", ROBOT, "--json"];
        let all: Vec<&str> = ["node"]
            .into_iter()
            .chain(args.iter().copied())
            .chain(tail)
            .collect();
        let (code, value, said) = mrroc(&all);
        assert_eq!(code, Some(0), "{args:?}: {said}");
        value
    }

    /// `mrroc node …`, to be refused in one line.
    fn refused(&self, args: &[&str], node: &str, code: i32, word: &str) {
        let tail = ["--bus", &self.hub, "--node", node];
        let all: Vec<&str> = ["node"]
            .into_iter()
            .chain(args.iter().copied())
            .chain(tail)
            .collect();
        let (got, _, said) = mrroc(&all);
        assert_eq!(got, Some(code), "{args:?}: {said}");
        assert!(
            said.starts_with("mrroc: ") && said.contains(word),
            "{args:?}: {said}"
        );
    }
}

/// Version, standing, reset cause, starts.
fn seen(info: &Value) -> [String; 4] {
    let text = |value: &Value| value.as_str().map_or_else(|| value.to_string(), Into::into);
    [
        text(&info["image"]["version"]),
        text(&info["image"]["standing"]),
        text(&info["reset"]["cause"]),
        text(&info["reset"]["boots"]),
    ]
}

fn end(mut node: Process) {
    node.interrupt();
    let (status, said) = node.end();
    assert_eq!(status.code(), Some(0), "{said:#?}");
}

#[test]
#[expect(
    clippy::too_many_lines,
    reason = "one story: starting the processes is dear"
)]
fn a_node_is_updated_rolled_back_and_keeps_its_first_fault_over_a_restart() {
    let files = Scratch::new("keeping");
    let mut simulator = Process::start("mrroc-hil-sim", &[ROBOT, "--bus", "hub:0", "--json"]);
    let port = simulator.event("ready", |_| true)["port"].as_u64().unwrap();
    let bench = Bench {
        hub: format!("hub:{port}"),
        state: files.path("state").to_str().unwrap().into(),
        _simulator: simulator,
    };
    let program = files.path("program");
    let bytes: Vec<u8> = (0..5000_u32)
        .map(|k| (k * 7 % 251).to_le_bytes()[0])
        .collect();
    std::fs::write(&program, bytes).unwrap();
    let image = |robot: &str, target: &str| {
        let path = files.path(&format!("{robot}-{target}"));
        let path = path.to_str().unwrap().to_owned();
        let program = program.to_str().unwrap();
        let args = [
            "node",
            "pack",
            program,
            "--robot",
            robot,
            "--target",
            target,
            "--image-version",
            "0.2.0",
            "-o",
            &path,
        ];
        let (code, _, said) = mrroc(&args);
        assert_eq!(code, Some(0), "{said}");
        path
    };
    let new = image(ROBOT, "host");

    let node = bench.node();
    assert_eq!(
        seen(&bench.ask(&["info"])),
        ["0.1.0", "Confirmed", "PowerOn", "1"]
    );
    // what cannot be is told apart, and changes nothing
    bench.refused(
        &["flash", &image("polycrank", "host")],
        ROBOT,
        78,
        "another robot",
    );
    bench.refused(
        &["flash", &image(ROBOT, "stm32g474")],
        ROBOT,
        78,
        "other hardware",
    );
    bench.refused(&["flash", program.to_str().unwrap()], ROBOT, 65, "MRROCIMG");
    bench.refused(&["flash", "/nowhere/image"], ROBOT, 66, "/nowhere/image");
    bench.refused(&["confirm"], ROBOT, 11, "not on trial");
    bench.refused(&["info"], "99", 69, "no answer");
    assert_eq!(bench.ask(&["faults"])["fault"], Value::Null);

    // sent, and not started before the next reset
    let sent = bench.ask(&["flash", &new]);
    assert_eq!(
        (&sent["slot"], &sent["phase"]),
        (&"B".into(), &"Activated".into())
    );
    assert_eq!(
        seen(&bench.ask(&["info"])),
        ["0.1.0", "Confirmed", "PowerOn", "1"]
    );
    let mut node = node;
    let started = bench.ask(&["restart"]);
    assert_eq!(
        (&started["cause"], &started["boots"]),
        (&"Software".into(), &2.into())
    );
    let again = node.event("ready", |_| true);
    assert_eq!(again["boots"], 2);
    assert_eq!(
        seen(&bench.ask(&["info"])),
        ["0.2.0", "Trial", "Software", "2"]
    );
    bench.refused(&["flash", &new], ROBOT, 11, "on trial");

    // not confirmed, and a process that vanishes: the old one is back
    node.kill();
    let node = bench.node();
    assert_eq!(
        seen(&bench.ask(&["info"])),
        ["0.1.0", "RolledBack", "Vanished", "3"]
    );
    bench.ask(&["flash", &new]);
    end(node);
    let mut node = bench.node();
    assert_eq!(bench.ask(&["confirm"])["confirmed"], true);
    bench.ask(&["restart"]);
    assert_eq!(
        seen(&bench.ask(&["info"])),
        ["0.2.0", "Confirmed", "Software", "5"]
    );

    // the first fault, over a restart
    let (_, _, said) = mrroc(&["stop", "--kind", "quick", "--bus", &bench.hub]);
    node.event("fault", |event| event["code"] == 14);
    let before = bench.ask(&["faults"]);
    assert_eq!(before["fault"]["code"], 14, "{said}");
    assert_eq!(before["boot"], 5);
    let samples = before["samples"].as_array().unwrap();
    assert!(samples.len() > 10, "{}", samples.len());
    let last = samples.last().unwrap();
    assert_eq!(last["fault"], 14);
    // the stop came by the bus, after a step and before the next
    let step = before["fault"]["step"].as_u64().unwrap();
    assert_eq!(last["step"], step + 1);
    node.kill();
    let _node = bench.node();
    let picture = files.path("faults.svg");
    let after = bench.ask(&["faults", "--plot", picture.to_str().unwrap()]);
    assert_eq!(after, before);
    assert!(
        std::fs::read_to_string(&picture)
            .unwrap()
            .contains("fault 14")
    );
    assert_eq!(bench.ask(&["reset-cause"])["cause"], "Vanished");
    assert_eq!(bench.ask(&["faults", "--clear"])["cleared"], true);
    assert_eq!(bench.ask(&["faults"])["fault"], Value::Null);
}
