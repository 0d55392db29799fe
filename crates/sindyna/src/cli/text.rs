//! Text for standard output.

use sindyna_report::text::fitted;

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
    /// What is written, on a terminal of `width` columns if it is one.
    pub(super) fn shown(&self, width: Option<usize>) -> std::borrow::Cow<'_, str> {
        match self {
            Self::People(text) => match width {
                Some(width) => fitted(&plain(text), width).into(),
                None => plain(text),
            },
            Self::Programs(text) => text.into(),
        }
    }
}
