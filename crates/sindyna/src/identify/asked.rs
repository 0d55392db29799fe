//! What is asked about a log.

use sindyna_core::Spec;
use sindyna_sindy::{Identifier, Watch};

use super::unmeasured::Unmeasured;
use crate::logs::{Log, Samples};

/// By how many rows inputs act later than over the step after theirs.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Delay {
    /// None, unless equations leave what no term explains, samples are even, and the data speak for one.
    #[default]
    Auto,
    /// So many; −1 for an input that acted over the step before its row, −0.5 for one that goes from row to row in a straight line.
    Rows(f64),
}

/// What is asked about a log, and who is told.
pub(crate) struct Asked<'a, E> {
    pub(crate) unmeasured: &'a Unmeasured,
    pub(crate) delay: Delay,
    /// The part of a log that equations are found in.
    pub(crate) kept: &'a (dyn Fn(&Log) -> Result<Samples, E> + Sync),
    /// Makes an identifier for a system.
    pub(crate) identifier: &'a (dyn Fn(&Spec) -> Result<Identifier, E> + Sync),
    pub(crate) watch: &'a Watch<'a>,
    /// Is told what is tried.
    pub(crate) say: &'a (dyn Fn(&str) + Sync),
}
