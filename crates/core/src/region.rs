//! Where a learned model may be believed.

use rand::RngExt as _;

use crate::{Channel, Kind, Rng};

/// A box in state space: the declared bounds where a channel has them, else the larger of its typical magnitude and
/// what the data reached. Angles without bounds are free.
///
/// Imagined rollouts that leave it are ended, because a model is worth nothing where it was never compared with the
/// system; and start states beyond the task's own are drawn from it.
#[derive(Debug, Clone, PartialEq)]
pub struct Region {
    limits: Vec<(f64, f64)>,
    free: Vec<bool>,
}

impl Region {
    /// The region of `channels` (n) around the visited `states` (rows of n values).
    pub fn new<'a>(channels: &[Channel], states: impl IntoIterator<Item = &'a [f64]>) -> Self {
        let mut reach: Vec<f64> = channels.iter().map(|c| c.scale).collect();
        for x in states {
            for (r, v) in reach.iter_mut().zip(x) {
                *r = r.max(v.abs());
            }
        }
        let limits = channels.iter().zip(&reach).map(|(c, &r)| match c.kind {
            _ if c.is_bounded() => c.bounds,
            Kind::Angle => (-std::f64::consts::PI, std::f64::consts::PI),
            _ => (c.bounds.0.max(-r), c.bounds.1.min(r)),
        });
        let free = channels.iter().map(|c| c.kind == Kind::Angle && !c.is_bounded()).collect();
        Self { limits: limits.collect(), free }
    }

    /// Whether `x` (n) lies inside, borders included.
    #[must_use]
    pub fn contains(&self, x: &[f64]) -> bool {
        x.iter().zip(&self.limits).zip(&self.free).all(|((v, (low, high)), free)| *free || (low..=high).contains(&v))
    }

    /// Draws a state uniformly into `x` (n).
    pub fn sample(&self, rng: &mut Rng, x: &mut [f64]) {
        for (v, &(low, high)) in x.iter_mut().zip(&self.limits) {
            *v = rng.random_range(low..=high);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Seed;

    #[test]
    fn declared_bounds_win_and_data_widen_the_rest() {
        let channels = [
            Channel::new("x", "m", Kind::Plain, 1.0),
            Channel::new("v", "m/s", Kind::RateOf(0), 1.0).within(-0.07, 0.07),
            Channel::new("θ", "rad", Kind::Angle, 1.0),
        ];
        let region = Region::new(&channels, [[-2.5, 5.0, 0.0].as_slice()]);
        assert!(region.contains(&[2.4, 0.07, 40.0]), "2.5 m was visited and angles are free");
        assert!(!region.contains(&[2.6, 0.0, 0.0]));
        assert!(!region.contains(&[0.0, 0.08, 0.0]));
        let mut x = [0.0; 3];
        let mut rng = Seed::new(1).numpy();
        for _ in 0..100 {
            region.sample(&mut rng, &mut x);
            assert!(region.contains(&x) && x[2].abs() <= std::f64::consts::PI);
        }
    }
}
