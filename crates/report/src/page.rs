//! A page of a report, in whatever form it is wanted.

use crate::document::{Block, figures, files};
use crate::{Figure, html, markdown};

/// Text, tables and figures under a title.
#[derive(Debug, Clone, PartialEq)]
pub struct Page {
    pub(crate) title: String,
    pub(crate) blocks: Vec<Block>,
}

impl Page {
    /// The same with a paragraph at the end.
    #[must_use]
    pub fn with_closing(mut self, text: impl Into<String>) -> Self {
        self.blocks.push(Block::text(text));
        self
    }

    /// The first line of [`Self::markdown`].
    #[must_use]
    pub fn markdown_heading(&self) -> String {
        format!("# {}\n", self.title)
    }

    /// As Markdown; `folder` is where its [figures](Self::figures) lie as `NAME.svg`, as seen from the file.
    #[must_use]
    pub fn markdown(&self, folder: &str) -> String {
        markdown::markdown(&self.title, &self.blocks, folder)
    }

    /// As one HTML file that needs nothing else, light or dark as the reader prefers.
    #[must_use]
    pub fn html(&self) -> String {
        html::page(&self.title, &self.blocks)
    }

    /// Names and contents of the files that the page has links to: they lie beside [HTML](Self::html), and in the folder of [Markdown](Self::markdown).
    pub fn files(&self) -> impl Iterator<Item = (&str, &str)> {
        files(&self.blocks).map(|file| (&*file.name, &*file.contents))
    }

    /// All figures.
    pub fn figures(&self) -> impl Iterator<Item = &Figure> {
        figures(&self.blocks)
    }
}
