//! The handshake, item by item: what is in order, what is awaited, what is wrong and what to do.

use super::failure::{Asked, Awaited, Failure};
use super::robot::{Image, Link};
use core::fmt;
use protocol::message::{Identity, NodeState};
use protocol::schema::{PROTOCOL, SCHEMA_HASH};
use serde_json::{Value, json};

/// How an item stands.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum State {
    /// Not known yet.
    Pending,
    /// In order; what was found.
    Ok {
        /// What was found.
        got: String,
    },
    /// Not in order.
    Failed {
        /// What was expected.
        expected: String,
        /// What was found.
        got: String,
        /// Which frame is missing or what to change.
        hint: String,
    },
}

/// An item of the list.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Item {
    /// What is checked.
    pub what: &'static str,
    /// How it stands.
    pub state: State,
}

/// The list for one robot.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Checklist {
    /// The robot.
    pub robot: String,
    /// Its node.
    pub node: u8,
    /// The items, in the order in which they come about.
    pub items: Vec<Item>,
}

const ANSWERS: &str = "node answers";
const LEASE: &str = "command lease";
const DRIVES: &str = "drives ready";
const TORQUE: &str = "torque on";

/// What must agree between the node and this program: name, expected, got, hint.
fn comparisons(
    image: &Image,
    identity: &Identity,
) -> [(&'static str, String, String, &'static str); 5] {
    let arm = image.arm();
    [
        (
            "robot",
            arm.kind().name().to_owned(),
            identity.robot.as_str().to_owned(),
            "another robot answers under this node number; correct the cell or the node's number",
        ),
        (
            "protocol version",
            format!("{}.x", PROTOCOL.0),
            format!("{}.{}", identity.protocol.0, identity.protocol.1),
            "install node and host of the same release",
        ),
        (
            "message set",
            format!("{SCHEMA_HASH:016x}"),
            format!("{:016x}", identity.schema_hash),
            "install node and host of the same release",
        ),
        (
            "axes",
            arm.axes().len().to_string(),
            identity.axes.to_string(),
            "the node is configured for another robot",
        ),
        (
            "servo step",
            format!("{} µs", arm.servo_step_us()),
            format!("{} µs", identity.servo_step_us),
            "the node is configured for another servo rate",
        ),
    ]
}

/// The nodes tell `major.minor`: equal major numbers understand each other.
fn agrees(what: &str, expected: &str, got: &str, identity: &Identity) -> bool {
    match what {
        "protocol version" => identity.protocol.0 == PROTOCOL.0,
        _ => expected == got,
    }
}

/// The first thing in which a node differs from what was expected.
#[must_use]
pub fn mismatch(image: &Image, identity: &Identity) -> Option<Failure> {
    comparisons(image, identity)
        .into_iter()
        .find(|(what, expected, got, _)| !agrees(what, expected, got, identity))
        .map(|(item, expected, got, hint)| Failure::Mismatch {
            who: image.who(),
            item,
            expected,
            got,
            hint,
        })
}

impl Checklist {
    /// The list of a robot as its image and the failure of the handshake, if it has failed, tell it.
    #[must_use]
    pub fn of(image: &Image, failure: Option<&Failure>) -> Self {
        let failure = failure.filter(|f| f.who() == Some(&image.who()));
        let mut items = vec![answers(image, failure)];
        let identity = image.identity();
        for what in [
            "robot",
            "protocol version",
            "message set",
            "axes",
            "servo step",
        ] {
            items.push(Item {
                what,
                state: identity.map_or(State::Pending, |identity| compared(image, identity, what)),
            });
        }
        items.push(Item {
            what: "configuration",
            state: identity.map_or(State::Pending, |identity| State::Ok {
                got: format!("CRC {:08x}", identity.config_crc),
            }),
        });
        items.push(lease(image, failure));
        items.push(drives(image, failure));
        items.push(torque(image, failure));
        items.push(homed(image));
        Self {
            robot: image.config().name.clone(),
            node: image.config().node.get(),
            items,
        }
    }

    /// Is nothing wrong?
    #[must_use]
    pub fn is_ok(&self) -> bool {
        !self
            .items
            .iter()
            .any(|item| matches!(item.state, State::Failed { .. }))
    }

    /// For machines: `{robot, node, items: [{what, state, got, expected, hint}]}`.
    #[must_use]
    pub fn json(&self) -> Value {
        let items: Vec<Value> = self
            .items
            .iter()
            .map(|item| match &item.state {
                State::Pending => json!({"what": item.what, "state": "pending"}),
                State::Ok { got } => json!({"what": item.what, "state": "ok", "got": got}),
                State::Failed {
                    expected,
                    got,
                    hint,
                } => json!({
                    "what": item.what, "state": "failed",
                    "expected": expected, "got": got, "hint": hint,
                }),
            })
            .collect();
        json!({"robot": self.robot, "node": self.node, "items": items})
    }
}

impl fmt::Display for Checklist {
    /// A line per robot, then a line per item.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} (node {})", self.robot, self.node)?;
        for Item { what, state } in &self.items {
            match state {
                State::Pending => write!(f, "\n  [ ] {what}")?,
                State::Ok { got } => write!(f, "\n  [x] {what}: {got}")?,
                State::Failed {
                    expected,
                    got,
                    hint,
                } => {
                    write!(f, "\n  [!] {what}: expected {expected}, got {got}; {hint}")?;
                }
            }
        }
        Ok(())
    }
}

fn answers(image: &Image, failure: Option<&Failure>) -> Item {
    let state = match (image.identity(), failure) {
        (Some(identity), _) => State::Ok {
            got: format!(
                "firmware {}.{}.{}, unique id {:016x}",
                identity.firmware.0, identity.firmware.1, identity.firmware.2, identity.unique_id
            ),
        },
        (
            None,
            Some(
                Failure::TimedOut {
                    awaited: Awaited::Identity,
                    ..
                }
                | Failure::Lost { .. },
            ),
        ) => State::Failed {
            expected: "the reply to Identify".to_owned(),
            got: "no frame".to_owned(),
            hint: "start mrroc-node on this bus, or correct the node number in the cell".to_owned(),
        },
        (None, _) => State::Pending,
    };
    Item {
        what: ANSWERS,
        state,
    }
}

fn compared(image: &Image, identity: &Identity, what: &str) -> State {
    comparisons(image, identity)
        .into_iter()
        .find(|(name, ..)| *name == what)
        .map_or(State::Pending, |(_, expected, got, hint)| {
            if agrees(what, &expected, &got, identity) {
                State::Ok { got }
            } else {
                State::Failed {
                    expected,
                    got,
                    hint: hint.to_owned(),
                }
            }
        })
}

fn lease(image: &Image, failure: Option<&Failure>) -> Item {
    let state = match (image.link(), failure) {
        (Link::Leased { epoch, .. }, _) => State::Ok {
            got: format!("epoch {epoch}"),
        },
        (
            _,
            Some(
                failure @ (Failure::LeaseLost { .. }
                | Failure::Refused {
                    asked: Asked::Acquire,
                    ..
                }
                | Failure::Unanswered {
                    asked: Asked::Acquire,
                    ..
                }),
            ),
        ) => State::Failed {
            expected: "the lease".to_owned(),
            got: "none".to_owned(),
            hint: failure.to_string(),
        },
        _ => State::Pending,
    };
    Item { what: LEASE, state }
}

fn drives(image: &Image, failure: Option<&Failure>) -> Item {
    let state = match (image.state(), failure) {
        (
            _,
            Some(
                failure @ (Failure::TimedOut {
                    awaited: Awaited::Drives,
                    ..
                }
                | Failure::Fault { .. }),
            ),
        ) => State::Failed {
            expected: "every drive configured".to_owned(),
            got: image
                .state()
                .map_or("no fresh feedback".to_owned(), |s| format!("{s:?}")),
            hint: failure.to_string(),
        },
        (None | Some(NodeState::Boot | NodeState::Configuring | NodeState::Faulted), _) => {
            State::Pending
        }
        (Some(_), _) => State::Ok {
            got: format!("{} axes", image.arm().axes().len()),
        },
    };
    Item {
        what: DRIVES,
        state,
    }
}

fn torque(image: &Image, failure: Option<&Failure>) -> Item {
    let state = match (image.state(), failure) {
        (
            _,
            Some(
                failure @ Failure::TimedOut {
                    awaited: Awaited::Torque,
                    ..
                },
            ),
        ) => State::Failed {
            expected: "torque on".to_owned(),
            got: image
                .state()
                .map_or("no fresh feedback".to_owned(), |s| format!("{s:?}")),
            hint: failure.to_string(),
        },
        (
            Some(
                state @ (NodeState::Unsynchronised
                | NodeState::Synchronising
                | NodeState::Holding
                | NodeState::Moving
                | NodeState::Stopping),
            ),
            _,
        ) => State::Ok {
            got: format!("{state:?}"),
        },
        _ => State::Pending,
    };
    Item {
        what: TORQUE,
        state,
    }
}

fn homed(image: &Image) -> Item {
    let state = if image.is_homed() {
        State::Ok {
            got: "every axis".to_owned(),
        }
    } else {
        State::Pending
    };
    Item {
        what: "homed",
        state,
    }
}
