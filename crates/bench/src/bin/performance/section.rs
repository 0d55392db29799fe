//! Parts of docs/performance.md.

use sindyna_bench::study::Page;

/// A part of the page, and what it says in a sentence or two.
pub(crate) struct Section {
    pub(crate) findings: Vec<String>,
    pub(crate) body: Page,
}

impl Section {
    pub(crate) fn new(title: &str, findings: impl IntoIterator<Item = String>) -> Self {
        Self { findings: findings.into_iter().collect(), body: Page::default().section(title) }
    }

    /// The same with `more` on its page.
    pub(crate) fn with(self, more: impl FnOnce(Page) -> Page) -> Self {
        Self { body: more(self.body), ..self }
    }
}
