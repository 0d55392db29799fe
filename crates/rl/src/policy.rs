//! A trained policy: all that is needed to act, and nothing that is only needed to learn.

use ndarray::{ArrayView2, ArrayViewMut2};
use rand_distr::{Distribution as _, StandardNormal};
use sindyna_core::{Mode, Policy, Rng};

use crate::{
    Scaling,
    gaussian::{squash, std_of},
    interface::ActionRange,
    scaled_net::ScaledNet,
};

/// A squashed Gaussian policy: network, scaling of the observations, range of the actions.
///
/// [`Mode::Exploit`] gives low + (tanh μ + 1)/2 · (high - low); [`Mode::Explore`] draws μ + σε in place of μ. An
/// observation's action depends neither on the other rows of its batch nor on the number of threads.
#[derive(Debug, Clone, PartialEq)]
pub struct GaussianPolicy {
    pub(crate) net: ScaledNet,
    pub(crate) range: ActionRange,
}

impl GaussianPolicy {
    /// Number of observed values m.
    #[must_use]
    pub fn observation_dim(&self) -> usize {
        self.net.scaling.width()
    }

    /// Number of action values k.
    #[must_use]
    pub fn action_dim(&self) -> usize {
        self.range.width()
    }

    /// How observations are scaled before the network sees them.
    #[must_use]
    pub fn scaling(&self) -> &Scaling {
        &self.net.scaling
    }

    /// Smallest actions (k).
    #[must_use]
    pub fn action_low(&self) -> &[f64] {
        self.range.low()
    }

    /// Largest actions (k).
    #[must_use]
    pub fn action_high(&self) -> &[f64] {
        self.range.high()
    }

    /// Widths of the network's layers, from the observation (m) to means and log standard deviations (2k).
    #[must_use]
    pub fn layer_sizes(&self) -> &[usize] {
        self.net.net.sizes()
    }

    /// Weights (inputs, outputs), row-major, and biases (outputs) of layer `l`, counted from the observation; `None`
    /// beyond the last. Every layer but the last is followed by ReLU.
    #[must_use]
    pub fn layer(&self, l: usize) -> Option<(&[f32], &[f32])> {
        self.net.layer(l)
    }
}

impl Policy for GaussianPolicy {
    /// # Panics
    /// If the widths of `observations` or `actions` are not the policy's, or their rows differ in number.
    fn act_batch(
        &self,
        observations: ArrayView2<'_, f64>,
        mode: Mode,
        rng: &mut Rng,
        mut actions: ArrayViewMut2<'_, f64>,
    ) {
        let k = self.action_dim();
        assert_eq!(actions.dim(), (observations.nrows(), k), "rows and values of the actions");
        let heads = self.net.heads(observations);
        for (head, mut action) in heads.chunks_exact(2 * k).zip(actions.rows_mut()) {
            for (j, a) in action.iter_mut().enumerate() {
                let mut u = f64::from(head[j]);
                if mode == Mode::Explore {
                    let noise: f64 = StandardNormal.sample(rng);
                    u += std_of(head[k + j]) * noise;
                }
                *a = self.range.to_world(j, squash(u).0);
            }
        }
    }
}
