//! Which size of an equation to believe.

use faer::Mat;

use super::candidates::{Candidate, binomial};
use super::problem::Problem;
use crate::Triangle;

/// Residuals up to this many times the floor count as rounding.
pub(crate) const FLOOR_FACTOR: f64 = 2.0;

/// Probability at which a subset is believed not to have reached the floor by chance.
const CHANCE: f64 = 1e-3;

/// RMS residual, corrected for the terms fitted.
pub(super) fn rms(rss: f64, rows: usize, terms: usize) -> f64 {
    (rss / rows.saturating_sub(terms).max(1) as f64).sqrt()
}

/// The squared residual that rounding explains.
pub(super) fn explained(floor: f64, rows: usize, terms: usize) -> f64 {
    (FLOOR_FACTOR * floor).powi(2) * rows.saturating_sub(terms).max(1) as f64
}

/// Whether some subset of this size would come so close even to a target that has nothing to do with the terms.
///
/// A random direction in N − k dimensions is within ε of a given one with probability about ε^(N − k), and there are
/// as many tries as subsets.
pub(super) fn by_chance(problem: &Problem, rss: f64, rows: usize, size: usize) -> bool {
    if size == 0 {
        return false;
    }
    let left = (rss / problem.total()).sqrt();
    let free = rows.saturating_sub(size) as f64;
    binomial(problem.n_columns(), size).ln() + free * left.ln() > CHANCE.ln()
}

/// What the score of a subset is computed from.
pub(super) struct Criterion<'a> {
    pub(super) problem: &'a Problem,
    pub(super) triangle: &'a Triangle,
    /// Number of each of the problem's columns in the triangle.
    pub(super) columns: &'a [usize],
    /// Complexity of each column of the triangle.
    pub(super) complexity: &'a [u32],
    /// The terms over the region where the equations are to be used.
    pub(super) region: Option<&'a Triangle>,
    /// RMS residual that rounding explains.
    pub(super) floor: f64,
}

impl Criterion<'_> {
    /// The score of a subset S of k of F terms, the smaller the better:
    /// N ln σ²(1 + ℓ) + k ln N + 2 ln C(F, k) + Σ c.
    ///
    /// σ² = RSS/(N − k), and ℓ is the mean leverage θᵀ(Θ_SᵀΘ_S)⁻¹θ over the region where the equations are to be used:
    /// σ²(1 + ℓ) is the squared error expected there. Over the data themselves ℓ = k/N and this is the extended BIC.
    /// Data from a narrow path leave many subsets with nearly the same residual that differ without limit elsewhere;
    /// ℓ is what tells them apart. c is the terms' complexity, the log-odds against them before any data are seen.
    ///
    /// # References
    /// Chen, Chen (2008), Biometrika 95(3), with γ = 1. Akaike (1970), final prediction error.
    pub(super) fn score(&self, candidate: &Candidate) -> f64 {
        let rows = self.triangle.n_rows();
        let (n, k) = (rows.max(1) as f64, candidate.subset.len());
        let smallest = (self.floor * self.floor).max(1e-30 * self.problem.total() / n).max(f64::MIN_POSITIVE);
        let variance = (candidate.rss / rows.saturating_sub(k).max(1) as f64).max(smallest);
        let support: Vec<usize> = candidate.subset.iter().map(|&j| self.columns[j]).collect();
        let leverage = match self.region {
            Some(region) => leverage(self.triangle, region, &support),
            None => k as f64 / n,
        };
        let complexity: f64 = support.iter().map(|&j| f64::from(self.complexity[j])).sum();
        n * (variance * (1.0 + leverage)).ln() + k as f64 * n.ln() + 2.0 * self.problem.n_subsets(k).ln() + complexity
    }
}

/// The mean of θᵀ(Θ_SᵀΘ_S)⁻¹θ over the rows behind `region`.
fn leverage(triangle: &Triangle, region: &Triangle, support: &[usize]) -> f64 {
    let k = support.len();
    let stacked = |t: &Triangle| {
        let height = support.iter().map(|&j| t.column(j).len()).max().unwrap_or(0).max(k);
        Mat::from_fn(height, k, |i, j| t.column(support[j]).get(i).copied().unwrap_or(0.0))
    };
    if k == 0 {
        return 0.0;
    }
    let data = stacked(triangle).qr();
    let r = data.thin_R();
    if (0..k).any(|i| r[(i, i)] == 0.0) {
        return f64::INFINITY;
    }
    // ‖G R⁻¹‖² by rows: w R = g, forward from the first column.
    let over = stacked(region);
    let mut sum = 0.0;
    let mut w = vec![0.0; k];
    for row in 0..over.nrows() {
        for j in 0..k {
            let known: f64 = (0..j).map(|i| w[i] * r[(i, j)]).sum();
            w[j] = (over[(row, j)] - known) / r[(j, j)];
        }
        sum += w.iter().map(|w| w * w).sum::<f64>();
    }
    sum / region.n_rows().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::Array2;

    #[test]
    fn leverage_over_the_data_is_the_number_of_terms() {
        let rows = Array2::from_shape_fn((20, 3), |(i, j)| ((i * (j + 1)) as f64 * 0.7).sin());
        let mut triangle = Triangle::new(3);
        triangle.push(rows.view()).expect("finite rows");
        assert!((leverage(&triangle, &triangle, &[0, 2]) - 2.0 / 20.0).abs() < 1e-12);
        let mut wide = Triangle::new(3);
        wide.push((10.0 * &rows).view()).expect("finite rows");
        assert!((leverage(&triangle, &wide, &[1]) - 100.0 / 20.0).abs() < 1e-9);
    }
}
