//! A page in Markdown: findings, tables, how they were measured.

use std::fmt::Write as _;

/// Paragraphs, lists and tables, one after the other.
#[derive(Debug, Clone, Default)]
pub struct Page(String);

impl Page {
    /// A page called `title`.
    #[must_use]
    pub fn new(title: &str) -> Self {
        Self(format!("# {title}\n"))
    }

    /// A part of the page.
    #[must_use]
    pub fn section(self, title: &str) -> Self {
        self.text(&format!("## {title}"))
    }

    /// A paragraph; nothing if it is empty.
    #[must_use]
    pub fn text(mut self, paragraph: &str) -> Self {
        if !paragraph.is_empty() {
            let _ = write!(self.0, "\n{paragraph}\n");
        }
        self
    }

    /// A list; nothing if it is empty.
    #[must_use]
    pub fn list(self, points: impl IntoIterator<Item = String>) -> Self {
        let lines: Vec<String> = points.into_iter().map(|point| format!("- {point}")).collect();
        self.text(&lines.join("\n"))
    }

    /// Lines as they are.
    #[must_use]
    pub fn code(self, lines: &[String]) -> Self {
        self.text(&format!("```text\n{}\n```", lines.join("\n")))
    }

    /// A table; nothing if it has no rows.
    #[must_use]
    pub fn table<S: AsRef<str>>(mut self, head: &[S], rows: impl IntoIterator<Item = Vec<String>>) -> Self {
        let mut rows = rows.into_iter().peekable();
        if rows.peek().is_some() {
            let head: Vec<&str> = head.iter().map(AsRef::as_ref).collect();
            let _ = write!(self.0, "\n| {} |\n|{}\n", head.join(" | "), "---|".repeat(head.len()));
            for row in rows {
                let _ = writeln!(self.0, "| {} |", row.join(" | "));
            }
        }
        self
    }

    /// The text.
    #[must_use]
    pub fn markdown(self) -> String {
        self.0
    }
}
