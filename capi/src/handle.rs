//! Handles that lock themselves.
//!
//! Calls that only read may come from any number of threads, those that change need a handle for themselves. A caller who
//! mistakes that gets an error, for nobody ever waits for a lock here. And as a lock knows when a panic left its holder, nothing
//! half done is used again.

use std::sync::{RwLock, RwLockReadGuard, RwLockWriteGuard, TryLockError};

use crate::status::AntumbraStatus::{ANTUMBRA_ERROR_BROKEN, ANTUMBRA_ERROR_BUSY};
use crate::status::Error;

/// What is behind a handle that calls change.
#[derive(Debug)]
pub struct Locked<T>(RwLock<T>);

impl<T: Send + Sync> Locked<T> {
    pub fn new(value: T) -> Locked<T> {
        Locked(RwLock::new(value))
    }

    /// To read, together with others who read.
    pub fn read(&self) -> Result<RwLockReadGuard<'_, T>, Error> {
        self.0.try_read().map_err(why)
    }

    /// To change, alone.
    pub fn write(&self) -> Result<RwLockWriteGuard<'_, T>, Error> {
        self.0.try_write().map_err(why)
    }
}

/// Fails to compile for what threads cannot share.
pub const fn is_shared_by_threads<T: Send + Sync>() {}

fn why<G>(error: TryLockError<G>) -> Error {
    match error {
        TryLockError::WouldBlock => Error::new(
            ANTUMBRA_ERROR_BUSY,
            "another thread is using the handle: calls that change it need it for themselves",
        ),
        TryLockError::Poisoned(_) => Error::new(
            ANTUMBRA_ERROR_BROKEN,
            "the handle was broken by a fault in an earlier call: it can only be destroyed",
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::status::AntumbraStatus::{self, ANTUMBRA_ERROR_INTERNAL, ANTUMBRA_OK};
    use crate::status::guard;

    fn change(handle: &Locked<i32>, by: impl FnOnce(&mut i32)) -> AntumbraStatus {
        guard(|| {
            by(&mut *handle.write()?);
            Ok(())
        })
    }

    fn look(handle: &Locked<i32>) -> AntumbraStatus {
        guard(|| {
            drop(handle.read()?);
            Ok(())
        })
    }

    #[test]
    fn readers_share_and_writers_do_not() {
        let handle = Locked::new(1);
        let reading = handle.read().expect("nobody writes");
        assert_eq!(look(&handle), ANTUMBRA_OK);
        assert_eq!(change(&handle, |n| *n = 2), ANTUMBRA_ERROR_BUSY);
        drop(reading);
        let writing = handle.write().expect("nobody reads");
        assert_eq!(look(&handle), ANTUMBRA_ERROR_BUSY);
        drop(writing);
        assert_eq!(change(&handle, |n| *n = 2), ANTUMBRA_OK);
    }

    #[test]
    fn what_a_panic_left_half_done_is_not_used_again() {
        let handle = Locked::new(1);
        let by = |n: &mut i32| {
            *n = 2;
            panic!("in the middle");
        };
        assert_eq!(change(&handle, by), ANTUMBRA_ERROR_INTERNAL);
        assert_eq!(change(&handle, |n| *n = 3), ANTUMBRA_ERROR_BROKEN);
        assert_eq!(look(&handle), ANTUMBRA_ERROR_BROKEN);
    }

    #[test]
    fn a_panic_of_a_reader_breaks_nothing() {
        let handle = Locked::new(1);
        let status = guard(|| {
            let _reading = handle.read()?;
            panic!("while reading");
        });
        assert_eq!(status, ANTUMBRA_ERROR_INTERNAL);
        assert_eq!(look(&handle), ANTUMBRA_OK);
    }
}
