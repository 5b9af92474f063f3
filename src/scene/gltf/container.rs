//! Bytes to JSON and binary chunk (glTF §4.4).
//!
//! ```text
//! "glTF" | version 2 | length of all   each 4 bytes, little endian
//! length | "JSON" | text               first
//! length | "BIN\0" | data              second, if at all; others are left alone
//! ```

use super::Result;
use crate::scene::error::{COPY_AGAIN, Fault};
use crate::scene::warnings::Warnings;

/// The two parts of a file; a `.gltf` file has no second.
pub(super) struct Parts<'a> {
    pub json: &'a [u8],
    pub binary: Option<&'a [u8]>,
}

const HEADER: usize = 12;
const CHUNK_HEADER: usize = 8;

/// Finds the parts of either kind of file.
pub(super) fn split<'a>(bytes: &'a [u8], warnings: &mut Warnings) -> Result<Parts<'a>> {
    if !bytes.starts_with(b"glTF") {
        let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        return match text.iter().find(|b| !b.is_ascii_whitespace()) {
            Some(b'{') => Ok(Parts {
                json: text,
                binary: None,
            }),
            Some(_) => Err(Fault::damaged_so(
                "header",
                "the file is neither binary glTF (it does not start with \"glTF\") nor JSON (nor with a brace)",
                "give a .glb or .gltf file",
            )),
            None => Err(Fault::damaged_so("header", "the file is empty", COPY_AGAIN)),
        };
    }
    let word = |at: usize| {
        bytes
            .get(at..at + 4)
            .and_then(|b| b.try_into().ok())
            .map(u32::from_le_bytes)
    };
    let (Some(version), Some(length)) = (word(4), word(8)) else {
        return Err(Fault::damaged_so(
            "header",
            format!("the file ends after {} bytes", bytes.len()),
            COPY_AGAIN,
        ));
    };
    if version != 2 {
        return Err(Fault::unsupported(
            "header",
            format!("it is glTF {version}"),
            "convert it to glTF 2.0",
        ));
    }
    let length = length as usize;
    if length > bytes.len() {
        return Err(Fault::damaged_so(
            "header",
            format!(
                "the file should have {length} bytes but has {}",
                bytes.len()
            ),
            COPY_AGAIN,
        ));
    }
    if length < bytes.len() {
        warnings.note(
            "bytes after the end that the header gives are left out",
            "header",
        );
    }
    let (mut json, mut binary, mut at) = (None, None, HEADER);
    while at < length {
        let (Some(size), Some(kind)) = (word(at), bytes.get(at + 4..at + 8)) else {
            return Err(Fault::damaged_so(
                "chunks",
                format!("the file ends inside the chunk at byte {at}"),
                COPY_AGAIN,
            ));
        };
        let start = at + CHUNK_HEADER;
        let Some(chunk) = bytes[..length]
            .get(start..)
            .and_then(|rest| rest.get(..size as usize))
        else {
            return Err(Fault::damaged_so(
                "chunks",
                format!(
                    "the chunk at byte {at} claims {size} bytes, but the file ends {} after it",
                    length - at
                ),
                COPY_AGAIN,
            ));
        };
        match kind {
            b"JSON" if at == HEADER => json = Some(chunk),
            b"BIN\0" if binary.is_none() => binary = Some(chunk),
            _ => warnings.note(
                "a chunk of unknown kind is left out",
                format_args!("chunk at byte {at}"),
            ),
        }
        at = start + size as usize;
    }
    match json {
        Some(json) => Ok(Parts { json, binary }),
        None => Err(Fault::damaged("chunks", "the first chunk is not JSON")),
    }
}
