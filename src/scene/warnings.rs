//! What was understood but left out, gathered so that a thousand alike make one sentence.
//!
//! Nothing may be skipped silently, and nothing may flood: each kind is kept once, with how often and where first.

use std::fmt;

/// The warnings of one load.
#[derive(Debug, Default)]
pub(super) struct Warnings {
    kinds: Vec<(&'static str, u64, String)>,
}

impl Warnings {
    /// Notes one thing left out, at `place`.
    pub(super) fn note(&mut self, kind: &'static str, place: impl fmt::Display) {
        match self.kinds.iter_mut().find(|(k, ..)| *k == kind) {
            Some((_, count, _)) => *count += 1,
            None => self.kinds.push((kind, 1, place.to_string())),
        }
    }

    /// One sentence each, in the order they were first met.
    pub(super) fn into_sentences(self) -> Vec<String> {
        let sentence = |(kind, count, place): (&str, u64, String)| match count {
            1 => format!("{place}: {kind}"),
            _ => format!("{place} and {} more: {kind}", count - 1),
        };
        self.kinds.into_iter().map(sentence).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn alike_warnings_make_one_sentence() {
        let mut warnings = Warnings::default();
        warnings.note("draws lines", "mesh 1");
        warnings.note("draws points", "mesh 2");
        warnings.note("draws lines", "mesh 3");
        assert_eq!(
            warnings.into_sentences(),
            ["mesh 1 and 1 more: draws lines", "mesh 2: draws points"]
        );
    }
}
