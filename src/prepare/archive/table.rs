//! The header and the table of sections: what lies where, and whether it is whole.

use std::ops::Range;

use rayon::prelude::*;

use super::checksum::checksum;
use super::error::Fault;
use super::records::{Fields, put};
use super::{ALIGNMENT, KINDS, Kind, MAGIC, VERSION};

const HEADER: usize = 32;
const ENTRY: usize = 32;
/// Where the header keeps the checksum of itself and the table.
const OWN_CHECKSUM: Range<usize> = 24..32;
/// The flag of a section that a reader has to know.
const REQUIRED: u32 = 1;

/// One line of the table.
#[derive(Clone, Copy, Debug)]
struct Entry {
    kind: u32,
    flags: u32,
    offset: u64,
    length: u64,
    checksum: u64,
}

impl Entry {
    fn name(&self) -> String {
        let known = KINDS.iter().find(|kind| kind.number == self.kind);
        known.map_or_else(
            || format!("section {}", self.kind),
            |kind| kind.name.to_owned(),
        )
    }
}

/// A table while its sections are being written, one after the other.
#[derive(Debug)]
pub(super) struct Draft {
    entries: Vec<Entry>,
    /// How many sections there will be.
    sections: usize,
    end: u64,
}

impl Draft {
    pub(super) fn of(sections: usize) -> Draft {
        Draft {
            entries: Vec::with_capacity(sections),
            sections,
            end: (HEADER + sections * ENTRY) as u64,
        }
    }

    /// Where the next section begins.
    pub(super) fn next_offset(&self) -> u64 {
        self.end.next_multiple_of(ALIGNMENT as u64)
    }

    /// Notes the next section.
    pub(super) fn add(&mut self, kind: Kind, bytes: &[u8]) {
        let offset = self.next_offset();
        self.end = offset + bytes.len() as u64;
        self.entries.push(Entry {
            kind: kind.number,
            flags: if kind.required { REQUIRED } else { 0 },
            offset,
            length: bytes.len() as u64,
            checksum: checksum(bytes),
        });
    }

    /// The header and the table, once all sections are known; and the length of the file.
    pub(super) fn finish(self) -> (Vec<u8>, u64) {
        debug_assert_eq!(self.entries.len(), self.sections);
        let mut bytes = MAGIC.to_vec();
        put(&mut bytes, VERSION.to_le_bytes());
        put(&mut bytes, (self.entries.len() as u32).to_le_bytes());
        put(&mut bytes, self.end.to_le_bytes());
        put(&mut bytes, [0; 8]);
        for entry in &self.entries {
            put(&mut bytes, entry.kind.to_le_bytes());
            put(&mut bytes, entry.flags.to_le_bytes());
            put(&mut bytes, entry.offset.to_le_bytes());
            put(&mut bytes, entry.length.to_le_bytes());
            put(&mut bytes, entry.checksum.to_le_bytes());
        }
        let sum = checksum(&bytes);
        bytes[OWN_CHECKSUM].copy_from_slice(&sum.to_le_bytes());
        (bytes, self.end)
    }
}

/// A checked table.
#[derive(Debug)]
pub(super) struct Table {
    sections: Vec<(u32, Range<usize>)>,
}

impl Table {
    /// Reads the table of an archive and checks each byte of the file against it.
    pub(super) fn check(file: &[u8]) -> Result<Table, Fault> {
        let header = |cause: &str| Fault::at("the header", cause);
        if !file.starts_with(&MAGIC) {
            return Err(header("does not begin as an archive does"));
        }
        let Some(bytes) = file.get(MAGIC.len()..HEADER) else {
            return Err(header("the file is truncated"));
        };
        let mut fields = Fields::of(bytes);
        let (version, sections) = (fields.u32(), fields.u32());
        let (length, own_checksum) = (fields.u64(), fields.u64());
        if version != VERSION {
            return Err(Fault::Version(version));
        }
        let is = file.len();
        if length != is as u64 {
            let cause = format!("the file has {is} bytes and should have {length}");
            return Err(header(&cause));
        }
        let end = (sections as usize).checked_mul(ENTRY);
        let end = end.and_then(|table| table.checked_add(HEADER));
        let Some(head) = end.and_then(|end| file.get(..end)) else {
            return Err(header("the file is truncated"));
        };
        let mut zeroed = head.to_vec();
        zeroed[OWN_CHECKSUM].fill(0);
        if checksum(&zeroed) != own_checksum {
            return Err(header("its checksum is wrong: it has been changed"));
        }
        let entries: Vec<Entry> = head[HEADER..]
            .as_chunks::<ENTRY>()
            .0
            .iter()
            .map(|bytes| {
                let mut fields = Fields::of(bytes);
                Entry {
                    kind: fields.u32(),
                    flags: fields.u32(),
                    offset: fields.u64(),
                    length: fields.u64(),
                    checksum: fields.u64(),
                }
            })
            .collect();
        Table::of(file, head.len(), &entries)
    }

    fn of(file: &[u8], head: usize, entries: &[Entry]) -> Result<Table, Fault> {
        let mut sections = Vec::with_capacity(entries.len());
        let mut end = head;
        for entry in entries {
            let fault = |cause: &str| Fault::at(entry.name(), cause);
            let range = Table::range(file, end, entry).map_err(fault)?;
            end = range.end;
            if sections.iter().any(|&(kind, _)| kind == entry.kind) {
                return Err(fault("is there twice"));
            }
            if entry.flags & !REQUIRED != 0 {
                return Err(fault("its flags are unknown"));
            }
            let is_known = KINDS.iter().any(|kind| kind.number == entry.kind);
            if !is_known && entry.flags & REQUIRED != 0 {
                return Err(fault("this build does not know it, but has to"));
            }
            sections.push((entry.kind, range));
        }
        if end != file.len() {
            return Err(Fault::at("the end", "there is more than the sections"));
        }
        let changed = entries
            .par_iter()
            .zip(&sections)
            .find_map_first(|(entry, (_, range))| {
                (checksum(&file[range.clone()]) != entry.checksum).then(|| entry.name())
            });
        match changed {
            Some(name) => Err(Fault::at(
                name,
                "its checksum is wrong: it has been changed",
            )),
            None => Ok(Table { sections }),
        }
    }

    /// Where a section lies that follows what ends at `end`.
    fn range(file: &[u8], end: usize, entry: &Entry) -> Result<Range<usize>, &'static str> {
        let start = end.next_multiple_of(ALIGNMENT);
        if entry.offset != start as u64 {
            return Err("it is not where it should be");
        }
        let length = usize::try_from(entry.length).ok();
        let range = length
            .and_then(|length| start.checked_add(length))
            .filter(|&end| end <= file.len())
            .map(|end| start..end)
            .ok_or("it reaches past the end of the file")?;
        if file[end..start].iter().any(|&byte| byte != 0) {
            return Err("what is before it should be zeros");
        }
        Ok(range)
    }

    /// Where a section lies; none if there is none of that kind.
    pub(super) fn find(&self, kind: Kind) -> Option<Range<usize>> {
        let mut sections = self.sections.iter();
        sections
            .find(|(number, _)| *number == kind.number)
            .map(|(_, range)| range.clone())
    }

    /// Where a section lies that has to be there.
    pub(super) fn get(&self, kind: Kind) -> Result<Range<usize>, Fault> {
        self.find(kind)
            .ok_or_else(|| Fault::at(kind.name, "is missing"))
    }
}
