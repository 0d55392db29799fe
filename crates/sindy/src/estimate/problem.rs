//! What is to be explained, and by what.

use std::cell::Cell;

use super::constraints::Constraints;
use crate::data::Segment;
use crate::library::Term;
use crate::motion::Stepping;
use crate::solve::Selected;
use crate::{BestSubset, Watch};

/// What is to be explained, and by what.
#[derive(Clone, Copy)]
pub(crate) struct Problem<'a> {
    /// Terms without parameters inside, then those with, then quotients by one variable.
    pub(crate) terms: &'a [Term],
    /// How many come first.
    pub(crate) n_plain: usize,
    /// The complexity of those that regressions may choose, at most.
    pub(crate) most_complex: u32,
    /// What explains parts of the data: to rounding, or as was found when there were fewer.
    pub(crate) of_parts: Option<&'a Structure>,
    /// Whether what explains the data otherwise is better than these equations, which leave more than noise of a part of them: then all samples need not be searched.
    pub(crate) instead: Option<&'a dyn Fn(OfPart<'_>) -> bool>,
    /// Equations that Lagrangians of these variables propose.
    pub(crate) mechanics: &'a [Structure],
    /// Per state: the state that is declared to be its rate.
    pub(crate) rates: &'a [Option<usize>],
    pub(crate) n_controls: usize,
    /// What is known of each equation; empty if nothing is.
    pub(crate) constraints: &'a [Constraints],
    pub(crate) segments: &'a [Segment],
    /// Smallest error of each state that is believed: rounding (n).
    pub(crate) floor: &'a [f64],
    /// Standard deviation of the noise of each state as its signal tells (n); found by [`estimate`](super::estimate).
    pub(crate) noise: &'a [f64],
    /// Equations that are adequate without the other states, per state; empty if there are none.
    pub(crate) alone: &'a [Alone],
    /// Ways in which a simulator may have gone from sample to sample.
    pub(crate) simulators: &'a [Stepping],
    pub(crate) solver: &'a BestSubset,
    /// Operations that may be spent on the whole search.
    pub(crate) whole: u64,
    /// Those that may be spent on this part of it.
    pub(crate) budget: u64,
    /// Operations spent so far.
    pub(crate) spent: &'a Cell<u64>,
    /// Whether the search begins with equations that were found in a part of the samples.
    pub(crate) again: bool,
    /// Whether positions whose rates were not measured may be those of a simulator.
    pub(crate) discrete: bool,
    pub(crate) watch: &'a Watch<'a>,
}

/// Equations of a part of the data, in which they leave more than noise.
#[derive(Clone, Copy)]
pub(crate) struct OfPart<'a> {
    pub(crate) terms: &'a [Term],
    pub(crate) fits: &'a [Selected],
    pub(crate) stepping: Stepping,
    /// Whether no proposal was passed over because the budget was spent.
    pub(crate) complete: bool,
}

/// Terms of each equation, and their coefficients one equation after the other.
pub(crate) type Structure = (Vec<Vec<usize>>, Vec<f64>);

/// An equation that was found in a part of the system, and adequate there.
#[derive(Debug, Clone)]
pub(crate) struct Separate {
    pub(super) support: Vec<usize>,
    pub(super) coefficients: Vec<f64>,
    /// Standard errors of the coefficients.
    pub(super) errors: Vec<f64>,
    /// RMS residual \[unit of the rate\].
    pub(super) residual: f64,
}

/// The equation of a state that was found alone, if it was.
pub(crate) type Alone = Option<Separate>;
