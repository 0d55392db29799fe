//! Between the task's state and the observations the networks know.

use sindyna_core::{Inverse, Observe as _, Precision, Rng, Sensors, Spec};

use super::EnsembleError;

/// x → o without the sensors' noise and rounding, and o → x.
#[derive(Debug, Clone)]
pub(super) struct Coordinates {
    exact: Sensors,
    inverse: Inverse,
}

impl Coordinates {
    /// The coordinates of `spec`.
    pub(super) fn new(spec: &Spec) -> Result<Self, EnsembleError> {
        let mut exact = spec.clone();
        (exact.noise, exact.precision) = (0.0, Precision::F64);
        let exact = Sensors::new(&exact).ok_or_else(|| EnsembleError::Unknown { task: spec.name.clone() })?;
        Ok(Self { exact, inverse: Inverse::of(spec)? })
    }

    /// Writes the exact observation `o` (m) of the state `x` (n). `rng` is not drawn from.
    pub(super) fn observe(&self, x: &[f64], rng: &mut Rng, o: &mut [f64]) {
        self.exact.observe(x, rng, o);
    }

    /// Writes the state `next` (n) that `o` (m) shows; angles are as near to those of `x` (n) as whole turns allow.
    pub(super) fn state(&self, o: &[f64], x: &[f64], next: &mut [f64]) {
        self.inverse.state(o, x, next);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sindyna_core::{Channel, Kind, Seed, Space};

    #[test]
    fn declared_noise_and_rounding_are_left_out() {
        let spec = Spec {
            name: "any".into(),
            state: vec![Channel::new("x", "m", Kind::Plain, 1.0)],
            observation: vec![Channel::new("x", "m", Kind::Plain, 1.0)],
            control: vec![],
            action_space: Space::Box { low: vec![], high: vec![] },
            precision: Precision::F32,
            noise: 0.1,
            dt: 0.1,
        };
        let coordinates = Coordinates::new(&spec).expect("all states are shown");
        let mut rng = Seed::new(0).numpy();
        let (before, mut o, mut back) = (rng.clone(), [0.0], [0.0]);
        coordinates.observe(&[0.1], &mut rng, &mut o);
        coordinates.state(&o, &[0.0], &mut back);
        assert_eq!((o, back), ([0.1], [0.1]));
        assert_eq!(rng, before, "no noise is drawn");
    }
}
