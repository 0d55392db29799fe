//! What sensors show of a state.

use std::sync::Arc;

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

#[derive(Debug, Clone, Copy)]
enum Reading {
    Direct(usize),
    Cosine(usize),
    Sine(usize),
}

/// The sensors a [`Spec`] declares: states, or cosines and sines of them, rounded to the declared precision.
#[derive(Debug, Clone)]
pub struct Sensors {
    readings: Vec<Reading>,
    precision: Precision,
}

impl Sensors {
    /// The sensors of `spec`; `None` if an observation channel names no state.
    #[must_use]
    pub fn new(spec: &Spec) -> Option<Self> {
        let readings = spec.observation.iter().map(|channel| match channel.kind {
            Kind::CosOf(i) => (i < spec.state_dim()).then_some(Reading::Cosine(i)),
            Kind::SinOf(i) => (i < spec.state_dim()).then_some(Reading::Sine(i)),
            _ => spec.state.iter().position(|s| s.name == channel.name).map(Reading::Direct),
        });
        Some(Self { readings: readings.collect::<Option<_>>()?, precision: spec.precision })
    }
}

impl Observe for Sensors {
    fn observe(&self, x: &[f64], _rng: &mut Rng, o: &mut [f64]) {
        for (value, reading) in o.iter_mut().zip(&self.readings) {
            let exact = match *reading {
                Reading::Direct(i) => x[i],
                Reading::Cosine(i) => x[i].cos(),
                Reading::Sine(i) => x[i].sin(),
            };
            *value = match self.precision {
                Precision::F32 => f64::from(exact as f32),
                Precision::F64 => exact,
            };
        }
    }
}
