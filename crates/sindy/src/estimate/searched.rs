//! What a search found.

use super::hypothesis::Hypothesis;
use super::regression::Regression;

/// What a search found.
#[derive(Clone)]
pub(super) struct Searched {
    pub(super) best: Hypothesis,
    /// The regressions along its path.
    pub(super) regressions: Vec<Regression>,
    /// Per equation, other terms that explain the data as well.
    pub(super) rivals: Vec<Rivals>,
    /// Hypotheses about as good.
    pub(super) others: Vec<Hypothesis>,
    /// Per equation, whether all other terms that were to be compared with its own were.
    pub(super) finished: Vec<bool>,
}

/// What a rough search found.
pub(super) enum Rough {
    /// All states have more noise than they were taken to have: a finer search finds the same.
    Noisy(Searched),
    /// Where a finer search begins.
    Begun(Hypothesis),
}

/// Other terms of an equation that explain the data as well.
pub(super) type Rivals = Vec<Vec<usize>>;
