//! Where a model is believed.

use std::sync::Arc;

use sindyna_core::{Dynamics, Rng, Seed, Support};

/// Where a learned model is believed: near the data that it was compared with, and where the models that the data allow agree.
///
/// All that depends on it asks here: what a step far from the data is charged, where a rollout ends because nobody follows the model any further, when a policy
/// works too far from the data for its prediction to be trusted, where rollouts begin that need not begin where episodes do, and what data to collect next.
pub struct Trust {
    support: Support,
    /// Models as likely as each other, stepped coarsely where they can be.
    models: Vec<Arc<dyn Dynamics>>,
    /// The likeliest of them, stepped so.
    model: Arc<dyn Dynamics>,
    /// Standard deviation to which the next of each state is measured.
    precision: Vec<f64>,
    /// What a step infinitely far from the data costs.
    penalty: f64,
}

/// What steps tell of which of the models is right: Σ Aᵀ A (models × models), by rows.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Evidence(Vec<f64>);

impl Evidence {
    /// ln det(I + Σ Aᵀ A / M): what is known of which of M models is right.
    pub(crate) fn known(&self) -> f64 {
        let m = (self.0.len() as f64).sqrt() as usize;
        let mut factor = vec![0.0; m * m];
        let mut known = 0.0;
        for i in 0..m {
            for j in 0..=i {
                let before: f64 = (0..j).map(|k| factor[i * m + k] * factor[j * m + k]).sum();
                let value = self.0[i * m + j] / m as f64 + if i == j { 1.0 } else { 0.0 } - before;
                factor[i * m + j] =
                    if i == j { value.max(f64::MIN_POSITIVE).sqrt() } else { value / factor[j * m + j] };
            }
            known += 2.0 * factor[i * m + i].ln();
        }
        known
    }
}

/// Models that are told apart, at most.
const TOLD_APART: usize = 16;

/// What no sensor measures better: a part of the standard deviation of a state over the data.
const FINE: f64 = 1e-4;

/// What is made of a step in the model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Judged {
    /// It ended where the model is followed: how far from the data, 0 for not at all and 1 for infinitely, and what that costs.
    Followed { away: f64, charge: f64 },
    /// It went where nobody follows the model.
    Beyond,
}

/// Mean distance from the data (`away`) from which a policy is far: a tenth of the time far outside.
const FAR: f64 = 0.1;

impl Trust {
    /// Trust in `models`, as likely as each other, that were compared with a system on `support`; a step infinitely far from it costs `penalty`.
    pub(crate) fn new(
        support: Support,
        (model, models): (Arc<dyn Dynamics>, Vec<Arc<dyn Dynamics>>),
        noise: Option<Vec<f64>>,
        penalty: f64,
    ) -> Self {
        // The state before was measured as well.
        let deviations = support.deviations();
        let precision = deviations.iter().enumerate().map(|(i, d)| {
            let noise = noise.as_ref().map_or(0.0, |noise| noise[i]);
            (2.0_f64.sqrt() * noise).max(FINE * d)
        });
        let precision = precision.collect();
        // Thousands of plans are compared, before every few real steps.
        let coarse = |model: Arc<dyn Dynamics>| model.coarse().unwrap_or(model);
        let (model, models) = (coarse(model), models.into_iter().map(coarse).collect());
        Self { support, model, models, precision, penalty }
    }

    /// Nothing was seen yet.
    pub(crate) fn no_evidence(&self) -> Evidence {
        let m = self.models.len().min(TOLD_APART);
        Evidence(vec![0.0; m * m])
    }

    /// Adds what a step with the control `u` (k) from the state `x` (n) tells to `evidence`; where it leads in the likeliest model, or nothing if it goes where nobody
    /// follows the models.
    pub(crate) fn observe(&self, x: &[f64], u: &[f64], evidence: &mut Evidence) -> Option<Vec<f64>> {
        let (n, m) = (x.len(), self.models.len().min(TOLD_APART));
        let mut rng = Seed::new(0).stream("disagreement", 0);
        let mut ends = vec![0.0; n * m];
        for (end, model) in ends.chunks_mut(n).zip(&self.models) {
            model.step(x, u, &mut rng, end).ok()?;
        }
        for i in 0..n {
            let mean = (0..m).map(|k| ends[k * n + i]).sum::<f64>() / m as f64;
            (0..m).for_each(|k| ends[k * n + i] = (ends[k * n + i] - mean) / self.precision[i]);
        }
        for a in 0..m {
            for b in 0..m {
                evidence.0[a * m + b] +=
                    ends[a * n..(a + 1) * n].iter().zip(&ends[b * n..(b + 1) * n]).map(|(a, b)| a * b).sum::<f64>();
            }
        }
        let mut next = vec![0.0; n];
        self.model.step(x, u, &mut rng, &mut next).ok()?;
        self.support.contains(&next).then_some(next)
    }

    /// Whether there are models to be told apart.
    pub(crate) fn has_alternatives(&self) -> bool {
        self.models.len() > 1
    }

    /// Where the data were.
    #[must_use]
    pub fn support(&self) -> &Support {
        &self.support
    }

    /// How much the models disagree on where the control `u` (k) leads from the state `x` (n): the root mean square distance of their next states from the
    /// mean of these, in whitened coordinates of the data. 0 for a model without rivals, infinite where one of them diverges.
    #[must_use]
    pub fn disagreement(&self, x: &[f64], u: &[f64]) -> f64 {
        // Learned equations draw nothing.
        let (mut rng, mut next) = (Seed::new(0).stream("disagreement", 0), vec![0.0; x.len()]);
        let mut ends = Vec::with_capacity(self.models.len());
        for model in &self.models {
            if model.step(x, u, &mut rng, &mut next).is_err() {
                return f64::INFINITY;
            }
            ends.push(next.clone());
        }
        let count = ends.len().max(1) as f64;
        let mean: Vec<f64> = (0..x.len()).map(|i| ends.iter().map(|e| e[i]).sum::<f64>() / count).collect();
        let length = |e: &Vec<f64>| self.support.length(e.iter().zip(&mean).map(|(e, mean)| e - mean));
        (ends.iter().map(|e| length(e).powi(2)).sum::<f64>() / count).sqrt()
    }

    /// What is made of a step to `next` (n).
    pub(crate) fn judge(&self, next: &[f64]) -> Judged {
        if !self.support.contains(next) {
            return Judged::Beyond;
        }
        let excess = self.support.excess(next);
        let away = excess / (1.0 + excess);
        Judged::Followed { away, charge: self.penalty * away }
    }

    /// Moves `x` (n) to the nearest place to which the models are followed.
    pub(crate) fn clamp(&self, x: &mut [f64]) {
        self.support.clamp(x);
    }

    /// Draws a state to begin a rollout in, anywhere in and around the data.
    pub(crate) fn draw(&self, rng: &mut Rng, x: &mut [f64]) {
        self.support.draw(rng, x);
    }

    /// Whether a policy whose steps were so far `away` on average works where the model was hardly compared with the system.
    pub(crate) fn is_far(away: f64) -> bool {
        away > FAR
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sindyna_core::{Dataset, Diverged};

    /// x' = x + gain u.
    struct Push(f64);

    impl Dynamics for Push {
        fn step(&self, x: &[f64], u: &[f64], _rng: &mut Rng, next: &mut [f64]) -> Result<(), Diverged> {
            next[0] = x[0] + self.0 * u[0];
            Diverged::check(next)
        }
    }

    /// Data from −2 to 2, with the deviation √2, so that the support is ±4.
    fn trust(gains: &[f64]) -> Trust {
        let spec = crate::one_state::spec();
        let mut data = Dataset::new(1, 1, 1, 0.1);
        data.begin(&[-2.0]).expect("finite");
        for x in [-1.0, 0.0, 1.0, 2.0] {
            data.push(&[1.0], &[1.0], 0.0, &[x]).expect("finite");
        }
        let models = gains.iter().map(|gain| Arc::new(Push(*gain)) as Arc<dyn Dynamics>);
        let models: Vec<_> = models.collect();
        Trust::new(Support::of(&spec, &data, &[]), (models[0].clone(), models), None, 8.0)
    }

    #[test]
    fn steps_are_charged_by_their_distance_until_nobody_follows() {
        let trust = trust(&[1.0]);
        assert_eq!(trust.judge(&[4.0]), Judged::Followed { away: 0.0, charge: 0.0 });
        assert_eq!(trust.judge(&[8.0]), Judged::Followed { away: 0.5, charge: 4.0 });
        assert_eq!(trust.judge(&[121.0]), Judged::Beyond);
        let mut far = [121.0];
        trust.clamp(&mut far);
        assert!(matches!(trust.judge(&far), Judged::Followed { .. }));
        assert!(Trust::is_far(0.5) && !Trust::is_far(0.0));
    }

    #[test]
    fn models_disagree_by_what_they_say_differently() {
        assert!(trust(&[1.0]).disagreement(&[0.0], &[1.0]) < f64::EPSILON);
        let two = trust(&[0.9, 1.1]);
        assert!(two.disagreement(&[0.0], &[0.0]) < f64::EPSILON, "without a push both say the same");
        let (small, large) = (two.disagreement(&[0.0], &[0.5]), two.disagreement(&[0.0], &[1.0]));
        assert!(
            (large - 0.1 / 2.0_f64.sqrt()).abs() < 1e-12 && (large - 2.0 * small).abs() < 1e-12,
            "{small}, {large}"
        );
        assert!(trust(&[1.0, f64::NAN]).disagreement(&[0.0], &[1.0]).is_infinite());
    }
}
