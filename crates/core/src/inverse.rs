//! The state behind an observation.

use crate::turning::unwrapped;
use crate::{Channel, Kind, Spec};

/// How one state is read from an observation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Source {
    Shown(usize),
    Turned { cosine: usize, sine: usize },
}

/// o → x for sensors that show all of the state: the inverse of what [`Sensors`](crate::Sensors) without noise and rounding do.
///
/// A state shown under its own name is that channel; else its cosine and sine are put together to an angle.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Inverse {
    sources: Vec<Source>,
}

impl Inverse {
    /// The inverse for the channels of `spec`.
    ///
    /// # Errors
    /// [`Unseen`] if a state follows from no observation.
    pub fn of(spec: &Spec) -> Result<Self, Unseen> {
        let at = |kind| spec.observation.iter().position(|o| o.kind == kind);
        let source = |(i, state): (usize, &Channel)| {
            let shown = spec.observation.iter().position(|o| o.name == state.name);
            match (shown, at(Kind::CosOf(i)), at(Kind::SinOf(i))) {
                (Some(at), _, _) => Ok(Source::Shown(at)),
                (None, Some(cosine), Some(sine)) => Ok(Source::Turned { cosine, sine }),
                _ => Err(Unseen { state: state.name.clone() }),
            }
        };
        Ok(Self { sources: spec.state.iter().enumerate().map(source).collect::<Result<_, _>>()? })
    }

    /// Number of states n.
    #[must_use]
    pub fn n_states(&self) -> usize {
        self.sources.len()
    }

    /// Writes the state `x` (n) that `o` (m) shows; angles put together are as near to those of `near` (n) as whole turns allow.
    pub fn state(&self, o: &[f64], near: &[f64], x: &mut [f64]) {
        for ((x, source), near) in x.iter_mut().zip(&self.sources).zip(near) {
            *x = match *source {
                Source::Shown(at) => o[at],
                Source::Turned { cosine, sine } => {
                    let angle = o[sine].atan2(o[cosine]);
                    unwrapped(angle, *near)
                }
            };
        }
    }
}

/// A state that follows from no observation.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("no observation shows the state `{state}`, nor do a cosine and a sine of it")]
pub struct Unseen {
    /// Its name.
    pub state: String,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Observe as _, Precision, Seed, Sensors, Space};

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
            precision: Precision::F64,
            noise: 0.0,
            dt: 0.1,
        }
    }

    #[test]
    fn a_state_survives_its_observation_also_after_many_turns() {
        let (inverse, sensors) =
            (Inverse::of(&spec()).expect("all is shown"), Sensors::new(&spec()).expect("all known"));
        let mut rng = Seed::new(0).numpy();
        for theta in [-40.0, -3.2, 0.0, 3.0, 3.3, 100.0] {
            let (x, mut o, mut back) = ([theta, 0.3], [0.0; 3], [0.0; 2]);
            sensors.observe(&x, &mut rng, &mut o);
            inverse.state(&o, &[theta + 0.4, 0.0], &mut back);
            assert!((back[0] - theta).abs() < 1e-12 && back[1] == 0.3, "{theta}: {back:?}");
        }
    }

    #[test]
    fn states_nobody_sees_are_named() {
        let mut blind = spec();
        blind.observation.remove(1);
        assert_eq!(Inverse::of(&blind), Err(Unseen { state: "θ".into() }));
    }
}
