//! Which version this is, in the header and in the library.

use std::ffi::{CStr, c_char};

/// The header's version: programs for one major version run with every library of that version.
pub const ANTUMBRA_VERSION_MAJOR: u32 = 0;
/// Grows with what is added. While the major version is 0, what is there may change with it too.
pub const ANTUMBRA_VERSION_MINOR: u32 = 1;
/// Grows with what is mended.
pub const ANTUMBRA_VERSION_PATCH: u32 = 0;

const VERSION: &CStr =
    match CStr::from_bytes_with_nul(concat!(env!("CARGO_PKG_VERSION"), "\0").as_bytes()) {
        Ok(version) => version,
        Err(_) => panic!("a version has no NUL"),
    };

/// The library's version, such as "0.1.0"; valid forever. It can differ from the header's ANTUMBRA_VERSION_MAJOR, _MINOR and
/// _PATCH where the library is shared.
#[unsafe(no_mangle)]
pub extern "C" fn antumbra_version() -> *const c_char {
    VERSION.as_ptr()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_header_has_the_library_s_version() {
        let header = [
            ANTUMBRA_VERSION_MAJOR,
            ANTUMBRA_VERSION_MINOR,
            ANTUMBRA_VERSION_PATCH,
        ];
        let header = header.map(|number| number.to_string()).join(".");
        assert_eq!(VERSION.to_str(), Ok(&*header));
    }
}
