//! Versions of formats: 1 is not written, so that files of before there were versions are the same.

use crate::RecordError;

/// The version that is written.
pub(crate) const CURRENT: u32 = 1;

/// What a file without a version has.
pub(crate) fn first() -> u32 {
    1
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde asks so")]
pub(crate) fn is_first(format: &u32) -> bool {
    *format == 1
}

/// Refuses a version that this program does not know.
pub(crate) fn check(what: &'static str, format: u32) -> Result<(), RecordError> {
    if (1..=CURRENT).contains(&format) { Ok(()) } else { Err(RecordError::Format { what, format, known: CURRENT }) }
}
