//! Errors as the user meets them: what is wrong, and what to do about it.

use std::fmt;

use anstyle::{AnsiColor, Style};
use serde_json::{Value, json};
use sindyna_record::RecordError;

use crate::cli::hints;
use crate::cli::plain::message;

/// Why a command could not run, with a hint where there is one.
#[derive(Debug)]
pub(crate) struct Failure {
    error: anyhow::Error,
    kind: &'static str,
    hint: Option<String>,
}

impl Failure {
    /// A failure that says `message`.
    pub(crate) fn new(message: impl fmt::Display + fmt::Debug + Send + Sync + 'static) -> Self {
        Self { error: anyhow::Error::msg(message), kind: "input", hint: None }
    }

    /// A command line that cannot be understood.
    pub(crate) fn usage(message: String) -> Self {
        Self { kind: "usage", ..Self::new(message) }
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

    /// Adds what the user can do about it, where nothing nearer is known.
    pub(crate) fn or_hint(self, hint: impl Into<String>) -> Self {
        if self.hint.is_some() { self } else { self.hint(hint) }
    }

    /// What it says, with its hint.
    pub(crate) fn text(&self) -> String {
        let hint = self.what_helps().map(|hint| format!("\n\nhint: {hint}")).unwrap_or_default();
        message(&format!("{:#}{hint}", self.error))
    }

    /// The same as an object.
    pub(super) fn json(&self) -> Value {
        json!({"kind": self.kind, "message": format!("{:#}", self.error), "hint": self.what_helps()})
    }

    fn what_helps(&self) -> Option<&str> {
        match (&self.hint, self.disk_is_full()) {
            (Some(hint), _) => Some(hint.as_str()),
            (None, true) => Some("free some room, or name a directory on another disk with --out"),
            (None, false) => None,
        }
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
        Self { hint: hints::of(&error), kind: hints::kind(&error), error }
    }
}

/// With colours; a stream takes them out where none are wanted.
impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let bold = |color: AnsiColor| Style::new().bold().fg_color(Some(color.into()));
        let (red, cyan) = (bold(AnsiColor::Red), bold(AnsiColor::Cyan));
        let text = self.text();
        let text = text.replacen("\n\nhint:", &format!("\n\n{cyan}hint:{cyan:#}"), 1);
        write!(f, "{red}error:{red:#} {text}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn causes_and_hints_are_printed() {
        let cause = std::io::Error::other("no space left");
        let failure = Failure::from(anyhow::Error::new(cause).context("cannot write a.json")).hint("free some room");
        assert_eq!(failure.text(), "cannot write a.json: no space left\n\nhint: free some room");
        let shown = anstream::adapter::strip_str(&failure.to_string()).to_string();
        assert_eq!(shown, "error: cannot write a.json: no space left\n\nhint: free some room");
        let expected = json!({"kind": "io", "message": "cannot write a.json: no space left", "hint": "free some room"});
        assert_eq!(failure.json(), expected);
    }
}
