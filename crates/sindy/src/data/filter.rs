//! A Kalman filter of integrated Wiener processes, and its smoother.

use nalgebra::{DMatrix, DVector, SMatrix, SVector};
use ndarray::Array2;

use super::Segment;

/// Units in which the numbers of a chain are neither large nor small: time in sampling intervals.
#[derive(Debug, Clone)]
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
#[derive(Debug, Clone, Copy)]
pub(super) struct Innovations {
    count: f64,
    squares: f64,
    logs: f64,
    /// Product of the variances whose logarithms `logs` does not have yet.
    product: f64,
}

impl Default for Innovations {
    fn default() -> Self {
        Self { count: 0.0, squares: 0.0, logs: 0.0, product: 1.0 }
    }
}

/// Products beyond this, or its inverse, become a logarithm.
const LARGE: f64 = 1e150;

impl Innovations {
    fn add(&mut self, innovation: f64, variance: f64) {
        self.count += 1.0;
        self.squares += innovation * innovation / variance;
        let product = self.product * variance;
        if (1.0 / LARGE..LARGE).contains(&product) {
            self.product = product;
        } else {
            self.logs += self.product.ln() + variance.ln();
            self.product = 1.0;
        }
    }

    fn logs(&self) -> f64 {
        self.logs + self.product.ln()
    }

    /// −2 ln L but for a constant.
    pub(super) fn total(&self) -> f64 {
        self.squares + self.logs()
    }

    /// The same with the scale of all variances chosen best.
    pub(super) fn profile(&self) -> f64 {
        if self.count < 1.0 {
            return 0.0;
        }
        self.count * (self.squares / self.count).max(f64::MIN_POSITIVE).ln() + self.logs()
    }

    /// That scale, as a standard deviation.
    pub(super) fn scale(&self) -> f64 {
        (self.squares / self.count.max(1.0)).sqrt()
    }
}

/// An integrated Wiener process whose first derivatives, those of the states of a chain, are measured with noise.
pub(super) trait Process {
    /// The innovations of all samples, for `noise` of each state of the chain and an intensity of the process.
    fn likelihood(&self, noise: &[f64], intensity: f64) -> Innovations;

    /// Per segment, values and derivatives of the chain (T + 1, chain), likewise.
    fn smoothed(&self, noise: &[f64], intensity: f64) -> Vec<(Array2<f64>, Array2<f64>)>;

    /// Standard deviation of what the samples up to one leave unknown of derivative number `j` there, likewise.
    fn uncertainty(&self, noise: &[f64], intensity: f64, j: usize) -> f64;
}

/// The process of order D of the states `chain`.
pub(super) fn process<'a, const D: usize>(
    segments: &'a [Segment],
    chain: &'a [usize],
    scale: &'a Scale,
) -> Box<dyn Process + 'a> {
    let starts = segments.iter().map(|s| start(s, chain, scale)).collect();
    let moves = segments.iter().map(|s| moves(s, scale)).collect();
    let units = std::array::from_fn(|order| scale.of_derivative(order));
    Box::new(Wiener::<D> { segments, chain, starts, moves, units })
}

struct Wiener<'a, const D: usize> {
    segments: &'a [Segment],
    chain: &'a [usize],
    /// Per segment, the state at its first sample as the first samples tell it.
    starts: Vec<SVector<f64, D>>,
    /// Per segment, what happens from each sample to the next; once if samples are evenly spaced.
    moves: Vec<Vec<Move<D>>>,
    /// Units of the states of the process.
    units: [f64; D],
}

/// The transition from one sample to the next, and the covariance that the process gathers in between if its intensity is one.
struct Move<const D: usize> {
    transition: SMatrix<f64, D, D>,
    gathered: SMatrix<f64, D, D>,
}

impl<const D: usize> Move<D> {
    /// Makes the covariance at a sample that before the measurements of the next one: A P Aᵀ + q G, where A is upper triangular.
    fn carry(&self, covariance: &mut SMatrix<f64, D, D>, intensity: f64) {
        let mut half = SMatrix::<f64, D, D>::zeros();
        for b in 0..D {
            for a in 0..D {
                half[(a, b)] = (a..D).map(|k| self.transition[(a, k)] * covariance[(k, b)]).sum();
            }
        }
        for b in 0..D {
            for a in 0..=b {
                let carried: f64 = (b..D).map(|k| half[(a, k)] * self.transition[(b, k)]).sum();
                covariance[(a, b)] = carried + self.gathered[(a, b)] * intensity;
                covariance[(b, a)] = covariance[(a, b)];
            }
        }
    }
}

fn moves<const D: usize>(segment: &Segment, scale: &Scale) -> Vec<Move<D>> {
    let of = |dt: &f64| Move { transition: transition(dt / scale.dt), gathered: gathered(dt / scale.dt) };
    segment.dt.iter().take(if interval(segment).is_some() { 1 } else { usize::MAX }).map(of).collect()
}

/// Standard deviation of the start, as it follows from the first samples, in units of what one step and one measurement add.
const DIFFUSE: f64 = 100.0;

/// The state at the first sample of the polynomial through the first samples.
fn start<const D: usize>(segment: &Segment, chain: &[usize], scale: &Scale) -> SVector<f64, D> {
    let measured = chain.iter().filter(|i| segment.measures(**i)).count().max(1);
    let samples = D.div_ceil(measured).min(segment.len() + 1);
    let mut time = 0.0;
    let (mut rows, mut values) = (Vec::new(), Vec::new());
    for t in 0..samples {
        let transition = transition::<D>(time);
        for (j, &i) in chain.iter().enumerate().filter(|(_, i)| segment.measures(**i)) {
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

/// The transition over `h` sampling intervals.
fn transition<const D: usize>(h: f64) -> SMatrix<f64, D, D> {
    SMatrix::from_fn(|i, j| if j < i { 0.0 } else { power_over_factorial(h, j - i) })
}

/// The covariance that the process gathers over `h` sampling intervals.
fn gathered<const D: usize>(h: f64) -> SMatrix<f64, D, D> {
    SMatrix::from_fn(|i, j| {
        let (a, b) = (D - 1 - i, D - 1 - j);
        h.powi((a + b + 1) as i32) / ((a + b + 1) as f64 * factorial(a) * factorial(b))
    })
}

/// Longest chain of a state, its rate, the rate of that and so on that is smoothed as one, and of which states may not have been measured.
pub const LONGEST_CHAIN: usize = 3;

/// Relative change of the covariance from sample to sample below which it stays as it is.
const STAYS: f64 = 1e-12;

/// What a filter does at one sample, whatever the measurements are.
#[derive(Clone)]
struct Gain<const D: usize> {
    /// Per measured state, by how much its innovation moves the mean, and the variance of the innovation.
    gains: [SVector<f64, D>; LONGEST_CHAIN],
    variances: [f64; LONGEST_CHAIN],
}

/// Covariances at one sample.
struct Known<const D: usize> {
    /// Before the measurements.
    predicted: SMatrix<f64, D, D>,
    /// After the measurements.
    covariance: SMatrix<f64, D, D>,
}

/// What a filter does at the samples of a segment, one after the other. Of evenly spaced samples all gains are kept, until they stay
/// as they are, for segments that are sampled alike; of others the last one.
struct Gains<const D: usize> {
    steps: Vec<Gain<D>>,
    /// Covariance after the last one of these.
    covariance: SMatrix<f64, D, D>,
    /// Covariances at all of these, if asked for.
    known: Option<Vec<Known<D>>>,
    /// Whether the covariance stays.
    steady: bool,
    /// Whether rounding has eaten the covariance: such parameters are beyond what numbers can tell.
    broken: bool,
    /// The sampling interval, if all samples so far are evenly spaced and equally exact.
    interval: Option<f64>,
}

/// Part of a sampling interval by which even ones may differ.
const EVEN: f64 = 1e-9;

/// The interval of the samples of `segment`, if they are evenly spaced and equally exact.
fn interval(segment: &Segment) -> Option<f64> {
    let first = *segment.dt.first()?;
    let even = segment.is_equally_exact() && segment.dt.iter().all(|dt| (dt - first).abs() <= EVEN * first);
    even.then_some(first)
}

impl<const D: usize> Gains<D> {
    fn none(known: bool) -> Self {
        Self {
            steps: Vec::new(),
            covariance: SMatrix::zeros(),
            known: known.then(Vec::new),
            steady: false,
            broken: false,
            interval: None,
        }
    }
}

/// What the samples of a chain are taken to be.
#[derive(Clone, Copy)]
struct Size<'a> {
    /// Standard deviations of the noise of its states.
    noise: &'a [f64],
    /// Intensity of the process.
    intensity: f64,
}

impl<const D: usize> Wiener<'_, D> {
    /// What happens between sample `t` of segment `at` and the sample before.
    fn moved(&self, at: usize, t: usize) -> &Move<D> {
        &self.moves[at][(t - 1).min(self.moves[at].len() - 1)]
    }

    /// Begins segment `at` with `gains`: those of the segment before, if it was sampled alike.
    fn begin(&self, at: usize, gains: &mut Gains<D>) {
        let interval = interval(&self.segments[at]);
        if interval.is_none() || interval != gains.interval {
            *gains = Gains { interval, ..Gains::none(gains.known.is_some()) };
        }
    }

    /// The gain at sample `t` of segment `at`, after that at the sample before.
    fn gain<'g>(&self, (at, t): (usize, usize), size: Size, gains: &'g mut Gains<D>) -> &'g Gain<D> {
        let even = gains.interval.is_some();
        if even && (gains.steady || t < gains.steps.len()) {
            return &gains.steps[t.min(gains.steps.len() - 1)];
        }
        let before = gains.covariance;
        if t == 0 {
            let measured = size.noise.iter().fold(0.0, |m: f64, s| m.max(s * s));
            gains.covariance = SMatrix::from_diagonal_element(DIFFUSE * DIFFUSE * (size.intensity + measured));
        } else {
            self.moved(at, t).carry(&mut gains.covariance, size.intensity);
        }
        let predicted = gains.known.is_some().then_some(gains.covariance);
        let (gain, broken) = self.measured((at, t), size.noise, &mut gains.covariance);
        gains.broken |= broken;
        if let (Some(known), Some(predicted)) = (&mut gains.known, predicted) {
            known.push(Known { predicted, covariance: gains.covariance });
        }
        let stays = |j: usize| (gains.covariance[(j, j)] / before[(j, j)] - 1.0).abs() < STAYS;
        gains.steady = even && t > 0 && (0..D).all(stays);
        if !even {
            gains.steps.clear();
        }
        gains.steps.push(gain);
        &gains.steps[gains.steps.len() - 1]
    }

    /// The gain at sample `t` of segment `at`, which makes a predicted covariance that after the measurements, and whether rounding has eaten it.
    fn measured(&self, (at, t): (usize, usize), noise: &[f64], covariance: &mut SMatrix<f64, D, D>) -> (Gain<D>, bool) {
        let mut broken = false;
        let mut gain = Gain { gains: [SVector::zeros(); LONGEST_CHAIN], variances: [1.0; LONGEST_CHAIN] };
        for (j, (&i, sigma)) in self.chain.iter().zip(noise).enumerate() {
            broken |= covariance[(j, j)] < 0.0;
            let relative = self.segments[at].relative(t, i);
            if relative.is_infinite() {
                gain.variances[j] = f64::INFINITY;
                continue;
            }
            let variance = covariance[(j, j)] + (sigma * relative).powi(2);
            let column: SVector<f64, D> = covariance.column(j).into_owned();
            let moved = column / variance;
            for b in 0..D {
                for a in 0..=b {
                    covariance[(a, b)] -= moved[a] * column[b];
                    covariance[(b, a)] = covariance[(a, b)];
                }
            }
            (gain.gains[j], gain.variances[j]) = (moved, variance);
        }
        (gain, broken)
    }

    /// Moves the mean to sample `t`, and there by what is measured; tells each innovation.
    fn filter(
        &self,
        (at, t): (usize, usize),
        gain: &Gain<D>,
        mean: &mut SVector<f64, D>,
        mut tell: impl FnMut(usize, f64),
    ) -> SVector<f64, D> {
        if t > 0 {
            *mean = self.moved(at, t).transition * *mean;
        }
        let predicted = *mean;
        for (j, &i) in self.chain.iter().enumerate() {
            let innovation = self.segments[at].x[[t, i]] / self.units[j] - mean[j];
            *mean += gain.gains[j] * innovation;
            tell(j, innovation);
        }
        predicted
    }
}

impl<const D: usize> Process for Wiener<'_, D> {
    fn likelihood(&self, noise: &[f64], intensity: f64) -> Innovations {
        let mut sums = Innovations::default();
        let mut gains = Gains::none(false);
        for (at, (segment, start)) in self.segments.iter().zip(&self.starts).enumerate() {
            self.begin(at, &mut gains);
            let mut mean = *start;
            for t in 0..=segment.len() {
                let gain = self.gain((at, t), Size { noise, intensity }, &mut gains);
                self.filter((at, t), gain, &mut mean, |j, innovation| {
                    // The first samples only fix the start.
                    if t >= D && gain.variances[j].is_finite() {
                        sums.add(innovation, gain.variances[j]);
                    }
                });
                if gains.broken {
                    return Innovations { squares: f64::INFINITY, ..Innovations::default() };
                }
            }
        }
        sums
    }

    /// By the Rauch–Tung–Striebel smoother.
    fn smoothed(&self, noise: &[f64], intensity: f64) -> Vec<(Array2<f64>, Array2<f64>)> {
        let mut gains = Gains::none(true);
        let mut smoothed = Vec::with_capacity(self.segments.len());
        for (at, (segment, start)) in self.segments.iter().zip(&self.starts).enumerate() {
            self.begin(at, &mut gains);
            let mut mean = *start;
            let of = |t: usize| {
                let gain = self.gain((at, t), Size { noise, intensity }, &mut gains);
                let predicted = self.filter((at, t), gain, &mut mean, |_, _| {});
                (predicted, mean)
            };
            let passed: Vec<(SVector<f64, D>, SVector<f64, D>)> = (0..=segment.len()).map(of).collect();
            let known = gains.known.as_deref().unwrap_or_default();
            let last = known.len() - 1;
            // From what is wrong with the prediction of a sample to what is wrong with the mean before.
            let back = |t: usize| {
                let (now, next) = (&known[t.min(last)], &known[(t + 1).min(last)]);
                let factor = next.predicted.cholesky()?;
                Some(now.covariance * self.moved(at, t + 1).transition.transpose() * factor.inverse())
            };
            let backs: Vec<Option<SMatrix<f64, D, D>>> = (0..known.len().min(segment.len())).map(back).collect();
            let shape = (segment.len() + 1, self.chain.len());
            let (mut x, mut x_dot) = (Array2::zeros(shape), Array2::zeros(shape));
            let mut later: Option<SVector<f64, D>> = None;
            for t in (0..=segment.len()).rev() {
                let mut mean = passed[t].1;
                if let (Some(later), Some(Some(back))) = (later, backs.get(t.min(backs.len().max(1) - 1))) {
                    mean += back * (later - passed[t + 1].0);
                }
                for j in 0..self.chain.len() {
                    x[[t, j]] = mean[j] * self.units[j];
                    x_dot[[t, j]] = mean[j + 1] * self.units[j + 1];
                }
                later = Some(mean);
            }
            smoothed.push((x, x_dot));
        }
        smoothed
    }

    fn uncertainty(&self, noise: &[f64], intensity: f64, j: usize) -> f64 {
        let Some(longest) = (0..self.segments.len()).max_by_key(|&at| self.segments[at].len()) else { return 1.0 };
        let mut gains = Gains::none(false);
        self.begin(longest, &mut gains);
        for t in 0..=self.segments[longest].len() {
            self.gain((longest, t), Size { noise, intensity }, &mut gains);
        }
        gains.covariance[(j, j)].max(0.0).sqrt()
    }
}

fn factorial(n: usize) -> f64 {
    (1..=n).map(|i| i as f64).product()
}

fn power_over_factorial(h: f64, n: usize) -> f64 {
    h.powi(n as i32) / factorial(n)
}
