//! `docs/wire.md` and the types say the same.

use protocol::codec::{MAX_MESSAGE, Payload};
use protocol::e2e::{HEADER, RESYNC};
use protocol::fault::{Cause, Reaction};
use protocol::id::{NodeId, Service, Subject};
use protocol::maintenance::{IMAGE_CHUNK, MaintenanceReply, MaintenanceRequest, SAMPLE_BATCH};
use protocol::message::{Command, DemandTrace, Event, Feedback, Reply, Request, StopAll, TimeSync};
use protocol::schema::PROTOCOL;
use protocol::transfer::{MAX_PADDING, MAX_TRANSFER};

fn spec() -> String {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/wire.md");
    std::fs::read_to_string(path).unwrap()
}

fn says(spec: &str, what: &str) {
    assert!(spec.contains(what), "docs/wire.md does not say {what:?}");
}

#[test]
fn every_identifier_is_in_the_table() {
    let spec = spec();
    let subjects = [
        ("Feedback", Subject::FEEDBACK),
        ("DemandTrace", Subject::DEMAND_TRACE),
        ("Event", Subject::EVENT),
        ("StopAll", Subject::STOP_ALL),
        ("TimeSync", Subject::TIME_SYNC),
        ("Heartbeat", Subject::HEARTBEAT),
    ];
    for (name, subject) in subjects {
        says(&spec, &format!("| `{name}` | subject {} |", subject.get()));
    }
    says(
        &spec,
        &format!("| `Command` | subject {} + n |", Subject::COMMAND_BASE),
    );
    says(
        &spec,
        &format!(
            "| `Request`, `Reply` | service {} |",
            Service::REQUEST.get()
        ),
    );
    says(
        &spec,
        &format!(
            "| `MaintenanceRequest`, `MaintenanceReply` | service {} |",
            Service::MAINTENANCE.get()
        ),
    );
    says(
        &spec,
        &format!("| `GetInfo` | service {} |", Service::GET_INFO.get()),
    );
    says(
        &spec,
        &format!("coordinating process (MP) | {}", NodeId::MP),
    );
    says(
        &spec,
        &format!("effector E_j | {} + j", NodeId::EFFECTOR_BASE),
    );
}

#[test]
fn every_size_is_in_the_table() {
    fn row<M: Payload>(spec: &str) {
        says(spec, &format!("| `{}` | {} |", M::NAME, M::MAX));
    }
    let spec = spec();
    row::<Command>(&spec);
    row::<Feedback>(&spec);
    row::<DemandTrace>(&spec);
    row::<Event>(&spec);
    row::<StopAll>(&spec);
    row::<TimeSync>(&spec);
    row::<Request>(&spec);
    row::<Reply>(&spec);
    row::<MaintenanceRequest>(&spec);
    row::<MaintenanceReply>(&spec);
    says(&spec, &format!("at most {IMAGE_CHUNK} bytes"));
    says(&spec, &format!("at most {SAMPLE_BATCH} `Sample`"));
    says(
        &spec,
        &format!("the longest message has {MAX_MESSAGE} bytes"),
    );
    says(&spec, &format!("{MAX_TRANSFER} bytes"));
    says(&spec, &format!("at most {MAX_PADDING} zero bytes"));
    says(&spec, &format!("{HEADER} bytes"));
    says(&spec, &format!("{} ms", RESYNC.0 / 1000));
    says(&spec, &format!("version {}.{}", PROTOCOL.0, PROTOCOL.1));
}

/// Field by field, from the source of the messages: every `pub` item, field and variant is named.
#[test]
fn every_field_and_variant_is_named() {
    let spec = spec();
    let source = include_str!("../../src/message.rs");
    let events = include_str!("../../src/message/event.rs");
    let maintenance = include_str!("../../src/maintenance.rs");
    let refusals = include_str!("../../src/fault.rs");
    let refusals = &refusals[refusals.find("pub struct Fault").unwrap()..];
    let mut checked = 0;
    for line in source
        .lines()
        .chain(events.lines())
        .chain(maintenance.lines())
        .chain(refusals.lines())
    {
        let text = line.trim();
        let name = text
            .trim_start_matches("pub struct ")
            .trim_start_matches("pub enum ")
            .trim_start_matches("pub ");
        let end = name
            .find(|c: char| !c.is_alphanumeric() && c != '_')
            .unwrap_or(name.len());
        let (name, rest) = name.split_at(end);
        let item = text.starts_with("pub struct ") || text.starts_with("pub enum ");
        let field = rest.starts_with(": ") && rest.ends_with(',');
        let variant = name.starts_with(char::is_uppercase)
            && (rest == "," || rest == " {" || rest.starts_with('('));
        if (item || field || variant) && !text.starts_with("///") && !text.starts_with('#') {
            assert!(
                spec.contains(name),
                "docs/wire.md does not name {name} ({text})"
            );
            checked += 1;
        }
    }
    assert!(checked > 250, "only {checked} names were checked");
}

#[test]
fn every_cause_is_in_the_table() {
    let spec = spec();
    for cause in Cause::ALL {
        let reaction = match cause.reaction() {
            Reaction::PathStop => "R1",
            Reaction::QuickStop => "R2",
            Reaction::TorqueOff => "R3",
        };
        says(
            &spec,
            &format!("| {} | `{cause:?}` | {reaction} |", cause.code()),
        );
    }
}
