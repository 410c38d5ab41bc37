//! Compiles Ruckig's C++ sources, as fetched by cargo, with the loops of `src/ruckig.cpp`.

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;

/// What the planner of positions needs: all but the client of Ruckig's cloud.
const SOURCES: &[&str] = &[
    "brake",
    "position_first_step1",
    "position_first_step2",
    "position_second_step1",
    "position_second_step2",
    "position_third_step1",
    "position_third_step2",
    "velocity_second_step1",
    "velocity_second_step2",
    "velocity_third_step1",
    "velocity_third_step2",
];
/// Those of Ruckig's own release build.
const FLAGS: &[&str] = &["-std=c++20", "-O3", "-DNDEBUG"];

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-changed=src/ruckig.cpp");
    println!("cargo:rerun-if-changed=Cargo.lock");
    let packages = packages();
    let ruckig = folder(&packages, "ruckig");
    let mut build = cc::Build::new();
    build
        .cpp(true)
        .no_default_flags(true)
        .warnings(false)
        .include(ruckig.join("include"))
        .file("src/ruckig.cpp")
        .files(
            SOURCES
                .iter()
                .map(|s| ruckig.join(format!("src/ruckig/{s}.cpp"))),
        );
    for flag in FLAGS {
        build.flag(flag);
    }
    // position-independent, as a Rust executable is
    build.flag("-fPIC").compile("ruckig_peer");

    let compiler = build.get_compiler();
    let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let about = [
        ("RUCKIG", version(&packages, "ruckig")),
        ("RSRUCKIG", version(&packages, "rsruckig")),
        ("CXX", first_line(compiler.path())),
        ("CXX_FLAGS", FLAGS.join(" ")),
        ("RUSTC", first_line(Path::new(&rustc))),
    ];
    for (name, text) in about {
        println!("cargo:rustc-env=PEERS_{name}={text}");
    }
}

/// Every package of the lock file; cargo fetches what is not there yet.
fn packages() -> Vec<Value> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let output = Command::new(cargo)
        .args(["metadata", "--format-version", "1"])
        .output()
        .expect("cargo starts");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "cargo metadata: {errors}");
    let mut metadata: Value = serde_json::from_slice(&output.stdout).expect("metadata is JSON");
    match metadata["packages"].take() {
        Value::Array(packages) => packages,
        other => panic!("no packages in the metadata but {other}"),
    }
}

fn package<'a>(packages: &'a [Value], name: &str) -> &'a Value {
    let found = packages.iter().find(|p| p["name"] == name);
    found.unwrap_or_else(|| panic!("no package {name}"))
}

fn folder(packages: &[Value], name: &str) -> PathBuf {
    let manifest = package(packages, name)["manifest_path"].as_str();
    let manifest = Path::new(manifest.expect("a path"));
    manifest.parent().expect("a folder").into()
}

fn version(packages: &[Value], name: &str) -> String {
    let version = package(packages, name)["version"].as_str();
    version.expect("a version").into()
}

/// The first line of what a compiler says of itself.
fn first_line(program: &Path) -> String {
    let output = Command::new(program).arg("--version").output();
    let text = output.map(|o| o.stdout).unwrap_or_default();
    let text = String::from_utf8_lossy(&text);
    text.lines().next().unwrap_or("unknown").to_owned()
}
