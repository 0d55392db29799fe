//! A structure fitted to all trajectories, and what these tell of it.

use ndarray::Array2;

use super::flow::Flow;
use super::inputs::{Told, inputs};
use super::slack::PARTS;
use super::state::{Bounds, State};
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
    /// How much better than a state that nothing drives the first ones must be known, −2 ln of that.
    pub(crate) expansion: f64,
    /// The factor of all rows over the coefficients, whitened.
    pub(crate) triangle: Triangle,
}

impl Fit {
    /// Takes the coefficients that are likeliest whatever the inputs were, and what is known of them then.
    pub(crate) fn take(&mut self, told: Told) {
        self.xi.iter_mut().zip(&told.change).for_each(|(xi, by)| *xi += by);
        self.errors = told.triangle.spread(&(0..self.xi.len()).collect::<Vec<_>>());
        self.triangle = told.triangle;
    }
}

/// Iterations at each part but the last, and at the last.
const ITERATIONS: (usize, usize) = (3, 12);

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
    let mut state = State::new(start.0.to_vec(), start.1.to_vec(), sigma.to_vec());
    let last = parts.end.min(PARTS.len()).saturating_sub(1);
    for (stage, part) in PARTS.iter().enumerate().take(last + 1).skip(parts.start) {
        let iterations = if stage == last { ITERATIONS.1 } else { ITERATIONS.0 };
        state.iterate(flow, segments, (*part, iterations), (work, go_on))?;
        state.update_noise(flow, segments, noise);
    }
    // With the noise that was found at last.
    let triangle = state.iterate(flow, segments, (PARTS[last], 3), (work, go_on))?;
    let expansion = state.expansion(flow, segments, PARTS[last]);
    state.update_noise(flow, segments, noise);
    let drift = state.drift();
    let triangle = whatever_the_inputs(flow, segments, &state, last, (work, go_on)).unwrap_or(triangle);
    let all: Vec<usize> = (0..flow.n_parameters()).collect();
    let errors = triangle.spread(&all);
    Some(Fit { xi: state.xi, errors, x: state.x, left: state.left, sigma: state.sigma, drift, expansion, triangle })
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
    let mut state = State::new(xi.to_vec(), x.to_vec(), sigma.to_vec());
    if !state.miss(flow, segments, work) {
        return None;
    }
    let told = || Some(state.eliminated(flow, segments, (PARTS[part], false), go_on, None)?.0);
    whatever_the_inputs(flow, segments, &state, part, (work, go_on)).or_else(told)
}

/// The factor over the coefficients where inputs were corrected: what is not known of these is not known of the coefficients.
fn whatever_the_inputs(
    flow: &Flow,
    segments: &[Segment],
    state: &State,
    part: usize,
    (work, go_on): (&Work, &dyn Fn() -> bool),
) -> Option<Triangle> {
    segments.iter().any(|s| s.corrections.is_some()).then_some(())?;
    inputs((flow, None), segments, (&state.xi, &state.x), &state.sigma, PARTS[part], (work, go_on))
        .map(|told| told.triangle)
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
    let mut state = State::new(xi.to_vec(), x.to_vec(), sigma.to_vec());
    if !state.miss(flow, segments, work) {
        return None;
    }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expr::parse;
    use crate::library::Term;
    use crate::motion::Stepping;
    use crate::shooting::Inputs;
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
            ramp: None,
            relative: None,
            of_inputs: Vec::new(),
            corrections: None,
        };
        for t in 0..samples {
            (0..2).for_each(|i| segment.x[[t, i]] = x[i] + noise[i] * normal(&mut rng));
            if t + 1 < samples {
                segment.u[[t, 0]] = 4.0 * rng.random::<f64>() - 2.0;
                let u = segment.u.row(t).to_vec();
                let mut next = vec![0.0; 2];
                flow.step((&x, Inputs::held(&u), dt), &[-9.0, -0.3, 1.0], &mut next, None, &mut scratch, &mut |_| {});
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

    #[test]
    fn the_start_of_a_state_that_runs_away_is_paid_for() {
        let names = ["x".to_owned()];
        let term = Term {
            expr: parse("x", &names).expect("a term"),
            name: "x".into(),
            complexity: 0,
            rate: None,
            shape: None,
        };
        let stepping = Stepping::Continuous { substeps: 2 };
        let flow = Flow::new(&[term], (&[vec![0]], &[], &[]), &[None], 0, stepping);
        let (steps, dt, noise) = (60, 0.1, 1e-3);
        let expansion = |rate: f64| {
            let mut rng = Seed::new(3).stream("noise", 0);
            let start = if rate > 0.0 { 1e-2 } else { 1.0 };
            let x = Array2::from_shape_fn((steps + 1, 1), |(t, _)| {
                start * (rate * dt * t as f64).exp() + noise * normal(&mut rng)
            });
            let segment = Segment {
                x,
                u: Array2::zeros((steps, 0)),
                dt: vec![dt; steps],
                relative: None,
                ramp: None,
                of_inputs: Vec::new(),
                corrections: None,
            };
            let bounds = Bounds { floor: &[1e-9], shape: &[noise] };
            let start = (&[rate][..], &[segment.x.clone()][..]);
            let watched = (&Work::default(), &(|| true) as &dyn Fn() -> bool);
            fit(&flow, std::slice::from_ref(&segment), start, &[noise], bounds, 0..4, watched).expect("a fit").expansion
        };
        // A start is known by Σ e^(2 λ t) samples, and one that nothing drives by their number.
        for rate in [0.5, 1.0] {
            let growth = |t: usize| (2.0 * rate * dt * t as f64).exp();
            let exact = ((0..=steps).map(growth).sum::<f64>() / (steps + 1) as f64).ln();
            assert!((expansion(rate) - exact).abs() < 0.05 * exact, "{} {exact}", expansion(rate));
        }
        assert_eq!(expansion(-0.5), 0.0);
    }
}
