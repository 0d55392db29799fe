//! What a report consists of, before it is a page or Markdown.

use super::figure::Figure;

/// A part of a report.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Block {
    /// A section begins.
    Section(String),
    /// A part of a section begins.
    Part(String),
    Text(String),
    /// What a page is about, in a sentence; whether it is good news, where that is known.
    Verdict {
        good: Option<bool>,
        text: String,
    },
    /// What is HTML already, every name in it escaped, and the same as text.
    Markup {
        html: String,
        text: String,
    },
    /// Names of things in the first `words` columns, numbers in the others.
    Table {
        words: usize,
        head: Vec<String>,
        rows: Vec<Vec<String>>,
    },
    Figures(Vec<Figure>),
    Code(String),
    /// Sentences, each for itself.
    List(Vec<String>),
    /// A file beside the page.
    File(File),
}

/// A file beside a page, of which the page has a link.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct File {
    pub(crate) name: String,
    /// What stands before the link.
    pub(crate) text: String,
    pub(crate) contents: String,
}

impl Block {
    pub(crate) fn text(text: impl Into<String>) -> Self {
        Self::Text(text.into())
    }

    pub(crate) fn table<const N: usize>(words: usize, head: [&str; N], rows: Vec<[String; N]>) -> Self {
        let rows = rows.into_iter().map(|row| row.to_vec()).collect();
        Self::Table { words, head: head.map(String::from).to_vec(), rows }
    }
}

/// All files beside a report.
pub(crate) fn files(blocks: &[Block]) -> impl Iterator<Item = &File> {
    blocks.iter().filter_map(|block| match block {
        Block::File(file) => Some(file),
        _ => None,
    })
}

/// All figures of a report.
pub(crate) fn figures(blocks: &[Block]) -> impl Iterator<Item = &Figure> {
    blocks.iter().flat_map(|block| match block {
        Block::Figures(figures) => &figures[..],
        _ => &[],
    })
}
