//! Errors as the user meets them: what is wrong, and what to do about it.

use std::fmt;

use sindyna_record::RecordError;

use crate::cli::hints;
use crate::cli::plain::message;

/// Why a command could not run, with a hint where there is one.
#[derive(Debug)]
pub(crate) struct Failure {
    error: anyhow::Error,
    hint: Option<String>,
}

impl Failure {
    /// A failure that says `message`.
    pub(crate) fn new(message: impl fmt::Display + fmt::Debug + Send + Sync + 'static) -> Self {
        Self { error: anyhow::Error::msg(message), hint: None }
    }

    /// A file that was not to be written over; `option` names another.
    pub(crate) fn of_own(error: RecordError, option: &str) -> Self {
        let is_own = matches!(error, RecordError::NotOwn { .. });
        let failure = Self::from(error);
        if is_own { failure.hint(format!("name another file with {option}")) } else { failure }
    }

    /// Adds what the user can do about it.
    pub(crate) fn hint(mut self, hint: impl Into<String>) -> Self {
        self.hint = Some(hint.into());
        self
    }

    /// What it says, with its hint.
    pub(crate) fn text(&self) -> String {
        self.beginning_with("")
    }

    fn beginning_with(&self, word: &str) -> String {
        let hint = match (&self.hint, self.disk_is_full()) {
            (Some(hint), _) => Some(hint.as_str()),
            (None, true) => Some("free some room, or name a directory on another disk with --out"),
            (None, false) => None,
        };
        let hint = hint.map(|hint| format!("\n\nhint: {hint}")).unwrap_or_default();
        message(&format!("{word}{:#}{hint}", self.error))
    }

    fn disk_is_full(&self) -> bool {
        use std::io::{Error, ErrorKind};
        self.error.chain().any(|cause| {
            cause
                .downcast_ref::<Error>()
                .is_some_and(|e| matches!(e.kind(), ErrorKind::StorageFull | ErrorKind::QuotaExceeded))
        })
    }
}

impl<E: Into<anyhow::Error>> From<E> for Failure {
    fn from(error: E) -> Self {
        let error = error.into();
        Self { hint: hints::of(&error), error }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.beginning_with("error: "))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn causes_and_hints_are_printed() {
        let cause = std::io::Error::other("no space left");
        let failure = Failure::from(anyhow::Error::new(cause).context("cannot write a.json")).hint("free some room");
        assert_eq!(failure.to_string(), "error: cannot write a.json: no space left\n\nhint: free some room");
    }
}
