//! What sensors show of a state.

use std::fmt;
use std::sync::Arc;

use rand_distr::{Distribution as _, StandardNormal};

use crate::{Kind, Precision, Rng, Spec};

/// o = h(x), with the sensors' rounding and noise.
pub trait Observe: Send + Sync {
    /// Writes the observation `o` of state `x`.
    fn observe(&self, x: &[f64], rng: &mut Rng, o: &mut [f64]);
}

impl<H: Observe + ?Sized> Observe for &H {
    fn observe(&self, x: &[f64], rng: &mut Rng, o: &mut [f64]) {
        (**self).observe(x, rng, o);
    }
}

impl<H: Observe + ?Sized> Observe for Arc<H> {
    fn observe(&self, x: &[f64], rng: &mut Rng, o: &mut [f64]) {
        (**self).observe(x, rng, o);
    }
}

/// A function of the state x (n).
pub type Computed = Arc<dyn Fn(&[f64]) -> f64 + Send + Sync>;

#[derive(Clone)]
enum Reading {
    Direct(usize),
    Cosine(usize),
    Sine(usize),
    Computed(Computed),
}

impl Reading {
    /// Without noise and rounding.
    fn of(&self, x: &[f64]) -> f64 {
        match self {
            Self::Direct(i) => x[*i],
            Self::Cosine(i) => x[*i].cos(),
            Self::Sine(i) => x[*i].sin(),
            Self::Computed(function) => function(x),
        }
    }
}

impl fmt::Debug for Reading {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Direct(i) => write!(f, "Direct({i})"),
            Self::Cosine(i) => write!(f, "Cosine({i})"),
            Self::Sine(i) => write!(f, "Sine({i})"),
            Self::Computed(_) => write!(f, "Computed"),
        }
    }
}

/// The sensors a [`Spec`] declares: states, or cosines and sines of them, with Gaussian noise of the declared standard
/// deviation, rounded to the declared precision.
///
/// Noise is independent from channel to channel and from step to step. Where none is declared, no random number is
/// drawn. A noisy reading may lie beyond the declared bounds of its channel.
#[derive(Debug, Clone)]
pub struct Sensors {
    readings: Vec<Reading>,
    /// Standard deviation of each reading; empty for sensors without noise.
    deviations: Vec<f64>,
    precision: Precision,
}

impl Sensors {
    /// The sensors of `spec`; `None` if an observation channel names no state.
    #[must_use]
    pub fn new(spec: &Spec) -> Option<Self> {
        Self::computing(spec, &[])
    }

    /// The same where observation channels that name no state are functions of the state, called by these names.
    #[must_use]
    pub fn computing(spec: &Spec, functions: &[(String, Computed)]) -> Option<Self> {
        let computed = |name: &String| functions.iter().find(|(known, _)| known == name).map(|(_, f)| f.clone());
        let readings = spec.observation.iter().map(|channel| match channel.kind {
            Kind::CosOf(i) => (i < spec.state_dim()).then_some(Reading::Cosine(i)),
            Kind::SinOf(i) => (i < spec.state_dim()).then_some(Reading::Sine(i)),
            _ => {
                let state = spec.state.iter().position(|s| s.name == channel.name).map(Reading::Direct);
                state.or_else(|| computed(&channel.name).map(Reading::Computed))
            }
        });
        let deviations = if spec.noise > 0.0 { spec.noise_deviations().collect() } else { Vec::new() };
        Some(Self { readings: readings.collect::<Option<_>>()?, deviations, precision: spec.precision })
    }

    /// Standard deviations of the noise (m); none for sensors without noise.
    #[must_use]
    pub fn deviations(&self) -> &[f64] {
        &self.deviations
    }

    /// The same sensors without noise.
    #[must_use]
    pub fn without_noise(&self) -> Self {
        Self { deviations: Vec::new(), ..self.clone() }
    }

    /// The same sensors with noise of the standard `deviations` (m); without any if all are 0.
    #[must_use]
    pub fn with_noise(mut self, deviations: &[f64]) -> Self {
        self.deviations = if deviations.iter().all(|d| *d == 0.0) { Vec::new() } else { deviations.to_vec() };
        self
    }
}

impl Observe for Sensors {
    fn observe(&self, x: &[f64], rng: &mut Rng, o: &mut [f64]) {
        for (value, reading) in o.iter_mut().zip(&self.readings) {
            *value = reading.of(x);
        }
        for (value, deviation) in o.iter_mut().zip(&self.deviations) {
            let normal: f64 = StandardNormal.sample(rng);
            *value += deviation * normal;
        }
        if self.precision == Precision::F32 {
            for value in o {
                *value = f64::from(*value as f32);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Channel, Seed, Space};

    /// x of scale 2, θ of scale 0.5 seen as its cosine.
    fn spec(noise: f64, precision: Precision) -> Spec {
        let x = Channel::new("x", "m", Kind::Plain, 2.0);
        Spec {
            name: "any".into(),
            state: vec![x.clone(), Channel::new("θ", "rad", Kind::Angle, 0.5)],
            observation: vec![x, Channel::new("cos θ", "", Kind::CosOf(1), 1.0)],
            control: vec![],
            action_space: Space::Box { low: vec![], high: vec![] },
            precision,
            noise,
            dt: 0.1,
        }
    }

    fn observe(noise: f64, precision: Precision, rng: &mut Rng) -> [f64; 2] {
        let sensors = Sensors::new(&spec(noise, precision)).expect("every channel shows a state");
        let mut o = [0.0; 2];
        sensors.observe(&[0.3, 0.7], rng, &mut o);
        o
    }

    #[test]
    fn values_may_be_computed_from_states() {
        let mut spec = spec(0.0, Precision::F64);
        spec.observation.push(Channel::new("x + 2 θ", "", Kind::Plain, 1.0));
        assert!(Sensors::new(&spec).is_none(), "no state is called so");
        let sum: Computed = Arc::new(|x: &[f64]| x[0] + 2.0 * x[1]);
        let sensors = Sensors::computing(&spec, &[("x + 2 θ".into(), sum)]).expect("all are known");
        let mut o = [0.0; 3];
        sensors.observe(&[0.3, 0.7], &mut Seed::new(0).numpy(), &mut o);
        assert_eq!(o, [0.3, 0.7_f64.cos(), 1.7]);
    }

    #[test]
    fn sensors_without_noise_draw_nothing() {
        let mut rng = Seed::new(0).numpy();
        let before = rng.clone();
        assert_eq!(observe(0.0, Precision::F64, &mut rng), [0.3, 0.7_f64.cos()]);
        assert_eq!(observe(0.0, Precision::F32, &mut rng), [0.3, 0.7_f64.cos()].map(|v| f64::from(v as f32)));
        assert_eq!(rng, before);
    }

    #[test]
    fn noise_is_gaussian_of_the_declared_share_of_each_scale() {
        const N: usize = 100_000;
        let mut rng = Seed::new(1).numpy();
        let (mut sums, mut squares, mut products, mut beyond) = ([0.0; 2], [0.0; 2], 0.0, 0);
        for _ in 0..N {
            let o = observe(0.1, Precision::F64, &mut rng);
            let z = [(o[0] - 0.3) / 0.2, (o[1] - 0.7_f64.cos()) / 0.1];
            for i in 0..2 {
                sums[i] += z[i];
                squares[i] += z[i] * z[i];
            }
            products += z[0] * z[1];
            beyond += usize::from(z[0].abs() > 1.96);
        }
        let n = N as f64;
        // Standard errors: 0.003 for means and correlation, 0.0045 for variances, 0.0007 for the share.
        for i in 0..2 {
            assert!((sums[i] / n).abs() < 0.015, "mean {}", sums[i] / n);
            assert!((squares[i] / n - 1.0).abs() < 0.02, "variance {}", squares[i] / n);
        }
        assert!((products / n).abs() < 0.015, "channels are independent: {}", products / n);
        assert!((beyond as f64 / n - 0.05).abs() < 0.004, "a Gaussian lies beyond 1.96 σ one time in 20: {beyond}");
    }

    #[test]
    fn one_seed_one_noise_and_rounding_comes_after_it() {
        let seeded = |seed, precision| observe(0.1, precision, &mut Seed::new(seed).numpy());
        assert_eq!(seeded(3, Precision::F64), seeded(3, Precision::F64));
        assert_ne!(seeded(3, Precision::F64), seeded(4, Precision::F64));
        assert_eq!(seeded(3, Precision::F32), seeded(3, Precision::F64).map(|v| f64::from(v as f32)));
    }
}
