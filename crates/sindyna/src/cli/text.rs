//! Text for standard output.

use super::plain::plain;

/// Text for standard output.
#[derive(Debug)]
pub(crate) enum Text {
    /// For people to read: nothing that a terminal obeys.
    People(String),
    /// For other programs, as it is.
    Programs(String),
}

impl Text {
    pub(super) fn shown(&self) -> std::borrow::Cow<'_, str> {
        match self {
            Self::People(text) => plain(text),
            Self::Programs(text) => text.into(),
        }
    }
}
