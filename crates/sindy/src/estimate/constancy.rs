//! Whether all parts of the data agree on the coefficients.

use nalgebra::{DMatrix, DVector};
use ndarray::{Array2, s};

use super::hypothesis::Hypothesis;
use super::problem::Problem;
use super::white::by_chance;
use crate::Triangle;
use crate::data::Segment;
use crate::shooting::{PARTS, linearised};

impl Problem<'_> {
    /// Per state, whether the first and the second half of the data agree on the coefficients of its equation. Those of an equation
    /// that only approximates the true one depend on where the states have been.
    ///
    /// # References
    /// Chow (1960), Econometrica 28(3), with both halves linearised at the common estimate.
    pub(super) fn halves_agree(&self, hypothesis: &Hypothesis) -> Vec<bool> {
        let n = self.rates.len();
        let total: usize = self.segments.iter().map(Segment::len).sum();
        let half = |first: usize, last: usize| moved(self.told_by(hypothesis, first, last)?);
        let (Some(one), Some(other)) = (half(0, total / 2), half(total / 2, total)) else { return vec![true; n] };
        let mut first = 0;
        let of = |i: usize| {
            let columns: Vec<usize> = (first..first + hypothesis.supports[i].len()).collect();
            first += columns.len();
            // What a half does not determine it does not contradict.
            columns.is_empty() || distance(&one, &other, &columns).is_none_or(|d| d < by_chance(columns.len()))
        };
        (0..n).map(of).collect()
    }

    /// Columns of the coefficients of `hypothesis` and of what it leaves, over steps `first` to `last`; and the slopes of the volume of the states, of systems that run away.
    pub(super) fn told_by(
        &self,
        hypothesis: &Hypothesis,
        first: usize,
        last: usize,
    ) -> Option<(Triangle, Option<Vec<f64>>)> {
        let (mut segments, mut x): (Vec<Segment>, Vec<Array2<f64>>) = (Vec::new(), Vec::new());
        let mut begun = 0;
        for (segment, followed) in self.segments.iter().zip(&hypothesis.fit.x) {
            let from = first.max(begun) - begun;
            let to = last.min(begun + segment.len()).saturating_sub(begun);
            if from < to {
                segments.push(segment.part(from, to));
                x.push(followed.slice(s![from..=to, ..]).to_owned());
            }
            begun += segment.len();
        }
        let (flow, fit) = (&hypothesis.flow, &hypothesis.fit);
        let triangle = self.working(|work| {
            let last = PARTS.len() - 1;
            linearised(flow, &segments, (&fit.xi, &x), &fit.sigma, last, (work, self.watch.asks()))
        })?;
        if fit.expansion <= 0.0 {
            return Some((triangle, None));
        }
        let at = (&fit.xi[..], &x[..]);
        let slopes =
            self.working(|work| fit.slopes(flow, &segments, at, PARTS.len() - 1, (work, self.watch.asks())))?;
        Some((triangle, Some(slopes)))
    }
}

/// By how much coefficients move by what is told of them; `None` where they are not all determined and the states tell of them, too.
fn moved((triangle, slopes): (Triangle, Option<Vec<f64>>)) -> Option<(Triangle, Vec<f64>)> {
    let p = triangle.n_columns() - 1;
    let mut moved = triangle.solve_unit(&(0..p).collect::<Vec<_>>(), p);
    if let Some(slopes) = slopes {
        // What is not determined is not compared.
        let shift = triangle.shift(&slopes)?;
        moved.iter_mut().zip(shift).for_each(|(moved, shift)| *moved -= shift);
    }
    Some((triangle, moved))
}

/// (a − b)ᵀ (A + B)⁻¹ (a − b) of the coefficients `columns` of two independent estimates with covariances A and B.
pub(super) fn distance(one: &(Triangle, Vec<f64>), other: &(Triangle, Vec<f64>), columns: &[usize]) -> Option<f64> {
    let covariance = block(&one.0, columns)? + block(&other.0, columns)?;
    let apart = DVector::from_iterator(columns.len(), columns.iter().map(|&j| one.1[j] - other.1[j]));
    let solved = covariance.cholesky()?.solve(&apart);
    Some(apart.dot(&solved)).filter(|d| d.is_finite())
}

/// The covariance of the coefficients `columns` of a triangle over all of them and a right-hand side, in units of their own.
fn block(triangle: &Triangle, columns: &[usize]) -> Option<DMatrix<f64>> {
    let rows = triangle.inverse()?.select_rows(columns);
    Some(&rows * rows.transpose())
}
