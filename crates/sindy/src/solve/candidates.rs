//! The best subsets found so far.

use std::collections::BTreeSet;

/// A subset of columns and its squared residual.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Candidate {
    pub(crate) rss: f64,
    /// Ascending column numbers.
    pub(crate) subset: Vec<usize>,
}

/// The best candidates of one size so far, best first; of equal ones the first in order of their columns.
#[derive(Debug, Clone)]
pub(crate) struct Kept {
    best: Vec<Candidate>,
    /// Number of candidates kept.
    keep: usize,
    /// Squared residuals this many times the best one's are of no interest.
    near: f64,
    /// Squared residuals up to this are of interest all the same.
    interesting: f64,
    /// Subsets of which all exchanges were offered.
    exchanged: BTreeSet<Vec<usize>>,
}

impl Kept {
    pub(crate) fn new(keep: usize, near: f64, interesting: f64) -> Self {
        Self { best: Vec::new(), keep: keep.max(1), near, interesting, exchanged: BTreeSet::new() }
    }

    /// Squared residuals above this are not kept.
    pub(crate) fn cutoff(&self) -> f64 {
        let Some(best) = self.best.first() else { return f64::INFINITY };
        let near = (self.near * best.rss).max(self.interesting);
        match self.best.last() {
            Some(last) if self.best.len() == self.keep => near.min(last.rss),
            _ => near,
        }
    }

    /// The squared residual of `subset`, if that is kept.
    pub(crate) fn known(&self, subset: &[usize]) -> Option<f64> {
        self.best.iter().find(|c| c.subset == subset).map(|c| c.rss)
    }

    pub(crate) fn offer(&mut self, rss: f64, subset: &[usize]) {
        if rss.is_nan() || rss > self.cutoff() || self.known(subset).is_some() {
            return;
        }
        let before = |c: &Candidate| c.rss.total_cmp(&rss).then_with(|| c.subset.as_slice().cmp(subset)).is_lt();
        let at = self.best.partition_point(before);
        self.best.insert(at, Candidate { rss, subset: subset.to_vec() });
        self.best.truncate(self.keep);
        let cutoff = self.cutoff();
        self.best.retain(|c| c.rss <= cutoff);
    }

    /// Whether the exchanges of `subset` were not offered yet; they are about to be.
    pub(crate) fn is_new(&mut self, subset: &[usize]) -> bool {
        self.exchanged.insert(subset.to_vec())
    }

    /// Whether a further candidate has to be better than the last one.
    pub(crate) fn is_full(&self) -> bool {
        self.best.len() == self.keep
    }

    pub(crate) fn into_best(self) -> Vec<Candidate> {
        self.best
    }
}

/// The number of ways to choose `k` of `n`.
pub(crate) fn binomial(n: usize, k: usize) -> f64 {
    if k > n {
        return 0.0;
    }
    (0..k).fold(1.0, |ways, i| ways * (n - i) as f64 / (i + 1) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ways_to_choose() {
        assert_eq!([binomial(40, 5), binomial(3, 4), binomial(7, 0)].map(|ways| ways as u64), [658_008, 0, 1]);
    }

    #[test]
    fn far_candidates_leave_when_a_better_one_comes() {
        let mut kept = Kept::new(3, 4.0, 0.0);
        kept.offer(8.0, &[0]);
        kept.offer(9.0, &[1]);
        kept.offer(1.0, &[2]);
        assert_eq!(kept.best.len(), 1);
        kept.offer(3.0, &[3]);
        kept.offer(2.0, &[4]);
        kept.offer(2.0, &[4]);
        assert_eq!(kept.best.iter().map(|c| c.subset[0]).collect::<Vec<_>>(), [2, 4, 3]);
        assert_eq!(kept.cutoff(), 3.0);
    }
}
