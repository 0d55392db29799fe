//! Sequentially thresholded least squares.

use std::ops::Range;

use super::reflect::Reflected;
use crate::Triangle;
use crate::error::{InvalidParam, at_least_zero};

/// Whether columns are scaled before thresholding.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Columns {
    /// The threshold acts on the coefficients themselves.
    AsTheyAre,
    /// Columns are scaled to unit Euclidean norm first, and the threshold acts on the coefficients of those.
    Normalised,
}

/// What the last solve on the chosen support is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Finish {
    /// Least squares without the ridge term, so that kept coefficients are not shrunk.
    Unbiased,
    /// The ridge regression of the last round.
    Ridge,
}

/// Sequentially thresholded least squares (STLSQ).
///
/// Solves Ẋ = Θ Ξᵀ row by row: ridge regression ‖Θξ − ẋ‖² + `ridge` ‖ξ‖² on what is left, drop every |ξ| < `threshold`,
/// repeat until the support stands still. `threshold` has the units of ξ.
///
/// Numbers and supports are those of PySINDy 2.1: the comparison keeps |ξ| = `threshold`, the ridge weight is not
/// divided by the number of rows, and the last solve has no ridge term and no further threshold. Where the kept columns
/// nearly depend on each other, that solve takes singular values up to 1e-6 of the largest as zero, which is the `tol`
/// of the scikit-learn (1.9) regression PySINDy hands it to.
///
/// # Deviations
/// 1. An equation that loses every term is a zero row, not a warning; reaching the last round is
///    [`SparseFit::converged`]` == false`.
/// 2. A column of zeros stays out of a normalised fit instead of making it NaN.
///
/// # References
/// Brunton, Proctor, Kutz (2016), PNAS 113(15). Arora, da Silva, Moss (2022), §2: threshold 0.0009.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stlsq {
    threshold: f64,
    ridge: f64,
    max_iterations: usize,
    columns: Columns,
    finish: Finish,
}

/// Relative singular value below which the last solve sees a dependence.
const CUTOFF: f64 = 1e-6;

/// A sparse row of coefficients.
#[derive(Debug, Clone, PartialEq)]
pub struct SparseFit {
    /// Coefficients of all terms (F), zero where a term was dropped.
    pub coefficients: Vec<f64>,
    /// Whether the support stood still before the last round.
    pub converged: bool,
    /// Number of terms kept after each round.
    pub history: Vec<usize>,
}

impl Default for Stlsq {
    /// PySINDy's: threshold 0.1, ridge 0.05, 20 rounds.
    fn default() -> Self {
        Self { threshold: 0.1, ridge: 0.05, max_iterations: 20, columns: Columns::AsTheyAre, finish: Finish::Unbiased }
    }
}

impl Stlsq {
    /// Thresholding at `threshold` with ridge weight `ridge`.
    ///
    /// # Errors
    /// [`InvalidParam`] for a number that is negative or not finite.
    pub fn new(threshold: f64, ridge: f64) -> Result<Self, InvalidParam> {
        let threshold = at_least_zero("threshold", threshold)?;
        let ridge = at_least_zero("ridge", ridge)?;
        Ok(Self { threshold, ridge, ..Self::default() })
    }

    /// The paper's: threshold 0.0009, and PySINDy's ridge weight of 0.05.
    #[must_use]
    pub fn paper() -> Self {
        Self { threshold: 0.0009, ..Self::default() }
    }

    /// The same with at most `n` rounds.
    ///
    /// # Errors
    /// [`InvalidParam`] for zero rounds.
    pub fn with_max_iterations(self, n: usize) -> Result<Self, InvalidParam> {
        if n == 0 {
            return Err(InvalidParam { name: "max_iterations", value: 0.0, wanted: "at least 1" });
        }
        Ok(Self { max_iterations: n, ..self })
    }

    /// The same with columns scaled or not.
    #[must_use]
    pub fn with_columns(self, columns: Columns) -> Self {
        Self { columns, ..self }
    }

    /// The same with another last solve.
    #[must_use]
    pub fn with_finish(self, finish: Finish) -> Self {
        Self { finish, ..self }
    }

    /// Fits the column `target` of `triangle` with its first `n_features` columns.
    #[must_use]
    pub fn solve(&self, triangle: &Triangle, n_features: usize, target: usize) -> SparseFit {
        self.solve_all(triangle, n_features, target..target + 1).remove(0)
    }

    /// Fits each of the columns `targets` of `triangle` with its first `n_features` columns. The first round has the same columns for all of them.
    pub(crate) fn solve_all(&self, triangle: &Triangle, n_features: usize, targets: Range<usize>) -> Vec<SparseFit> {
        let scales: Vec<f64> = match self.columns {
            Columns::AsTheyAre => vec![1.0; n_features],
            Columns::Normalised => (0..n_features).map(|j| triangle.norm(j)).collect(),
        };
        let columns: Vec<usize> = (0..n_features).filter(|&j| scales[j] > 0.0).collect();
        let round = Round::new(triangle, &scales, columns, targets.clone(), self.ridge);
        targets.map(|target| self.rounds(&round, target)).collect()
    }

    /// All rounds for one target, after the `first`.
    fn rounds(&self, first: &Round<'_>, target: usize) -> SparseFit {
        let mut support = first.columns.clone();
        let mut kept = Vec::new();
        let mut history = Vec::new();
        let mut converged = false;
        for _ in 0..self.max_iterations {
            let xi = first.coefficients(&support, target);
            let before = support.len();
            kept = support.iter().copied().zip(xi).filter(|(_, c)| c.abs() >= self.threshold).collect();
            support = kept.iter().map(|(j, _)| *j).collect();
            history.push(support.len());
            converged = support.len() == before;
            if converged {
                break;
            }
        }
        // A threshold of zero keeps everything; what is nothing but rounding is not a term.
        kept.retain(|(_, c)| c.abs() > 1e-14);
        if self.finish == Finish::Unbiased {
            let support: Vec<usize> = kept.iter().map(|(j, _)| *j).collect();
            let xi = first.unbiased(&support, target);
            kept = support.into_iter().zip(xi).collect();
        }
        let mut coefficients = vec![0.0; first.scales.len()];
        for (j, c) in kept {
            coefficients[j] = c / first.scales[j];
        }
        SparseFit { coefficients, converged, history }
    }
}

/// The first round: ridge regressions of all targets on all columns.
struct Round<'a> {
    triangle: &'a Triangle,
    scales: &'a [f64],
    columns: Vec<usize>,
    targets: Range<usize>,
    ridge: f64,
    /// The factor of [Θ; √ridge I], with which columns that are dropped leave that of the others.
    factor: Reflected,
}

impl<'a> Round<'a> {
    fn new(triangle: &'a Triangle, scales: &'a [f64], columns: Vec<usize>, targets: Range<usize>, ridge: f64) -> Self {
        let mut factor = Reflected::new(columns.len(), targets.len(), ridge.sqrt());
        factor.absorb(&mut rows(triangle, scales, &columns, targets.clone()));
        Self { triangle, scales, columns, targets, ridge, factor }
    }

    /// Ridge coefficients of the columns `support` for the column `target`.
    fn coefficients(&self, support: &[usize], target: usize) -> Vec<f64> {
        let number = target - self.targets.start;
        let found = if support.len() == self.columns.len() {
            self.factor.solve(number)
        } else {
            let place = |j: &usize| self.columns.partition_point(|c| c < j);
            self.factor.chosen(&support.iter().map(place).collect::<Vec<_>>(), number).solve(0)
        };
        found.unwrap_or_else(|| self.triangle.solve_scaled(support, target, self.ridge, |j| self.scales[j]))
    }

    /// Least-squares coefficients of the columns `support` for the column `target`, without what is nearly a dependence.
    fn unbiased(&self, support: &[usize], target: usize) -> Vec<f64> {
        let mut factor = Reflected::new(support.len(), 1, 0.0);
        factor.absorb(&mut rows(self.triangle, self.scales, support, target..target + 1));
        // No singular value is below the cutoff, so all of them count.
        let independent = factor.condition() * CUTOFF < 1.0;
        let found = independent.then(|| factor.solve(0)).flatten();
        found.unwrap_or_else(|| self.triangle.solve_truncated(support, target, CUTOFF, |j| self.scales[j]))
    }
}

/// Scaled columns and targets of the triangle, column after column, down to the last row that one of the columns reaches.
fn rows(triangle: &Triangle, scales: &[f64], columns: &[usize], targets: Range<usize>) -> Vec<f64> {
    let height = columns.iter().map(|&j| triangle.column(j).len()).max().unwrap_or(0);
    let mut rows = Vec::with_capacity(height * (columns.len() + targets.len()));
    let scaled = columns.iter().map(|&j| (j, scales[j])).chain(targets.map(|j| (j, 1.0)));
    for (number, (j, scale)) in scaled.enumerate() {
        rows.extend(triangle.column(j).iter().take(height).map(|v| v / scale));
        rows.resize((number + 1) * height, 0.0);
    }
    rows
}
