//! From a triangle to a problem: unit columns, the promising ones first, fixed terms taken out.

use super::constraints::Constraints;
use super::problem::{DEPENDENT, Problem, dot, square, subtract, take_out_all};
use crate::Triangle;

/// Length of the difference of two unit columns below which they are the same.
const SAME: f64 = 1e-9;

/// Cosine of the angle between two columns that may be the same.
const NEARLY: f64 = 0.999;

/// A column of the triangle, of unit length.
pub(super) type Unit = (usize, Vec<f64>);

/// A regression ready for a search.
pub(super) struct Prepared {
    pub(super) problem: Problem,
    /// The terms of the search: the problem's columns that come together.
    pub(super) units: Vec<Vec<usize>>,
    /// Whether every unit is one column.
    pub(super) singles: bool,
    /// Columns left out, each with the one that equals it.
    pub(super) equal: Vec<(usize, usize)>,
    /// The triangle's number of each of the problem's columns.
    columns: Vec<usize>,
    /// Columns every subset has.
    fixed: Vec<usize>,
}

impl Prepared {
    /// The triangle's columns of a subset.
    pub(super) fn support(&self, subset: &[usize]) -> Vec<usize> {
        let mut support: Vec<usize> = subset.iter().map(|&j| self.columns[j]).chain(self.fixed.clone()).collect();
        support.sort_unstable();
        support
    }
}

/// The problem under `constraints`, which are known to be valid.
pub(super) fn prepare(triangle: &Triangle, n_features: usize, target: usize, constraints: &Constraints) -> Prepared {
    let dim = n_features.min(triangle.n_rows());
    let (mut y, unreachable) = split(triangle, target, dim);
    let mut basis: Vec<Vec<f64>> = Vec::new();
    for &j in &constraints.fixed {
        basis.extend(unit(triangle, j, dim).and_then(|(_, a)| remaining(a, &basis)));
    }
    basis.iter().for_each(|q| subtract(&mut y, q));
    let left = |j: usize| unit(triangle, j, dim).and_then(|(j, a)| Some((j, remaining(a, &basis)?)));
    let taken = |j: &usize| {
        [&constraints.fixed, &constraints.forbidden].into_iter().chain(&constraints.groups).any(|some| some.contains(j))
    };
    let (mut kept, equal) = distinct((0..n_features).filter(|j| !taken(j)).filter_map(left));
    most_promising_first(&mut kept, &y);
    let mut units: Vec<Vec<usize>> = (0..kept.len()).map(|j| vec![j]).collect();
    for group in &constraints.groups {
        let from = kept.len();
        kept.extend(group.iter().filter_map(|&j| left(j)));
        units.push((from..kept.len()).collect());
    }
    let (columns, problem) = problem(dim, kept, y, unreachable);
    let singles = constraints.groups.is_empty();
    Prepared { problem, units, singles, equal, columns, fixed: constraints.fixed.clone() }
}

/// Column `j` scaled to unit length, without its end that is zero; none if it is zero.
pub(super) fn unit(triangle: &Triangle, j: usize, dim: usize) -> Option<Unit> {
    let length = triangle.norm(j);
    let mut unit = vec![0.0; dim];
    unit.iter_mut().zip(triangle.column(j)).for_each(|(u, v)| *u = v / length);
    (length > 0.0).then_some((j, unit))
}

/// What is left of a unit column outside the span of `basis`, scaled to unit length; none if that is next to nothing.
fn remaining(mut a: Vec<f64>, basis: &[Vec<f64>]) -> Option<Vec<f64>> {
    take_out_all(&mut a, basis);
    let left = square(&a);
    a.iter_mut().for_each(|v| *v /= left.sqrt());
    (left >= DEPENDENT).then_some(a)
}

/// The part of a target that the first columns can reach, and the squared length of the rest.
pub(super) fn split(triangle: &Triangle, target: usize, dim: usize) -> (Vec<f64>, f64) {
    let y = triangle.column(target);
    let mut reachable = vec![0.0; dim];
    let shared = dim.min(y.len());
    reachable[..shared].copy_from_slice(&y[..shared]);
    (reachable, square(&y[shared..]))
}

/// The columns that differ, the first of equal ones; and those left out, each with the one that equals it.
pub(super) fn distinct(columns: impl Iterator<Item = Unit>) -> (Vec<Unit>, Vec<(usize, usize)>) {
    let mut kept: Vec<Unit> = Vec::new();
    let mut equal = Vec::new();
    for (j, unit) in columns {
        match kept.iter().find(|(_, other)| same(&unit, other)) {
            Some((first, _)) => equal.push((j, *first)),
            None => kept.push((j, unit)),
        }
    }
    (kept, equal)
}

/// Whether two unit vectors point along the same line.
fn same(a: &[f64], b: &[f64]) -> bool {
    let along = dot(a, b);
    if along.abs() < NEARLY {
        return false;
    }
    let sign = along.signum();
    a.iter().zip(b).map(|(a, b)| (a - sign * b).powi(2)).sum::<f64>() < SAME * SAME
}

/// Sorts by the share of the target that a column reaches alone.
pub(super) fn most_promising_first(columns: &mut [Unit], y: &[f64]) {
    let mut keyed: Vec<(f64, Unit)> = columns.iter_mut().map(|c| (dot(&c.1, y).abs(), std::mem::take(c))).collect();
    keyed.sort_by(|(a, i), (b, j)| b.total_cmp(a).then(i.0.cmp(&j.0)));
    columns.iter_mut().zip(keyed).for_each(|(slot, (_, column))| *slot = column);
}

/// The problem of these columns, with their numbers in the triangle.
pub(super) fn problem(dim: usize, columns: Vec<Unit>, y: Vec<f64>, unreachable: f64) -> (Vec<usize>, Problem) {
    let (numbers, columns): (Vec<usize>, Vec<Vec<f64>>) = columns.into_iter().unzip();
    let problem = Problem::new(dim, columns.concat(), y, unreachable);
    // For which columns are the same.
    problem.worked(numbers.len() * numbers.len() / 2, 0, 0);
    (numbers, problem)
}
