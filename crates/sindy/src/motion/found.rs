//! What is looked for, and equations that are found.

use super::{Run, Stepping, System};
use crate::regression::Space;
use crate::solve::Selected;
use crate::{BestSubset, Model, Watch};

/// Equations found, one per state, and how they are stepped.
#[derive(Debug, Clone)]
pub(crate) struct Found {
    pub(crate) model: Model,
    pub(crate) fits: Vec<Selected>,
    pub(crate) stepping: Stepping,
    /// Condition number of the whitened terms of each equation.
    pub(crate) condition: f64,
    /// Σ of squared, whitened errors of one step, over the fitted equations.
    pub(crate) misfit: f64,
}

impl Found {
    /// Whether every equation leaves no more than the errors of the samples explain.
    pub(crate) fn explains(&self) -> bool {
        self.fits.iter().all(|fit| fit.reached_floor)
    }
}

/// What is being looked for, and in what.
#[derive(Clone, Copy)]
pub(crate) struct Search<'a> {
    pub(crate) system: &'a System<'a>,
    pub(crate) runs: &'a [Run],
    pub(crate) space: &'a Space,
    pub(crate) solver: &'a BestSubset,
    pub(crate) watch: &'a Watch<'a>,
}
