//! Names that a comparison may have.

/// The names that a comparison may have, in their usual order: others become neither names of files nor text in pages.
#[derive(Debug, Clone, Copy)]
pub struct Names<'a> {
    /// Tasks.
    pub tasks: &'a [&'a str],
    /// Methods.
    pub methods: &'a [&'a str],
}
