//! What C alone can vouch for: how long lists and strings are, and that a handle is one. All unsafe code of the interface.

use std::ffi::{CStr, c_char};
use std::mem::MaybeUninit;
use std::path::Path;
use std::slice;

use crate::status::AntumbraStatus::{ANTUMBRA_ERROR_NULL_POINTER, ANTUMBRA_ERROR_UTF8};
use crate::status::Error;

/// Makes sure that a list can be one, as far as can be seen from here.
fn check<T>(first: *const T, count: usize, name: &str) -> Result<(), Error> {
    if first.is_null() {
        return Err(Error::new(
            ANTUMBRA_ERROR_NULL_POINTER,
            format_args!("{name} must not be NULL"),
        ));
    }
    if !first.is_aligned() {
        let alignment = align_of::<T>();
        return Err(Error::invalid(format_args!(
            "{name} is not at a multiple of {alignment} bytes"
        )));
    }
    let bytes = count.checked_mul(size_of::<T>());
    if bytes.is_none_or(|bytes| bytes > isize::MAX as usize) {
        return Err(Error::invalid(format_args!(
            "{name}: {count} elements are more than memory holds"
        )));
    }
    Ok(())
}

/// `count` elements, none of which may change during the call; NULL if there are none.
pub fn list<'a, T>(first: *const T, count: usize, name: &str) -> Result<&'a [T], Error> {
    if count == 0 {
        return Ok(&[]);
    }
    check(first, count, name)?;
    // SAFETY: not null, aligned, and no larger than memory, as checked. That there are so many elements, which nobody changes during the
    // call, is what the header asks of the caller; what is made of the list does not outlive the call.
    Ok(unsafe { slice::from_raw_parts(first, count) })
}

/// Room for `count` elements; NULL if there are none.
pub fn room<'a, T>(
    first: *mut T,
    count: usize,
    name: &str,
) -> Result<&'a mut [MaybeUninit<T>], Error> {
    if count == 0 {
        return Ok(&mut []);
    }
    check(first, count, name)?;
    // SAFETY: as in `list`; that nobody else has access to the room during the call is asked of the caller too. It need not hold anything
    // yet.
    Ok(unsafe { slice::from_raw_parts_mut(first.cast(), count) })
}

/// A handle that a call changes. It locks itself, so nothing is lost if others have it too.
pub fn handle<'a, T>(handle: *mut T, name: &str) -> Result<&'a T, Error> {
    check(handle, 1, name)?;
    // SAFETY: not null, aligned. That it was created and not destroyed is asked of the caller. Nobody has a `&mut` to a handle.
    Ok(unsafe { &*handle })
}

/// A string in UTF-8.
pub fn string<'a>(text: *const c_char, name: &str) -> Result<&'a str, Error> {
    if text.is_null() {
        return Err(Error::new(
            ANTUMBRA_ERROR_NULL_POINTER,
            format_args!("{name} must not be NULL"),
        ));
    }
    // SAFETY: not null. That it ends with a NUL and does not change during the call is asked of the caller; what is made of it does not
    // outlive the call.
    let text = unsafe { CStr::from_ptr(text) };
    text.to_str().map_err(|error| {
        let message = format_args!("{name} is not UTF-8: {error}");
        Error::new(ANTUMBRA_ERROR_UTF8, message)
    })
}

/// The name of a file in UTF-8.
pub fn path<'a>(file: *const c_char, name: &str) -> Result<&'a Path, Error> {
    Ok(Path::new(string(file, name)?))
}
