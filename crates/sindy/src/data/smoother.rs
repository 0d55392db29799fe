//! Signals and noise levels of measured channels, before any equation is known.

use ndarray::Array2;

use super::differences::by_differences;
use super::filter::{LONGEST_CHAIN, Process, Scale, process};
use super::{Segment, measures, sample_of};

/// Smoothed channels.
#[derive(Debug, Clone)]
pub(crate) struct Signals {
    /// Per segment: values of all states at the samples (T + 1, n).
    pub(crate) x: Vec<Array2<f64>>,
    /// Per segment: their derivatives there (T + 1, n).
    pub(crate) x_dot: Vec<Array2<f64>>,
    /// Standard deviation of the noise of each state (n).
    pub(crate) sigma: Vec<f64>,
}

/// Logarithms of the ratio of intensity to the noise's variance among which the likeliest is looked for.
const LOGS: (f64, f64) = (-24.0, 24.0);

/// Signals of recordings: the process behind each chain of states and its noise, estimated once.
///
/// A channel is taken as an integrated Wiener process, whose order and intensity are estimated, seen with white
/// noise. A chain of rates is smoothed as one process of which every derivative down the chain is measured. Sampling may be uneven.
///
/// # References
/// Wahba (1978), J. R. Stat. Soc. B 40(3): the posterior mean is a smoothing spline. Särkkä (2013), Bayesian Filtering and
/// Smoothing, algorithms 4.2 (filter) and 8.2 (smoother).
pub(crate) struct Smoother<'a> {
    segments: &'a [Segment],
    chains: Vec<Chain>,
}

/// A state, the state that is its rate, and so on, and the process behind them.
struct Chain {
    states: Vec<usize>,
    scale: Scale,
    order: Order,
    intensity: f64,
    /// Standard deviations of the noise of the states, in units of the scale.
    noise: Vec<f64>,
}

impl<'a> Smoother<'a> {
    /// By maximum likelihood of some of the samples, as long as `go_on` says so, for noise of every state of at least `floor` (n). `rates` holds, per state, the state that is its rate.
    pub(crate) fn new(
        segments: &'a [Segment],
        rates: &[Option<usize>],
        floor: &[f64],
        go_on: &dyn Fn() -> bool,
    ) -> Self {
        let told = sample_of(segments, SAMPLES);
        let n = rates.len();
        let is_rate = |i: usize| rates.contains(&Some(i));
        let mut done = vec![false; n];
        let mut chains = Vec::new();
        // Chains first from their heads; what a circle of rates leaves is smoothed alone.
        let heads: Vec<usize> = (0..n).filter(|&i| !is_rate(i)).chain(0..n).collect();
        for head in heads {
            let mut states = Vec::new();
            let mut next = Some(head);
            // A chain that is too long goes on with the next head.
            while let Some(i) = next.filter(|&i| !done[i] && states.len() < LONGEST_CHAIN) {
                done[i] = true;
                states.push(i);
                next = rates[i];
            }
            let orders: &[Order] = match states.len() {
                0 => continue,
                1 => &ALONE,
                2 => &[process::<3>, process::<4>, process::<6>],
                _ => &[process::<4>, process::<5>, process::<7>],
            };
            chains.extend(Chain::likeliest(&told, states, (orders, floor), go_on));
        }
        Self { segments, chains }
    }

    /// The signals if the noise of every state is at least `floor` (n).
    pub(crate) fn signals(&self, floor: &[f64]) -> Signals {
        let zeros = || self.segments.iter().map(|s| Array2::zeros(s.x.dim())).collect::<Vec<_>>();
        let mut signals = Signals { x: zeros(), x_dot: zeros(), sigma: vec![0.0; floor.len()] };
        for Chain { states, scale, order, intensity, noise } in &self.chains {
            let floored = |(j, sigma): (usize, &f64)| sigma.max(floor[states[j]] / scale.of_derivative(j));
            let noise: Vec<f64> = noise.iter().enumerate().map(floored).collect();
            let process = order(self.segments, states, scale);
            for (j, &i) in states.iter().enumerate() {
                let measured = measures(self.segments, i);
                let sigma = if measured { noise[j] } else { process.uncertainty(&noise, *intensity, j) };
                signals.sigma[i] = sigma * scale.of_derivative(j);
            }
            let smoothed = process.smoothed(&noise, *intensity);
            for (at, (x, x_dot)) in smoothed.iter().enumerate() {
                for (j, &i) in states.iter().enumerate() {
                    signals.x[at].column_mut(i).assign(&x.column(j));
                    signals.x_dot[at].column_mut(i).assign(&x_dot.column(j));
                }
            }
        }
        signals
    }
}

/// Steps that decide on noise and smoothness, at most: more change no digit that matters.
const SAMPLES: usize = 1000;

/// Searches along each parameter of a chain.
const TURNS: usize = 3;

/// Logarithms of the factors by which the noise of a channel may differ from what its own differences tell.
const FACTORS: (f64, f64) = (-2.3, 1.0);

/// A process of one order behind a chain.
type Order = for<'a> fn(&'a [Segment], &'a [usize], &'a Scale) -> Box<dyn Process + 'a>;

/// The orders tried for a channel by itself: from a signal with a jerky slope, as a state has on which an input acts, to one as
/// smooth as an orbit.
const ALONE: [Order; 3] = [process::<2>, process::<3>, process::<5>];

impl Chain {
    /// The likeliest of the processes `orders` behind `states`.
    fn likeliest(
        segments: &[Segment],
        states: Vec<usize>,
        (orders, floor): (&[Order], &[f64]),
        go_on: &dyn Fn() -> bool,
    ) -> Option<Self> {
        let scale = Scale::of(segments, &states);
        // States that were not measured come after one that was.
        let measured: Vec<usize> = (0..states.len()).filter(|&j| measures(segments, states[j])).collect();
        let of = |i: usize| {
            let by_differences = by_differences(segments, i);
            let least = (FACTORS.0.exp() * by_differences).max(floor[i]);
            if measured.len() == 1 && go_on() { noise_of(segments, i, least) } else { by_differences }
        };
        let mut alone = vec![f64::INFINITY; states.len()];
        measured.iter().for_each(|&j| alone[j] = of(states[j]).max(floor[states[j]]) / scale.of_derivative(j));
        let least = alone.iter().copied().fold(f64::INFINITY, f64::min);
        alone.iter_mut().filter(|noise| noise.is_infinite()).for_each(|noise| *noise = least);
        let of =
            |order: &Order| (together(order(segments, &states, &scale).as_ref(), &alone, &measured, go_on), *order);
        let likeliest = orders.iter().map(of).min_by(|a, b| a.0.2.total_cmp(&b.0.2));
        likeliest.map(|((intensity, noise, _), order)| Self { states, scale, order, intensity, noise })
    }
}

/// Noise of state `i` alone, at least `floor`.
fn noise_of(segments: &[Segment], i: usize, floor: f64) -> f64 {
    let (scale, states) = (Scale::of(segments, &[i]), [i]);
    let found = ALONE.iter().map(|order| {
        let process = order(segments, &states, &scale);
        let unit = |log_ratio: f64| process.likelihood(&[1.0], log_ratio.exp());
        unit(minimum(LOGS, |l| unit(l).profile()))
    });
    let likeliest = found.min_by(|a, b| a.profile().total_cmp(&b.profile()));
    likeliest.map_or(0.0, |found| scale.value * found.scale()).max(floor)
}

/// The intensity of the process of a chain, the noise of its channels, and −2 ln L there; by searches along one of them after the
/// other from the noise each channel has `alone`; that of channels other than those `measured` does not matter.
fn together(
    process: &dyn Process,
    alone: &[f64],
    measured: &[usize],
    go_on: &dyn Fn() -> bool,
) -> (f64, Vec<f64>, f64) {
    let mut noise = alone.to_vec();
    if !go_on() {
        return (1.0, noise, f64::INFINITY);
    }
    let unit = alone.iter().fold(f64::INFINITY, |m, s| m.min(*s)).max(1e-12).powi(2);
    let at = |intensity: f64, noise: &[f64]| process.likelihood(noise, intensity).total();
    let mut log = minimum(LOGS, |l| at(l.exp() * unit, &noise));
    // A channel by itself has the noise that it has; those of a chain tell of each other.
    for _ in 0..if measured.len() > 1 { TURNS } else { 0 } {
        for &j in measured {
            if !go_on() {
                return (unit, noise, f64::INFINITY);
            }
            let moved = |l: f64| {
                let mut noise = noise.clone();
                noise[j] *= l.exp();
                noise
            };
            let reached = (noise[j] / alone[j]).ln();
            let range = (FACTORS.0 - reached, FACTORS.1 - reached);
            let best = minimum(range, |l| at(log.exp() * unit, &moved(l)));
            noise = moved(best);
        }
        log = minimum((log - 4.0, log + 4.0), |l| at(l.exp() * unit, &noise));
    }
    let intensity = log.exp() * unit;
    let total = at(intensity, &noise);
    (intensity, noise, total)
}

/// Where `f` is smallest: the best of a coarse grid over `range`, refined by golden sections.
fn minimum((low, high): (f64, f64), f: impl Fn(f64) -> f64) -> f64 {
    const GRID: usize = 16;
    const ROUNDS: usize = 9;
    let step = (high - low) / GRID as f64;
    let place = |i: usize| low + i as f64 * step;
    let values: Vec<f64> = (0..=GRID).map(|i| f(place(i))).collect();
    let best = (0..=GRID).min_by(|&a, &b| values[a].total_cmp(&values[b])).unwrap_or(0);
    let golden = 0.5 * (5_f64.sqrt() - 1.0);
    let (mut a, mut b) = ((place(best) - step).max(low), (place(best) + step).min(high));
    let (mut c, mut d) = (b - golden * (b - a), a + golden * (b - a));
    let (mut f_c, mut f_d) = (f(c), f(d));
    for _ in 0..ROUNDS {
        if f_c < f_d {
            (b, d, f_d) = (d, c, f_c);
            c = b - golden * (b - a);
            f_c = f(c);
        } else {
            (a, c, f_c) = (c, d, f_d);
            d = a + golden * (b - a);
            f_d = f(d);
        }
    }
    0.5 * (a + b)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::RngExt as _;
    use sindyna_core::Seed;

    fn wave(noise: f64, samples: usize, uneven: bool) -> Segment {
        let mut rng = Seed::new(3).stream("noise", 0);
        let mut normal = || (0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0;
        let mut t = 0.0;
        let mut dt = Vec::new();
        let mut x = Array2::zeros((samples, 2));
        for i in 0..samples {
            x[[i, 0]] = f64::sin(3.0 * t) + noise * normal();
            x[[i, 1]] = 3.0 * f64::cos(3.0 * t) + noise * normal();
            let step = if uneven { 0.02 + 0.03 * (i % 3) as f64 } else { 0.04 };
            if i + 1 < samples {
                dt.push(step);
            }
            t += step;
        }
        Segment {
            u: Array2::zeros((samples - 1, 0)),
            x,
            dt,
            relative: None,
            ramp: None,
            of_inputs: Vec::new(),
            corrections: None,
        }
    }

    #[test]
    fn noise_is_found_to_a_few_percent_and_the_signal_below_it() {
        for uneven in [false, true] {
            for noise in [1e-4, 1e-2, 0.1] {
                let segment = wave(noise, 400, uneven);
                let clean = wave(0.0, 400, uneven);
                let floor = [1e-12; 2];
                let signals = Smoother::new(&[segment], &[Some(1), None], &floor, &|| true).signals(&floor);
                for i in 0..2 {
                    let ratio = signals.sigma[i] / noise;
                    // Of a ten-thousandth a smooth process takes a part for itself.
                    let least = if noise < 1e-3 { 0.4 } else { 0.85 };
                    assert!((least..1.15).contains(&ratio), "{uneven} {noise} {i}: {ratio}");
                    let left = (&signals.x[0].column(i) - &clean.x.column(i)).mapv(|v| v * v).mean();
                    let left = left.expect("samples").sqrt();
                    assert!(left < 1.1 * noise, "{noise} {i}: {left}");
                }
                let slope = (&signals.x_dot[0].column(0) - &clean.x.column(1)).mapv(|v| v * v).mean();
                assert!(slope.expect("samples").sqrt() < 1.1 * noise, "the rate is measured too");
            }
        }
    }

    #[test]
    fn without_noise_the_samples_are_kept() {
        let clean = wave(0.0, 200, false);
        let floor = [1e-12; 2];
        let signals = Smoother::new(std::slice::from_ref(&clean), &[None, None], &floor, &|| true).signals(&floor);
        for i in 0..2 {
            assert!(signals.sigma[i] < 2e-5, "{:?}", signals.sigma);
            let left = (&signals.x[0].column(i) - &clean.x.column(i)).mapv(f64::abs);
            assert!(left.iter().all(|v| *v < 2e-5), "{left}");
        }
    }
}
