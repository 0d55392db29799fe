//! The innermost loop: every pair of columns after those already chosen.

use sindyna_core::vectorized;

use super::errors::Errors;

/// The regression after some columns are taken out, as inner products; columns are numbered from 0.
#[derive(Debug, Default)]
pub(super) struct Pairs {
    /// What a pivot shares with each column: the products of two columns are `gram − shared shared'`.
    pub(super) shared: Vec<f64>,
    /// Products of the columns with the residual.
    pub(super) overlap: Vec<f64>,
    /// Squared lengths of the columns.
    pub(super) square: Vec<f64>,
    /// Squared length of the residual.
    pub(super) rss: f64,
    /// Bounds on the rounding errors.
    pub(super) error: Errors,
}

/// Lanes looked at together.
const LANES: usize = 8;

/// What one row of pairs (k, ·) is tested against.
#[derive(Debug, Clone, Copy)]
struct Row {
    shared: f64,
    /// 1 / ‖a_k‖².
    inverse: f64,
    /// a_k·r / ‖a_k‖².
    along: f64,
    /// What the second column has to take away at least.
    wanted: f64,
    error: f64,
    overlap_error: f64,
}

impl Row {
    /// Not negative where the pair may be good enough: (|a_l·r| + ε)² ≥ wanted (‖a_l‖² − ε), with a_k taken out of a_l.
    #[inline(always)]
    fn test(&self, gram: f64, shared: f64, overlap: f64, square: f64) -> f64 {
        let product = gram - self.shared * shared;
        let overlap = (overlap - product * self.along).abs() + self.overlap_error;
        let square = square - product * product * self.inverse - self.error;
        overlap * overlap - self.wanted * square
    }
}

impl Pairs {
    fn row(&self, k: usize, cutoff: f64) -> Row {
        let inverse = 1.0 / self.square[k].max(self.error.gram).max(f64::MIN_POSITIVE);
        let along = self.overlap[k] * inverse;
        let growth = 2.0 + 2.0 * inverse;
        let rss_error = self.error.rss + (2.0 * self.error.overlap + along.abs() * self.error.gram) * along.abs();
        Row {
            shared: self.shared[k],
            inverse,
            along,
            wanted: (self.rss - self.overlap[k] * along - rss_error - cutoff).max(0.0),
            error: self.error.gram * growth,
            overlap_error: (self.error.overlap + self.error.gram * self.rss.sqrt()) * growth,
        }
    }

    /// Puts into `hits` the pairs of `columns` (ascending) whose squared residual may be `cutoff` or less; no pair that
    /// is that good is missed. `gram` is (columns, columns). Returns the number of pairs looked at.
    pub(super) fn scan(&self, gram: &[f64], columns: &[usize], cutoff: f64, hits: &mut Vec<(usize, usize)>) -> u64 {
        let n = self.square.len();
        // A few scattered columns are looked at one by one, most of them as whole rows.
        if columns.len() * LANES < n {
            for (at, &k) in columns.iter().enumerate() {
                let row = self.row(k, cutoff);
                for &l in &columns[at + 1..] {
                    let test = row.test(gram[k * n + l], self.shared[l], self.overlap[l], self.square[l]);
                    if test >= 0.0 {
                        hits.push((k, l));
                    }
                }
            }
            return (columns.len() * columns.len() / 2) as u64;
        }
        let last = columns.last().map_or(0, |l| l + 1);
        vectorized(
            #[inline(always)]
            || {
                for &k in columns {
                    self.scan_row(gram, k, last, cutoff, hits);
                }
            },
        );
        columns.iter().map(|k| (last - k) as u64).sum()
    }

    #[inline(always)]
    fn scan_row(&self, gram: &[f64], k: usize, last: usize, cutoff: f64, hits: &mut Vec<(usize, usize)>) {
        let n = self.square.len();
        let row = self.row(k, cutoff);
        let gram = &gram[k * n..k * n + last];
        let (shared, overlap, square) = (&self.shared[..last], &self.overlap[..last], &self.square[..last]);
        let mut best = [f64::NEG_INFINITY; LANES];
        let mut from = k + 1;
        while from + LANES <= last {
            let range = from..from + LANES;
            let (g, s) = (&gram[range.clone()], &shared[range.clone()]);
            let (o, q) = (&overlap[range.clone()], &square[range]);
            for i in 0..LANES {
                let test = row.test(g[i], s[i], o[i], q[i]);
                best[i] = if test > best[i] { test } else { best[i] };
            }
            // The last lanes overlap those before, if need be.
            let rest = last - from - LANES;
            from += if rest == 0 { LANES } else { LANES.min(rest) };
        }
        let hit = best.iter().any(|b| *b >= 0.0);
        let from = if hit || last < k + 1 + LANES { k + 1 } else { last };
        for l in from..last {
            if row.test(gram[l], shared[l], overlap[l], square[l]) >= 0.0 {
                hits.push((k, l));
            }
        }
    }
}
