//! Lines to stdout and stderr that survive a closed pipe.

use std::fmt::Display;
use std::io::{ErrorKind, Write, stderr, stdout};

use super::failure::Failure;

/// Warnings of one kind shown before the rest is only counted.
const MOST_WARNINGS: usize = 5;

/// Writes a line to stdout. A reader that has gone away is no failure; a full disk is.
///
/// # Errors
/// If stdout cannot be written for another reason than a closed pipe.
pub fn say(line: impl Display) -> Result<(), Failure> {
    match writeln!(stdout().lock(), "{line}") {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(Failure::Failed(format!(
            "stdout: cannot be written: {error}"
        ))),
        _ => Ok(()),
    }
}

/// Writes a line to stderr: `kind: line`. There is nowhere to complain if that fails.
pub fn complain(kind: &str, line: impl Display) {
    let _ = writeln!(stderr().lock(), "{kind}: {line}");
}

/// Passes a scene's warnings on.
pub fn warn(warnings: &[String]) {
    for warning in warnings.iter().take(MOST_WARNINGS) {
        complain("warning", warning);
    }
    if warnings.len() > MOST_WARNINGS {
        complain(
            "warning",
            format!("and {} more", warnings.len() - MOST_WARNINGS),
        );
    }
}

/// A count with its thousands apart.
pub fn thousands(count: u64) -> String {
    let digits = count.to_string();
    let mut grouped = String::with_capacity(digits.len() * 4 / 3);
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            grouped.push(',');
        }
        grouped.push(digit);
    }
    grouped
}

/// A count of things, thousands apart: `1 object`, `2,000 objects`.
pub fn count_of(count: u64, thing: &str) -> String {
    let plural = if count == 1 { "" } else { "s" };
    format!("{} {thing}{plural}", thousands(count))
}

/// `part` of `whole` in per cent; of nothing, everything.
pub fn percent(part: u64, whole: u64) -> f64 {
    if whole == 0 {
        100.0
    } else {
        part as f64 * 100.0 / whole as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thousands_are_set_apart() {
        assert_eq!(thousands(0), "0");
        assert_eq!(thousands(999), "999");
        assert_eq!(thousands(1_000), "1,000");
        assert_eq!(thousands(12_345_678), "12,345,678");
    }
}
