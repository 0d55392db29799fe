//! The squashed Gaussian: a = tanh(μ + σε), its log-density, and their gradients.

use sindyna_core::vectorized;

use crate::real;

/// Range of log σ, as in the reference implementations.
const LOG_STD: (f64, f64) = (-20.0, 2.0);

/// Keeps log(1 - a² + …) finite when tanh saturates.
const SQUASH_FLOOR: f64 = 1e-6;

const HALF_LOG_TAU: f64 = 0.918_938_533_204_672_8;

/// Actions drawn from a head, and what their gradients need. Rows B, action values k.
///
/// A head row is (μ₁…μₖ, log σ₁…log σₖ) with log σ clamped to -20..2, and
/// log π(a) = Σⱼ log N(uⱼ; μⱼ, σⱼ) - log(1 - aⱼ² + 1e-6), u = μ + σε, a = tanh u. The density is that of the action
/// in -1..1, whatever its range in the environment.
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
    elements: Elements,
}

/// What is kept of every action value (B k), each in a vector of its own, so that the arithmetic is vector code.
#[derive(Debug, Clone, Default)]
struct Elements {
    mean: Vec<f64>,
    /// log σ before it is clamped.
    log_std: Vec<f64>,
    /// The action before it is squashed.
    u: Vec<f64>,
    action: Vec<f64>,
    /// ∂a/∂u.
    slope: Vec<f64>,
    /// ∂u/∂log σ = σε; 0 where log σ is clamped.
    d_log_std: Vec<f64>,
    /// ∂log π/∂log σ without its way through a; 0 where log σ is clamped.
    d_density: Vec<f64>,
    /// The value's part of -log π.
    surprise: Vec<f64>,
}

impl Elements {
    fn resize(&mut self, n: usize) {
        let Self { mean, log_std, u, action, slope, d_log_std, d_density, surprise } = self;
        for values in [mean, log_std, u, action, slope, d_log_std, d_density, surprise] {
            values.resize(n, 0.0);
        }
    }

    /// All from means, log σ and `noise`.
    fn draw(&mut self, noise: &[f64]) {
        let n = noise.len();
        let (mean, raw) = (&self.mean[..n], &self.log_std[..n]);
        let (action, slope) = (&mut self.action[..n], &mut self.slope[..n]);
        let (d_log_std, d_density) = (&mut self.d_log_std[..n], &mut self.d_density[..n]);
        let (u, surprise) = (&mut self.u[..n], &mut self.surprise[..n]);
        vectorized(
            #[inline(always)]
            || {
                // Three short loops: of one long one too few turns would be under way at once.
                for i in 0..n {
                    let (e, raw) = (noise[i], raw[i]);
                    let log_std = if raw < LOG_STD.0 { LOG_STD.0 } else { raw };
                    let log_std = if log_std > LOG_STD.1 { LOG_STD.1 } else { log_std };
                    let free = if log_std.to_bits() == raw.to_bits() { 1.0 } else { 0.0 };
                    let spread = real::exp(log_std) * e;
                    u[i] = mean[i] + spread;
                    surprise[i] = 0.5 * e * e + log_std + HALF_LOG_TAU;
                    d_log_std[i] = free * spread;
                    d_density[i] = -free;
                }
                for i in 0..n {
                    (action[i], slope[i]) = squash_with(real::exp, u[i]);
                }
                for i in 0..n {
                    surprise[i] += real::ln(slope[i] + SQUASH_FLOOR);
                }
            },
        );
    }
}

impl Squashed {
    /// Draws one action per row of `head` (B, 2k) with the standard normal numbers `noise` (B, k).
    pub(crate) fn draw(&mut self, head: &[f32], noise: &[f64], n_actions: usize) {
        debug_assert_eq!(head.len(), 2 * noise.len());
        let elements = &mut self.elements;
        elements.resize(noise.len());
        let rows = elements.mean.chunks_exact_mut(n_actions).zip(elements.log_std.chunks_exact_mut(n_actions));
        for ((means, log_stds), head) in rows.zip(head.chunks_exact(2 * n_actions)) {
            let (head_means, head_log_stds) = head.split_at(n_actions);
            means.iter_mut().zip(head_means).for_each(|(v, h)| *v = f64::from(*h));
            log_stds.iter_mut().zip(head_log_stds).for_each(|(v, h)| *v = f64::from(*h));
        }
        elements.draw(noise);
        self.actions.clear();
        self.actions.extend(elements.action.iter().map(|a| *a as f32));
        self.log_probs.clear();
        self.log_probs.extend(elements.surprise.chunks_exact(n_actions).map(|row| -row.iter().sum::<f64>()));
    }

    /// ∂L/∂head (B, 2k), given ∂L/∂a `d_actions` (B, k) and ∂L/∂log π, the same number for every row.
    pub(crate) fn backward(&self, d_actions: &[f32], d_log_prob: f64, n_actions: usize, d_head: &mut Vec<f32>) {
        d_head.resize(2 * d_actions.len(), 0.0);
        let e = &self.elements;
        let rows = d_head.chunks_exact_mut(2 * n_actions).zip(d_actions.chunks_exact(n_actions));
        for (row, (d_head, d_actions)) in rows.enumerate() {
            let (d_means, d_log_stds) = d_head.split_at_mut(n_actions);
            for (j, d_action) in d_actions.iter().enumerate() {
                let i = row * n_actions + j;
                // log π depends on u only through -log(1 - a² + 1e-6): the Gaussian part is a function of ε and σ.
                let d_squash = 2.0 * e.action[i] * e.slope[i] / (e.slope[i] + SQUASH_FLOOR);
                let d_u = f64::from(*d_action) * e.slope[i] + d_log_prob * d_squash;
                d_means[j] = d_u as f32;
                d_log_stds[j] = (d_u * e.d_log_std[i] + d_log_prob * e.d_density[i]) as f32;
            }
        }
    }
}

/// tanh u, to 1e-16, and 1 - tanh²u, to full precision also where tanh saturates.
pub(crate) fn squash(u: f64) -> (f64, f64) {
    squash_with(f64::exp, u)
}

#[inline(always)]
fn squash_with(exp: impl Fn(f64) -> f64, u: f64) -> (f64, f64) {
    let e = exp(-2.0 * u.abs());
    let inverse = 1.0 / (1.0 + e);
    (((1.0 - e) * inverse).copysign(u), 4.0 * e * inverse * inverse)
}

/// The spread of a head's action: σ of its clamped logarithm.
pub(crate) fn std_of(log_std: f32) -> f64 {
    f64::from(log_std).clamp(LOG_STD.0, LOG_STD.1).exp()
}
