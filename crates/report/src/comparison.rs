//! A comparison: its records, and what is known besides.

use sindyna_record::comparison::Digest;

use crate::document::Block;
use crate::groups::{Group, groups};
use crate::{Catalog, Page, content};

const TITLE: &str = "How many real steps each method needs";

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

    /// Everything that is to be said.
    #[must_use]
    pub fn report(&self) -> Page {
        Page { title: TITLE.into(), blocks: content::blocks(self) }
    }

    /// The table of real steps alone.
    #[must_use]
    pub fn steps_table(&self) -> Page {
        let mut blocks = content::speed_ups(self);
        blocks.extend(self.gaps().map(Block::Text));
        Page { title: TITLE.into(), blocks }
    }

    /// Pairs of task and method that have fewer seeds than were asked for, or than others, and why some have none.
    #[must_use]
    pub fn gaps(&self) -> Option<String> {
        content::gaps(self.digest, self.catalog)
    }
}
