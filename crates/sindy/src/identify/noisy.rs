//! Samples whose noise is estimated, and what is first looked for in them.

use super::report::{Counts, Identified};
use crate::data::Segment;
use crate::mechanics::Proposal;
use crate::motion::Stepping;
use crate::regression::Space;
use crate::{BestSubset, Watch};

/// Samples with noise that is estimated, and how equations are looked for in them.
#[derive(Clone, Copy)]
pub(super) struct Noisy<'a> {
    pub(super) segments: &'a [Segment],
    /// Smallest error of each state that is believed (n).
    pub(super) floor: &'a [f64],
    /// How equations are stepped, as the states with declared rates show.
    pub(super) stepping: Stepping,
    /// Ways in which a simulator may have gone from sample to sample.
    pub(super) simulators: &'a [Stepping],
    pub(super) counts: Counts,
    pub(super) space: &'a Space,
    pub(super) solver: &'a BestSubset,
    pub(super) watch: &'a Watch<'a>,
}

/// What Lagrangians of several joints come to.
pub(super) enum Joined {
    /// Equations against which nothing speaks.
    Adequate(Box<Identified>),
    /// Others, which may be none.
    Proposed(Vec<Proposal>),
}
