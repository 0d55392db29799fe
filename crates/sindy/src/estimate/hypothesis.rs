//! One hypothesis and its score.

use ndarray::Array2;

use super::search::Problem;
use crate::Stage;
use crate::motion::Stepping;
use crate::shooting::{self, Bounds, Fit, Flow, PARTS};
use crate::solve::binomial;

/// Terms of every equation, a way of stepping, and what fits them best.
#[derive(Debug, Clone)]
pub(super) struct Hypothesis {
    /// Terms of each state's equation, ascending; none for states with declared rates.
    pub(super) supports: Vec<Vec<usize>>,
    pub(super) flow: Flow,
    pub(super) fit: Fit,
    /// Smaller is better.
    pub(super) score: f64,
    /// Whether what is left is no more than the finest Runge–Kutta steps are wrong.
    pub(super) numerical: bool,
    /// Number of the [`PARTS`] with which it was fitted last.
    pub(super) part: usize,
}

/// Part of the noise by which one step may be wrong numerically.
const TRUNCATION: f64 = 3e-3;

/// Runge–Kutta steps per sampling interval, at most; and while states follow the data.
const FINEST: usize = 32;
const LOOSE: usize = 4;

/// Classical substeps of a model per sampling interval, at most.
const FINEST_CLASSICAL: usize = 64;

/// Part of what the signals tell of noise, below which residuals are no noise.
const BELOW: f64 = 0.1;

/// Steps by which the error of Runge–Kutta steps is judged.
const LOOKED_AT: usize = 200;

/// Operations of all fits together: some seconds.
pub(super) const BUDGET: u64 = 1_200_000_000;

/// Passes over the data that a fit takes.
const ITERATIONS: u64 = 40;

impl Problem<'_> {
    /// The hypothesis that equations have the terms `supports`, fitted from coefficients `xi` and states `x`. `None` if such equations
    /// cannot follow the data.
    pub(super) fn hypothesis(
        &self,
        supports: Vec<Vec<usize>>,
        stepping: Stepping,
        (xi, x, sigma): (&[f64], &[Array2<f64>], &[f64]),
        parts: std::ops::Range<usize>,
    ) -> Option<Hypothesis> {
        let flow = Flow::new(self.terms, (&supports, &self.given()), self.rates, self.n_controls, stepping);
        // States that are free to follow the data need no digit of the equations.
        let finest = if parts.end < PARTS.len() { LOOSE } else { FINEST };
        let mut flow = self.accurate(flow, (stepping, finest), xi, x, sigma);
        let mut fit = self.spend(&flow).then(|| self.fit(&flow, (xi, x), sigma, parts.clone()))??;
        loop {
            // What is left may be less than was thought, and the steps then too coarse for it.
            let finer = self.accurate(flow.clone(), (flow.stepping(), finest), &fit.xi, &fit.x, &fit.sigma);
            if finer.stepping() == flow.stepping() || !self.spend(&finer) {
                break;
            }
            let from = (&fit.xi[..], &fit.x[..]);
            let Some(better) = self.fit(&finer, from, &fit.sigma, parts.clone()) else { break };
            (flow, fit) = (finer, better);
        }
        if !flow.is_regular(self.segments, &fit.x, &fit.xi) {
            return None;
        }
        let mut rest = &fit.xi[..];
        for (support, constraints) in supports.iter().zip(self.constraints) {
            let (own, later) = rest.split_at(support.len());
            if !constraints.agrees(support, own) {
                return None;
            }
            rest = later;
        }
        // Bounds on the noise keep a residual from counting for less than it is told, not for less than it is.
        let seen: Vec<f64> = fit.left.iter().zip(&fit.sigma).map(|(left, sigma)| left.max(*sigma)).collect();
        // Contributions are of the size of the rates, or seldom larger: a Cauchy distribution. Terms that cancel are worth it only
        // where the data tell them so.
        let contributions = flow.contributions(self.segments, &fit.x, &fit.xi);
        let prior: f64 = contributions.iter().map(|c| 2.0 * (c * c).ln_1p()).sum();
        let score = self.score(&supports, &seen) + prior;
        let numerical = finest == FINEST && self.is_numerical(&flow, &fit);
        let part = parts.end.min(PARTS.len()).saturating_sub(1);
        score.is_finite().then_some(Hypothesis { supports, flow, fit, score, numerical, part })
    }

    fn fit(
        &self,
        flow: &Flow,
        from: (&[f64], &[Array2<f64>]),
        sigma: &[f64],
        parts: std::ops::Range<usize>,
    ) -> Option<Fit> {
        let noise = Bounds { floor: self.floor, shape: self.noise };
        shooting::fit(flow, self.segments, from, sigma, noise, parts, self.watch.asks())
    }

    /// Takes what a fit of `flow` costs from the budget; `false` if there is not as much left.
    fn spend(&self, flow: &Flow) -> bool {
        let (samples, n, p) = (self.samples() as u64, self.rates.len() as u64, flow.n_parameters() as u64);
        let substeps = match flow.stepping() {
            Stepping::Continuous { substeps } => substeps as u64,
            _ => 1,
        };
        let operations = ITERATIONS * samples * ((n + p) * (n + p) + substeps * (n + p));
        let spent = self.spent.get() + operations;
        self.spent.set(spent);
        self.watch.tell(Stage::Search { spent: (spent as f64 / BUDGET as f64).min(1.0) });
        spent <= BUDGET && self.watch.go_on()
    }

    /// `flow` with as many Runge–Kutta steps as the noise makes worth while.
    fn accurate(
        &self,
        flow: Flow,
        (stepping, finest): (Stepping, usize),
        xi: &[f64],
        x: &[Array2<f64>],
        sigma: &[f64],
    ) -> Flow {
        let Stepping::Continuous { substeps: first } = stepping else { return flow };
        let of = |substeps: usize| flow.with_stepping(Stepping::Continuous { substeps });
        let mut substeps = first;
        while substeps < finest {
            let (coarse, fine) = (of(substeps), of(2 * substeps));
            if self.difference(&coarse, &fine, xi, x, sigma) < TRUNCATION * 16.0 / 15.0 {
                break;
            }
            substeps *= 2;
        }
        of(substeps)
    }

    /// The way `hypothesis` is stepped by classical substeps, as many as the noise makes worth while.
    pub(super) fn classical(&self, hypothesis: &Hypothesis) -> Stepping {
        let (flow, fit) = (&hypothesis.flow, &hypothesis.fit);
        let Stepping::Continuous { substeps: first } = flow.stepping() else { return flow.stepping() };
        let of = |substeps: usize| flow.classical().with_stepping(Stepping::Continuous { substeps });
        let mut substeps = first;
        while substeps < FINEST_CLASSICAL
            && self.difference(&of(substeps), flow, &fit.xi, &fit.x, &fit.sigma) > TRUNCATION
        {
            substeps *= 2;
        }
        Stepping::Continuous { substeps }
    }

    /// Whether the errors of the finest Runge–Kutta steps add up to the residuals along a segment.
    fn is_numerical(&self, flow: &Flow, fit: &Fit) -> bool {
        let finer = flow.with_stepping(Stepping::Continuous { substeps: 2 * FINEST });
        let length = self.samples() / self.segments.len().max(1) as f64;
        // Of samples with noise the steps are no limit, whatever equations make of them.
        let below = |(left, noise): (&f64, &f64)| *left < BELOW * noise;
        flow.stepping() == Stepping::Continuous { substeps: FINEST }
            && fit.left.iter().zip(self.noise).all(below)
            && self.difference(flow, &finer, &fit.xi, &fit.x, &fit.sigma) * length > 1.0
    }

    /// RMS difference of the steps of two flows, in standard deviations of the noise.
    fn difference(&self, a: &Flow, b: &Flow, xi: &[f64], x: &[Array2<f64>], sigma: &[f64]) -> f64 {
        let n = sigma.len();
        let (mut left, mut right) = (vec![0.0; n], vec![0.0; n]);
        let (mut scratch_a, mut scratch_b) = (a.scratch(), b.scratch());
        let (mut sum, mut count) = (0.0, 0.0);
        let every = (self.samples() as usize).div_ceil(LOOKED_AT);
        for (segment, x) in self.segments.iter().zip(x) {
            for t in (0..segment.len()).step_by(every) {
                let (now, u) = (x.row(t).to_vec(), segment.u.row(t).to_vec());
                let step = (&now[..], &u[..], segment.dt[t]);
                let finite = a.step(step, xi, &mut left, None, &mut scratch_a, &mut |_| {})
                    && b.step(step, xi, &mut right, None, &mut scratch_b, &mut |_| {});
                if finite {
                    sum += (0..n).map(|i| ((left[i] - right[i]) / sigma[i]).powi(2)).sum::<f64>();
                    count += n as f64;
                }
            }
        }
        (sum / f64::max(count, 1.0)).sqrt()
    }

    /// −2 ln L + Σ ln N + 2 ln C(F, k) + complexity: the extended BIC of the prediction error, with the noise of each channel at its
    /// likeliest.
    ///
    /// # References
    /// Chen, Chen (2008), Biometrika 95(3), with γ = 1.
    pub(super) fn score(&self, supports: &[Vec<usize>], sigma: &[f64]) -> f64 {
        let samples = self.samples();
        let likelihood: f64 = sigma.iter().map(|s| 2.0 * samples * s.ln()).sum();
        likelihood + supports.iter().map(|support| self.penalty(support)).sum::<f64>()
    }

    /// What the terms of one equation cost.
    pub(super) fn penalty(&self, support: &[usize]) -> f64 {
        let complexity: f64 = support.iter().map(|&j| f64::from(self.terms[j].complexity)).sum();
        support.len() as f64 * self.samples().ln() + 2.0 * binomial(self.terms.len(), support.len()).ln() + complexity
    }

    pub(super) fn samples(&self) -> f64 {
        self.segments.iter().map(|s| s.x.nrows() as f64).sum()
    }
}
