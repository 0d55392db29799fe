//! Which parameters of a Lagrangian windows of samples tell.

use nalgebra::{DMatrix, DVector};

use super::elimination::eliminated;
use super::windows::{Fitted, Windows};
use crate::Triangle;
use crate::solve::binomial;

/// Parameters beside the unit, and how surely they are told.
pub(super) struct Choice {
    /// Places among those that were fitted, ascending, and their values.
    pub(super) columns: Vec<usize>,
    pub(super) values: Vec<f64>,
    /// By how much more squares are left with another parameter in place of one of these, that is no more far-fetched: the least.
    pub(super) nearest: f64,
}

impl Windows<'_> {
    /// What so many parameters cost by the extended Bayesian information criterion.
    ///
    /// # References
    /// Chen, Chen (2008), Biometrika 95(3), with γ = 1.
    pub(super) fn price(&self, size: usize) -> f64 {
        size as f64 * self.count().ln() + 2.0 * binomial(self.lagrangian.parameters.len(), size).ln()
    }

    /// Those of the parameters `all` that this criterion keeps: one after the other is left out, then others are taken in their place, simpler ones rather, and what these do without is left out too.
    pub(super) fn chosen(&self, all: &Fitted) -> Option<Choice> {
        let triangle = self.linearised(all)?;
        let path = eliminated(&triangle, &all.values[1..]);
        let score = |left: f64, size: usize| left * left + self.price(size);
        let best = path.into_iter().min_by(|one, other| {
            score(one.left, one.columns.len()).total_cmp(&score(other.left, other.columns.len()))
        })?;
        let told = Told::new(&triangle, &all.values[1..]);
        let complexity: Vec<f64> = all.chosen[1..].iter().map(|&p| self.lagrangian.complexity(p)).collect();
        let (mut columns, mut left) = (best.columns.clone(), told.left(&best.columns));
        // Each exchange lowers a sum of squares and complexities, there are finitely many sets of one size, and no set grows.
        let nearest = loop {
            let mut nearest = f64::INFINITY;
            let mut better: Option<(f64, f64, Vec<usize>)> = None;
            let others: Vec<usize> = (0..complexity.len()).filter(|other| !columns.contains(other)).collect();
            for (at, own) in columns.iter().enumerate() {
                let kept: Vec<usize> = columns.iter().copied().filter(|column| column != own).collect();
                for (&other, squares) in others.iter().zip(told.left_with_each(&kept, &others)) {
                    let mut exchanged = columns.clone();
                    exchanged[at] = other;
                    let simpler = complexity[*own] - complexity[other];
                    let more = squares - left;
                    if simpler >= 0.0 {
                        nearest = nearest.min(more);
                    }
                    let gain = simpler - more;
                    if gain > MARGIN && better.as_ref().is_none_or(|(most, ..)| gain > *most) {
                        better = Some((gain, left + more, exchanged));
                    }
                }
            }
            let without = |at: usize| {
                let kept: Vec<usize> = columns.iter().copied().filter(|column| *column != columns[at]).collect();
                (told.left(&kept), kept)
            };
            let fewer = (0..columns.len()).map(without).min_by(|(one, _), (other, _)| one.total_cmp(other));
            let saved = self.price(columns.len()) - self.price(columns.len().saturating_sub(1));
            match (better, fewer) {
                (Some((_, squares, exchanged)), _) => (columns, left) = (exchanged, squares),
                (None, Some((squares, kept))) if squares - left < saved => (columns, left) = (kept, squares),
                _ => break nearest,
            }
        };
        columns.sort_unstable();
        let values = told.values(&columns);
        Some(Choice { columns, values, nearest })
    }
}

/// Square of the sine of the angle to other columns below which a column of unit length is one of them.
const PARALLEL: f64 = 1e-14;

/// Difference of scores that is no rounding.
const MARGIN: f64 = 1e-6;

/// All that is to be explained, not only what the values of all parameters leave.
struct Told(Triangle, usize);

impl Told {
    /// Of a `triangle` linearised at `known` values of its columns.
    fn new(triangle: &Triangle, known: &[f64]) -> Self {
        let target = known.len();
        let mut columns: Vec<Vec<(usize, f64)>> = (0..target).map(|j| vec![(j, 1.0)]).collect();
        columns.push(known.iter().copied().enumerate().chain([(target, 1.0)]).collect());
        Self(triangle.combined(&columns), target)
    }

    fn values(&self, columns: &[usize]) -> Vec<f64> {
        self.0.solve_unit(columns, self.1)
    }

    /// Squares that the columns `kept` leave with each of `others` beside them: what is left of a column perpendicular to the ones kept takes its part of the rest away.
    fn left_with_each(&self, kept: &[usize], others: &[usize]) -> Vec<f64> {
        let unit = |j: usize| {
            let column = self.column(j);
            let length = column.norm();
            column / length.max(f64::MIN_POSITIVE)
        };
        let columns: Vec<DVector<f64>> = kept.iter().map(|&j| unit(j)).collect();
        let basis = (!columns.is_empty()).then(|| DMatrix::from_columns(&columns).qr().q());
        let perpendicular = |of: DVector<f64>| match &basis {
            Some(basis) => &of - basis * basis.tr_mul(&of),
            None => of,
        };
        let rest = perpendicular(self.column(self.1));
        let left = |&other: &usize| {
            let column = perpendicular(unit(other));
            let square = column.norm_squared();
            let part = if square > PARALLEL { column.dot(&rest).powi(2) / square } else { 0.0 };
            (rest.norm_squared() - part).max(0.0)
        };
        others.iter().map(left).collect()
    }

    fn column(&self, j: usize) -> DVector<f64> {
        let known = self.0.column(j);
        DVector::from_fn(self.1 + 1, |i, _| known.get(i).copied().unwrap_or(0.0))
    }

    /// Squares that the `columns` leave.
    fn left(&self, columns: &[usize]) -> f64 {
        self.0.residual_norm(columns, &self.values(columns), self.1).powi(2)
    }
}
