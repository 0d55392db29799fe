//! Branch and bound over the subsets of one size.

mod bounds;
mod cholesky;
mod cuts;
mod errors;
mod node;
mod scan;

use super::candidates::{Kept, binomial};
use super::problem::Problem;
use bounds::{Verdict, by_gains, coherence, examine};
use cholesky::Factor;
pub use cuts::Bound;
use node::Node;
use scan::Pairs;

/// What a search may cost.
pub(crate) struct Limits<'a> {
    pub(crate) bound: Bound,
    /// Operations: pairs of columns looked at, and the like.
    pub(crate) budget: u64,
    /// Asked now and then whether to go on.
    pub(crate) go_on: &'a dyn Fn() -> bool,
}

/// What a search did.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Account {
    /// No subset has a squared residual below this, if it is not one of those kept.
    pub(crate) open: f64,
    /// Operations spent.
    pub(crate) work: u64,
    /// Nodes with three or more columns still to choose.
    pub(crate) nodes: u64,
}

/// Part of the squared target below which a squared residual is nothing but rounding.
pub(super) const EXACT: f64 = 1e-28;

struct Search<'a> {
    problem: &'a Problem,
    limits: &'a Limits<'a>,
    kept: &'a mut Kept,
    chosen: Vec<usize>,
    account: Account,
    stopped: bool,
    pairs: Pairs,
    hits: Vec<(usize, usize)>,
}

/// Offers to `kept` every subset of `size` that is good enough to be kept, as far as the limits allow.
pub(crate) fn search(problem: &Problem, size: usize, limits: &Limits<'_>, kept: &mut Kept) -> Account {
    let account = Account { open: f64::INFINITY, work: 0, nodes: 0 };
    let mut search = Search {
        problem,
        limits,
        kept,
        chosen: Vec::new(),
        account,
        stopped: false,
        pairs: Pairs::default(),
        hits: Vec::new(),
    };
    let all: Vec<usize> = (0..problem.n_columns()).collect();
    if let Some(root) = Node::fresh(problem, &[], &all, 0.0) {
        search.descend(root, size, 0.0);
    }
    search.account.open += problem.unreachable();
    search.account
}

impl Search<'_> {
    fn cutoff(&self) -> f64 {
        self.kept.cutoff() - self.problem.unreachable()
    }

    /// Whether the search ends here; then `bound` holds for what is left out.
    fn spent(&mut self, bound: f64) -> bool {
        if self.kept.is_full() && self.kept.cutoff() <= EXACT * self.problem.total() {
            // Nothing is better than exact: the rest need not be looked at.
            return true;
        }
        self.stopped = self.stopped || self.account.work >= self.limits.budget || !(self.limits.go_on)();
        if self.stopped {
            self.account.open = self.account.open.min(bound);
        }
        self.stopped
    }

    fn offer(&mut self) {
        self.account.work += (self.chosen.len() * self.chosen.len() * self.problem.dim() / 2) as u64;
        let mut subset = self.chosen.clone();
        subset.sort_unstable();
        if let Some(rss) = self.problem.rss(&subset) {
            self.kept.offer(rss, &subset);
        }
    }

    /// Looks at every choice of `r` more of the node's columns; none falls below `bound`.
    fn descend(&mut self, node: Node, r: usize, bound: f64) {
        if node.len() < r || self.spent(bound) {
            return;
        }
        match r {
            0 => self.offer(),
            1 => {
                let wanted = node.wanted(self.cutoff());
                self.account.work += node.len() as u64;
                for i in (0..node.len()).filter(|&i| node.gain(i) >= wanted) {
                    self.chosen.push(node.free[i]);
                    self.offer();
                    self.chosen.pop();
                }
            }
            2 => {
                let mut pairs = std::mem::take(&mut self.pairs);
                node.pairs(&mut pairs);
                let all: Vec<usize> = (0..node.len()).collect();
                self.pairs_of(&node, &pairs, &all);
                self.pairs = pairs;
            }
            3 => self.triples(node, bound),
            _ => self.branch(node, r, bound),
        }
    }

    /// The columns `keep` of `node` after its column `i`, the last one of those chosen, is taken out.
    fn including(&mut self, node: &Node, i: usize, keep: &[usize]) -> Option<Node> {
        self.account.work += if node.is_stale_after(i) {
            Node::cost_of_fresh(self.problem, self.chosen.len(), keep.len())
        } else {
            (keep.len() * keep.len() / 2) as u64
        };
        node.including(self.problem, i, keep, &self.chosen)
    }

    fn pairs_of(&mut self, node: &Node, pairs: &Pairs, columns: &[usize]) {
        let mut hits = std::mem::take(&mut self.hits);
        hits.clear();
        self.account.work += pairs.scan(&node.gram, columns, self.cutoff(), &mut hits);
        for &(k, l) in &hits {
            self.chosen.extend([node.free[k], node.free[l]]);
            self.offer();
            self.chosen.truncate(self.chosen.len() - 2);
        }
        self.hits = hits;
    }

    fn triples(&mut self, mut node: Node, bound: f64) {
        self.account.nodes += 1;
        let wanted = node.wanted(self.cutoff());
        let bounded = self.limits.bound >= Bound::Gains && wanted > 0.0;
        let mut correlation = 1.0;
        if bounded {
            self.account.work += (node.len() * node.len() / 4) as u64;
            let all: Vec<usize> = (0..node.len()).collect();
            let keep = by_gains(&node, 3, wanted, all);
            if keep.len() < node.len() {
                node = node.restricted(&keep);
            }
            let all: Vec<usize> = (0..node.len()).collect();
            correlation = coherence(&node, &all).sqrt();
        }
        let mut pairs = std::mem::take(&mut self.pairs);
        for i in 0..node.len().saturating_sub(2) {
            if self.spent(bound) {
                break;
            }
            self.account.work += node.len() as u64;
            self.chosen.push(node.free[i]);
            let later: Vec<usize> = (i + 1..node.len()).collect();
            if node.is_stale_after(i) {
                if let Some(next) = self.including(&node, i, &later) {
                    next.pairs(&mut pairs);
                    let all: Vec<usize> = (0..next.len()).collect();
                    self.pairs_of(&next, &pairs, &all);
                }
            } else {
                node.pairs_after(i, &mut pairs);
                let columns = if correlation < 0.5 { self.worthwhile(&pairs, later, correlation) } else { later };
                if columns.len() >= 2 {
                    self.pairs_of(&node, &pairs, &columns);
                }
            }
            self.chosen.pop();
        }
        self.pairs = pairs;
    }

    /// The columns that some good enough pair may have; no two columns had a correlation beyond `correlation` before
    /// the last one was taken out.
    fn worthwhile(&self, pairs: &Pairs, mut columns: Vec<usize>, correlation: f64) -> Vec<usize> {
        // The partial correlation is at most (m + m²) / (1 − m²).
        let least = 1.0 - correlation / (1.0 - correlation) - pairs.error.gram;
        let wanted = (pairs.rss - pairs.error.rss - self.cutoff()) * least;
        let gain =
            |i: usize| (pairs.overlap[i].abs() + pairs.error.overlap).powi(2) / (pairs.square[i] - pairs.error.gram);
        let most = columns.iter().map(|&i| gain(i)).fold(0.0, f64::max);
        columns.retain(|&i| gain(i) + most >= wanted);
        columns
    }

    fn branch(&mut self, mut node: Node, mut r: usize, mut bound: f64) {
        let depth = self.chosen.len();
        self.account.nodes += 1;
        loop {
            let cutoff = self.cutoff();
            let Some(verdict) = self.verdict(&mut node, r, cutoff, bound) else { break };
            bound = bound.max(verdict.bound);
            if bound > cutoff || verdict.forced.len() > r || verdict.keep.len() < r {
                break;
            }
            if let Some(&i) = verdict.forced.first() {
                // Every good choice has this column: it is taken, and the rest looked at again.
                let keep: Vec<usize> = verdict.keep.iter().copied().filter(|&j| j != i).collect();
                self.chosen.push(node.free[i]);
                let Some(next) = self.including(&node, i, &keep) else { break };
                (node, r) = (next, r - 1);
                if r < 4 {
                    self.descend(node, r, bound);
                    break;
                }
                continue;
            }
            if verdict.keep.len() * 5 <= node.len() * 4 {
                node = node.restricted(&verdict.keep);
                continue;
            }
            self.children(&node, r, bound, &verdict);
            break;
        }
        self.chosen.truncate(depth);
    }

    fn children(&mut self, node: &Node, r: usize, bound: f64, verdict: &Verdict) {
        for (at, &i) in verdict.keep.iter().enumerate().take(verdict.keep.len() + 1 - r) {
            let bound = bound.max(verdict.remainders[i]);
            if bound > self.cutoff() || self.spent(bound) {
                break;
            }
            self.chosen.push(node.free[i]);
            if let Some(next) = self.including(node, i, &verdict.keep[at + 1..]) {
                self.descend(next, r - 1, bound);
            }
            self.chosen.pop();
        }
    }

    /// What is known about a node, whose columns are first put in order. None if no choice is good enough.
    fn verdict(&mut self, node: &mut Node, r: usize, cutoff: f64, bound: f64) -> Option<Verdict> {
        let f = node.len();
        let mut order: Vec<usize> = (0..f).collect();
        let plain = |f: usize| Verdict {
            bound: f64::NEG_INFINITY,
            forced: Vec::new(),
            keep: (0..f).collect(),
            remainders: vec![bound; f],
        };
        if self.limits.bound == Bound::None || node.wanted(cutoff) <= 0.0 {
            return Some(plain(f));
        }
        if self.limits.bound >= Bound::Gains {
            self.account.work += (f * f / 4) as u64;
            order = by_gains(node, r, node.wanted(cutoff), order);
            if order.len() < r {
                return None;
            }
        }
        let gains: Vec<f64> = (0..f).map(|i| node.gain(i)).collect();
        order.sort_by(|&a, &b| gains[b].total_cmp(&gains[a]));
        *node = node.restricted(&order);
        let f = node.len();
        let independent = f + self.chosen.len() <= self.problem.dim();
        // A bound costs about f³ operations, looking at every choice a good quarter of their number.
        if binomial(f, r) < (f * f * f) as f64 || !independent {
            return Some(plain(f));
        }
        if let Some(factor) = Factor::of(node) {
            self.account.work += (f * f * f / 8) as u64;
            if self.limits.bound == Bound::Relaxation {
                self.account.work += (f * f * f / 8 + 12 * f * f) as u64;
                node.least = factor.least_eigenvalue(node, node.least);
            }
            return Some(examine(node, &factor, r, cutoff, self.limits.bound));
        }
        let remainders = self.problem.remainders(&self.chosen, &node.free);
        self.account.work += (f * f * self.problem.dim()) as u64;
        Some(Verdict { remainders: remainders[..f].iter().map(|v| v * (1.0 - 1e-9)).collect(), ..plain(f) })
    }
}
