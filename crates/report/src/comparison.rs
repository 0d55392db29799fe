//! A comparison: its records, and what is known besides.

use sindyna_record::comparison::Digest;

use crate::Catalog;
use crate::groups::{Group, groups};

/// A comparison of methods: records, facts that no record holds, and the numbers that follow.
pub struct Comparison<'a> {
    pub(crate) digest: &'a Digest,
    pub(crate) catalog: &'a dyn Catalog,
    pub(crate) groups: Vec<Group>,
}

impl<'a> Comparison<'a> {
    /// The comparison whose runs `digest` holds.
    #[must_use]
    pub fn new(digest: &'a Digest, catalog: &'a dyn Catalog) -> Self {
        Self { digest, catalog, groups: groups(digest, catalog) }
    }

    /// One for each task and method there are runs of.
    #[must_use]
    pub fn groups(&self) -> &[Group] {
        &self.groups
    }
}
