//! Start states of a task: how each state is drawn, and which draws count.

use std::f64::consts::{PI, TAU};

use rand::RngExt as _;
use rand_distr::{Distribution as _, StandardNormal};
use sindyna_core::{Channel, Kind, Prior, Rng, Spec};

use super::condition::Condition;

/// Draws after which the last one counts whatever it is. Where less than a hundredth of all draws count, a task is refused.
const MOST_DRAWS: usize = 10_000;

/// Draws from which the share of those that count is estimated.
const TRIED: usize = 1_000;

/// How the start value of one state is drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Start {
    /// Uniformly between two values.
    Uniform(f64, f64),
    /// From a normal distribution with a mean and a standard deviation, within the bounds of the state.
    Normal(f64, f64),
}

/// Start states.
#[derive(Debug, Clone)]
pub(super) struct Starts {
    /// One for each state.
    each: Vec<Start>,
    /// Samples of start states from which the range of each state was estimated; `None` where it is known.
    samples: Vec<Option<usize>>,
    /// Over x.
    condition: Option<Condition>,
    /// Bounds of each state.
    bounds: Vec<(f64, f64)>,
}

impl Starts {
    pub(super) fn new(spec: &Spec, each: Vec<Start>, condition: Option<Condition>) -> Self {
        let bounds = spec.state.iter().map(|channel| channel.prior.bounds).collect();
        Self { samples: vec![None; each.len()], each, condition, bounds }
    }

    /// The same with uniform ranges that are estimates from so many `samples` (n).
    pub(super) fn estimated(self, samples: Vec<Option<usize>>) -> Self {
        Self { samples, ..self }
    }

    /// Draws a state (n) into `x`.
    pub(super) fn draw(&self, rng: &mut Rng, x: &mut [f64]) {
        for _ in 0..MOST_DRAWS {
            self.draw_once(rng, x);
            if self.counts(x) {
                break;
            }
        }
    }

    fn draw_once(&self, rng: &mut Rng, x: &mut [f64]) {
        for (value, start) in x.iter_mut().zip(&self.each) {
            *value = match *start {
                Start::Uniform(low, high) => rng.random_range(low..=high),
                Start::Normal(mean, deviation) => {
                    let unit: f64 = StandardNormal.sample(rng);
                    mean + deviation * unit
                }
            };
        }
    }

    fn counts(&self, x: &[f64]) -> bool {
        let normal = self.each.iter().zip(x).zip(&self.bounds);
        let mut normal = normal.filter(|((start, _), _)| matches!(start, Start::Normal(..)));
        normal.all(|((_, value), (low, high))| (low..=high).contains(&value))
            && self.condition.as_ref().is_none_or(|condition| condition.holds(x))
    }

    /// The share of all draws that count, estimated.
    pub(super) fn share(&self, rng: &mut Rng) -> f64 {
        let mut x = vec![0.0; self.each.len()];
        let counted = (0..TRIED).filter(|_| {
            self.draw_once(rng, &mut x);
            self.counts(&x)
        });
        counted.count() as f64 / TRIED as f64
    }

    /// The same with ranges drawn from their posterior; `None` where all are known.
    ///
    /// The range W of n samples of a uniform distribution on \[a, b\] has the posterior W / (b − a) ~ Beta(n − 1, 2) under the prior 1 / (b − a), which is the
    /// second largest of n uniform numbers; what b − a has more is anywhere on both sides.
    pub(super) fn drawn(&self, spec: &Spec, rng: &mut Rng) -> Option<Self> {
        let mut drawn = self.clone();
        let mut differs = false;
        for (i, samples) in self.samples.iter().enumerate() {
            let Start::Uniform(low, high) = self.each[i] else { continue };
            let Some(n) = samples.filter(|n| *n > 2 && high > low).map(|n| n as f64) else { continue };
            differs = true;
            let (middle, seen) = (0.5 * (low + high), (high - low) * (n - 1.0) / (n + 1.0));
            let share = rng.random::<f64>().powf(1.0 / n) * rng.random::<f64>().powf(1.0 / (n - 1.0));
            let (more, left) = (seen * (1.0 / share - 1.0), rng.random::<f64>());
            let Channel { kind, prior: Prior { bounds, .. }, .. } = spec.state[i];
            let range = (middle - 0.5 * seen - left * more, middle + 0.5 * seen + (1.0 - left) * more);
            let turn = kind == Kind::Angle && range.1 - range.0 > TAU;
            let (low, high) = if turn { (-PI, PI) } else { (range.0.max(bounds.0), range.1.min(bounds.1)) };
            drawn.each[i] = Start::Uniform(low, high);
        }
        differs.then_some(drawn)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sindyna_core::{Precision, Seed, Space};

    fn spec(bounds: (f64, f64)) -> Spec {
        let channel = |name: &str| Channel::new(name, "", Kind::Plain, 1.0);
        let state = vec![channel("x").within(bounds.0, bounds.1), channel("y")];
        Spec {
            name: "any".into(),
            observation: state.clone(),
            state,
            control: vec![Channel::new("u", "", Kind::Plain, 1.0)],
            action_space: Space::Box { low: vec![-1.0], high: vec![1.0] },
            precision: Precision::F64,
            noise: 0.0,
            dt: 0.1,
        }
    }

    /// Mean and standard deviation of each of two states over many draws.
    fn moments(starts: &Starts) -> [(f64, f64); 2] {
        let (n, mut rng, mut x) = (20_000, Seed::new(5).numpy(), [0.0; 2]);
        let drawn: Vec<[f64; 2]> = (0..n)
            .map(|_| {
                starts.draw(&mut rng, &mut x);
                x
            })
            .collect();
        [0, 1].map(|i| {
            let mean = drawn.iter().map(|x| x[i]).sum::<f64>() / f64::from(n);
            let squares = drawn.iter().map(|x| (x[i] - mean).powi(2)).sum::<f64>();
            (mean, (squares / f64::from(n)).sqrt())
        })
    }

    #[test]
    fn start_values_have_the_moments_of_their_distributions() {
        let unbounded = spec((f64::NEG_INFINITY, f64::INFINITY));
        let starts = Starts::new(&unbounded, vec![Start::Normal(2.0, 0.5), Start::Uniform(-1.0, 3.0)], None);
        // Standard errors: 0.0035 and 0.0025; 0.008 and 0.004.
        let [x, y] = moments(&starts);
        assert!((x.0 - 2.0).abs() < 0.015 && (x.1 - 0.5).abs() < 0.01, "{x:?}");
        assert!((y.0 - 1.0).abs() < 0.035 && (y.1 - 4.0 / 12.0_f64.sqrt()).abs() < 0.02, "{y:?}");
        // Half of a normal distribution: mean σ √(2/π).
        let starts = Starts::new(&spec((0.0, 9.0)), vec![Start::Normal(0.0, 0.5), Start::Uniform(0.0, 0.0)], None);
        let [x, _] = moments(&starts);
        assert!((x.0 - 0.5 * (2.0 / PI).sqrt()).abs() < 0.01, "{x:?}");
    }

    #[test]
    fn states_that_do_not_count_are_drawn_again() {
        let names = ["x", "y"].map(String::from);
        let disc = Condition::parse("x^2 + y^2 <= 1", &names).unwrap();
        let unbounded = spec((f64::NEG_INFINITY, f64::INFINITY));
        let starts = Starts::new(&unbounded, vec![Start::Uniform(-1.0, 1.0); 2], Some(disc));
        let (mut rng, mut x) = (Seed::new(1).numpy(), [0.0; 2]);
        for _ in 0..1_000 {
            starts.draw(&mut rng, &mut x);
            assert!(x[0].hypot(x[1]) <= 1.0, "{x:?}");
        }
        // π/4, standard error 0.013.
        assert!((starts.share(&mut rng) - PI / 4.0).abs() < 0.05);
        // Each coordinate of a disc has the deviation 1/2.
        let [x, y] = moments(&starts);
        assert!((x.1 - 0.5).abs() < 0.01 && (y.1 - 0.5).abs() < 0.01, "{x:?} {y:?}");
    }

    #[test]
    fn ranges_drawn_hold_the_true_ones_as_often_as_their_posterior_says() {
        let mut rng = Seed::new(3).numpy();
        let (runs, n) = (2_000, 5);
        let mut below = 0;
        let spec = spec((f64::NEG_INFINITY, f64::INFINITY));
        for _ in 0..runs {
            let samples: Vec<f64> = (0..n).map(|_| rng.random_range(1.0..3.0)).collect();
            let (low, high) = samples.iter().fold((f64::MAX, f64::MIN), |(l, h), v| (v.min(l), v.max(h)));
            let wider = 0.5 * (high - low) * ((n + 1) as f64 / (n - 1) as f64 - 1.0);
            let each = vec![Start::Uniform(low - wider, high + wider), Start::Uniform(0.0, 0.0)];
            let estimated = Starts::new(&spec, each, None).estimated(vec![Some(n), Some(n)]);
            let drawn = estimated.drawn(&spec, &mut rng).unwrap();
            let Start::Uniform(from, to) = drawn.each[0] else { panic!("a range stays one") };
            assert!(from <= low && high <= to, "what was seen is possible");
            assert_eq!(drawn.each[1], Start::Uniform(0.0, 0.0), "what never differs stays");
            below += u32::from(to - from < 2.0);
        }
        // A width drawn from the posterior is below the true one every second time: both are as likely. Standard error 0.011.
        let share = f64::from(below) / f64::from(runs);
        assert!((share - 0.5).abs() < 0.04, "{share}");
        let known = Starts::new(&spec, vec![Start::Uniform(0.0, 1.0); 2], None);
        assert!(known.drawn(&spec, &mut rng).is_none(), "known ranges are");
    }
}
