//! Who may import whom: the layers of the workspace, checked against `cargo metadata`.

use crate::report::Findings;
use crate::shell::{cargo_stdout, root};
use anyhow::{Context, Result, anyhow};
use serde_json::Value;
use std::fmt::Write as _;
use std::path::Path;

/// What a package may import of the workspace.
#[derive(Clone, Copy)]
enum Imports {
    /// These packages only.
    Only(&'static [&'static str]),
    /// Every package but [`NEVER_IMPORTED`].
    Anything,
}

/// The rule of one package.
struct Rule {
    package: &'static str,
    folder: &'static str,
    imports: Imports,
    /// May it import packages from outside the workspace?
    external: bool,
    /// Must its library be `no_std` and forbid unsafe code?
    no_std: bool,
}

/// Packages nobody imports, not even for tests.
const NEVER_IMPORTED: &[&str] = &["mrroc-tests", "xtask"];

const AGENT: &str = "mrroc-agent";
const MOTION: &str = "mrroc-motion";
const ROBOTS: &str = "mrroc-robots";
const PROTOCOL: &str = "mrroc-protocol";
const BUS: &str = "mrroc-bus";
const PROCESS: &str = "mrroc-process";
const FIRMWARE: &str = "mrroc-firmware";
const BOARD: &str = "mrroc-board";
const HIL_SIM: &str = "mrroc-hil-sim";
const HOST: &str = "mrroc-host";

/// The table. Dependencies of tests (dev-dependencies) are free, save for [`NEVER_IMPORTED`].
const RULES: &[Rule] = &[
    pure(AGENT, "agent", &[], false),
    pure(MOTION, "motion", &[], true),
    pure(ROBOTS, "robots", &[MOTION], true),
    pure(PROTOCOL, "protocol", &[], true),
    pure(
        FIRMWARE,
        "firmware",
        &[AGENT, MOTION, ROBOTS, PROTOCOL],
        true,
    ),
    pure(
        BOARD,
        "firmware/boards/common",
        &[PROTOCOL, ROBOTS, FIRMWARE],
        true,
    ),
    pure(
        "mrroc-mcu-generator",
        "examples/mcu-generator",
        &[AGENT, ROBOTS, PROTOCOL, FIRMWARE, BOARD],
        true,
    ),
    rim(BUS, "bus", Imports::Only(&[PROTOCOL])),
    rim(PROCESS, "process", Imports::Only(&[])),
    rim(
        "mrroc-node",
        "firmware/node",
        Imports::Only(&[AGENT, MOTION, ROBOTS, PROTOCOL, BUS, PROCESS, FIRMWARE]),
    ),
    rim(
        HIL_SIM,
        "hil-sim",
        Imports::Only(&[AGENT, MOTION, ROBOTS, PROTOCOL, BUS, PROCESS, FIRMWARE]),
    ),
    rim(
        HOST,
        "host",
        Imports::Only(&[AGENT, MOTION, ROBOTS, PROTOCOL, BUS, PROCESS]),
    ),
    rim(
        "mrroc",
        "host/cli",
        Imports::Only(&[
            AGENT, MOTION, ROBOTS, PROTOCOL, BUS, PROCESS, FIRMWARE, HIL_SIM, HOST,
        ]),
    ),
    rim("mrroc-examples", "examples", Imports::Anything),
    rim("mrroc-tests", "tests", Imports::Anything),
    rim("xtask", "xtask", Imports::Only(&[])),
];

/// A crate that also runs on the microcontroller.
const fn pure(
    package: &'static str,
    folder: &'static str,
    imports: &'static [&'static str],
    external: bool,
) -> Rule {
    Rule {
        package,
        folder,
        imports: Imports::Only(imports),
        external,
        no_std: true,
    }
}

/// A crate that needs an operating system.
const fn rim(package: &'static str, folder: &'static str, imports: Imports) -> Rule {
    Rule {
        package,
        folder,
        imports,
        external: true,
        no_std: false,
    }
}

/// The packages that must build without the standard library.
pub(crate) fn no_std_packages() -> impl Iterator<Item = &'static str> {
    RULES.iter().filter(|r| r.no_std).map(|r| r.package)
}

/// Checks the workspace against the table.
pub(crate) fn check() -> Result<Findings> {
    // Without resolving, the declared dependencies are there and no registry is needed.
    let arguments = [
        "metadata",
        "--format-version",
        "1",
        "--offline",
        "--no-deps",
    ];
    let metadata: Value = serde_json::from_str(&cargo_stdout(&arguments)?)?;
    let source =
        |path: &Path| std::fs::read_to_string(path).with_context(|| format!("{}", path.display()));
    check_metadata(&metadata, &root(), &source)
}

fn check_metadata(
    metadata: &Value,
    root: &Path,
    source: &dyn Fn(&Path) -> Result<String>,
) -> Result<Findings> {
    let packages = array(metadata, "packages")?;
    let mut findings = vec![];
    for rule in RULES {
        if !packages.iter().any(|p| p["name"] == rule.package) {
            findings.push(format!(
                "{} is in the table but not in the workspace",
                rule.package
            ));
        }
    }
    for package in packages {
        let name = string(package, "name")?;
        let Some(rule) = RULES.iter().find(|r| r.package == name) else {
            findings.push(format!("{name} is not in the table (xtask/src/deps.rs)"));
            continue;
        };
        let manifest = root.join(rule.folder).join("Cargo.toml");
        if Path::new(string(package, "manifest_path")?) != manifest {
            findings.push(format!("{name} is not in {}", rule.folder));
        }
        for dependency in array(package, "dependencies")? {
            findings.extend(forbidden(rule, dependency)?);
        }
        if rule.no_std {
            findings.extend(missing_attributes(name, package, source)?);
        }
    }
    Ok(findings)
}

/// What the table says against one dependency, if anything.
fn forbidden(rule: &Rule, dependency: &Value) -> Result<Option<String>> {
    let name = string(dependency, "name")?;
    let package = rule.package;
    if NEVER_IMPORTED.contains(&name) {
        return Ok(Some(format!("{package} imports {name}; nothing may")));
    }
    if dependency["kind"] == "dev" {
        return Ok(None);
    }
    let of_workspace = RULES.iter().any(|r| r.package == name);
    Ok(match (of_workspace, rule.imports) {
        (false, _) if !rule.external => Some(format!(
            "{package} depends on {name}; it may have no dependency at all"
        )),
        (true, Imports::Only(allowed)) if !allowed.contains(&name) => Some(format!(
            "{package} imports {name}; it may import: {}",
            list(allowed)
        )),
        (false, _) | (true, Imports::Only(_) | Imports::Anything) => None,
    })
}

/// The attributes a `no_std` library lacks.
fn missing_attributes(
    name: &str,
    package: &Value,
    source: &dyn Fn(&Path) -> Result<String>,
) -> Result<Findings> {
    let library = array(package, "targets")?.iter().find(|t| {
        t["kind"]
            .as_array()
            .is_some_and(|kinds| kinds.iter().any(|k| k == "lib"))
    });
    let Some(library) = library else {
        return Ok(vec![format!("{name} has no library")]);
    };
    let text = source(Path::new(string(library, "src_path")?))?;
    Ok(["#![no_std]", "#![forbid(unsafe_code)]"]
        .into_iter()
        .filter(|attribute| !text.lines().any(|line| line.trim() == *attribute))
        .map(|attribute| format!("{name}: lib.rs lacks {attribute}"))
        .collect())
}

/// The table as Markdown.
pub(crate) fn markdown() -> String {
    let mut out = String::from("| package | folder | may import | std |\n|---|---|---|---|\n");
    for rule in RULES {
        let imports = match rule.imports {
            Imports::Only([]) if !rule.external => "nothing at all".to_owned(),
            Imports::Only(allowed) => list(allowed),
            Imports::Anything => format!("all but {}", NEVER_IMPORTED.join(", ")),
        };
        let std = if rule.no_std { "no" } else { "yes" };
        // Writing to a string cannot fail.
        let _ = writeln!(
            out,
            "| `{}` | `{}` | {imports} | {std} |",
            rule.package, rule.folder
        );
    }
    out
}

fn list(packages: &[&str]) -> String {
    if packages.is_empty() {
        "no crate of ours".to_owned()
    } else {
        packages.join(", ")
    }
}

fn array<'a>(value: &'a Value, key: &str) -> Result<&'a Vec<Value>> {
    value[key]
        .as_array()
        .ok_or_else(|| anyhow!("cargo metadata: no list `{key}`"))
}

fn string<'a>(value: &'a Value, key: &str) -> Result<&'a str> {
    value[key]
        .as_str()
        .ok_or_else(|| anyhow!("cargo metadata: no string `{key}`"))
}

#[cfg(test)]
mod test {
    use super::*;
    use serde_json::json;

    const GOOD: &str = "//! Doc.\n#![no_std]\n#![forbid(unsafe_code)]\n";

    /// A workspace that obeys the table and imports all it may.
    fn workspace() -> Value {
        let packages: Vec<Value> = RULES
            .iter()
            .map(|rule| {
                let dependencies: Vec<Value> = match rule.imports {
                    Imports::Only(allowed) => allowed.iter().map(|a| import(a)).collect(),
                    Imports::Anything => vec![import(HOST)],
                };
                json!({
                    "name": rule.package,
                    "manifest_path": Path::new("/r").join(rule.folder).join("Cargo.toml"),
                    "dependencies": dependencies,
                    "targets": [{ "kind": ["lib"], "src_path": format!("/r/{}", rule.package) }],
                })
            })
            .collect();
        json!({ "packages": packages })
    }

    fn import(name: &str) -> Value {
        json!({ "name": name, "kind": null })
    }

    fn findings(metadata: &Value, text: &str) -> Findings {
        check_metadata(metadata, Path::new("/r"), &|_| Ok(text.to_owned())).unwrap()
    }

    fn with(package: &str, dependency: Value) -> Findings {
        let mut metadata = workspace();
        let packages = metadata["packages"].as_array_mut().unwrap();
        let found = packages.iter_mut().find(|p| p["name"] == package).unwrap();
        found["dependencies"]
            .as_array_mut()
            .unwrap()
            .push(dependency);
        findings(&metadata, GOOD)
    }

    #[test]
    fn a_workspace_by_the_table_passes() {
        assert_eq!(findings(&workspace(), GOOD), [""; 0]);
    }

    #[test]
    fn the_table_has_no_cycle() {
        // a package imports only what a list of layers has before it
        let layers = [
            AGENT,
            MOTION,
            ROBOTS,
            PROTOCOL,
            BUS,
            PROCESS,
            FIRMWARE,
            BOARD,
            "mrroc-mcu-generator",
            "mrroc-node",
            HIL_SIM,
            HOST,
            "mrroc",
        ];
        for rule in RULES {
            if let Imports::Only(allowed) = rule.imports {
                let own = layers
                    .iter()
                    .position(|l| *l == rule.package)
                    .unwrap_or(layers.len());
                for import in allowed {
                    assert!(layers.iter().position(|l| l == import).unwrap() < own);
                }
            }
        }
    }

    #[test]
    fn nothing_but_the_operators_command_tests_and_examples_imports_the_host() {
        for rule in RULES {
            let refused = !with(rule.package, import(HOST)).is_empty();
            let may = ["mrroc", "mrroc-tests", "mrroc-examples"].contains(&rule.package);
            assert_eq!(refused, !may, "{}", rule.package);
        }
    }

    #[test]
    fn forbidden_imports_are_named() {
        let refused = with(HOST, import(FIRMWARE));
        assert_eq!(refused.len(), 1);
        assert!(refused[0].starts_with("mrroc-host imports mrroc-firmware; it may import: "));
        assert_eq!(
            with(AGENT, import("serde")),
            ["mrroc-agent depends on serde; it may have no dependency at all"]
        );
        assert_eq!(with(MOTION, import("serde")), [""; 0]);
        assert_eq!(
            with(PROTOCOL, json!({ "name": MOTION, "kind": "build" })).len(),
            1
        );
    }

    #[test]
    fn tests_may_import_more_but_never_the_tests_crate() {
        assert_eq!(
            with(AGENT, json!({ "name": "proptest", "kind": "dev" })),
            [""; 0]
        );
        assert_eq!(
            with(HIL_SIM, json!({ "name": "mrroc-tests", "kind": "dev" })),
            ["mrroc-hil-sim imports mrroc-tests; nothing may"]
        );
    }

    #[test]
    fn unknown_missing_and_moved_packages_are_found() {
        let mut metadata = workspace();
        metadata["packages"][0]["name"] = json!("newcomer");
        assert_eq!(
            findings(&metadata, GOOD),
            [
                "mrroc-agent is in the table but not in the workspace",
                "newcomer is not in the table (xtask/src/deps.rs)"
            ]
        );
        let mut metadata = workspace();
        metadata["packages"][0]["manifest_path"] = json!("/r/elsewhere/Cargo.toml");
        assert_eq!(findings(&metadata, GOOD), ["mrroc-agent is not in agent"]);
    }

    #[test]
    fn both_attributes_are_asked_for_and_a_comment_is_none() {
        let lacking = findings(&workspace(), "//! #![no_std]\n#![forbid(unsafe_code)]\n");
        assert_eq!(lacking.len(), no_std_packages().count());
        assert!(
            lacking
                .iter()
                .all(|f| f.ends_with("lib.rs lacks #![no_std]"))
        );
        assert_eq!(
            findings(&workspace(), "#![no_std]\n").len(),
            no_std_packages().count()
        );
    }

    #[test]
    fn the_printed_table_has_a_row_a_package() {
        let table = markdown();
        assert_eq!(table.lines().count(), RULES.len() + 2);
        assert!(table.contains("| `mrroc-agent` | `agent` | nothing at all | no |\n"));
        assert!(table.contains("| `mrroc-bus` | `bus` | mrroc-protocol | yes |\n"));
    }
}
