//! What no choice of r of a node's columns can fall below.

use super::cholesky::Factor;
use super::cuts::Bound;
use super::node::Node;

/// What is known about a node before its columns are tried one by one.
#[derive(Debug)]
pub(super) struct Verdict {
    /// No r of the columns reach a squared residual below this.
    pub(super) bound: f64,
    /// Columns that every good enough choice has.
    pub(super) forced: Vec<usize>,
    /// Columns that some good enough choice may have, in the order to try them.
    pub(super) keep: Vec<usize>,
    /// For each i: no r of the columns `keep[i..]` reach a squared residual below this.
    pub(super) remainders: Vec<f64>,
}

/// Largest partial correlation a bound by gains is tried with.
const CORRELATED: f64 = 0.5;

/// The largest squared partial correlation of two columns of `among`, 1 if it is too large for a bound.
pub(super) fn coherence(node: &Node, among: &[usize]) -> f64 {
    let f = node.len();
    let inverse: Vec<f64> = (0..f).map(|i| 1.0 / node.square_at_least(i)).collect();
    let mut largest = 0.0_f64;
    for (at, &k) in among.iter().enumerate() {
        let row = &node.gram[k * f..(k + 1) * f];
        let of_row = among[at + 1..].iter().fold(0.0_f64, |most, &l| {
            let shared = row[l].abs() + node.error.gram;
            most.max(shared * shared * inverse[l])
        });
        largest = largest.max(of_row * inverse[k]);
        if largest > CORRELATED * CORRELATED {
            return 1.0;
        }
    }
    largest
}

/// The columns of `among` that some choice of `r` with a gain of `wanted` may have; none if there is no such choice.
///
/// r columns of unit length with correlations of at most m have a Gram matrix with no eigenvalue below 1 − (r − 1) m,
/// so that together they gain no more than the sum of what each gains alone, divided by it.
pub(super) fn by_gains(node: &Node, r: usize, wanted: f64, mut among: Vec<usize>) -> Vec<usize> {
    let gains: Vec<f64> = (0..node.len()).map(|i| node.gain(i)).collect();
    loop {
        let before = among.len();
        if before < r {
            return Vec::new();
        }
        let least = 1.0 - (r - 1) as f64 * coherence(node, &among).sqrt();
        if least <= 0.0 {
            return among;
        }
        let mut sorted: Vec<f64> = among.iter().map(|&i| gains[i]).collect();
        sorted.sort_unstable_by(|a, b| b.total_cmp(a));
        let others: f64 = sorted[..r - 1].iter().sum();
        if others + sorted[r - 1] < wanted * least {
            return Vec::new();
        }
        among.retain(|&i| gains[i] + others >= wanted * least);
        if among.len() * 10 > before * 9 {
            return among;
        }
    }
}

/// Examines the choices of `r` of the node's columns that reach `cutoff`. `node` has its columns in the order in which
/// they are to be tried, and `factor` belongs to it.
pub(super) fn examine(node: &Node, factor: &Factor, r: usize, cutoff: f64, kind: Bound) -> Verdict {
    let f = node.len();
    let solution = factor.solve(&node.overlap);
    let diagonal = factor.inverse_diagonal();
    let slack = slack(node, &solution);
    let all = node.rss - solution.iter().zip(&node.overlap).map(|(b, c)| b * c).sum::<f64>() - slack;
    // Leaving out column j alone costs β_j² / (S⁻¹)_jj; a thousandth is left to rounding.
    let price: Vec<f64> = solution.iter().zip(&diagonal).map(|(b, d)| 0.999 * b * b / d).collect();
    let mut verdict = Verdict {
        bound: all,
        forced: (0..f).filter(|&j| all + price[j] > cutoff).collect(),
        keep: (0..f).collect(),
        remainders: factor.remainders(node).iter().map(|v| v - slack).collect(),
    };
    if kind == Bound::Relaxation && node.least > 0.0 {
        let relaxed = Relaxed::of(node, r, &solution);
        relaxed.sharpen(node, r, cutoff, &mut verdict);
    }
    verdict
}

/// What rounding may do to a quadratic form c'u or u'Su.
fn slack(node: &Node, u: &[f64]) -> f64 {
    let size: f64 = u.iter().map(|u| u.abs()).sum();
    node.error.rss + 4.0 * size * (node.error.gram * size + node.error.overlap)
}

/// A dual solution of the perspective relaxation.
///
/// With S = M + λI and M positive semidefinite, β'Mβ ≥ 2u'Mβ − u'Mu for every u, so that for β with r entries
/// ‖y − Xβ‖² = ‖y‖² − 2c'β + β'Mβ + λ‖β‖² ≥ ‖y‖² − u'Mu − Σ of the r largest (c − Mu)_j² / λ.
///
/// # References
/// Günlük, Linderoth (2010), Math. Program. 124 (perspective). Zheng, Sun, Li (2014), INFORMS J. Comput. 26(4), splitting
/// off a diagonal. Hazimeh, Mazumder, Saab (2022), Math. Program. 196, bounds from any dual point.
struct Relaxed {
    /// ‖y‖² − u'Mu.
    base: f64,
    /// (c − Mu)_j² / λ.
    value: Vec<f64>,
}

/// Steps of the dual ascent.
const STEPS: usize = 12;

impl Relaxed {
    fn of(node: &Node, r: usize, solution: &[f64]) -> Self {
        let mut u = solution.to_vec();
        let mut best: Option<(f64, Self)> = None;
        for step in 0..STEPS {
            let (relaxed, slope) = Self::at(node, &u);
            let largest = relaxed.largest(r);
            let bound = relaxed.base - largest.iter().map(|&j| relaxed.value[j]).sum::<f64>();
            // β_H keeps the r largest of (c − Mu)/λ: h rises from u towards it.
            let mut towards = vec![0.0; u.len()];
            largest.iter().for_each(|&j| towards[j] = slope[j] / node.least);
            let weight = 2.0 / (step + 3) as f64;
            u.iter_mut().zip(&towards).for_each(|(u, t)| *u += weight * (t - *u));
            if best.as_ref().is_none_or(|(b, _)| bound > *b) {
                best = Some((bound, relaxed));
            }
        }
        best.map_or_else(|| Self { base: 0.0, value: vec![0.0; u.len()] }, |(_, relaxed)| relaxed)
    }

    /// The bound's parts at `u`, and c − Mu.
    fn at(node: &Node, u: &[f64]) -> (Self, Vec<f64>) {
        let f = node.len();
        let mut product: Vec<f64> = u.iter().map(|u| -node.least * u).collect();
        for (i, &weight) in u.iter().enumerate().filter(|(_, u)| **u != 0.0) {
            let row = &node.gram[i * f..(i + 1) * f];
            product.iter_mut().zip(row).for_each(|(p, g)| *p += weight * g);
        }
        let quadratic: f64 = u.iter().zip(&product).map(|(u, p)| u * p).sum();
        let slope: Vec<f64> = node.overlap.iter().zip(&product).map(|(c, p)| c - p).collect();
        let value = slope.iter().map(|v| v * v / node.least).collect();
        (Self { base: node.rss - quadratic - slack(node, u), value }, slope)
    }

    /// The `r` columns with the largest values, largest first.
    fn largest(&self, r: usize) -> Vec<usize> {
        let mut order: Vec<usize> = (0..self.value.len()).collect();
        order.sort_unstable_by(|&a, &b| self.value[b].total_cmp(&self.value[a]).then(a.cmp(&b)));
        order.truncate(r);
        order
    }

    fn sharpen(&self, node: &Node, r: usize, cutoff: f64, verdict: &mut Verdict) {
        let f = node.len();
        let largest = self.largest(r + 1);
        let value = |at: usize| largest.get(at).map_or(0.0, |&j| self.value[j]);
        let bound = self.base - largest.iter().take(r).map(|&j| self.value[j]).sum::<f64>();
        verdict.bound = verdict.bound.max(bound);
        let inside = |j: usize| largest[..r.min(largest.len())].contains(&j);
        verdict.keep.retain(|&j| inside(j) || bound + value(r - 1) - self.value[j] <= cutoff);
        for &j in largest.iter().take(r) {
            if bound + self.value[j] - value(r) > cutoff && !verdict.forced.contains(&j) {
                verdict.forced.push(j);
            }
        }
        // The r largest values among the columns from i on, kept while going backwards.
        let mut top: Vec<f64> = Vec::with_capacity(r + 1);
        for i in (0..f).rev() {
            let at = top.partition_point(|v| *v > self.value[i]);
            top.insert(at, self.value[i]);
            top.truncate(r);
            verdict.remainders[i] = verdict.remainders[i].max(self.base - top.iter().sum::<f64>());
        }
    }
}
