//! Parameters of a Lagrangian fitted to windows of samples with noise, each from a start of its own.

use ndarray::{Array2, s};

use super::mechanism::Mechanism;
use crate::Triangle;
use crate::data::Segment;
use crate::library::{Joints, Lagrangian};
use crate::motion::Stepping;

/// Parts of a Gauss–Newton step that are tried, one after the other.
const PARTS: [f64; 5] = [1.0, 0.5, 0.25, 0.1, 0.02];

/// Singular values of scaled columns below this part of the largest are taken as zero.
const CUTOFF: f64 = 1e-8;

/// Part of the logarithm of the likelihood, for each number, that a round must gain to be followed by another.
const GAIN: f64 = 1e-3;

/// Part of the time in which a joint moves as far as it does at all, over which is predicted, and steps at least.
const AHEAD: f64 = 0.5;
const SHORTEST: usize = 3;

/// Consecutive samples.
#[derive(Debug, Clone)]
pub(super) struct Window {
    /// States (T + 1, n).
    pub(super) x: Array2<f64>,
    /// Inputs (T, k).
    pub(super) u: Array2<f64>,
    /// Time from each sample to the next \[s\] (T).
    pub(super) dt: Vec<f64>,
}

/// What one Lagrangian is to explain.
#[derive(Clone, Copy)]
pub(super) struct Windows<'a> {
    pub(super) lagrangian: &'a Lagrangian,
    pub(super) windows: &'a [Window],
    /// Smallest error of each state that is believed (n).
    pub(super) floor: &'a [f64],
    pub(super) stepping: Stepping,
}

/// Parameters with their values, the first of them the unit of the others, and the state at the start of each window.
#[derive(Debug, Clone)]
pub(super) struct Fitted {
    pub(super) chosen: Vec<usize>,
    pub(super) values: Vec<f64>,
    starts: Vec<Vec<f64>>,
    /// Standard deviation of what is left of each state (n).
    pub(super) sigma: Vec<f64>,
    /// −2 ln L but for a constant, with the noise of each state at its likeliest.
    pub(super) misfit: f64,
}

/// Windows followed from their starts.
struct Followed {
    /// Per window: errors of all samples (T + 1, n), and what they change with parameters and start (T + 1, n, P + n).
    errors: Vec<Array2<f64>>,
    slopes: Vec<Vec<Vec<f64>>>,
}

impl Windows<'_> {
    /// Numbers that were measured, less those that the starts take up.
    pub(super) fn count(&self) -> f64 {
        self.windows.iter().map(|w| (w.x.nrows() - 1) as f64 * w.x.ncols() as f64).sum()
    }

    /// `values` of the parameters `chosen`, and the starts of all windows, from `starts` or the samples there, fitted in so many `rounds` of Gauss–Newton. `None` where the windows cannot be followed.
    pub(super) fn fitted(
        &self,
        (chosen, values): (&[usize], Vec<f64>),
        starts: Option<&[Vec<f64>]>,
        rounds: usize,
    ) -> Option<Fitted> {
        let mechanism = self.mechanism(chosen);
        let measured = || self.windows.iter().map(|w| w.x.row(0).to_vec()).collect();
        let mut starts = starts.map_or_else(measured, <[Vec<f64>]>::to_vec);
        let mut values = values;
        let mut followed = self.followed(&mechanism, &values, &starts)?;
        let (mut sigma, mut misfit) = self.left(&followed);
        for _ in 0..rounds {
            let own: Vec<Triangle> = self.triangles(&followed, &sigma)?;
            let whole = told(&own, sigma.len())?;
            let free = values.len() - 1;
            let all: Vec<usize> = (0..free).collect();
            let length = |j: usize| whole.norm(j).max(f64::MIN_POSITIVE);
            let step = whole.solve_truncated(&all, free, CUTOFF, length);
            let step: Vec<f64> = step.iter().enumerate().map(|(j, d)| d / length(j)).collect();
            let moves: Vec<Vec<f64>> = own.iter().map(|own| moved(own, sigma.len(), &step)).collect();
            let tried = PARTS.iter().find_map(|part| {
                let mut next = values.clone();
                next[1..].iter_mut().zip(&step).for_each(|(v, d)| *v += part * d);
                let begun =
                    |(start, by): (&Vec<f64>, &Vec<f64>)| start.iter().zip(by).map(|(x, d)| x + part * d).collect();
                let begun: Vec<Vec<f64>> = starts.iter().zip(&moves).map(begun).collect();
                let followed = self.followed(&mechanism, &next, &begun)?;
                let (sigma, left) = self.left(&followed);
                (left < misfit).then_some((followed, sigma, left, next, begun))
            });
            let Some((next, s, left, v, b)) = tried else { break };
            let is_last = misfit - left < GAIN * self.count();
            (followed, sigma, misfit, values, starts) = (next, s, left, v, b);
            if is_last {
                break;
            }
        }
        Some(Fitted { chosen: chosen.to_vec(), values, starts, sigma, misfit })
    }

    /// Errors of all samples near `fitted`, as parts of what is left, linear in the parameters beside the unit: columns of their changes, and last the errors; starts are taken out.
    pub(super) fn linearised(&self, fitted: &Fitted) -> Option<Triangle> {
        let followed = self.followed(&self.mechanism(&fitted.chosen), &fitted.values, &fitted.starts)?;
        told(&self.triangles(&followed, &fitted.sigma)?, fitted.sigma.len())
    }

    /// The same parameters and others that are 0 as yet, all of them fitted.
    pub(super) fn with_others(&self, fitted: &Fitted, others: &[usize], rounds: usize) -> Option<Fitted> {
        let unit = fitted.chosen[0];
        let value = |p: &usize| fitted.chosen.iter().position(|q| q == p).map_or(0.0, |at| fitted.values[at]);
        let chosen: Vec<usize> = std::iter::once(unit).chain(others.iter().copied()).collect();
        let values = chosen.iter().map(value).collect();
        self.fitted((&chosen, values), Some(&fitted.starts), rounds)
    }

    /// The parameters `columns` of `fitted` beside the unit alone, with these values, fitted.
    pub(super) fn with_fewer(
        &self,
        fitted: &Fitted,
        (columns, values): (&[usize], &[f64]),
        rounds: usize,
    ) -> Option<Fitted> {
        let chosen: Vec<usize> =
            std::iter::once(fitted.chosen[0]).chain(columns.iter().map(|j| fitted.chosen[1 + j])).collect();
        let values = fitted.values[..1].iter().chain(values).copied().collect();
        self.fitted((&chosen, values), Some(&fitted.starts), rounds)
    }

    /// The sign of the kinetic energy with the `values` of the parameters `chosen`; `None` where it is not definite, and the same, at the start of every window.
    pub(super) fn sign(&self, chosen: &[usize], values: &[f64]) -> Option<f64> {
        let mechanism = self.mechanism(chosen);
        let mut signs = self.windows.iter().map(|w| mechanism.sign_of_masses(&w.x.row(0).to_vec(), values));
        let first = signs.next()??;
        signs.all(|sign| sign == Some(first)).then_some(first)
    }

    fn mechanism(&self, chosen: &[usize]) -> Mechanism {
        let dims = self.windows.first().map_or((0, 0), |w| (w.x.ncols(), w.u.ncols()));
        Mechanism::new(self.lagrangian, chosen, dims).with_starts()
    }

    fn followed(&self, mechanism: &Mechanism, values: &[f64], starts: &[Vec<f64>]) -> Option<Followed> {
        let (mut errors, mut slopes) = (Vec::new(), Vec::new());
        for (window, start) in self.windows.iter().zip(starts) {
            let n = start.len();
            let mut of_window = Array2::zeros(window.x.dim());
            let mut changes = Vec::with_capacity(window.x.nrows());
            let mut flight = mechanism.start(start);
            for (t, samples) in window.x.rows().into_iter().enumerate() {
                if t > 0 {
                    let u = window.u.row(t - 1).to_vec();
                    flight = mechanism.step(flight, &u, values, window.dt[t - 1], self.stepping)?;
                }
                samples.iter().enumerate().for_each(|(i, x)| of_window[[t, i]] = x - flight.state(i));
                // The unit stays.
                changes.push((0..n).flat_map(|i| flight.changes(i)[1..].iter().copied()).collect());
            }
            errors.push(of_window);
            slopes.push(changes);
        }
        Some(Followed { errors, slopes })
    }

    /// Standard deviation of what is left of each state, and −2 ln L.
    fn left(&self, followed: &Followed) -> (Vec<f64>, f64) {
        let n = self.floor.len();
        let (mut squares, mut count) = (vec![0.0; n], 0.0);
        for errors in &followed.errors {
            for (at, error) in errors.indexed_iter() {
                squares[at.1] += error * error;
            }
            count += (errors.nrows() - 1) as f64;
        }
        let sigma: Vec<f64> =
            squares.iter().zip(self.floor).map(|(sum, floor)| (sum / count).sqrt().max(*floor)).collect();
        let misfit = sigma.iter().map(|s| 2.0 * count * s.max(f64::MIN_POSITIVE).ln()).sum();
        (sigma, misfit)
    }

    /// Per window, the triangle of what its errors change with its start, then with the parameters, and the errors.
    fn triangles(&self, followed: &Followed, sigma: &[f64]) -> Option<Vec<Triangle>> {
        let n = sigma.len();
        let of = |(errors, slopes): (&Array2<f64>, &Vec<Vec<f64>>)| {
            let columns = slopes.first()?.len() / n;
            let free = columns - n;
            let mut rows = Array2::zeros((errors.len(), columns + 1));
            for (t, changes) in slopes.iter().enumerate() {
                for (i, sigma) in sigma.iter().enumerate() {
                    let sigma = sigma.max(f64::MIN_POSITIVE);
                    let mut row = rows.row_mut(t * n + i);
                    (0..n).for_each(|j| row[j] = changes[i * columns + free + j] / sigma);
                    (0..free).for_each(|p| row[n + p] = changes[i * columns + p] / sigma);
                    row[columns] = errors[[t, i]] / sigma;
                }
            }
            let mut triangle = Triangle::new(columns + 1);
            triangle.push(rows.view()).ok()?;
            Some(triangle)
        };
        followed.errors.iter().zip(&followed.slopes).map(of).collect()
    }
}

/// Windows of `stride` steps, one after the other.
pub(super) fn windows(segments: &[Segment], stride: usize) -> Vec<Window> {
    let of = |segment: &Segment| {
        let u = segment.mean_inputs();
        let window = |from: usize| {
            let to = (from + stride).min(segment.len());
            Window {
                x: segment.x.slice(s![from..=to, ..]).to_owned(),
                u: u.slice(s![from..to, ..]).to_owned(),
                dt: segment.dt[from..to].to_vec(),
            }
        };
        (0..segment.len()).step_by(stride).map(window).collect::<Vec<_>>()
    };
    segments.iter().flat_map(of).collect()
}

/// Steps over which predictions tell most: part of the time in which a joint moves as far as it does at all.
pub(super) fn stride(joints: &Joints, segments: &[Segment]) -> usize {
    let spread = |i: usize| {
        let all: Vec<f64> = segments.iter().flat_map(|segment| segment.x.column(i).to_vec()).collect();
        let mean = all.iter().sum::<f64>() / all.len().max(1) as f64;
        (all.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / all.len().max(1) as f64).sqrt()
    };
    let time = |(q, v): (usize, usize)| spread(q) / spread(v).max(f64::MIN_POSITIVE);
    let shortest = joints.pairs().map(time).fold(f64::INFINITY, f64::min);
    let mut steps: Vec<f64> = segments.iter().flat_map(|segment| segment.dt.iter().copied()).collect();
    steps.sort_by(f64::total_cmp);
    let step = steps.get(steps.len() / 2).copied().unwrap_or(1.0);
    ((AHEAD * shortest / step) as usize).max(SHORTEST)
}

/// All windows together, with their starts (n) taken out.
fn told(own: &[Triangle], n: usize) -> Option<Triangle> {
    let mut whole: Option<Triangle> = None;
    for own in own {
        let own = own.trailing(n);
        match &mut whole {
            Some(whole) => whole.merge(&own).ok()?,
            None => whole = Some(own),
        }
    }
    whole
}

/// By how much the start (n) of a window moves where the parameters move by `step`.
fn moved(own: &Triangle, n: usize, step: &[f64]) -> Vec<f64> {
    let at = |i: usize, j: usize| own.column(j).get(i).copied().unwrap_or(0.0);
    let mut moves = vec![0.0; n];
    for i in (0..n).rev() {
        let by_parameters: f64 = step.iter().enumerate().map(|(p, d)| at(i, n + p) * d).sum();
        let by_later: f64 = (i + 1..n).map(|j| at(i, j) * moves[j]).sum();
        let left = at(i, n + step.len()) - by_parameters - by_later;
        moves[i] = if at(i, i) == 0.0 { 0.0 } else { left / at(i, i) };
    }
    moves
}
