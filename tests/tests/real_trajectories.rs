//! Taught files of the original, replayed as they are: what the robots can do they do, and what they
//! cannot is refused in one line before anything moves.
//!
//! The files are not ours and so not here: `MRROC_TRJ_SAMPLES` names their directory. Without it, and
//! without `../shared/data/trj`, there is nothing to test.

use mrroc_tests::binary::{self, Scratch};
use mrroc_tests::workspace;
use std::path::PathBuf;

const TRACK: &str = "irp6-track";
const POSTUMENT: &str = "irp6-postument";

/// What must become of a file.
#[derive(Clone, Copy, Debug)]
enum Fate {
    /// It is replayed.
    Done,
    /// Something of it is outside the limits: exit code 11, and a word of the reason.
    Refused(&'static str),
    /// It is for another robot: exit code 65.
    Malformed(&'static str),
}

use Fate::{Done, Malformed, Refused};

const EXPECTED: &[(&str, &str, Fate)] = &[
    ("ball-irp6ot_init.trj", TRACK, Done),
    ("ball-irp6ot_init.trj", POSTUMENT, Refused("lower arm")),
    // T would leave its motor's range by 6 rad
    (
        "ball-irp6p_init.trj",
        POSTUMENT,
        Refused("motor of axis 4 (T) would be -76.0"),
    ),
    (
        "ball-irp6p_init.trj",
        TRACK,
        Refused("joint of axis 1 (track) would be -1.5708"),
    ),
    ("block_move-block_reaching.trj", TRACK, Done),
    ("block_move-block_reaching.trj", POSTUMENT, Done),
    ("block_move-build.trj", TRACK, Done),
    // from where homing ends, N has no room for a turn of 0.3 rad
    (
        "block_move-build.trj",
        POSTUMENT,
        Refused("(N) would be -2.88"),
    ),
    ("conveyor.trj", TRACK, Malformed("expected 7 values, got 1")),
    (
        "conveyor.trj",
        POSTUMENT,
        Malformed("expected 6 values, got 1"),
    ),
    ("draughts-pawn_moving.trj", TRACK, Done),
    ("draughts-pawn_moving.trj", POSTUMENT, Done),
    (
        "polycrank.trj",
        TRACK,
        Refused("joint of axis 1 (track) would be 2.35393"),
    ),
    ("polycrank.trj", POSTUMENT, Refused("lower arm")),
    ("rcsc-irp6ot_sm_ap_1.trj", TRACK, Done),
    ("rcsc-irp6ot_sm_ap_1.trj", POSTUMENT, Refused("lower arm")),
    ("rcsc-irp6ot_sm_fchange_ap_cl_0_phase_1.trj", TRACK, Done),
    ("rcsc-irp6p_sm_ap_1.trj", POSTUMENT, Done),
    (
        "rcsc-irp6p_sm_ap_1.trj",
        TRACK,
        Malformed("expected 7 values, got 6"),
    ),
    ("rcsc-irp6p_sm_fchange_ap_cl_0_phase_1.trj", POSTUMENT, Done),
    ("trajectory.trj", POSTUMENT, Done),
    (
        "trajectory.trj",
        TRACK,
        Malformed("expected 7 values, got 6"),
    ),
];

fn samples() -> PathBuf {
    std::env::var_os("MRROC_TRJ_SAMPLES")
        .map_or_else(|| workspace().join("../shared/data/trj"), PathBuf::from)
}

#[test]
fn taught_files_are_replayed_or_refused() {
    let samples = samples();
    if !samples.is_dir() {
        println!("skipped: no taught files in {}", samples.display());
        return;
    }
    let scratch = Scratch::new("real-trajectories");
    for (file, robot, fate) in EXPECTED {
        let path = samples.join(file);
        if !path.is_file() {
            println!("skipped: no {file}");
            continue;
        }
        let record = scratch.path("record.log");
        let _ = std::fs::remove_file(&record);
        let mut arguments = vec!["run".into(), path.into_os_string()];
        arguments.extend(["--robot", robot, "--json", "-q"].map(std::ffi::OsString::from));
        if !matches!(fate, Done) {
            arguments.extend(["--record".into(), record.clone().into_os_string()]);
        }
        let output = binary::run(arguments);
        let what = format!("{file} on {robot}: {output:?}");
        // warnings tell of columns and nodes that are skipped; then comes at most the error
        let warning = |line: &&str| line.starts_with("mrroc: warning: ");
        let errors: Vec<&str> = output
            .stderr
            .lines()
            .filter(|line| !warning(line))
            .collect();
        match fate {
            Done => {
                assert_eq!(output.code, Some(0), "{what}");
                assert_eq!(errors, Vec::<&str>::new(), "{what}");
                let summary = output.json();
                let done = &summary["robots"][0];
                assert_eq!(summary["ok"], true, "{what}");
                assert_eq!(
                    (&done["faults"], &done["limit_violations"]),
                    (&0.into(), &0.into())
                );
                // on the straight way between two poses, in the space that the file names
                let error = done["setpoint_path_error_max_m"].as_f64().unwrap();
                assert!(error < 1e-5, "{what}");
            }
            Refused(word) | Malformed(word) => {
                let code = if matches!(fate, Refused(_)) { 11 } else { 65 };
                assert_eq!(output.code, Some(code), "{what}");
                assert_eq!(errors.len(), 1, "{what}");
                assert!(
                    errors[0].contains(file) && errors[0].contains(word),
                    "{what}"
                );
                assert!(!mrroc_tests::watch::ever_had_torque(&record), "{what}");
            }
        }
    }
}
