//! How a call ends: a status, a message, and nothing that unwinds into C.

use std::any::Any;
use std::cell::RefCell;
use std::ffi::{CStr, CString, c_char};
use std::fmt::Display;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// How a call ended. Later versions may have more errors than these.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(non_camel_case_types, reason = "these are the names in C")]
pub enum AntumbraStatus {
    /// All went well.
    ANTUMBRA_OK = 0,
    /// A pointer that has to point to something is NULL.
    ANTUMBRA_ERROR_NULL_POINTER = 1,
    /// An argument makes no sense: a number that is not finite or out of its range, a value that no list has, a matrix that is not
    /// affine, indices without vertices.
    ANTUMBRA_ERROR_INVALID_ARGUMENT = 2,
    /// There is no object, mesh, cluster, frame or pixel of that number.
    ANTUMBRA_ERROR_OUT_OF_RANGE = 3,
    /// The size of a struct is none that this version knows.
    ANTUMBRA_ERROR_STRUCT_SIZE = 4,
    /// A string is not UTF-8.
    ANTUMBRA_ERROR_UTF8 = 5,
    /// A file cannot be read or written.
    ANTUMBRA_ERROR_IO = 6,
    /// A file is damaged, of an unknown kind or version, or asks for what is not built in.
    ANTUMBRA_ERROR_FILE = 7,
    /// A scene built in memory makes no sense: the message names the mesh or object and the cause.
    ANTUMBRA_ERROR_SCENE = 8,
    /// The call comes at the wrong time: drawing after the end of drawing, asking before the first frame.
    ANTUMBRA_ERROR_STATE = 9,
    /// Another thread is using the handle, and one of the two calls changes it. Nothing was done.
    ANTUMBRA_ERROR_BUSY = 10,
    /// The operating system gives no threads.
    ANTUMBRA_ERROR_THREADS = 11,
    /// This machine or build lacks the instruction set.
    ANTUMBRA_ERROR_LEVEL = 12,
    /// A fault in Antumbra itself: please report it, with the message. A handle that was being changed is broken from then on.
    ANTUMBRA_ERROR_INTERNAL = 13,
    /// The handle is broken: an earlier call on it ended with ANTUMBRA_ERROR_INTERNAL. It can only be destroyed.
    ANTUMBRA_ERROR_BROKEN = 14,
}

use AntumbraStatus::*;

/// Why a call cannot do what it is asked for.
#[derive(Debug)]
pub struct Error {
    pub status: AntumbraStatus,
    message: String,
}

impl Error {
    pub fn new(status: AntumbraStatus, message: impl Display) -> Error {
        Error {
            status,
            message: message.to_string(),
        }
    }

    /// An argument that makes no sense.
    pub fn invalid(message: impl Display) -> Error {
        Error::new(ANTUMBRA_ERROR_INVALID_ARGUMENT, message)
    }

    /// There is no such thing among so many.
    pub fn out_of_range(what: &str, index: impl Display, count: usize) -> Error {
        Error::new(
            ANTUMBRA_ERROR_OUT_OF_RANGE,
            format_args!("there is no {what} {index}: there are {count}"),
        )
    }

    /// A call at the wrong time.
    pub fn state(message: &str) -> Error {
        Error::new(ANTUMBRA_ERROR_STATE, message)
    }
}

thread_local! {
    static LAST_ERROR: RefCell<Option<CString>> = const { RefCell::new(None) };
}

/// C cannot hold a NUL within a string.
pub fn c_string(text: &str) -> CString {
    CString::new(text.replace('\0', "\u{fffd}")).unwrap_or_default()
}

fn remember(message: &str) {
    let message = c_string(message);
    // While a thread ends there may be no place left: then nobody can ask either.
    let _ = LAST_ERROR.try_with(|last| last.replace(Some(message)));
}

fn message_of(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<&str>().copied();
    text.or_else(|| panic.downcast_ref::<String>().map(String::as_str))
        .unwrap_or("unknown")
}

/// Does what a call is for. Every exported function that can fail is wrapped in this.
pub fn guard(call: impl FnOnce() -> Result<(), Error>) -> AntumbraStatus {
    // What a panic leaves half done is behind a handle's lock, which it poisons.
    match catch_unwind(AssertUnwindSafe(call)) {
        Ok(Ok(())) => ANTUMBRA_OK,
        Ok(Err(error)) => {
            remember(&error.message);
            error.status
        }
        Err(panic) => {
            let message = message_of(&*panic);
            remember(&format!("a fault in Antumbra: {message}"));
            ANTUMBRA_ERROR_INTERNAL
        }
    }
}

/// What was wrong with the last call on this thread that failed: a sentence in UTF-8 for people, which names the argument, file
/// or object, and what to do. It is empty if none failed yet. It is valid until the next call on this thread that fails, and
/// never NULL.
#[unsafe(no_mangle)]
pub extern "C" fn antumbra_last_error() -> *const c_char {
    const NONE: *const c_char = c"".as_ptr();
    let last = LAST_ERROR.try_with(|last| last.borrow().as_ref().map_or(NONE, |m| m.as_ptr()));
    last.unwrap_or(NONE)
}

/// The names, in the order of the numbers.
const NAMES: [(AntumbraStatus, &CStr); 15] = [
    (ANTUMBRA_OK, c"ANTUMBRA_OK"),
    (ANTUMBRA_ERROR_NULL_POINTER, c"ANTUMBRA_ERROR_NULL_POINTER"),
    (
        ANTUMBRA_ERROR_INVALID_ARGUMENT,
        c"ANTUMBRA_ERROR_INVALID_ARGUMENT",
    ),
    (ANTUMBRA_ERROR_OUT_OF_RANGE, c"ANTUMBRA_ERROR_OUT_OF_RANGE"),
    (ANTUMBRA_ERROR_STRUCT_SIZE, c"ANTUMBRA_ERROR_STRUCT_SIZE"),
    (ANTUMBRA_ERROR_UTF8, c"ANTUMBRA_ERROR_UTF8"),
    (ANTUMBRA_ERROR_IO, c"ANTUMBRA_ERROR_IO"),
    (ANTUMBRA_ERROR_FILE, c"ANTUMBRA_ERROR_FILE"),
    (ANTUMBRA_ERROR_SCENE, c"ANTUMBRA_ERROR_SCENE"),
    (ANTUMBRA_ERROR_STATE, c"ANTUMBRA_ERROR_STATE"),
    (ANTUMBRA_ERROR_BUSY, c"ANTUMBRA_ERROR_BUSY"),
    (ANTUMBRA_ERROR_THREADS, c"ANTUMBRA_ERROR_THREADS"),
    (ANTUMBRA_ERROR_LEVEL, c"ANTUMBRA_ERROR_LEVEL"),
    (ANTUMBRA_ERROR_INTERNAL, c"ANTUMBRA_ERROR_INTERNAL"),
    (ANTUMBRA_ERROR_BROKEN, c"ANTUMBRA_ERROR_BROKEN"),
];

/// The name of a status, such as "ANTUMBRA_ERROR_FILE"; "unknown" if it has none. Valid forever.
#[unsafe(no_mangle)]
pub extern "C" fn antumbra_status_name(status: u32) -> *const c_char {
    let named = NAMES.get(status as usize);
    named.map_or(c"unknown", |(_, name)| name).as_ptr()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The message as C reads it.
    fn last_error() -> String {
        let held = LAST_ERROR.with(|last| last.borrow().clone());
        let pointer = antumbra_last_error();
        let held = held.unwrap_or_default();
        assert_eq!(held.is_empty(), pointer == c"".as_ptr());
        held.into_string().expect("UTF-8")
    }

    #[test]
    fn a_panic_ends_as_a_status_with_its_message() {
        let status = guard(|| panic!("{} is not {}", 1, 2));
        assert_eq!(status, ANTUMBRA_ERROR_INTERNAL);
        assert_eq!(last_error(), "a fault in Antumbra: 1 is not 2");
    }

    #[test]
    fn a_message_stays_until_the_next_one_of_the_same_thread() {
        let fail = |message: &'static str| move || Err(Error::invalid(message));
        assert_eq!(guard(fail("first")), ANTUMBRA_ERROR_INVALID_ARGUMENT);
        assert_eq!(guard(|| Ok(())), ANTUMBRA_OK);
        std::thread::spawn(move || {
            assert_eq!(last_error(), "");
            guard(fail("of another thread"));
        })
        .join()
        .expect("ended");
        assert_eq!(last_error(), "first");
        guard(fail("with a \0 in it"));
        assert_eq!(last_error(), "with a \u{fffd} in it");
    }

    #[test]
    fn names_stand_at_their_numbers() {
        for (number, (status, name)) in NAMES.iter().enumerate() {
            assert_eq!(*status as usize, number);
            assert_eq!(name.to_str(), Ok(&*format!("{status:?}")));
        }
        assert_eq!(antumbra_status_name(15), c"unknown".as_ptr());
    }
}
