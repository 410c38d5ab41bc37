//! One number for the whole interface: the hash of every type that travels.
//!
//! The hash runs over the source text of the type definitions, without comments and white space,
//! so neither a better doc comment nor a reformatting changes it, and any change of a field, its
//! type, its order or an identifier does. Two programs with equal hashes understand each other
//! fully; with different hashes and equal [`PROTOCOL`] major number, only
//! [`crate::message::Request::Identify`], `Acquire`, `Release`, `Stop`, a
//! [`crate::message::Command`] without coordination, [`crate::message::StopAll`] and
//! [`crate::maintenance`] may be used (message set v0).

/// Protocol version: major, minor. Major: the meaning of the v0 set changed; minor: it has grown (1: maintenance).
pub const PROTOCOL: (u8, u8) = (1, 1);

/// The hash of this build's interface, sent in [`crate::message::Identity`].
pub const SCHEMA_HASH: u64 = {
    let mut hash = FNV_OFFSET;
    hash = hash_of(hash, include_str!("time.rs"));
    hash = hash_of(hash, include_str!("units.rs"));
    hash = hash_of(hash, include_str!("fault.rs"));
    hash = hash_of(hash, include_str!("message.rs"));
    hash = hash_of(hash, include_str!("message/event.rs"));
    hash = hash_of(hash, include_str!("maintenance.rs"));
    hash_of(hash, include_str!("id.rs"))
};

/// FNV-1a, 64 bits.
const FNV_OFFSET: u64 = 0xCBF2_9CE4_8422_2325;
const FNV_PRIME: u64 = 0x0000_0100_0000_01B3;

const BEGIN: &[u8] = b"// schema: begin";
const END: &[u8] = b"// schema: end";

/// Continues `hash` over the marked regions of a source text.
const fn hash_of(mut hash: u64, source: &str) -> u64 {
    let mut rest = source.as_bytes();
    let mut inside = false;
    let mut quoted = false;
    while let [byte, tail @ ..] = rest {
        if !quoted && starts_with(rest, b"//") {
            if starts_with(rest, BEGIN) {
                inside = true;
            } else if starts_with(rest, END) {
                inside = false;
            }
            rest = after_line(rest);
            continue;
        }
        if *byte == b'"' {
            quoted = !quoted;
        }
        if inside && !byte.is_ascii_whitespace() {
            hash = (hash ^ *byte as u64).wrapping_mul(FNV_PRIME);
        }
        rest = tail;
    }
    hash
}

const fn starts_with(mut text: &[u8], mut start: &[u8]) -> bool {
    while let [expected, start_tail @ ..] = start {
        match text {
            [byte, text_tail @ ..] if *byte == *expected => {
                text = text_tail;
                start = start_tail;
            }
            _ => return false,
        }
    }
    true
}

const fn after_line(mut text: &[u8]) -> &[u8] {
    while let [byte, tail @ ..] = text {
        text = tail;
        if *byte == b'\n' {
            break;
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::format;
    use std::string::{String, ToString};

    fn of(body: &str) -> u64 {
        hash_of(
            FNV_OFFSET,
            &format!("// schema: begin\n{body}\n// schema: end\n"),
        )
    }

    const TYPE: &str = "/// Docs.\npub struct A {\n    /// x\n    pub x: u16,\n}";

    #[test]
    fn comments_layout_and_what_is_outside_do_not_count() {
        assert_eq!(of(TYPE), of("pub struct A { pub x: u16, } // note"));
        assert_eq!(of(TYPE), hash_of(of(TYPE), "fn outside() {}"));
        assert_ne!(of(TYPE), of(""));
    }

    #[test]
    fn every_change_of_a_definition_counts() {
        for other in [
            "pub struct A { pub x: u32, }",
            "pub struct A { pub y: u16, }",
            "pub struct B { pub x: u16, }",
            "pub struct A { pub x: u16, pub y: u16, }",
        ] {
            assert_ne!(of(TYPE), of(other));
        }
    }

    /// Every byte of the real definitions counts: removing any one line that is not a comment
    /// changes the hash.
    #[test]
    fn every_line_of_the_messages_counts() {
        let source = include_str!("message.rs");
        let whole = hash_of(FNV_OFFSET, source);
        let mut inside = false;
        let mut lines = 0;
        for (k, line) in source.lines().enumerate() {
            inside = match line.trim() {
                "// schema: begin" => true,
                "// schema: end" => false,
                _ => inside,
            };
            let text = line.trim();
            if inside && !text.is_empty() && !text.starts_with("//") {
                let without: String = source
                    .lines()
                    .enumerate()
                    .filter(|(j, _)| *j != k)
                    .map(|(_, l)| l.to_string() + "\n")
                    .collect();
                assert_ne!(hash_of(FNV_OFFSET, &without), whole, "line {}", k + 1);
                lines += 1;
            }
        }
        assert!(lines > 200, "only {lines} lines are hashed");
    }
}
