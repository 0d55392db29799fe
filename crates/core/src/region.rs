//! The box in which models are compared with their systems.

use rand::RngExt as _;

use crate::{Channel, Kind, Rng, Spec};

/// A box in state space: the declared bounds where a channel has them, else its declared typical magnitude. Angles without bounds are free.
///
/// It is for judging models, over the same states whatever was learned from; learners know nothing of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Region {
    limits: Vec<(f64, f64)>,
    free: Vec<bool>,
}

impl Region {
    /// The box of the system `spec` declares.
    #[must_use]
    pub fn of(spec: &Spec) -> Self {
        let limits = spec.state.iter().map(|channel| {
            if channel.is_bounded() {
                return channel.prior.bounds;
            }
            if turns_freely(spec, channel) {
                return (-std::f64::consts::PI, std::f64::consts::PI);
            }
            (channel.prior.bounds.0.max(-channel.prior.scale), channel.prior.bounds.1.min(channel.prior.scale))
        });
        Self { limits: limits.collect(), free: spec.state.iter().map(|c| turns_freely(spec, c)).collect() }
    }

    /// Whether `x` (n) lies inside, borders included.
    #[must_use]
    pub fn contains(&self, x: &[f64]) -> bool {
        x.iter().zip(&self.limits).zip(&self.free).all(|((v, (low, high)), free)| *free || (low..=high).contains(&v))
    }

    /// Moves `x` (n) to the nearest place inside.
    pub fn clamp(&self, x: &mut [f64]) {
        for ((v, &(low, high)), free) in x.iter_mut().zip(&self.limits).zip(&self.free) {
            if !free {
                *v = v.clamp(low, high);
            }
        }
    }

    /// Draws a state uniformly into `x` (n).
    pub fn sample(&self, rng: &mut Rng, x: &mut [f64]) {
        for (v, &(low, high)) in x.iter_mut().zip(&self.limits) {
            *v = rng.random_range(low..=high);
        }
    }
}

/// An angle without bounds that is seen only through its cosine and sine: one turn of it is all there is.
pub(crate) fn turns_freely(spec: &Spec, channel: &Channel) -> bool {
    let shown = spec.observation.iter().any(|o| o.name == channel.name);
    channel.kind == Kind::Angle && !channel.is_bounded() && !shown
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Precision, Seed, Space};

    #[test]
    fn declared_bounds_win_and_sizes_limit_the_rest() {
        let x = Channel::new("x", "m", Kind::Plain, 2.5);
        let v = Channel::new("v", "m/s", Kind::RateOf(0), 1.0).within(-0.07, 0.07);
        let angle = Channel::new("θ", "rad", Kind::Angle, 1.0);
        let cosine = Channel::new("cos θ", "", Kind::CosOf(2), 1.0);
        let spec = Spec {
            name: "any".into(),
            state: vec![x.clone(), v.clone(), angle],
            observation: vec![x, v, cosine],
            control: vec![],
            action_space: Space::Box { low: vec![], high: vec![] },
            precision: Precision::F64,
            noise: 0.0,
            dt: 0.1,
        };
        let region = Region::of(&spec);
        assert!(region.contains(&[2.4, 0.07, 40.0]), "hidden angles are free");
        assert!(!region.contains(&[2.6, 0.0, 0.0]) && !region.contains(&[0.0, 0.08, 0.0]));
        let (mut drawn, mut rng) = ([0.0; 3], Seed::new(1).numpy());
        for _ in 0..100 {
            region.sample(&mut rng, &mut drawn);
            assert!(region.contains(&drawn) && drawn[2].abs() <= std::f64::consts::PI);
        }
    }
}
