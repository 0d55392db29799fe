//! A log of whose states some were not measured.

use crate::{Difference, Log, Note};

impl Log {
    /// The same log with a note of each of `differences`, and nothing said of its samples.
    #[must_use]
    pub fn without_measurements(mut self, differences: Vec<Difference>) -> Self {
        for Difference { rate, .. } in &differences {
            self.notes.retain(|note| !note.is_of(rate));
            self.findings.retain(|finding| !finding.is_of(rate));
        }
        self.notes.extend(differences.into_iter().map(Note::Difference));
        self
    }
}
