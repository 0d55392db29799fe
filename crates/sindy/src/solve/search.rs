//! The subsets of a given size with the smallest residuals.

/// Columns of one regression, each of unit length, and their target.
#[derive(Debug, Clone)]
pub(crate) struct Problem {
    /// Length of a column.
    dim: usize,
    /// (columns, dim), one column after the other.
    columns: Vec<f64>,
    target: Vec<f64>,
    /// Squared length of the part of the target that no column reaches.
    unreachable: f64,
}

/// A subset of columns and its squared residual.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Candidate {
    pub(crate) rss: f64,
    /// Ascending column numbers.
    pub(crate) subset: Vec<usize>,
}

/// Candidates kept per size.
const KEPT: usize = 24;

/// Squared distance from the span of the others at which a column of unit length counts as dependent.
const DEPENDENT: f64 = 1e-18;

/// Residuals are first computed by a difference of squares, which cannot see below this part of the target.
const CANCELLATION: f64 = 1e-12;

/// Residuals this many times the best one's (squared) are of no interest.
pub(super) const NEAR_BEST: f64 = 4.0;

/// Subtrees with fewer leaves are searched rather than bounded.
const WORTH_A_BOUND: f64 = 20_000.0;

impl Problem {
    /// A problem of `columns` and a `target`, all of length `dim`; `unreachable` is the squared length of what was cut
    /// off the target. The columns must have unit length.
    pub(crate) fn new(dim: usize, columns: Vec<f64>, target: Vec<f64>, unreachable: f64) -> Self {
        Self { dim, columns, target, unreachable }
    }

    pub(crate) fn n_columns(&self) -> usize {
        self.columns.len().checked_div(self.dim).unwrap_or(0)
    }

    /// Number of subsets of `size`.
    pub(crate) fn n_subsets(&self, size: usize) -> f64 {
        binomial(self.n_columns(), size)
    }

    /// Squared length of the target.
    pub(crate) fn total(&self) -> f64 {
        square(&self.target) + self.unreachable
    }

    /// The best subsets of `size`, best first, by looking at all of them. Residuals up to `interesting` are kept even
    /// when the best one is much smaller. With `bounded`, subtrees that cannot hold a good one are cut.
    pub(crate) fn exhaustive(&self, size: usize, interesting: f64, bounded: bool) -> Vec<Candidate> {
        let mut kept = Kept { best: Vec::new(), interesting };
        let mut chosen = Vec::with_capacity(size);
        let root =
            Node { columns: self.columns.clone(), norms: vec![1.0; self.n_columns()], residual: self.target.clone() };
        match size {
            0 => kept.offer(self.total(), &[]),
            1 => {
                for j in 0..self.n_columns() {
                    kept.offer(self.exact(&root.residual, column(&root.columns, self.dim, j)), &[j]);
                }
            }
            _ => {
                let mut spare = vec![root.clone(); size - 2];
                self.descend(&root, 0, size, bounded, &mut spare, &mut chosen, &mut kept);
            }
        }
        kept.best
    }

    /// Visits every subset of `remaining` (≥ 2) columns from `start` on; `node` is what is left of columns and target
    /// after the columns in `chosen` are taken out.
    #[allow(clippy::too_many_arguments)]
    fn descend(
        &self,
        node: &Node,
        start: usize,
        remaining: usize,
        bounded: bool,
        spare: &mut [Node],
        chosen: &mut Vec<usize>,
        kept: &mut Kept,
    ) {
        let m = self.n_columns();
        if bounded
            && remaining > 2
            && binomial(m - start, remaining) > WORTH_A_BOUND
            && self.bound(node, start) > kept.cutoff()
        {
            return;
        }
        for j in start..=m - remaining {
            if node.norms[j] < DEPENDENT {
                continue;
            }
            let Some(unit) = normalised(column(&node.columns, self.dim, j)) else { continue };
            chosen.push(j);
            if remaining == 2 {
                self.leaves(node, j, &unit, chosen, kept);
            } else if let Some((next, rest)) = spare.split_first_mut() {
                next.take_out(node, &unit, j + 1, self.dim);
                self.descend(next, j + 1, remaining - 1, bounded, rest, chosen, kept);
            }
            chosen.pop();
        }
    }

    /// Tries each column after `j` as the last one; `unit` is the direction of column `j`.
    fn leaves(&self, node: &Node, j: usize, unit: &[f64], chosen: &mut Vec<usize>, kept: &mut Kept) {
        let along = dot(unit, &node.residual);
        let residual: Vec<f64> = node.residual.iter().zip(unit).map(|(r, q)| r - along * q).collect();
        let rss = square(&residual);
        let scale = CANCELLATION * square(&node.residual);
        let cutoff = kept.cutoff() - self.unreachable;
        for l in j + 1..self.n_columns() {
            let a = column(&node.columns, self.dim, l);
            let (shared, overlap) = dot2(a, unit, &residual);
            let left = node.norms[l] - shared * shared;
            if node.norms[l] < DEPENDENT || left < 1e-6 * node.norms[l] {
                // Too much of the column is gone for a difference of squares.
                let a: Vec<f64> = a.iter().zip(unit).map(|(a, q)| a - shared * q).collect();
                if square(&a) < DEPENDENT {
                    continue;
                }
                chosen.push(l);
                kept.offer(self.exact(&residual, &a), chosen);
                chosen.pop();
                continue;
            }
            if rss - overlap * overlap / left <= cutoff + scale {
                let a: Vec<f64> = a.iter().zip(unit).map(|(a, q)| a - shared * q).collect();
                chosen.push(l);
                kept.offer(self.exact(&residual, &a), chosen);
                chosen.pop();
            }
        }
    }

    /// The squared residual after `a` is taken out of `residual`, without cancellation.
    fn exact(&self, residual: &[f64], a: &[f64]) -> f64 {
        let along = dot(residual, a) / square(a);
        residual.iter().zip(a).map(|(r, a)| (r - along * a) * (r - along * a)).sum::<f64>() + self.unreachable
    }

    /// A squared residual that no subset of the columns from `start` on can fall below.
    fn bound(&self, node: &Node, start: usize) -> f64 {
        let mut residual = node.residual.clone();
        let mut basis: Vec<Vec<f64>> = Vec::new();
        for j in start..self.n_columns() {
            let mut a = column(&node.columns, self.dim, j).to_vec();
            take_out_all(&mut a, &basis);
            if square(&a) < DEPENDENT {
                continue;
            }
            let Some(unit) = normalised(&a) else { continue };
            subtract(&mut residual, &unit);
            basis.push(unit);
        }
        square(&residual) + self.unreachable
    }

    /// Good subsets of one more column than `from` have: a forward step from each, then exchanges until none helps.
    pub(crate) fn grow(&self, from: &[Candidate], interesting: f64) -> Vec<Candidate> {
        /// Subsets to start from.
        const STARTS: usize = 2;
        /// Rounds of exchanges; each one improves the residual, so this is never reached in practice.
        const ROUNDS: usize = 40;
        let mut kept = Kept { best: Vec::new(), interesting };
        for start in from.iter().take(STARTS) {
            let Some(mut current) = self.complete(&start.subset, &mut kept) else { continue };
            for _ in 0..ROUNDS {
                let mut better: Option<Candidate> = None;
                for out in 0..current.subset.len() {
                    let mut rest = current.subset.clone();
                    rest.remove(out);
                    let found = self.complete(&rest, &mut kept);
                    let bar = better.as_ref().map_or(current.rss * (1.0 - 1e-9), |b| b.rss);
                    better = found.filter(|c| c.rss < bar).or(better);
                }
                match better {
                    Some(next) => current = next,
                    None => break,
                }
            }
        }
        kept.best
    }

    /// Offers `subset` with each other column added; the best of these.
    fn complete(&self, subset: &[usize], kept: &mut Kept) -> Option<Candidate> {
        let mut basis: Vec<Vec<f64>> = Vec::with_capacity(subset.len());
        let mut residual = self.target.clone();
        for &j in subset {
            let mut a = column(&self.columns, self.dim, j).to_vec();
            take_out_all(&mut a, &basis);
            let unit = normalised(&a)?;
            subtract(&mut residual, &unit);
            basis.push(unit);
        }
        let mut best: Option<Candidate> = None;
        for j in (0..self.n_columns()).filter(|j| !subset.contains(j)) {
            let mut a = column(&self.columns, self.dim, j).to_vec();
            take_out_all(&mut a, &basis);
            if square(&a) < DEPENDENT {
                continue;
            }
            let rss = self.exact(&residual, &a);
            let mut with = subset.to_vec();
            with.insert(with.partition_point(|&i| i < j), j);
            kept.offer(rss, &with);
            if best.as_ref().is_none_or(|b| rss < b.rss) {
                best = Some(Candidate { rss, subset: with });
            }
        }
        best
    }
}

/// Columns and target with some columns taken out.
#[derive(Debug, Clone)]
struct Node {
    columns: Vec<f64>,
    /// Squared lengths of the columns.
    norms: Vec<f64>,
    residual: Vec<f64>,
}

impl Node {
    /// Becomes `node` with the direction `unit` taken out of the target and of every column from `start` on.
    fn take_out(&mut self, node: &Self, unit: &[f64], start: usize, dim: usize) {
        self.residual.copy_from_slice(&node.residual);
        subtract(&mut self.residual, unit);
        for l in start..self.norms.len() {
            let from = column(&node.columns, dim, l);
            let shared = dot(from, unit);
            let to = &mut self.columns[l * dim..(l + 1) * dim];
            let mut norm = 0.0;
            for ((to, from), q) in to.iter_mut().zip(from).zip(unit) {
                *to = from - shared * q;
                norm += *to * *to;
            }
            self.norms[l] = norm;
        }
    }
}

/// The best candidates so far, best first.
struct Kept {
    best: Vec<Candidate>,
    interesting: f64,
}

impl Kept {
    /// Squared residuals above this are not kept.
    fn cutoff(&self) -> f64 {
        let Some(best) = self.best.first() else { return f64::INFINITY };
        let near = (NEAR_BEST * best.rss).max(self.interesting);
        match self.best.last() {
            Some(last) if self.best.len() == KEPT => near.min(last.rss),
            _ => near,
        }
    }

    fn offer(&mut self, rss: f64, subset: &[usize]) {
        if rss.is_nan() || rss > self.cutoff() || self.best.iter().any(|c| c.subset == subset) {
            return;
        }
        let at = self.best.partition_point(|c| c.rss <= rss);
        self.best.insert(at, Candidate { rss, subset: subset.to_vec() });
        self.best.truncate(KEPT);
    }
}

/// The number of ways to choose `k` of `n`.
pub(crate) fn binomial(n: usize, k: usize) -> f64 {
    if k > n {
        return 0.0;
    }
    (0..k).fold(1.0, |ways, i| ways * (n - i) as f64 / (i + 1) as f64)
}

fn column(columns: &[f64], dim: usize, j: usize) -> &[f64] {
    &columns[j * dim..(j + 1) * dim]
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    dot2(a, b, b).0
}

/// (a·b, a·c), in four lanes each.
fn dot2(a: &[f64], b: &[f64], c: &[f64]) -> (f64, f64) {
    const LANES: usize = 4;
    let (mut first, mut second) = ([0.0; LANES], [0.0; LANES]);
    let (a4, a_rest) = a.as_chunks::<LANES>();
    let (b4, b_rest) = b.as_chunks::<LANES>();
    let (c4, c_rest) = c.as_chunks::<LANES>();
    for ((a, b), c) in a4.iter().zip(b4).zip(c4) {
        for i in 0..LANES {
            first[i] += a[i] * b[i];
            second[i] += a[i] * c[i];
        }
    }
    let mut sums = (first.iter().sum::<f64>(), second.iter().sum::<f64>());
    for ((a, b), c) in a_rest.iter().zip(b_rest).zip(c_rest) {
        sums.0 += a * b;
        sums.1 += a * c;
    }
    sums
}

fn square(a: &[f64]) -> f64 {
    dot(a, a)
}

fn normalised(a: &[f64]) -> Option<Vec<f64>> {
    let length = square(a).sqrt();
    (length > 0.0).then(|| a.iter().map(|v| v / length).collect())
}

/// r ← r − (r·q) q.
fn subtract(r: &mut [f64], q: &[f64]) {
    let along = dot(r, q);
    for (r, q) in r.iter_mut().zip(q) {
        *r -= along * q;
    }
}

/// Takes every direction of an orthonormal `basis` out of `a`, twice, so that rounding leaves nothing behind.
fn take_out_all(a: &mut [f64], basis: &[Vec<f64>]) {
    for _ in 0..2 {
        for q in basis {
            subtract(a, q);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Columns of unit length and a target near the span of three of them.
    fn problem(dim: usize, m: usize) -> Problem {
        let mut state = 11_u64;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        let columns: Vec<Vec<f64>> =
            (0..m).map(|_| normalised(&(0..dim).map(|_| next()).collect::<Vec<_>>()).expect("not zero")).collect();
        let target = (0..dim).map(|i| columns[2][i] - 2.0 * columns[7][i] + columns[11][i] + 0.1 * next()).collect();
        Problem::new(dim, columns.concat(), target, 0.3)
    }

    #[test]
    fn bounds_cut_nothing_that_would_be_kept() {
        let problem = problem(60, 36);
        assert!(problem.n_subsets(4) > WORTH_A_BOUND);
        let (all, bounded) = (problem.exhaustive(4, 0.0, false), problem.exhaustive(4, 0.0, true));
        assert_eq!(all, bounded);
        assert_eq!(all.len(), KEPT);
    }

    #[test]
    fn growing_finds_the_best_here_too() {
        let problem = problem(60, 36);
        let grown = problem.grow(&problem.exhaustive(3, 0.0, true), 0.0);
        assert_eq!(grown[0].subset, problem.exhaustive(4, 0.0, true)[0].subset);
    }

    #[test]
    fn residuals_far_below_the_target_are_seen() {
        let mut problem = problem(60, 36);
        problem.unreachable = 0.0;
        let sum = |i: usize| [4, 9, 20].iter().map(|j| column(&problem.columns, 60, *j)[i]).sum::<f64>();
        problem.target = (0..60).map(|i| sum(i) + 1e-10 * (i as f64).sin()).collect();
        let best = &problem.exhaustive(3, 0.0, true)[0];
        assert_eq!(best.subset, [4, 9, 20]);
        assert!(best.rss < 60.0 * 1e-20, "{}", best.rss);
    }

    #[test]
    fn ways_to_choose() {
        assert_eq!([binomial(40, 5), binomial(3, 4), binomial(7, 0)].map(|ways| ways as u64), [658_008, 0, 1]);
    }
}
