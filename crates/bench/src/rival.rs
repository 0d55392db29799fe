//! What others make of the same data.

use serde::{Deserialize, Serialize};
use sindyna_core::Dataset;
use sindyna_sindy::{Identifier, SolverChoice, Stlsq, Target};

use sindyna_truth::{Deviation, Truth};

use crate::measure::Off;

/// Thresholds the best of which is looked for: a factor of √10 apart.
const THRESHOLDS: [f64; 11] = [1e-4, 3e-4, 1e-3, 3e-3, 1e-2, 3e-2, 0.1, 0.3, 1.0, 3.0, 10.0];

/// Deviations from the truth of sequentially thresholded least squares, with the same candidate terms as ours.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Rivals {
    /// With the paper's threshold, of increments.
    pub stlsq: Off,
    /// The nearest to the truth over all thresholds, of increments and of central differences: what a user could reach who
    /// knew the truth.
    pub stlsq_best: Off,
}

/// Fits `data` as others would. A fit that fails is no fit.
#[must_use]
pub fn rivals(truth: &Truth, identifier: &Identifier, data: &Dataset) -> Rivals {
    let fit = |target: Target, stlsq: Stlsq| {
        let identifier = identifier.clone().with_target(target).with_solver(SolverChoice::Stlsq(stlsq));
        identifier.identify(data).ok().map(|found| truth.deviation(&found.model))
    };
    let off = |deviation: Option<Deviation>| deviation.map_or_else(Off::default, Off::from);
    let targets = || [Some(Target::Increment), "continuous".parse().ok()].into_iter().flatten();
    let best = targets().flat_map(|target| {
        let solvers = THRESHOLDS.iter().filter_map(|threshold| Stlsq::new(*threshold, 0.05).ok());
        solvers.filter_map(move |stlsq| fit(target, stlsq))
    });
    Rivals {
        stlsq: off(fit(Target::Increment, Stlsq::paper())),
        stlsq_best: off(best.min_by(|a, b| a.worst.total_cmp(&b.worst))),
    }
}
