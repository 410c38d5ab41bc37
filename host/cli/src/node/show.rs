//! What a node said of itself, for people and for machines.

use host::error::fault_text;
use protocol::maintenance::{
    FaultRecord, ImagePhase, ImageStatus, NodeIdentity, ResetCause, ResetReport, RunningImage,
    Standing,
};
use protocol::message::Identity;
use protocol::schema::SCHEMA_HASH;
use serde_json::{Value, json};
use std::fmt::Write as _;

/// A value on a line of its own.
pub(super) fn line(value: &Value) -> String {
    format!("{value}\n")
}

pub(super) fn version((major, minor, patch): (u8, u8, u8)) -> String {
    format!("{major}.{minor}.{patch}")
}

/// Why it started, in words.
const fn cause(cause: ResetCause) -> &'static str {
    match cause {
        ResetCause::Unknown => "for a reason that nothing tells",
        ResetCause::PowerOn => "because power came on, or for the first time",
        ResetCause::Pin => "because of its reset pin",
        ResetCause::BrownOut => "because its supply sagged",
        ResetCause::Software => "after the program before it ended as it should",
        ResetCause::Watchdog => "by its watchdog",
        ResetCause::Option => "because its option bytes were loaded",
        ResetCause::Vanished => "after the process before it vanished",
    }
}

#[expect(clippy::cast_precision_loss, reason = "seconds for people")]
fn seconds(report: &ResetReport) -> f64 {
    (u64::from(report.steps) * u64::from(report.servo_step_us)) as f64 / 1e6
}

pub(super) fn reset(report: &ResetReport) -> String {
    format!(
        "{}; start {}, {:.1} s ago",
        cause(report.cause),
        report.boots,
        seconds(report)
    )
}

pub(super) fn reset_json(report: &ResetReport) -> Value {
    json!({
        "cause": format!("{:?}", report.cause),
        "boots": report.boots,
        "steps": report.steps,
        "uptime_s": seconds(report),
    })
}

/// Why and when a node started.
pub(super) fn started(name: &str, report: &ResetReport, json: bool) -> String {
    if json {
        line(&reset_json(report))
    } else {
        format!("{name}: started {}\n", reset(report))
    }
}

const fn standing(standing: Standing) -> &'static str {
    match standing {
        Standing::Confirmed => "confirmed",
        Standing::Trial => "on trial: confirm it, or the other starts at the next reset",
        Standing::RolledBack => "rolled back to: the other was not confirmed, or is damaged",
    }
}

fn same(schema_hash: u64) -> &'static str {
    if schema_hash == SCHEMA_HASH {
        "as ours"
    } else {
        "not ours: it can be asked, stopped and updated, and nothing else"
    }
}

fn image_json(image: &RunningImage) -> Value {
    json!({
        "slot": format!("{:?}", image.slot),
        "version": version(image.version),
        "crc": format!("{:08x}", image.crc),
        "standing": format!("{:?}", image.standing),
    })
}

/// All that is known of a node.
pub(super) struct Info<'a> {
    pub(super) identity: &'a NodeIdentity,
    pub(super) reset: &'a ResetReport,
    pub(super) fault: Option<&'a FaultRecord>,
    pub(super) next: Option<&'a ImageStatus>,
}

impl Info<'_> {
    pub(super) fn text(&self, number: u8) -> String {
        let who = self.identity;
        let mut text = format!("{}, node {number}\n", who.robot);
        let mut row = |what: &str, is: String| {
            // writing to a String cannot fail
            let _ = writeln!(text, "  {what:<14} {is}");
        };
        row("unique id", format!("{:016x}", who.unique_id));
        row("target", who.target.as_str().into());
        row("protocol", format!("{}.{}", who.protocol.0, who.protocol.1));
        let hash = who.schema_hash;
        row("schema hash", format!("{hash:016x}, {}", same(hash)));
        row("configuration", format!("CRC {:08x}", who.config_crc));
        row("firmware", version(who.firmware));
        row(
            "image",
            who.image.map_or_else(
                || "no slots: it cannot be updated by the bus".into(),
                |image| {
                    format!(
                        "slot {:?}, {}, CRC {:08x}, {}",
                        image.slot,
                        version(image.version),
                        image.crc,
                        standing(image.standing)
                    )
                },
            ),
        );
        if let Some(next) = self.next {
            row("next image", coming(next));
        }
        row("started", reset(self.reset));
        row(
            "first fault",
            self.fault.map_or_else(
                || "none is recorded".into(),
                |record| format!("{} (mrroc node faults)", fault_text(&record.fault)),
            ),
        );
        text
    }

    pub(super) fn json(&self) -> Value {
        let who = self.identity;
        json!({
            "robot": who.robot.as_str(),
            "unique_id": format!("{:016x}", who.unique_id),
            "target": who.target.as_str(),
            "protocol": format!("{}.{}", who.protocol.0, who.protocol.1),
            "schema_hash": format!("{:016x}", who.schema_hash),
            "schema_hash_ours": format!("{SCHEMA_HASH:016x}"),
            "config_crc": format!("{:08x}", who.config_crc),
            "firmware": version(who.firmware),
            "image": who.image.as_ref().map(image_json),
            "next_image": self.next.map(|next| json!({
                "slot": format!("{:?}", next.slot),
                "phase": format!("{:?}", next.phase),
                "crc": format!("{:08x}", next.image),
                "next": next.next,
                "capacity": next.capacity,
            })),
            "reset": reset_json(self.reset),
            "first_fault": self.fault.map(|record| record.fault.cause.code()),
        })
    }
}

fn coming(next: &ImageStatus) -> String {
    let slot = format!("slot {:?} has room for {} bytes", next.slot, next.capacity);
    match next.phase {
        ImagePhase::None => format!("none; {slot}"),
        ImagePhase::Receiving => format!(
            "{:08x} is under way, {} bytes; {slot}",
            next.image, next.next
        ),
        ImagePhase::Verified => format!("{:08x} is verified, not activated; {slot}", next.image),
        ImagePhase::Activated => format!(
            "{:08x} starts on trial at the next reset; {slot}",
            next.image
        ),
    }
}

/// A node that says only what every node says.
pub(super) fn plain(number: u8, who: &Identity) -> String {
    format!(
        "{}, node {number}\n  {:<14} {:016x}\n  {:<14} {}.{}\n  {:<14} {:016x}, {}\n  {:<14} CRC {:08x}\n  \
         {:<14} {}\n  {:<14} no maintenance service: no reset cause, no record of faults, no update\n",
        who.robot,
        "unique id",
        who.unique_id,
        "protocol",
        who.protocol.0,
        who.protocol.1,
        "schema hash",
        who.schema_hash,
        same(who.schema_hash),
        "configuration",
        who.config_crc,
        "firmware",
        version(who.firmware),
        "image",
    )
}

pub(super) fn plain_json(who: &Identity) -> Value {
    json!({
        "robot": who.robot.as_str(),
        "unique_id": format!("{:016x}", who.unique_id),
        "protocol": format!("{}.{}", who.protocol.0, who.protocol.1),
        "schema_hash": format!("{:016x}", who.schema_hash),
        "schema_hash_ours": format!("{SCHEMA_HASH:016x}"),
        "config_crc": format!("{:08x}", who.config_crc),
        "firmware": version(who.firmware),
        "image": null,
        "reset": null,
        "first_fault": null,
    })
}
