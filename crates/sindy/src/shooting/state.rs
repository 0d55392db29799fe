//! Coefficients and all states together: their sum of squares, and Gauss–Newton steps that make it smaller.

use ndarray::Array2;

use super::eliminate::Elimination;
use super::flow::Flow;
use super::passes::Samples;
use super::slack::slack;
use super::work::Work;
use crate::Triangle;
use crate::data::{Segment, measures};

/// Steps tried along one direction, each half as long as the one before.
const HALVINGS: i32 = 5;

/// Dampings tried after these, as parts of the squared lengths of the columns.
const DAMPINGS: [f64; 3] = [1e-4, 1e-2, 1.0];

/// Relative gain in the sum of squares below which iterations end.
const ENOUGH: f64 = 1e-7;

/// Factor by which the noise of one channel may differ from what it should be beside that of the others.
const APART: f64 = 10.0;

/// Samples after which what they tell is put together, and it is asked again whether to go on.
pub(super) const ASKED: usize = 200;

/// The step of the coefficients that the factor tells, damped in units of their columns, and that of the states with it.
///
/// # References
/// Marquardt (1963), SIAM J. Appl. Math. 11(2).
pub(super) fn direction(
    factor: &Triangle,
    eliminations: &[Elimination],
    damping: f64,
) -> Option<(Vec<f64>, Vec<Array2<f64>>)> {
    let p = factor.n_columns() - 1;
    let all: Vec<usize> = (0..p).collect();
    let length = |j: usize| factor.norm(j).max(f64::MIN_POSITIVE);
    let scaled = factor.solve_scaled(&all, p, damping, length);
    let delta: Vec<f64> = scaled.iter().enumerate().map(|(j, d)| d / length(j)).collect();
    let states = eliminations.iter().map(|e| e.states(&delta)).collect::<Option<Vec<_>>>()?;
    delta.iter().all(|d| d.is_finite()).then_some((delta, states))
}

/// What is known of the noise before.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bounds<'a> {
    /// Smallest standard deviation of each state that is believed (n).
    pub(crate) floor: &'a [f64],
    /// Standard deviations by the smoothness of the signals (n): their ratios are believed within a factor of [`APART`].
    pub(crate) shape: &'a [f64],
}

/// Coefficients and states, and the noise by which they are judged.
pub(super) struct State {
    pub(super) xi: Vec<f64>,
    pub(super) x: Vec<Array2<f64>>,
    /// What samples are weighted by (n).
    pub(super) sigma: Vec<f64>,
    /// RMS of what is left of each state, freedom taken into account (n).
    pub(super) left: Vec<f64>,
    /// ln √det of the information about all states, at the last step of the iterations.
    volume: f64,
    /// Per segment: x⁺ − F(x; ξ) of every step (T, n), once [`Self::miss`] was asked.
    pub(super) missed: Vec<Array2<f64>>,
}

impl State {
    pub(super) fn new(xi: Vec<f64>, x: Vec<Array2<f64>>, sigma: Vec<f64>) -> Self {
        Self { xi, x, left: sigma.clone(), sigma, volume: 0.0, missed: Vec::new() }
    }

    /// Finds by how much the states miss their equations; `false` if a step is not finite.
    pub(super) fn miss(&mut self, flow: &Flow, segments: &[Segment], work: &Work) -> bool {
        work.steps(flow, segments);
        let Self { xi, x, missed, .. } = self;
        missed.clear();
        segments.iter().zip(x).all(|(segment, x)| {
            let mut of_segment = Array2::zeros((segment.len(), x.ncols()));
            let finite = flow.each_step(Samples { segment, x, every: 1 }, xi, false, &mut |made| {
                let next = made.next.iter().zip(x.row(made.t + 1));
                of_segment.row_mut(made.t).iter_mut().zip(next).for_each(|(slot, (next, x))| *slot = x - next);
                made.finite
            });
            missed.push(of_segment);
            finite
        })
    }

    /// The sum of squares; infinite where a step is not finite.
    fn cost(&mut self, flow: &Flow, segments: &[Segment], part: f64, work: &Work) -> f64 {
        if !self.miss(flow, segments, work) {
            return f64::INFINITY;
        }
        let mut total = 0.0;
        for ((segment, x), missed) in segments.iter().zip(&self.x).zip(&self.missed) {
            for t in 0..x.nrows() {
                for (i, sigma) in self.sigma.iter().enumerate() {
                    total += ((segment.x[[t, i]] - x[[t, i]]) / (sigma * segment.relative(t, i))).powi(2);
                }
            }
            let q = slack(flow, segment, &self.sigma, part);
            for d in missed.rows() {
                total += d.iter().zip(&q).map(|(d, q)| (d / q).powi(2)).sum::<f64>();
            }
        }
        if total.is_nan() { f64::INFINITY } else { total }
    }

    /// RMS over the samples of the sum of x⁺ − F(x; ξ) up to there, per state (n).
    pub(super) fn drift(&self) -> Vec<f64> {
        let n = self.sigma.len();
        let (mut squares, mut steps) = (vec![0.0; n], 0.0);
        for missed in &self.missed {
            let mut sum = vec![0.0; n];
            for d in missed.rows() {
                steps += 1.0;
                for i in 0..n {
                    sum[i] += d[i];
                    squares[i] += sum[i] * sum[i];
                }
            }
        }
        squares.iter().map(|s: &f64| (s / f64::max(steps, 1.0)).sqrt()).collect()
    }

    /// −2 ln of the share of all states that the data leave, beyond what they would leave of states that nothing drives: 2 ln det ∂x_T/∂x₀ along the
    /// directions that grow. None of it where they shrink. Its states were found with `part` of the noise in every step.
    ///
    /// Where errors grow as e^(λ t), a start must be known e^(λ T) times as well as the state at T. A likelihood that integrates over the states pays for that; one at the
    /// likeliest states does not, and a state that runs away, told by what comes after it, would explain anything.
    ///
    /// # References
    /// MacKay (1992), Neural Computation 4(3): the Occam factor, of states instead of parameters.
    pub(super) fn expansion(&self, flow: &Flow, segments: &[Segment], part: f64) -> f64 {
        let n = self.sigma.len();
        let still = vec![0.0; n];
        let mut slopes = vec![0.0; n * n];
        (0..n).for_each(|i| slopes[i * n + i] = 1.0);
        let of_segment = |segment: &Segment| {
            let mut elimination = Elimination::new(n, 0, false);
            let q = slack(flow, segment, &self.sigma, part);
            let sigma = |t: usize| (0..n).map(|i| self.sigma[i] * segment.relative(t, i)).collect::<Vec<f64>>();
            for (t, dt) in segment.dt.iter().enumerate() {
                for (i, v) in flow.rates.iter().enumerate().filter_map(|(i, v)| Some((i, (*v)?))) {
                    slopes[i * n + v] = *dt;
                }
                elimination.step(&still, &sigma(t), &slopes, &still, &q);
            }
            elimination.finish(&still, &sigma(segment.len()));
            elimination.volume()
        };
        (2.0 * (self.volume - segments.iter().map(of_segment).sum::<f64>())).max(0.0)
    }

    /// Gauss–Newton steps, each halved until it gains. The factor over the coefficients of the last one.
    pub(super) fn iterate(
        &mut self,
        flow: &Flow,
        segments: &[Segment],
        (part, iterations): (f64, usize),
        (work, go_on): (&Work, &dyn Fn() -> bool),
    ) -> Option<Triangle> {
        let mut cost = self.cost(flow, segments, part, work);
        let mut triangle = None;
        if !cost.is_finite() {
            return None;
        }
        for _ in 0..iterations {
            work.elimination(flow, segments);
            let (factor, eliminations) = self.eliminated(flow, segments, (part, true), go_on, None)?;
            self.volume = eliminations.iter().map(Elimination::volume).sum();
            let mut taken = None;
            // First the whole step and parts of it; then, of parameters inside terms, steps that ill-determined combinations take no part in.
            let whole = (0..HALVINGS).map(|halvings| (0.0, 0.5_f64.powi(halvings)));
            let mut step = direction(&factor, &eliminations, 0.0)?;
            let left = factor.residual_norm(&(0..step.0.len()).collect::<Vec<_>>(), &step.0, step.0.len()).powi(2);
            if cost - left < ENOUGH * cost {
                triangle = Some(factor);
                break;
            }
            for (damping, by) in
                whole.chain(DAMPINGS.map(|damping| (damping, 1.0)).into_iter().filter(|_| flow.is_curved()))
            {
                if damping > 0.0 {
                    step = direction(&factor, &eliminations, damping)?;
                }
                let (delta, moved) = &step;
                let xi = self.xi.iter().zip(delta).map(|(c, d)| c + by * d).collect();
                let x = self.x.iter().zip(moved).map(|(x, d)| x + &(d * by)).collect();
                let mut trial = Self { volume: self.volume, ..Self::new(xi, x, self.sigma.clone()) };
                let gained = trial.cost(flow, segments, part, work);
                if gained < cost {
                    taken = Some((trial, gained));
                    break;
                }
            }
            triangle = Some(factor);
            let Some((trial, gained)) = taken else { break };
            let enough = cost - gained < ENOUGH * cost;
            (*self, cost) = (trial, gained);
            if enough {
                break;
            }
        }
        triangle
    }

    /// The factor over changes of the coefficients and what is left, and per segment what tells the states, if these are wanted. `visit` is shown the
    /// innovations of every sample, with the number of its segment.
    pub(super) fn eliminated(
        &self,
        flow: &Flow,
        segments: &[Segment],
        (part, with_states): (f64, bool),
        go_on: &dyn Fn() -> bool,
        mut visit: Option<&mut dyn FnMut(usize, Vec<f64>)>,
    ) -> Option<(Triangle, Vec<Elimination>)> {
        let (n, p) = (self.sigma.len(), flow.n_parameters());
        let rough = flow.for_derivatives();
        let mut triangle = Triangle::new(p + 1);
        let mut eliminations = Vec::with_capacity(segments.len());
        for (number, ((segment, x), missed)) in segments.iter().zip(&self.x).zip(&self.missed).enumerate() {
            let mut elimination = Elimination::new(n, p, with_states);
            let q = slack(flow, segment, &self.sigma, part);
            let sample = |t: usize| -> (Vec<f64>, Vec<f64>) {
                let of = |i: usize| (segment.x[[t, i]] - x[[t, i]], self.sigma[i] * segment.relative(t, i));
                (0..n).map(of).unzip()
            };
            let mut seen = |elimination: &Elimination, y: &[f64], sigma: &[f64]| {
                if let Some(visit) = &mut visit {
                    elimination.innovations(y, sigma).into_iter().for_each(|innovations| visit(number, innovations));
                }
            };
            let whole = rough.each_step(Samples { segment, x, every: 1 }, &self.xi, true, &mut |made| {
                if made.t.is_multiple_of(ASKED) && (triangle.push(elimination.rows().view()).is_err() || !go_on()) {
                    return false;
                }
                let (y, sigma) = sample(made.t);
                seen(&elimination, &y, &sigma);
                let d: Vec<f64> = missed.row(made.t).iter().map(|d| -d).collect();
                elimination.step(&y, &sigma, made.s, &d, &q);
                made.finite
            });
            if !whole {
                return None;
            }
            let (y, sigma) = sample(segment.len());
            seen(&elimination, &y, &sigma);
            elimination.finish(&y, &sigma);
            triangle.push(elimination.rows().view()).ok()?;
            eliminations.push(elimination);
        }
        Some((triangle, eliminations))
    }

    /// σ from what is left, freedom taken into account.
    pub(super) fn update_noise(&mut self, flow: &Flow, segments: &[Segment], noise: Bounds<'_>) {
        let n = self.sigma.len();
        let samples: usize = segments.iter().map(|s| s.len() + 1).sum();
        let fitted = flow.n_parameters() + segments.len() * n;
        let measured: Vec<usize> = (0..n).filter(|&i| measures(segments, i)).collect();
        let freedom = (1.0 - fitted as f64 / (samples * measured.len()).max(1) as f64).max(0.1);
        for &i in &measured {
            let left = |(s, x): (&Segment, &Array2<f64>)| -> f64 {
                (0..x.nrows()).map(|t| ((s.x[[t, i]] - x[[t, i]]) / s.relative(t, i)).powi(2)).sum()
            };
            let squares: f64 = segments.iter().zip(&self.x).map(left).sum();
            self.sigma[i] = (squares / (samples as f64 * freedom)).sqrt().max(noise.floor[i]);
        }
        self.left.fill(0.0);
        measured.iter().for_each(|&i| self.left[i] = self.sigma[i]);
        // Of one channel a model can follow every sample at the cost of others: its likelihood then has no bound.
        let ratio = |i: usize| (self.sigma[i] / noise.shape[i]).ln();
        let common = measured.iter().map(|&i| ratio(i)).sum::<f64>() / measured.len().max(1) as f64;
        for i in 0..n {
            let (low, high) = (common.exp() * noise.shape[i] / APART, common.exp() * noise.shape[i] * APART);
            self.sigma[i] = self.sigma[i].max(low).min(high).max(noise.floor[i]);
        }
        // How closely a state that was not measured follows its equation.
        for i in (0..n).filter(|i| !measured.contains(i)) {
            self.sigma[i] = common.exp() * noise.shape[i];
        }
    }
}
