//! The log of an image: defmt frames, decoded with the texts that are in the image's file.

use defmt_decoder::{DecodeError, Table};
use std::path::Path;

/// The lines of a log.
///
/// # Errors
/// If the file is no image with texts, or the log has no such frames.
pub fn lines(image: &Path, log: &[u8]) -> Result<Vec<String>, String> {
    let bytes = std::fs::read(image).map_err(|error| error.to_string())?;
    let table = Table::parse(&bytes)
        .map_err(|error| error.to_string())?
        .ok_or("the image has no texts of a log")?;
    let mut decoder = table.new_stream_decoder();
    decoder.received(log);
    let mut out = Vec::new();
    loop {
        match decoder.decode() {
            Ok(frame) => out.push(frame.display_message().to_string()),
            Err(DecodeError::UnexpectedEof) => return Ok(out),
            Err(DecodeError::Malformed) => return Err("a log that is none".into()),
        }
    }
}
