//! The search where some terms are several columns.

use super::candidates::Kept;
use super::problem::Problem;
use super::tree::{Account, Bound, EXACT, Limits};

/// Offers to `kept` every choice of `size` of the `units` that is good enough, as far as the limits allow. Units are
/// sets of the problem's columns. A part of the tree is cut by the residual of all columns that may still come.
pub(super) fn search(
    problem: &Problem,
    units: &[Vec<usize>],
    size: usize,
    limits: &Limits<'_>,
    kept: &mut Kept,
) -> Account {
    let mut order: Vec<&[usize]> = units.iter().map(Vec::as_slice).collect();
    let alone: Vec<f64> = order.iter().map(|unit| problem.span_rss(unit)).collect();
    let mut by_promise: Vec<usize> = (0..order.len()).collect();
    by_promise.sort_by(|&a, &b| alone[a].total_cmp(&alone[b]).then(a.cmp(&b)));
    order = by_promise.iter().map(|&i| units[i].as_slice()).collect();
    let account = Account { open: f64::INFINITY, work: 0, nodes: 0 };
    let mut search = Search { problem, units: order, limits, kept, account, stopped: false };
    search.descend(&mut Vec::new(), 0, size, problem.unreachable());
    search.account
}

struct Search<'a> {
    problem: &'a Problem,
    units: Vec<&'a [usize]>,
    limits: &'a Limits<'a>,
    kept: &'a mut Kept,
    account: Account,
    stopped: bool,
}

impl Search<'_> {
    fn spent(&mut self, bound: f64) -> bool {
        if self.kept.is_full() && self.kept.cutoff() <= EXACT * self.problem.total() {
            return true;
        }
        self.stopped = self.stopped || self.account.work >= self.limits.budget || !(self.limits.go_on)();
        if self.stopped {
            self.account.open = self.account.open.min(bound);
        }
        self.stopped
    }

    /// Looks at every choice of `r` of the units from `start` on, with the columns `chosen`.
    fn descend(&mut self, chosen: &mut Vec<usize>, start: usize, r: usize, bound: f64) {
        if self.spent(bound) {
            return;
        }
        if r == 0 {
            let mut subset = chosen.clone();
            subset.sort_unstable();
            self.account.work += (subset.len() * subset.len() * self.problem.dim()) as u64;
            self.kept.offer(self.problem.span_rss(&subset), &subset);
            return;
        }
        self.account.nodes += 1;
        let order: Vec<usize> = self.units[start..].iter().flat_map(|unit| unit.iter().copied()).collect();
        let remainders = if self.limits.bound > Bound::None && r > 1 {
            self.account.work += (order.len() * order.len() * self.problem.dim()) as u64;
            self.problem.remainders(chosen, &order)
        } else {
            vec![0.0; order.len() + 1]
        };
        let mut at = 0;
        for i in start..(self.units.len() + 1).saturating_sub(r) {
            let bound = bound.max(remainders[at] * (1.0 - 1e-9) + self.problem.unreachable());
            if bound > self.kept.cutoff() || self.spent(bound) {
                break;
            }
            let length = chosen.len();
            chosen.extend(self.units[i]);
            self.descend(chosen, i + 1, r - 1, bound);
            chosen.truncate(length);
            at += self.units[i].len();
        }
    }
}
