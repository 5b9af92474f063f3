//! Buffers: in the file itself, in a `data:` URI, or in a file beside it (glTF §3.6.1).
//!
//! Each is read when geometry first asks for it, so that a missing picture file harms nothing.

use std::borrow::Cow;
use std::cell::{OnceCell, RefCell};
use std::collections::HashSet;
use std::path::{Path, PathBuf};

use base64::Engine;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};

use super::document::{BufferView, Document};
use super::{Result, lookup};
use crate::scene::error::{COPY_AGAIN, Fault};
use crate::scene::load_budget::LoadBudget;
use crate::scene::read_file;

const BASE64: GeneralPurpose = GeneralPurpose::new(
    &base64::alphabet::STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

/// The buffers of one file.
pub(super) struct Buffers<'a> {
    document: &'a Document,
    binary: Option<&'a [u8]>,
    folder: &'a Path,
    budget: &'a LoadBudget,
    loaded: Vec<OnceCell<Cow<'a, [u8]>>>,
    files_read: RefCell<HashSet<PathBuf>>,
}

impl<'a> Buffers<'a> {
    pub(super) fn new(
        document: &'a Document,
        binary: Option<&'a [u8]>,
        folder: &'a Path,
        budget: &'a LoadBudget,
    ) -> Buffers<'a> {
        let loaded = document.buffers.iter().map(|_| OnceCell::new()).collect();
        Buffers {
            document,
            binary,
            folder,
            budget,
            loaded,
            files_read: RefCell::default(),
        }
    }

    /// The record of a view and its bytes.
    pub(super) fn view(&self, index: u32) -> Result<(&BufferView, &[u8])> {
        let view = lookup(&self.document.buffer_views, index, "buffer view")?;
        let name = || format!("buffer view {index}");
        let buffer = self
            .buffer(view.buffer)
            .map_err(|fault| fault.within(name()))?;
        let bytes = view
            .byte_offset
            .checked_add(view.byte_length)
            .filter(|&end| end <= buffer.len() as u64)
            .map(|end| &buffer[view.byte_offset as usize..end as usize]);
        match bytes {
            Some(bytes) => Ok((view, bytes)),
            None => Err(Fault::damaged(
                name(),
                format!(
                    "{} bytes from byte {} on reach past the end of buffer {}, which has {}",
                    view.byte_length,
                    view.byte_offset,
                    view.buffer,
                    buffer.len()
                ),
            )),
        }
    }

    fn buffer(&self, index: u32) -> Result<&[u8]> {
        let record = lookup(&self.document.buffers, index, "buffer")?;
        let cell = &self.loaded[index as usize];
        if cell.get().is_none() {
            let name = format!("buffer {index}");
            let bytes = match record.uri.as_deref() {
                Some(uri) => self
                    .read_uri(uri, record.byte_length)
                    .map_err(|fault| fault.within(&name))?,
                None => self.embedded(index).map_err(|fault| fault.within(&name))?,
            };
            if (bytes.len() as u64) < record.byte_length {
                return Err(Fault::damaged_so(
                    name,
                    format!(
                        "it should have {} bytes but has {}",
                        record.byte_length,
                        bytes.len()
                    ),
                    COPY_AGAIN,
                ));
            }
            let used = record.byte_length as usize;
            let exact = match bytes {
                Cow::Borrowed(bytes) => Cow::Borrowed(&bytes[..used]),
                Cow::Owned(mut bytes) => {
                    bytes.truncate(used);
                    Cow::Owned(bytes)
                }
            };
            let _ = cell.set(exact);
        }
        Ok(cell.get().map_or(&[], |bytes| bytes))
    }

    fn embedded(&self, index: u32) -> Result<Cow<'a, [u8]>> {
        match self.binary {
            Some(binary) if index == 0 => Ok(Cow::Borrowed(binary)),
            _ => Err(Fault::damaged(
                "its data",
                "it has no uri, and the file has no binary chunk for it (only buffer 0 of a .glb file has one)",
            )),
        }
    }

    fn read_uri(&self, uri: &str, length: u64) -> Result<Cow<'a, [u8]>> {
        if uri
            .get(..5)
            .is_some_and(|scheme| scheme.eq_ignore_ascii_case("data:"))
        {
            return self.decode(&uri[5..]).map(Cow::Owned);
        }
        let name = || format!("uri {:?}", shortened(uri));
        let path = relative_path(uri).map_err(|cause| {
            Fault::unsupported(
                name(),
                cause,
                "only files beside the scene are read: put the buffer there and name it without a scheme",
            )
        })?;
        let path = self.folder.join(path);
        let unreadable = |error| {
            Fault::damaged_so(
                name(),
                format!("{} cannot be read: {error}", path.display()),
                "put the file where the scene expects it",
            )
        };
        let size = std::fs::metadata(&path)
            .map_err(unreadable)?
            .len()
            .min(length);
        // A file that is read under several names raises the limit once.
        let one_name = std::fs::canonicalize(&path).map_err(unreadable)?;
        if self.files_read.borrow_mut().insert(one_name) {
            self.budget.has_read(size);
        }
        self.budget.reserve(size, name())?;
        read_file(&path, size).map(Cow::Owned).map_err(unreadable)
    }

    /// What follows `data:`, which must be base64 (RFC 2397, RFC 4648).
    fn decode(&self, uri: &str) -> Result<Vec<u8>> {
        let place = "its data: URI";
        let Some((media_type, text)) = uri.split_once(',') else {
            return Err(Fault::damaged_so(
                place,
                "it has no comma before its data",
                COPY_AGAIN,
            ));
        };
        if !media_type.ends_with(";base64") {
            return Err(Fault::unsupported(
                place,
                "it is not base64",
                "export the scene again, as .glb",
            ));
        }
        let estimate = base64::decoded_len_estimate(text.len()) as u64;
        self.budget.reserve(estimate, place)?;
        BASE64.decode(text).map_err(|error| {
            Fault::damaged_so(place, format!("its base64 is broken: {error}"), COPY_AGAIN)
        })
    }
}

fn shortened(uri: &str) -> String {
    match uri.char_indices().nth(80) {
        Some((end, _)) => format!("{}…", &uri[..end]),
        None => uri.to_owned(),
    }
}

/// The path a relative reference names, percent-encoding undone (RFC 3986 §2.1, §4.2), or why there is none.
fn relative_path(uri: &str) -> std::result::Result<PathBuf, String> {
    if uri
        .split(['/', '?', '#'])
        .next()
        .is_some_and(|first| first.contains(':'))
    {
        return Err("it is not a file beside the scene but has a scheme".to_owned());
    }
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.bytes();
    while let Some(byte) = rest.next() {
        if byte != b'%' {
            bytes.push(byte);
            continue;
        }
        let digit = |d: Option<u8>| d.and_then(|d| (d as char).to_digit(16));
        match (digit(rest.next()), digit(rest.next())) {
            (Some(high), Some(low)) => bytes.push((high * 16 + low) as u8),
            _ => return Err("its percent-encoding is broken".to_owned()),
        }
    }
    let path =
        String::from_utf8(bytes).map_err(|_| "its percent-encoding is not UTF-8".to_owned())?;
    let path = PathBuf::from(path);
    if path.is_absolute() || path.has_root() {
        return Err("it is an absolute path".to_owned());
    }
    Ok(path)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn relative_references_lose_their_percent_encoding() {
        assert_eq!(
            relative_path("my%20parts/%C3%A4.bin"),
            Ok(PathBuf::from("my parts/ä.bin"))
        );
        assert_eq!(relative_path("../a.bin"), Ok(PathBuf::from("../a.bin")));
    }

    #[test]
    fn schemes_and_absolute_paths_are_refused() {
        for uri in [
            "https://example.org/a.bin",
            "file:///a.bin",
            "C:/a.bin",
            "/etc/a.bin",
            "%2Fa.bin",
            "a%2",
            "%ff",
        ] {
            assert!(relative_path(uri).is_err(), "{uri}");
        }
    }
}
