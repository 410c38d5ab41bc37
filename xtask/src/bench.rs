//! What things cost: `cargo xtask bench` prints the table the README quotes.
//!
//! | module | one line |
//! |---|---|
//! | [`workload`] | a step, a message, a frame: time, and instructions where valgrind is there |
//! | [`job`] | the main job: how much faster than real time it is simulated |
//! | [`table`] | what is printed |
//!
//! A missed target is no failure: it depends on the machine, and the table says it.

mod job;
mod table;
mod workload;

use crate::report::Findings;
use crate::shell::cargo;
use anyhow::{Context, Result, anyhow, ensure};
use serde_json::Value;
use std::path::PathBuf;
use std::process::Stdio;

/// Measures everything and prints it, as Markdown or as one JSON object.
pub(crate) fn run(json: bool) -> Result<Findings> {
    let cost = built(
        &["bench", "-p", "mrroc-tests", "--bench", "cost", "--no-run"],
        "cost",
    )?;
    let mrroc = built(&["build", "--release", "-p", "mrroc"], "mrroc")?;
    let measured = table::Measured {
        machine: table::Machine::this()?,
        workloads: workload::measure(&cost)?,
        job: job::measure(&mrroc)?,
    };
    if json {
        println!("{:#}", measured.json());
    } else {
        print!("{}", measured.markdown());
    }
    Ok(vec![])
}

/// Builds something and says where it is.
pub(crate) fn built(arguments: &[&str], name: &str) -> Result<PathBuf> {
    let line = arguments.join(" ");
    let output = cargo(arguments)
        .arg("--message-format=json-render-diagnostics")
        .stderr(Stdio::inherit())
        .output()
        .with_context(|| format!("cannot start cargo {line}"))?;
    ensure!(output.status.success(), "cargo {line}: {}", output.status);
    executable(&String::from_utf8_lossy(&output.stdout), name)
        .ok_or_else(|| anyhow!("cargo {line} built no {name}"))
}

/// The executable of a target in cargo's messages.
fn executable(messages: &str, name: &str) -> Option<PathBuf> {
    messages
        .lines()
        .filter_map(|line| serde_json::from_str::<Value>(line).ok())
        .filter(|message| message.pointer("/target/name").and_then(Value::as_str) == Some(name))
        .find_map(|message| Some(message.get("executable")?.as_str()?.into()))
}

#[cfg(test)]
mod test {
    use super::executable;
    use std::path::PathBuf;

    #[test]
    fn the_executable_is_that_of_the_target_asked_for() {
        let messages = r#"{"target":{"name":"other"},"executable":"/x/other"}
not json
{"target":{"name":"cost"},"executable":null}
{"target":{"name":"cost"},"executable":"/x/cost-1"}"#;
        assert_eq!(
            executable(messages, "cost"),
            Some(PathBuf::from("/x/cost-1"))
        );
        assert_eq!(executable(messages, "none"), None);
    }
}
