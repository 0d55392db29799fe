//! Names that a comparison may have.

/// The names that a comparison may have, in their usual order: others become neither names of files nor text in pages.
#[derive(Debug, Clone, Copy)]
pub struct Names<'a> {
    /// Tasks that come along. Others may be called with letters, digits, `-` and `_`.
    pub tasks: &'a [&'a str],
    /// Methods. Each may have variants, `METHOD+NAME`.
    pub methods: &'a [&'a str],
}

/// What stands between a method and the name of its variant.
const JOINT: char = '+';

/// Characters of the name of a variant; a task has four times as many bytes.
const LONGEST: usize = 40;

impl Names<'_> {
    /// Whether a comparison may have the task `name`.
    #[must_use]
    pub fn has_task(&self, name: &str) -> bool {
        let plain = |c: char| c.is_alphanumeric() || c == '-' || c == '_';
        self.tasks.contains(&name) || ((1..=4 * LONGEST).contains(&name.len()) && name.chars().all(plain))
    }

    /// Whether a comparison may have the method `name`, or the variant.
    #[must_use]
    pub fn has_method(&self, name: &str) -> bool {
        let variant = name.split_once(JOINT).map(|(_, variant)| variant);
        self.methods.contains(&base(name)) && variant.is_none_or(is_variant)
    }
}

/// The method that the method or variant `name` is, or is a variant of.
#[must_use]
pub fn base(name: &str) -> &str {
    name.split_once(JOINT).map_or(name, |(base, _)| base)
}

/// The name of the variant `name` of `method`.
#[must_use]
pub fn variant(method: &str, name: &str) -> String {
    format!("{method}{JOINT}{name}")
}

/// Whether `name` can be that of a variant: letters, digits, `-` and `_`.
#[must_use]
pub fn is_variant(name: &str) -> bool {
    let plain = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    (1..=LONGEST).contains(&name.len()) && name.chars().all(plain)
}
