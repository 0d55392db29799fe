//! Regressions whose rows come in groups that are disturbed as a whole.

use ndarray::Array2;

use crate::solve::Subset;
use crate::{BestSubset, Triangle};

/// Blocks of consecutive groups that are left out in turn.
pub(super) const BLOCKS: usize = 10;

/// Median misfits at which a group has half its weight.
const HALF: f64 = 4.0;

/// Times that terms and weights are found in turn.
const ROUNDS: usize = 3;

/// Times that coefficients and weights are found in turn.
const SWEEPS: usize = 5;

/// Standard errors by which fewer columns may predict blocks worse: between the smallest loss, which keeps what says nothing, and one, which leaves out
/// friction that only a few pieces show.
const ERRORS: f64 = 0.5;

/// Part of the squares that a column more must explain, and how many in a row may not before larger subsets are of no interest.
const GAIN: f64 = 0.01;
const PATIENCE: usize = 3;

/// Operations for the subsets of one size.
const BUDGET: u64 = 50_000;

/// Subsets of one size from which those of the next are grown.
const STARTS: usize = 2;

/// Rows of one group: candidate columns, then the target (d, C + 1).
#[derive(Debug, Clone)]
pub(super) struct Group {
    pub(super) rows: Array2<f64>,
    /// The block it belongs to.
    pub(super) block: usize,
}

/// What explains most of the groups.
#[derive(Debug, Clone)]
pub(super) struct Choice {
    /// Columns, ascending, and their coefficients.
    pub(super) support: Vec<usize>,
    pub(super) xi: Vec<f64>,
    /// Per group, from 0 to 1.
    pub(super) weights: Vec<f64>,
    /// What groups lose when their block was left out, as part of what they lose without any column.
    pub(super) loss: f64,
}

/// The block of the group `at` of `count`.
pub(super) fn block(at: usize, count: usize) -> usize {
    at * BLOCKS / count.max(1)
}

/// The misfit at which a group has half its weight.
pub(super) fn half(misfits: &[f64]) -> f64 {
    let mut sorted: Vec<f64> = misfits.to_vec();
    sorted.sort_by(f64::total_cmp);
    (HALF * sorted.get(sorted.len() / 2).copied().unwrap_or(0.0)).max(f64::MIN_POSITIVE)
}

/// Weights 1/(1 + m/s) of groups with the mean squares m: those of a Cauchy distribution.
///
/// # References
/// Huber, Ronchetti (2009), Robust Statistics, §7.
pub(super) fn weights(misfits: &[f64], half: f64) -> Vec<f64> {
    misfits.iter().map(|m| if m.is_finite() { 1.0 / (1.0 + m / half) } else { 0.0 }).collect()
}

/// ln(1 + m/s).
pub(super) fn loss(misfit: f64, half: f64) -> f64 {
    if misfit.is_finite() { (misfit / half).ln_1p() } else { f64::MAX.ln() }
}

/// Mean squares of what the columns `support` with coefficients `xi` leave of each group.
fn misfits(groups: &[Group], support: &[usize], xi: &[f64]) -> Vec<f64> {
    let of = |group: &Group| {
        let target = group.rows.ncols() - 1;
        let square = |row: ndarray::ArrayView1<'_, f64>| {
            let sum: f64 = support.iter().zip(xi).map(|(j, c)| c * row[*j]).sum();
            (row[target] - sum).powi(2)
        };
        group.rows.rows().into_iter().map(square).sum::<f64>() / group.rows.nrows().max(1) as f64
    };
    groups.iter().map(of).collect()
}

/// The triangle of the `columns` of some groups, rows weighed by their group.
fn triangle<'a>(groups: impl Iterator<Item = (&'a Group, &'a f64)>, columns: &[usize]) -> Option<Triangle> {
    let mut values = Vec::new();
    for (group, weight) in groups {
        let by = (weight / group.rows.nrows().max(1) as f64).sqrt();
        group.rows.rows().into_iter().for_each(|row| values.extend(columns.iter().map(|&j| by * row[j])));
    }
    let rows = Array2::from_shape_vec((values.len() / columns.len().max(1), columns.len()), values).ok()?;
    let mut all = Triangle::new(columns.len());
    all.push(rows.view()).ok()?;
    Some(all)
}

/// The coefficients of the columns `support`, rows weighed by their group.
fn solved(groups: &[Group], weights: &[f64], support: &[usize], target: usize) -> Option<Vec<f64>> {
    let columns = [support, &[target]].concat();
    let own: Vec<usize> = (0..support.len()).collect();
    Some(triangle(groups.iter().zip(weights), &columns)?.solve_unit(&own, support.len()))
}

/// The columns that explain most of the `groups`, as few as predict blocks that are left out about as well as any more: within [`ERRORS`] standard errors of the
/// difference. Coefficients of columns that are `positive` (C) are so.
///
/// # References
/// Breiman, Friedman, Olshen, Stone (1984), Classification and Regression Trees, §3.4.3 (there one standard error).
pub(super) fn chosen(
    groups: &[Group],
    begun: Option<&[f64]>,
    positive: &[bool],
    (solver, go_on): (&BestSubset, &dyn Fn() -> bool),
) -> Option<Choice> {
    let target = groups.first()?.rows.ncols() - 1;
    let mut weight = begun.map_or_else(|| vec![1.0; groups.len()], <[f64]>::to_vec);
    let mut found: Option<Choice> = None;
    for _ in 0..ROUNDS {
        if !go_on() {
            return None;
        }
        let of_block = |b: usize| {
            let all = groups.iter().zip(&weight).filter(|(group, _)| group.block == b);
            triangle(all, &(0..=target).collect::<Vec<_>>())
        };
        let blocks: Vec<Triangle> = (0..BLOCKS).map(of_block).collect::<Option<_>>()?;
        let mut whole = Triangle::new(target + 1);
        for block in &blocks {
            whole.merge(block).ok()?;
        }
        let without: Vec<Triangle> = (0..BLOCKS)
            .map(|b| {
                let mut others = Triangle::new(target + 1);
                let rest = blocks.iter().enumerate().filter(|(at, _)| *at != b);
                rest.for_each(|(_, block)| others.merge(block).unwrap_or_default());
                others
            })
            .collect();
        let solver = solver.within(BUDGET);
        let (mut least, mut idle) = (f64::INFINITY, 0);
        let enough = |best: &Subset| {
            idle = if best.rss < (1.0 - GAIN) * least { 0 } else { idle + 1 };
            least = least.min(best.rss);
            idle >= PATIENCE
        };
        let sizes = solver.candidates(&whole, (target, STARTS), &vec![0; target], go_on, enough).sizes;
        let has_signs = |support: &[usize]| {
            let xi = whole.solve_unit(support, target);
            support.iter().zip(xi).all(|(&j, xi)| !positive[j] || xi >= 0.0)
        };
        let best = |(subsets, _): &(Vec<Subset>, bool)| {
            subsets.iter().map(|subset| subset.support.clone()).find(|support| has_signs(support))
        };
        let supports: Vec<Vec<usize>> = sizes.iter().filter_map(best).collect();
        let largest = supports.last()?;
        let half = half(&misfits(groups, largest, &whole.solve_unit(largest, target)));
        let losses: Vec<Vec<f64>> = supports.iter().map(|s| left_out(groups, &without, s, half)).collect();
        let sum = |k: &usize| losses[*k].iter().sum::<f64>();
        let best = (0..losses.len()).min_by(|a, b| sum(a).total_cmp(&sum(b)))?;
        let few = (0..=best).find(|&k| {
            let differences: Vec<f64> = losses[k].iter().zip(&losses[best]).map(|(a, b)| a - b).collect();
            sum(&k) - sum(&best) <= ERRORS * standard_error(&differences)
        })?;
        let support = supports[few].clone();
        let mut xi = whole.solve_unit(&support, target);
        for _ in 0..SWEEPS {
            let misfits = misfits(groups, &support, &xi);
            weight = weights(&misfits, self::half(&misfits));
            xi = solved(groups, &weight, &support, target)?;
        }
        let whole_loss = sum(&0).max(f64::MIN_POSITIVE);
        let same = found.as_ref().is_some_and(|before| before.support == support);
        found = Some(Choice { loss: sum(&few) / whole_loss, support, xi, weights: weight.clone() });
        if same {
            break;
        }
    }
    found
}

/// Per block, what its groups lose by the coefficients that the others have.
fn left_out(groups: &[Group], without: &[Triangle], support: &[usize], half: f64) -> Vec<f64> {
    let target = groups.first().map_or(0, |g| g.rows.ncols() - 1);
    let xi: Vec<Vec<f64>> = without.iter().map(|others| others.solve_unit(support, target)).collect();
    let mut losses = vec![0.0; without.len()];
    for group in groups {
        let misfit = misfits(std::slice::from_ref(group), support, &xi[group.block]);
        losses[group.block] += loss(misfit.first().copied().unwrap_or(0.0), half);
    }
    losses
}

/// The standard error of the sum of `values`.
fn standard_error(values: &[f64]) -> f64 {
    // Blocks without groups differ in nothing.
    let n = values.iter().filter(|v| **v != 0.0).count().max(1) as f64;
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0).max(1.0);
    (n * variance).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::RngExt as _;
    use sindyna_core::Seed;

    #[test]
    fn true_columns_are_chosen_though_a_fifth_of_the_groups_is_disturbed() {
        let mut rng = Seed::new(1003).stream("groups", 0);
        let mut uniform = || rng.random_range(-1.0..1.0);
        let count = 200;
        let group = |at: usize, uniform: &mut dyn FnMut() -> f64| {
            let mut rows = Array2::from_shape_fn((2, 13), |_| uniform());
            for mut row in rows.rows_mut() {
                row[12] = 2.0 * row[1] - 0.5 * row[7] + 0.02 * uniform();
                if at.is_multiple_of(5) {
                    row[12] += 3.0 + uniform();
                }
            }
            Group { rows, block: block(at, count) }
        };
        let groups: Vec<Group> = (0..count).map(|at| group(at, &mut uniform)).collect();
        let found = chosen(&groups, None, &[false; 12], (&BestSubset::default(), &|| true)).expect("columns");
        assert_eq!(found.support, [1, 7]);
        assert!((found.xi[0] - 2.0).abs() < 0.01 && (found.xi[1] + 0.5).abs() < 0.01, "{:?}", found.xi);
        assert!(found.weights.iter().enumerate().all(|(at, w)| at.is_multiple_of(5) == (*w < 0.1)));
    }
}
