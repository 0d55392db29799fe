//! Sequentially thresholded least squares.

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
        let scale = |j: usize| match self.columns {
            Columns::AsTheyAre => 1.0,
            Columns::Normalised => triangle.norm(j),
        };
        let mut support: Vec<usize> = (0..n_features).filter(|&j| scale(j) > 0.0).collect();
        let mut kept = Vec::new();
        let mut history = Vec::new();
        let mut converged = false;
        for _ in 0..self.max_iterations {
            let xi = triangle.solve_scaled(&support, target, self.ridge, scale);
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
            let xi = triangle.solve_truncated(&support, target, CUTOFF, scale);
            kept = support.into_iter().zip(xi).collect();
        }
        let mut coefficients = vec![0.0; n_features];
        for (j, c) in kept {
            coefficients[j] = c / scale(j);
        }
        SparseFit { coefficients, converged, history }
    }
}
