//! Gauss–Newton over coefficients and all states together.

use ndarray::Array2;

use super::eliminate::Elimination;
use super::flow::Flow;
use super::work::Work;
use crate::Triangle;
use crate::data::Segment;

/// A fit of one structure to all trajectories.
#[derive(Debug, Clone)]
pub(crate) struct Fit {
    /// Coefficients, as [`Flow`] numbers them.
    pub(crate) xi: Vec<f64>,
    /// Their standard errors; infinite where the data do not determine them.
    pub(crate) errors: Vec<f64>,
    /// Per segment: the states that follow the equations, at the samples (T + 1, n).
    pub(crate) x: Vec<Array2<f64>>,
    /// RMS of x measured − x, per state (n), freedom taken into account.
    pub(crate) left: Vec<f64>,
    /// The same within the bounds of the noise: what the samples are weighted by.
    pub(crate) sigma: Vec<f64>,
    /// RMS over the samples of the sum of x⁺ − F(x; ξ) up to there, per state (n): next to nothing, unless the iterations ended before the states
    /// followed the equations.
    pub(crate) drift: Vec<f64>,
    /// The factor of all rows over the coefficients, whitened.
    pub(crate) triangle: Triangle,
}

/// Parts of σ by which a state may miss its equation in one step, from the first iterations to the last: with the first the
/// states follow the data, with the last the equations.
pub(crate) const PARTS: [f64; 4] = [1.0, 0.1, 1e-2, 1e-3];

/// Iterations at each part but the last, and at the last.
const ITERATIONS: (usize, usize) = (3, 12);

/// Steps tried along one direction, each half as long as the one before.
const HALVINGS: i32 = 5;

/// Dampings tried after these, as parts of the squared lengths of the columns.
const DAMPINGS: [f64; 3] = [1e-4, 1e-2, 1.0];

/// Relative gain in the sum of squares below which iterations end.
const ENOUGH: f64 = 1e-7;

/// Factor by which the noise of one channel may differ from what it should be beside that of the others.
const APART: f64 = 10.0;

/// Samples after which what they tell is put together, and it is asked again whether to go on.
const ASKED: usize = 200;

/// What is known of the noise before.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bounds<'a> {
    /// Smallest standard deviation of each state that is believed (n).
    pub(crate) floor: &'a [f64],
    /// Standard deviations by the smoothness of the signals (n): their ratios are believed within a factor of [`APART`].
    pub(crate) shape: &'a [f64],
}

/// Fits the coefficients of `flow` to `segments`, from `xi` and states `x` (T + 1, n each) near the data; `sigma` (n) is a guess
/// of the noise, which is estimated anew, within the bounds `noise`. `parts` are the numbers of the [`PARTS`] gone through; `work` tells what
/// it cost. `None` if the equations cannot follow the data, or `go_on` says no.
///
/// Minimises Σ ((x measured − x)/σ)² + Σ ((x⁺ − F(x; ξ))/q)² over ξ and all x, where q is a small part of σ: the equations are
/// followed through each whole trajectory, and yet every sample is a node from which they are linearised.
///
/// # References
/// Bock (1983), multiple shooting for parameter estimation; continuity by a square-root information filter.
pub(crate) fn fit(
    flow: &Flow,
    segments: &[Segment],
    start: (&[f64], &[Array2<f64>]),
    sigma: &[f64],
    noise: Bounds<'_>,
    parts: std::ops::Range<usize>,
    (work, go_on): (&Work, &dyn Fn() -> bool),
) -> Option<Fit> {
    let mut state = State { xi: start.0.to_vec(), x: start.1.to_vec(), sigma: sigma.to_vec(), left: sigma.to_vec() };
    let last = parts.end.min(PARTS.len()).saturating_sub(1);
    for (stage, part) in PARTS.iter().enumerate().take(last + 1).skip(parts.start) {
        let iterations = if stage == last { ITERATIONS.1 } else { ITERATIONS.0 };
        state.iterate(flow, segments, (*part, iterations), (work, go_on))?;
        state.update_noise(flow, segments, noise);
    }
    // With the noise that was found at last.
    let triangle = state.iterate(flow, segments, (PARTS[last], 3), (work, go_on))?;
    state.update_noise(flow, segments, noise);
    let drift = state.drift(flow, segments);
    let all: Vec<usize> = (0..flow.n_parameters()).collect();
    let errors = triangle.spread(&all);
    Some(Fit { xi: state.xi, errors, x: state.x, left: state.left, sigma: state.sigma, drift, triangle })
}

/// What `segments` tell of changes of the coefficients of `flow`, linearised at `xi` and the states `x` that follow the equations but for
/// the number `part` of the [`PARTS`]: the factor of the whitened rows over them and what they leave. `None` if a step is not finite.
pub(crate) fn linearised(
    flow: &Flow,
    segments: &[Segment],
    (xi, x): (&[f64], &[Array2<f64>]),
    sigma: &[f64],
    part: usize,
    (work, go_on): (&Work, &dyn Fn() -> bool),
) -> Option<Triangle> {
    work.elimination(flow, segments);
    let state = State { xi: xi.to_vec(), x: x.to_vec(), sigma: sigma.to_vec(), left: Vec::new() };
    Some(state.eliminated(flow, segments, (PARTS[part], false), go_on, None)?.0)
}

/// What every sample after the first ones adds to those before it, if `flow` has the coefficients `xi`: the prediction errors of its states, in units of their standard
/// deviations (·, n), per segment. Where the equations are the true ones they are independent, unlike what a fit leaves of short segments.
/// `None` if a step is not finite, or `go_on` says no.
pub(crate) fn innovations(
    flow: &Flow,
    segments: &[Segment],
    (xi, x): (&[f64], &[Array2<f64>]),
    sigma: &[f64],
    part: usize,
    (work, go_on): (&Work, &dyn Fn() -> bool),
) -> Option<Vec<Array2<f64>>> {
    work.elimination(flow, segments);
    let state = State { xi: xi.to_vec(), x: x.to_vec(), sigma: sigma.to_vec(), left: Vec::new() };
    let mut all = vec![Vec::new(); segments.len()];
    state.eliminated(
        flow,
        segments,
        (PARTS[part], false),
        go_on,
        Some(&mut |segment, innovations| all[segment].extend(innovations)),
    )?;
    let n = sigma.len();
    let rows = |values: Vec<f64>| Array2::from_shape_vec((values.len() / n, n), values).expect("rows are pushed whole");
    Some(all.into_iter().map(rows).collect())
}

/// The step of the coefficients that the factor tells, damped in units of their columns, and that of the states with it.
///
/// # References
/// Marquardt (1963), SIAM J. Appl. Math. 11(2).
fn direction(factor: &Triangle, eliminations: &[Elimination], damping: f64) -> Option<(Vec<f64>, Vec<Array2<f64>>)> {
    let p = factor.n_columns() - 1;
    let all: Vec<usize> = (0..p).collect();
    let length = |j: usize| factor.norm(j).max(f64::MIN_POSITIVE);
    let scaled = factor.solve_scaled(&all, p, damping, length);
    let delta: Vec<f64> = scaled.iter().enumerate().map(|(j, d)| d / length(j)).collect();
    let states = eliminations.iter().map(|e| e.states(&delta)).collect::<Option<Vec<_>>>()?;
    delta.iter().all(|d| d.is_finite()).then_some((delta, states))
}

struct State {
    xi: Vec<f64>,
    x: Vec<Array2<f64>>,
    sigma: Vec<f64>,
    left: Vec<f64>,
}

impl State {
    /// The sum of squares; infinite where a step is not finite.
    fn cost(&self, flow: &Flow, segments: &[Segment], part: f64) -> f64 {
        let mut total = 0.0;
        for (segment, x) in segments.iter().zip(&self.x) {
            for t in 0..x.nrows() {
                for (i, sigma) in self.sigma.iter().enumerate() {
                    total += ((segment.x[[t, i]] - x[[t, i]]) / (sigma * segment.relative(t, i))).powi(2);
                }
            }
        }
        let finite = self.defects(flow, segments, &mut |_, d| {
            total += d.iter().zip(&self.sigma).map(|(d, sigma)| (d / (part * sigma)).powi(2)).sum::<f64>();
        });
        if finite && !total.is_nan() { total } else { f64::INFINITY }
    }

    /// Visits x⁺ − F(x; ξ) of every step, with the number of the step in its segment; `false` if a step is not finite.
    fn defects(&self, flow: &Flow, segments: &[Segment], visit: &mut dyn FnMut(usize, &[f64])) -> bool {
        let mut scratch = flow.scratch();
        let mut next = vec![0.0; self.sigma.len()];
        for (segment, x) in segments.iter().zip(&self.x) {
            for t in 0..segment.len() {
                let (now, u) = (x.row(t).to_vec(), segment.u.row(t).to_vec());
                if !flow.step((&now, &u, segment.dt[t]), &self.xi, &mut next, None, &mut scratch, &mut |_| {}) {
                    return false;
                }
                next.iter_mut().zip(x.row(t + 1)).for_each(|(next, x)| *next = x - *next);
                visit(t, &next);
            }
        }
        true
    }

    fn drift(&self, flow: &Flow, segments: &[Segment]) -> Vec<f64> {
        let n = self.sigma.len();
        let (mut sum, mut squares, mut steps) = (vec![0.0; n], vec![0.0; n], 0.0);
        self.defects(flow, segments, &mut |t, d| {
            if t == 0 {
                sum.fill(0.0);
            }
            steps += 1.0;
            for i in 0..n {
                sum[i] += d[i];
                squares[i] += sum[i] * sum[i];
            }
        });
        squares.iter().map(|s: &f64| (s / f64::max(steps, 1.0)).sqrt()).collect()
    }

    /// Gauss–Newton steps, each halved until it gains. The factor over the coefficients of the last one.
    fn iterate(
        &mut self,
        flow: &Flow,
        segments: &[Segment],
        (part, iterations): (f64, usize),
        (work, go_on): (&Work, &dyn Fn() -> bool),
    ) -> Option<Triangle> {
        work.steps(flow, segments);
        let mut cost = self.cost(flow, segments, part);
        let mut triangle = None;
        if !cost.is_finite() {
            return None;
        }
        for _ in 0..iterations {
            work.elimination(flow, segments);
            let (factor, eliminations) = self.eliminated(flow, segments, (part, true), go_on, None)?;
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
                let trial = Self { xi, x, sigma: self.sigma.clone(), left: Vec::new() };
                work.steps(flow, segments);
                let gained = trial.cost(flow, segments, part);
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
    fn eliminated(
        &self,
        flow: &Flow,
        segments: &[Segment],
        (part, with_states): (f64, bool),
        go_on: &dyn Fn() -> bool,
        mut visit: Option<&mut dyn FnMut(usize, Vec<f64>)>,
    ) -> Option<(Triangle, Vec<Elimination>)> {
        let (n, p) = (self.sigma.len(), flow.n_parameters());
        let rough = flow.for_derivatives();
        let mut scratch = flow.scratch();
        let mut triangle = Triangle::new(p + 1);
        let q: Vec<f64> = self.sigma.iter().map(|s| part * s).collect();
        let (mut next, mut s) = (vec![0.0; n], vec![0.0; n * (n + p)]);
        let mut eliminations = Vec::with_capacity(segments.len());
        for (number, (segment, x)) in segments.iter().zip(&self.x).enumerate() {
            let mut elimination = Elimination::new(n, p, with_states);
            for t in 0..=segment.len() {
                if t.is_multiple_of(ASKED) {
                    triangle.push(elimination.rows().view()).ok()?;
                    if !go_on() {
                        return None;
                    }
                }
                let y: Vec<f64> = (0..n).map(|i| segment.x[[t, i]] - x[[t, i]]).collect();
                let sigma: Vec<f64> = (0..n).map(|i| self.sigma[i] * segment.relative(t, i)).collect();
                if let Some(visit) = &mut visit {
                    elimination.innovations(&y, &sigma).into_iter().for_each(|innovations| visit(number, innovations));
                }
                if t == segment.len() {
                    elimination.finish(&y, &sigma);
                    break;
                }
                let (now, u) = (x.row(t).to_vec(), segment.u.row(t).to_vec());
                let step = (&now[..], &u[..], segment.dt[t]);
                if !rough.step(step, &self.xi, &mut next, Some(&mut s), &mut scratch, &mut |_| {})
                    || !flow.step(step, &self.xi, &mut next, None, &mut scratch, &mut |_| {})
                {
                    return None;
                }
                let d: Vec<f64> = (0..n).map(|i| next[i] - x[[t + 1, i]]).collect();
                elimination.step(&y, &sigma, &s, &d, &q);
            }
            triangle.push(elimination.rows().view()).ok()?;
            eliminations.push(elimination);
        }
        Some((triangle, eliminations))
    }

    /// σ from what is left, freedom taken into account.
    fn update_noise(&mut self, flow: &Flow, segments: &[Segment], noise: Bounds<'_>) {
        let n = self.sigma.len();
        let samples: usize = segments.iter().map(|s| s.len() + 1).sum();
        let fitted = flow.n_parameters() + segments.len() * n;
        let freedom = (1.0 - fitted as f64 / (samples * n) as f64).max(0.1);
        for i in 0..n {
            let left = |(s, x): (&Segment, &Array2<f64>)| -> f64 {
                (0..x.nrows()).map(|t| ((s.x[[t, i]] - x[[t, i]]) / s.relative(t, i)).powi(2)).sum()
            };
            let squares: f64 = segments.iter().zip(&self.x).map(left).sum();
            self.sigma[i] = (squares / (samples as f64 * freedom)).sqrt().max(noise.floor[i]);
        }
        self.left.clone_from(&self.sigma);
        // Of one channel a model can follow every sample at the cost of others: its likelihood then has no bound.
        let ratio = |i: usize| (self.sigma[i] / noise.shape[i]).ln();
        let common = (0..n).map(ratio).sum::<f64>() / n.max(1) as f64;
        for i in 0..n {
            let (low, high) = (common.exp() * noise.shape[i] / APART, common.exp() * noise.shape[i] * APART);
            self.sigma[i] = self.sigma[i].max(low).min(high).max(noise.floor[i]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expr::parse;
    use crate::library::Term;
    use crate::motion::Stepping;
    use rand::RngExt as _;
    use sindyna_core::Seed;

    fn normal(rng: &mut sindyna_core::Rng) -> f64 {
        (0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0
    }

    /// ẋ = v, v̇ = −9 x − 0.3 v + u with noise.
    fn oscillator(seed: u64, samples: usize, dt: f64, noise: [f64; 2]) -> (Flow, Segment) {
        let names: Vec<String> = ["x", "v", "u"].map(String::from).into();
        let term = |text: &str| Term {
            expr: parse(text, &names).expect("a term"),
            name: text.into(),
            complexity: 0,
            rate: None,
            shape: None,
        };
        let terms = ["x", "v", "u"].map(term);
        let stepping = Stepping::Continuous { substeps: 2 };
        let flow = Flow::new(&terms, (&[vec![], vec![0, 1, 2]], &[], &[]), &[Some(1), None], 1, stepping);
        let mut rng = Seed::new(seed).stream("noise", 0);
        let (mut x, mut scratch) = (vec![1.0, 0.0], flow.scratch());
        let mut segment = Segment {
            x: Array2::zeros((samples, 2)),
            u: Array2::zeros((samples - 1, 1)),
            dt: vec![dt; samples - 1],
            relative: None,
        };
        for t in 0..samples {
            (0..2).for_each(|i| segment.x[[t, i]] = x[i] + noise[i] * normal(&mut rng));
            if t + 1 < samples {
                segment.u[[t, 0]] = 4.0 * rng.random::<f64>() - 2.0;
                let u = segment.u.row(t).to_vec();
                let mut next = vec![0.0; 2];
                flow.step((&x, &u, dt), &[-9.0, -0.3, 1.0], &mut next, None, &mut scratch, &mut |_| {});
                x = next;
            }
        }
        (flow, segment)
    }

    #[test]
    fn coefficients_are_as_accurate_as_the_whole_log_allows_and_the_errors_say_so() {
        // Standard deviations attainable with one start, from the exact Fisher information: 200 samples of 0.05 s.
        let noise = [0.01, 0.03];
        let truth = [-9.0, -0.3, 1.0];
        let (mut squares, mut within, mut reported) = ([0.0; 3], 0, [0.0; 3]);
        let seeds = 60;
        for seed in 0..seeds {
            let (flow, segment) = oscillator(seed, 200, 0.05, noise);
            let x = [segment.x.clone()];
            let found = fit(
                &flow,
                &[segment],
                (&[-8.0, 0.0, 0.5], &x),
                &[0.1, 0.1],
                Bounds { floor: &[1e-9; 2], shape: &[0.01, 0.03] },
                0..4,
                (&Work::default(), &|| true),
            )
            .expect("a fit");
            for i in 0..3 {
                let z = (found.xi[i] - truth[i]) / found.errors[i];
                squares[i] += z * z;
                within += usize::from(z.abs() < 1.96);
                reported[i] += found.errors[i];
            }
            assert!((found.sigma[0] / noise[0] - 1.0).abs() < 0.25, "{:?}", found.sigma);
        }
        let covered = within as f64 / (3 * seeds) as f64;
        assert!((0.9..=0.99).contains(&covered), "{covered}");
        for (i, sum) in squares.iter().enumerate() {
            let z = (sum / seeds as f64).sqrt();
            assert!((0.8..1.25).contains(&z), "{i}: {z}");
        }
        // With free pieces of twenty steps the first would be 8e-3.
        assert!(reported[0] / (seeds as f64) < 4e-3, "{reported:?}");
    }
}
