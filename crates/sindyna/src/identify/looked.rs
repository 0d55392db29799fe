//! What was found in a log, and how the log was read in the end.

use sindyna_sindy::{Identified, Identifier};

use super::unmeasured::Rates;
use crate::logs::Log;

/// What was found in a log.
pub(crate) struct Looked {
    pub(crate) found: Identified,
    pub(crate) identifier: Identifier,
    /// The log as it was read in the end.
    pub(crate) log: Log,
}

impl Looked {
    /// The same, with a warning that no other reading of the log was tried to its end.
    pub(super) fn interrupted(mut self) -> Self {
        let warning = "the search was interrupted: other readings of the log (delays and lags of the inputs, first-order hold, angles, \
                       unmeasured rates) were not tried to the end";
        if self.found.report.warnings.iter().all(|told| told != warning) {
            self.found.report.warnings.push(warning.into());
        }
        self
    }
}

impl From<Rates> for Looked {
    fn from(Rates { found, identifier, log }: Rates) -> Self {
        Self { found, identifier, log }
    }
}
