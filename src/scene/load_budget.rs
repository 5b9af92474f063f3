//! How much memory a file may make us take.
//!
//! A file can claim more than it holds: a count of four billion, a thousand accessors over the same bytes, an empty
//! record of three bytes that becomes a hundred in memory. Reading it must stay under ten times the file's size plus
//! 64 MiB. So every allocation whose size a file decides is reserved here *before* it is made. The limit leaves room
//! for the file itself and for the process; ordinary scenes take two to four times their size, the densest sound ones
//! (strips of bytes) about six.

use std::cell::Cell;
use std::fmt;

use super::error::Fault;

/// Bytes that may be taken for each byte of input.
const PER_INPUT_BYTE: u64 = 8;
/// Bytes that may be taken by the smallest file.
const ALLOWANCE: u64 = 40 << 20;

/// Bytes that an object costs from when it is read until its scene is made: itself, its bounds, and the hierarchy
/// over it while that is built.
pub(super) const OBJECT_BYTES: u64 = 560;

/// What has been read and what has been reserved.
#[derive(Debug, Default)]
pub(super) struct LoadBudget {
    input: Cell<u64>,
    reserved: Cell<u64>,
}

impl LoadBudget {
    /// Counts bytes read from a file: they raise the limit.
    pub(super) fn has_read(&self, bytes: u64) {
        self.input.set(self.input.get().saturating_add(bytes));
    }

    /// Takes `bytes`, or says that `what` is out of proportion.
    pub(super) fn reserve(&self, bytes: u64, what: impl fmt::Display) -> Result<(), Fault> {
        let needed = self.reserved.get().saturating_add(bytes);
        let limit = self
            .input
            .get()
            .saturating_mul(PER_INPUT_BYTE)
            .saturating_add(ALLOWANCE);
        if needed > limit {
            return Err(Fault::too_large(what, needed, limit));
        }
        self.reserved.set(needed);
        Ok(())
    }

    /// Gives back what was reserved.
    pub(super) fn release(&self, bytes: u64) {
        self.reserved.set(self.reserved.get().saturating_sub(bytes));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_limit_grows_with_the_input_and_nothing_overflows() {
        let budget = LoadBudget::default();
        assert!(budget.reserve(ALLOWANCE, "x").is_ok());
        assert!(budget.reserve(1, "x").is_err());
        budget.has_read(1);
        assert!(budget.reserve(8, "x").is_ok());
        assert!(budget.reserve(u64::MAX, "x").is_err());
        budget.release(u64::MAX);
        budget.has_read(u64::MAX);
        assert!(budget.reserve(u64::MAX, "x").is_ok());
    }
}
