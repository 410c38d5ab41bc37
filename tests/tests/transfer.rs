//! The Polycrank's fast transfer, and the trajectories that were taught to the real one.

use mrroc_tests::binary::{self, Scratch};
use mrroc_tests::workspace;
use std::path::Path;

fn sound(task: &Path) -> serde_json::Value {
    let output = binary::run([
        "run".as_ref(),
        task.as_os_str(),
        "--json".as_ref(),
        "-q".as_ref(),
    ]);
    assert_eq!(output.code, Some(0), "{output:?}");
    let summary = output.json();
    for robot in summary["robots"].as_array().unwrap() {
        assert_eq!(robot["limit_violations"], 0, "{robot}");
        assert_eq!(robot["faults"], 0, "{robot}");
    }
    summary
}

#[test]
fn the_transfer_goes_on_round_and_never_back() {
    let summary = sound(&workspace().join("tasks/fast-transfer.toml"));
    let steps = summary["steps"].as_array().unwrap();
    let took = |name: &str| {
        let step = steps.iter().find(|step| step["name"] == name).unwrap();
        step["duration_s"].as_f64().unwrap()
    };
    // 7.4 rad at 5.04 rad/s, the share that a plan may use of 6.3, and 1.5 times that in all
    assert!((1.4..2.3).contains(&took("swing")), "{}", took("swing"));
    assert!(took("on to the source") < took("swing"));
}

#[test]
fn taught_trajectories_of_the_real_robot_are_replayed() {
    let files = Scratch::new("taught");
    for name in ["polycrank.trj", "polycrank2.trj"] {
        let taught = workspace().join("../shared/data/trj").join(name);
        if !taught.is_file() {
            eprintln!("{} is not here: skipped", taught.display());
            continue;
        }
        let task = files.path("job.toml");
        let text = format!(
            "title = \"taught\"\ncell = {{ robot = [{{ kind = \"polycrank\", velocity_factor = 1.0 }}] }}\n\
             [[step]]\nhome = [\"polycrank\"]\n[[step]]\ntrj = {{ polycrank = {:?} }}\n",
            taught.to_str().unwrap()
        );
        std::fs::write(&task, text).unwrap();
        sound(&task);
    }
}
