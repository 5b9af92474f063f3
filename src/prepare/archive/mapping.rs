//! An archive's bytes: the file itself, mapped into memory, or read as a whole where it cannot be.
//!
//! This is the only place that knows which. Mapping is the business of `mmap-io`, and all here is safe code; what that
//! cannot promise is that nobody else changes the file, see the [module above](super).

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

/// The bytes of a file, at an address that is a multiple of 8.
pub(super) enum Mapping {
    #[cfg(all(feature = "mmap", any(unix, windows)))]
    Mapped(mmap_io::MemoryMappedFile),
    Read {
        words: Vec<u64>,
        length: usize,
    },
}

impl Mapping {
    /// Maps or reads a file.
    pub(super) fn open(file: File, path: &Path) -> io::Result<Mapping> {
        Mapping::mapped(&file, path).map_or_else(|| Mapping::read(file), Ok)
    }

    /// None where the system cannot map the file.
    #[cfg(all(feature = "mmap", any(unix, windows)))]
    fn mapped(file: &File, path: &Path) -> Option<Mapping> {
        use mmap_io::{MemoryMappedFile, MmapMode};
        let file = file.try_clone().ok()?;
        let mapped = MemoryMappedFile::from_file(file, MmapMode::ReadOnly, path).ok()?;
        Some(Mapping::Mapped(mapped))
    }

    #[cfg(not(all(feature = "mmap", any(unix, windows))))]
    fn mapped(_: &File, _: &Path) -> Option<Mapping> {
        None
    }

    fn read(mut file: File) -> io::Result<Mapping> {
        let length = usize::try_from(file.metadata()?.len())
            .map_err(|_| io::Error::from(io::ErrorKind::FileTooLarge))?;
        let mut words = Vec::new();
        words.try_reserve_exact(length.div_ceil(8))?;
        words.resize(length.div_ceil(8), 0);
        file.read_exact(&mut bytemuck::cast_slice_mut(&mut words)[..length])?;
        Ok(Mapping::Read { words, length })
    }

    /// All bytes.
    pub(super) fn bytes(&self) -> &[u8] {
        match self {
            #[cfg(all(feature = "mmap", any(unix, windows)))]
            // Fails for nothing but a range that the file does not have.
            Mapping::Mapped(mapped) => mapped.as_slice_bytes(0, mapped.len()).unwrap_or_default(),
            Mapping::Read { words, length } => &bytemuck::cast_slice(words)[..*length],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn read_and_mapped_give_the_same_bytes() {
        let path = std::env::temp_dir().join(format!("antumbra-mapping-{}", std::process::id()));
        for length in [1, 7, 8, 4097] {
            let bytes: Vec<u8> = (0..length).map(|i| (i * 31) as u8).collect();
            std::fs::write(&path, &bytes).expect("written");
            let open = || File::open(&path).expect("there");
            let read = Mapping::read(open()).expect("read");
            let opened = Mapping::open(open(), &path).expect("opened");
            assert_eq!((read.bytes(), opened.bytes()), (&bytes[..], &bytes[..]));
            assert_eq!(opened.bytes().as_ptr() as usize % 8, 0);
        }
        std::fs::remove_file(&path).expect("removed");
    }
}
