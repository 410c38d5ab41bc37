//! Goldens: committed bytes. `MRROC_BLESS=1 cargo test -p mrroc-protocol` rewrites them; a changed
//! golden is a changed wire and belongs in the changelog.

use protocol::frame::{Frame, Id};
use std::fmt::Write as _;
use std::path::PathBuf;

/// Compares lines `name hex` with the file of that name.
pub(super) fn check(file: &str, lines: &[(String, Vec<u8>)]) {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR"))
        .join("tests/golden")
        .join(file);
    let mut text = String::new();
    for (name, bytes) in lines {
        writeln!(text, "{name} {}", hex(bytes)).unwrap();
    }
    if std::env::var_os("MRROC_BLESS").is_some() {
        std::fs::write(&path, &text).unwrap();
        return;
    }
    let golden = std::fs::read_to_string(&path).unwrap_or_default();
    for (golden, now) in golden.lines().zip(text.lines()) {
        assert_eq!(golden, now, "{}", path.display());
    }
    assert_eq!(
        golden.lines().count(),
        lines.len(),
        "{}: lines",
        path.display()
    );
}

pub(super) fn hex(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |mut text, byte| {
        write!(text, "{byte:02x}").unwrap();
        text
    })
}

/// The frame as `identifier data`, in one line of bytes: 4 of the identifier, then the data.
pub(super) fn frame_bytes(frame: &Frame) -> Vec<u8> {
    let Id::Extended(id) = frame.id() else {
        panic!("the MP wire has only extended frames")
    };
    id.to_be_bytes()
        .into_iter()
        .chain(frame.data().iter().copied())
        .collect()
}

#[test]
fn the_schema_hash_is_the_committed_one() {
    let hash = protocol::schema::SCHEMA_HASH.to_be_bytes();
    check("schema.hex", &[("schema".into(), hash.to_vec())]);
}
