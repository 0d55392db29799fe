//! A Kalman filter of integrated Wiener processes, and its smoother.

use nalgebra::{DMatrix, DVector, SMatrix, SVector};
use ndarray::Array2;

use super::Segment;

/// Samples that decide on noise and smoothness, at most: more change no digit that matters.
const SAMPLES: usize = 1000;

/// Units in which the numbers of a chain are neither large nor small: time in sampling intervals.
pub(super) struct Scale {
    pub(super) dt: f64,
    /// Unit of the head of the chain.
    pub(super) value: f64,
}

impl Scale {
    pub(super) fn of(segments: &[Segment], chain: &[usize]) -> Self {
        let mut steps: Vec<f64> = segments.iter().flat_map(|s| s.dt.iter().copied()).collect();
        steps.sort_by(f64::total_cmp);
        let dt = steps.get(steps.len() / 2).copied().unwrap_or(1.0);
        let (mut sum, mut count) = (0.0, 0.0);
        for segment in segments {
            let column = segment.x.column(chain[0]);
            let mean = column.mean().unwrap_or(0.0);
            sum += column.iter().map(|v| (v - mean).powi(2)).sum::<f64>();
            count += column.len() as f64;
        }
        let value = (sum / f64::max(count, 1.0)).sqrt();
        Self { dt, value: if value > 0.0 { value } else { 1.0 } }
    }

    pub(super) fn of_derivative(&self, order: usize) -> f64 {
        self.value / self.dt.powi(order as i32)
    }
}

/// Sums over the innovations of a filter.
#[derive(Default, Clone, Copy)]
pub(super) struct Innovations {
    count: f64,
    squares: f64,
    logs: f64,
}

impl Innovations {
    /// −2 ln L but for a constant.
    pub(super) fn total(&self) -> f64 {
        self.squares + self.logs
    }

    /// The same with the scale of all variances chosen best.
    pub(super) fn profile(&self) -> f64 {
        if self.count < 1.0 {
            return 0.0;
        }
        self.count * (self.squares / self.count).max(f64::MIN_POSITIVE).ln() + self.logs
    }

    /// That scale, as a standard deviation.
    pub(super) fn scale(&self) -> f64 {
        (self.squares / self.count.max(1.0)).sqrt()
    }
}

/// The innovations of the first [`SAMPLES`] samples.
pub(super) fn likelihood<const D: usize>(
    segments: &[Segment],
    chain: &[usize],
    scale: &Scale,
    noise: &[f64],
    intensity: f64,
) -> Innovations {
    let mut sums = Innovations::default();
    for segment in segments {
        if sums.count as usize > SAMPLES * chain.len() {
            break;
        }
        let mut filter = Filter::<D>::new(segment, chain, scale, noise, intensity);
        for t in 0..=segment.len() {
            filter.predict(t);
            filter.update(t, &mut sums);
        }
    }
    sums
}

/// A Kalman filter of an integrated Wiener process of order D whose first derivatives are measured.
struct Filter<'a, const D: usize> {
    segment: &'a Segment,
    chain: &'a [usize],
    scale: &'a Scale,
    noise: &'a [f64],
    intensity: f64,
    mean: SVector<f64, D>,
    covariance: SMatrix<f64, D, D>,
}

/// Standard deviation of the start, as it follows from the first samples, in units of what one step and one measurement add.
const DIFFUSE: f64 = 100.0;

/// The state at the first sample of the polynomial through the first samples.
fn start<const D: usize>(segment: &Segment, chain: &[usize], scale: &Scale) -> SVector<f64, D> {
    let samples = D.div_ceil(chain.len()).min(segment.len() + 1);
    let mut time = 0.0;
    let (mut rows, mut values) = (Vec::new(), Vec::new());
    for t in 0..samples {
        let transition = Filter::<D>::transition(time);
        for (j, &i) in chain.iter().enumerate() {
            rows.push(transition.row(j).into_owned());
            values.push(segment.x[[t, i]] / scale.of_derivative(j));
        }
        time += segment.dt.get(t).map_or(0.0, |dt| dt / scale.dt);
    }
    let polynomial = DMatrix::from_fn(rows.len(), D, |i, j| rows[i][j]);
    match polynomial.svd(true, true).solve(&DVector::from_vec(values), 1e-12) {
        Ok(found) => SVector::from_fn(|j, _| found[j]),
        Err(_) => SVector::zeros(),
    }
}

impl<'a, const D: usize> Filter<'a, D> {
    fn new(segment: &'a Segment, chain: &'a [usize], scale: &'a Scale, noise: &'a [f64], intensity: f64) -> Self {
        let mean = start(segment, chain, scale);
        let measured = noise.iter().fold(0.0, |m: f64, s| m.max(s * s));
        let covariance = SMatrix::from_diagonal_element(DIFFUSE * DIFFUSE * (intensity + measured));
        Self { segment, chain, scale, noise, intensity, mean, covariance }
    }

    /// The transition over `h` sampling intervals.
    fn transition(h: f64) -> SMatrix<f64, D, D> {
        SMatrix::from_fn(|i, j| if j < i { 0.0 } else { power_over_factorial(h, j - i) })
    }

    /// The covariance that the process gathers over `h` sampling intervals.
    fn gathered(h: f64) -> SMatrix<f64, D, D> {
        SMatrix::from_fn(|i, j| {
            let (a, b) = (D - 1 - i, D - 1 - j);
            h.powi((a + b + 1) as i32) / ((a + b + 1) as f64 * factorial(a) * factorial(b))
        })
    }

    /// From sample t − 1 to t.
    fn predict(&mut self, t: usize) -> SMatrix<f64, D, D> {
        if t == 0 {
            return SMatrix::identity();
        }
        let h = self.segment.dt[t - 1] / self.scale.dt;
        let f = Self::transition(h);
        self.mean = f * self.mean;
        self.covariance = f * self.covariance * f.transpose() + Self::gathered(h) * self.intensity;
        f
    }

    fn update(&mut self, t: usize, sums: &mut Innovations) {
        for (j, (&i, sigma)) in self.chain.iter().zip(self.noise).enumerate() {
            let y = self.segment.x[[t, i]] / self.scale.of_derivative(j);
            let variance = self.covariance[(j, j)] + (sigma * self.segment.relative(t, i)).powi(2);
            if self.covariance[(j, j)] < 0.0 {
                // Rounding has eaten the covariance: these parameters are beyond what numbers can tell.
                sums.squares = f64::INFINITY;
            }
            let innovation = y - self.mean[j];
            let gain = self.covariance.column(j) / variance;
            self.mean += gain * innovation;
            self.covariance -= gain * gain.transpose() * variance;
            self.covariance = (self.covariance + self.covariance.transpose()) * 0.5;
            // The first samples only fix the start.
            if t >= D {
                sums.count += 1.0;
                sums.squares += innovation * innovation / variance;
                sums.logs += variance.ln();
            }
        }
    }
}

/// Values and derivatives of the channels of `chain` (T + 1, chain) by the Rauch–Tung–Striebel smoother.
pub(super) fn smoothed<const D: usize>(
    segment: &Segment,
    chain: &[usize],
    scale: &Scale,
    noise: &[f64],
    intensity: f64,
) -> (Array2<f64>, Array2<f64>) {
    let mut filter = Filter::<D>::new(segment, chain, scale, noise, intensity);
    let mut ignored = Innovations::default();
    let mut passed = Vec::with_capacity(segment.len() + 1);
    for t in 0..=segment.len() {
        let transition = filter.predict(t);
        let predicted = (filter.mean, filter.covariance);
        filter.update(t, &mut ignored);
        passed.push((transition, predicted, filter.mean, filter.covariance));
    }
    let shape = (segment.len() + 1, chain.len());
    let (mut x, mut x_dot) = (Array2::zeros(shape), Array2::zeros(shape));
    let mut later: Option<SVector<f64, D>> = None;
    for t in (0..=segment.len()).rev() {
        let (_, _, mut mean, covariance) = passed[t];
        if let (Some(later), Some((transition, predicted, ..))) = (later, passed.get(t + 1))
            && let Some(factor) = predicted.1.cholesky()
        {
            mean += covariance * transition.transpose() * factor.solve(&(later - predicted.0));
        }
        for j in 0..chain.len() {
            x[[t, j]] = mean[j] * scale.of_derivative(j);
            x_dot[[t, j]] = mean[j + 1] * scale.of_derivative(j + 1);
        }
        later = Some(mean);
    }
    (x, x_dot)
}

fn factorial(n: usize) -> f64 {
    (1..=n).map(|i| i as f64).product()
}

fn power_over_factorial(h: f64, n: usize) -> f64 {
    h.powi(n as i32) / factorial(n)
}
