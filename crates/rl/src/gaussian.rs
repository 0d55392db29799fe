//! The squashed Gaussian: a = tanh(μ + σε), its log-density, and their gradients.

/// Range of log σ, as in the reference implementations.
const LOG_STD: (f64, f64) = (-20.0, 2.0);

/// Keeps log(1 - a² + …) finite when tanh saturates.
const SQUASH_FLOOR: f64 = 1e-6;

const HALF_LOG_TAU: f64 = 0.918_938_533_204_672_8;

/// Actions drawn from a head, and what their gradients need. Rows B, action values k.
///
/// A head row is (μ₁…μₖ, log σ₁…log σₖ) with log σ clamped to -20..2, and
/// log π(a) = Σⱼ log N(uⱼ; μⱼ, σⱼ) - log(1 - aⱼ² + 1e-6), u = μ + σε, a = tanh u. The density is that of the action
/// in -1..1, whatever its range in the world.
///
/// # Deviations
/// 1. 1 - a² is computed from u as 1/cosh²u, in f64: as a difference of f32 numbers it would lose all its digits
///    where tanh saturates.
///
/// # References
/// Haarnoja et al. (2018), arXiv:1801.01290, appendix C.
#[derive(Debug, Clone, Default)]
pub(crate) struct Squashed {
    /// The actions (B, k), in -1..1.
    pub(crate) actions: Vec<f32>,
    /// log π of each row (B).
    pub(crate) log_probs: Vec<f64>,
    elements: Vec<Element>,
}

#[derive(Debug, Clone, Copy)]
struct Element {
    action: f64,
    /// ∂a/∂u.
    slope: f64,
    /// ∂u/∂log σ = σε; 0 where log σ is clamped.
    d_log_std: f64,
    /// ∂log π/∂log σ without its way through a; 0 where log σ is clamped.
    d_density: f64,
}

impl Squashed {
    /// Draws one action per row of `head` (B, 2k) with the standard normal numbers `noise` (B, k).
    pub(crate) fn draw(&mut self, head: &[f32], noise: &[f64], n_actions: usize) {
        debug_assert_eq!(head.len(), 2 * noise.len());
        self.actions.clear();
        self.log_probs.clear();
        self.elements.clear();
        for (head, noise) in head.chunks_exact(2 * n_actions).zip(noise.chunks_exact(n_actions)) {
            let (means, log_stds) = head.split_at(n_actions);
            let mut log_prob = 0.0;
            for ((mean, log_std), e) in means.iter().zip(log_stds).zip(noise) {
                let (mean, raw) = (f64::from(*mean), f64::from(*log_std));
                let log_std = raw.clamp(LOG_STD.0, LOG_STD.1);
                let spread = log_std.exp() * e;
                let (action, slope) = squash(mean + spread);
                log_prob -= 0.5 * e * e + log_std + HALF_LOG_TAU + (slope + SQUASH_FLOOR).ln();
                let free = if (LOG_STD.0..=LOG_STD.1).contains(&raw) { 1.0 } else { 0.0 };
                self.elements.push(Element { action, slope, d_log_std: free * spread, d_density: -free });
                self.actions.push(action as f32);
            }
            self.log_probs.push(log_prob);
        }
    }

    /// ∂L/∂head (B, 2k), given ∂L/∂a `d_actions` (B, k) and ∂L/∂log π, the same number for every row.
    pub(crate) fn backward(&self, d_actions: &[f32], d_log_prob: f64, n_actions: usize, d_head: &mut Vec<f32>) {
        let rows = d_actions.len() / n_actions;
        d_head.resize(2 * d_actions.len(), 0.0);
        let elements = self.elements[..rows * n_actions].chunks_exact(n_actions);
        let grads = d_head.chunks_exact_mut(2 * n_actions).zip(d_actions.chunks_exact(n_actions));
        for (row, (d_head, d_actions)) in elements.zip(grads) {
            let (d_means, d_log_stds) = d_head.split_at_mut(n_actions);
            for (j, e) in row.iter().enumerate() {
                // log π depends on u only through -log(1 - a² + 1e-6): the Gaussian part is a function of ε and σ.
                let d_squash = 2.0 * e.action * e.slope / (e.slope + SQUASH_FLOOR);
                let d_u = f64::from(d_actions[j]) * e.slope + d_log_prob * d_squash;
                d_means[j] = d_u as f32;
                d_log_stds[j] = (d_u * e.d_log_std + d_log_prob * e.d_density) as f32;
            }
        }
    }
}

/// tanh u, to 1e-16, and 1 - tanh²u, to full precision also where tanh saturates.
pub(crate) fn squash(u: f64) -> (f64, f64) {
    let e = (-2.0 * u.abs()).exp();
    let inverse = 1.0 / (1.0 + e);
    (((1.0 - e) * inverse).copysign(u), 4.0 * e * inverse * inverse)
}

/// The spread of a head's action: σ of its clamped logarithm.
pub(crate) fn std_of(log_std: f32) -> f64 {
    f64::from(log_std).clamp(LOG_STD.0, LOG_STD.1).exp()
}
