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

impl From<Rates> for Looked {
    fn from(Rates { found, identifier, log }: Rates) -> Self {
        Self { found, identifier, log }
    }
}
