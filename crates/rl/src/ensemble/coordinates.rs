//! Between the task's state and the observations the networks know.

use std::f64::consts::TAU;

use sindyna_core::{Kind, Observe as _, Precision, Rng, Sensors, Spec};

use super::EnsembleError;

/// How one state is read from an observation.
#[derive(Debug, Clone, Copy)]
enum Source {
    Shown(usize),
    Turned { cosine: usize, sine: usize },
}

/// x → o without the sensors' noise and rounding, and o → x.
#[derive(Debug, Clone)]
pub(super) struct Coordinates {
    exact: Sensors,
    sources: Vec<Source>,
}

impl Coordinates {
    /// The coordinates of `spec`. A state shown under its own name is that channel; else its cosine and sine are put
    /// together to an angle.
    pub(super) fn new(spec: &Spec) -> Result<Self, EnsembleError> {
        let mut exact = spec.clone();
        (exact.noise, exact.precision) = (0.0, Precision::F64);
        let exact = Sensors::new(&exact).ok_or_else(|| EnsembleError::Unknown { task: spec.name.clone() })?;
        let at = |kind| spec.observation.iter().position(|o| o.kind == kind);
        let source = |(i, state): (usize, &sindyna_core::Channel)| {
            let shown = spec.observation.iter().position(|o| o.name == state.name);
            match (shown, at(Kind::CosOf(i)), at(Kind::SinOf(i))) {
                (Some(at), _, _) => Ok(Source::Shown(at)),
                (None, Some(cosine), Some(sine)) => Ok(Source::Turned { cosine, sine }),
                _ => Err(EnsembleError::Unseen { state: state.name.clone() }),
            }
        };
        Ok(Self { exact, sources: spec.state.iter().enumerate().map(source).collect::<Result<_, _>>()? })
    }

    /// Writes the exact observation `o` (m) of the state `x` (n). `rng` is not drawn from.
    pub(super) fn observe(&self, x: &[f64], rng: &mut Rng, o: &mut [f64]) {
        self.exact.observe(x, rng, o);
    }

    /// Writes the state `next` (n) that `o` (m) shows; angles are as near to those of `x` (n) as whole turns allow.
    pub(super) fn state(&self, o: &[f64], x: &[f64], next: &mut [f64]) {
        for ((next, source), x) in next.iter_mut().zip(&self.sources).zip(x) {
            *next = match *source {
                Source::Shown(at) => o[at],
                Source::Turned { cosine, sine } => {
                    let angle = o[sine].atan2(o[cosine]);
                    angle + TAU * ((x - angle) / TAU).round()
                }
            };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sindyna_core::{Channel, Seed, Space};

    fn spec() -> Spec {
        let rate = Channel::new("ω", "rad/s", Kind::RateOf(0), 1.0);
        Spec {
            name: "any".into(),
            state: vec![Channel::new("θ", "rad", Kind::Angle, 1.0), rate.clone()],
            observation: vec![
                Channel::new("cos θ", "", Kind::CosOf(0), 1.0),
                Channel::new("sin θ", "", Kind::SinOf(0), 1.0),
                rate,
            ],
            control: vec![],
            action_space: Space::Box { low: vec![], high: vec![] },
            precision: Precision::F32,
            noise: 0.1,
            dt: 0.1,
            max_steps: 10,
            solved_at: None,
        }
    }

    #[test]
    fn a_state_survives_its_observation_also_after_many_turns() {
        let coordinates = Coordinates::new(&spec()).expect("all states are shown");
        let mut rng = Seed::new(0).numpy();
        let before = rng.clone();
        for theta in [-40.0, -3.2, 0.0, 3.0, 3.3, 100.0] {
            let (x, mut o, mut back) = ([theta, 0.3], [0.0; 3], [0.0; 2]);
            coordinates.observe(&x, &mut rng, &mut o);
            coordinates.state(&o, &[theta + 0.4, 0.0], &mut back);
            assert!((back[0] - theta).abs() < 1e-12 && back[1] == 0.3, "{theta}: {back:?}");
        }
        assert_eq!(rng, before, "declared noise is not drawn");
    }

    #[test]
    fn states_nobody_sees_are_named() {
        let mut blind = spec();
        blind.observation.remove(1);
        assert_eq!(Coordinates::new(&blind).err(), Some(EnsembleError::Unseen { state: "θ".into() }));
    }
}
