//! Adam, with the target network's average taken along in the same pass.

use serde::{Deserialize, Serialize};

use sindyna_core::vectorized;

const DECAY_MEAN: f64 = 0.9;
const DECAY_SQUARE: f64 = 0.999;
const EPSILON: f64 = 1e-8;

/// The optimiser of one parameter vector.
///
/// m ← m + (1-β₁)(g - m), v ← β₂ v + (1-β₂) g², p ← p - η/(1-β₁ᵗ) · m / (√v/√(1-β₂ᵗ) + ε), with β₁ = 0.9,
/// β₂ = 0.999, ε = 1e-8, as PyTorch's `Adam`.
///
/// # Deviations
/// 1. Moments below 1e-30 are zero: units that no longer fire would leave subnormal numbers behind for ever, and
///    arithmetic on those is many times slower.
///
/// # References
/// Kingma, Ba (2015), arXiv:1412.6980, Algorithm 1.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Adam {
    pub(crate) learning_rate: f64,
    pub(crate) step: u64,
    pub(crate) mean: Vec<f32>,
    pub(crate) square: Vec<f32>,
}

/// The numbers of one step that are the same for every parameter.
#[derive(Clone, Copy)]
struct Step {
    size: f32,
    inverse_root: f32,
}

impl Adam {
    /// An optimiser of `n_params` parameters that has not moved yet.
    pub(crate) fn new(n_params: usize, learning_rate: f64) -> Self {
        Self { learning_rate, step: 0, mean: vec![0.0; n_params], square: vec![0.0; n_params] }
    }

    /// Moves `params` against `gradients`.
    pub(crate) fn step(&mut self, params: &mut [f32], gradients: &[f32]) {
        let step = self.advance();
        vectorized(
            #[inline(always)]
            || {
                let moments = self.mean.iter_mut().zip(&mut self.square);
                for ((p, g), (m, v)) in params.iter_mut().zip(gradients).zip(moments) {
                    *p = step.moved(*p, *g, m, v);
                }
            },
        );
    }

    /// [`Self::step`], and `target` ← `target` + `polyak`·(`params` - `target`) with the parameters after it.
    pub(crate) fn step_and_track(&mut self, params: &mut [f32], gradients: &[f32], target: &mut [f32], polyak: f64) {
        let step = self.advance();
        let polyak = polyak as f32;
        vectorized(
            #[inline(always)]
            || {
                let moments = self.mean.iter_mut().zip(&mut self.square);
                for (((p, g), (m, v)), t) in params.iter_mut().zip(gradients).zip(moments).zip(target) {
                    *p = step.moved(*p, *g, m, v);
                    *t += polyak * (*p - *t);
                }
            },
        );
    }

    /// [`Self::step`] for the gradient of a loss to which c/2 ‖p‖² is added, part by part: `parts` says how many parameters
    /// come next and their c.
    pub(crate) fn step_decaying(
        &mut self,
        params: &mut [f32],
        gradients: &[f32],
        parts: impl Iterator<Item = (usize, f64)>,
    ) {
        let step = self.advance();
        let mut at = 0;
        for (len, decay) in parts {
            let (part, decay) = (at..at + len, decay as f32);
            let (params, gradients) = (&mut params[part.clone()], &gradients[part.clone()]);
            let (mean, square) = (&mut self.mean[part.clone()], &mut self.square[part]);
            vectorized(
                #[inline(always)]
                || {
                    for ((p, g), (m, v)) in params.iter_mut().zip(gradients).zip(mean.iter_mut().zip(square)) {
                        *p = step.moved(*p, *g + decay * *p, m, v);
                    }
                },
            );
            at += len;
        }
        debug_assert_eq!(at, params.len(), "the parts are all there is");
    }

    fn advance(&mut self) -> Step {
        self.step += 1;
        let (mean, square) = bias_corrections(self.step);
        Step { size: (self.learning_rate / mean) as f32, inverse_root: (1.0 / square.sqrt()) as f32 }
    }
}

impl Step {
    #[inline(always)]
    fn moved(self, p: f32, g: f32, m: &mut f32, v: &mut f32) -> f32 {
        const FLOOR: f32 = 1e-30;
        let mean = *m + (1.0 - DECAY_MEAN) as f32 * (g - *m);
        let square = DECAY_SQUARE as f32 * *v + (1.0 - DECAY_SQUARE) as f32 * g * g;
        *m = if mean.abs() < FLOOR { 0.0 } else { mean };
        *v = if square < FLOOR { 0.0 } else { square };
        p - self.size * *m / (v.sqrt() * self.inverse_root + EPSILON as f32)
    }
}

/// 1 - β₁ᵗ and 1 - β₂ᵗ.
fn bias_corrections(step: u64) -> (f64, f64) {
    let t = step as f64;
    (1.0 - DECAY_MEAN.powf(t), 1.0 - DECAY_SQUARE.powf(t))
}

/// Adam for a single number, in double precision.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct ScalarAdam {
    pub(crate) learning_rate: f64,
    pub(crate) step: u64,
    pub(crate) mean: f64,
    pub(crate) square: f64,
}

impl ScalarAdam {
    /// An optimiser that has not moved yet.
    pub(crate) fn new(learning_rate: f64) -> Self {
        Self { learning_rate, step: 0, mean: 0.0, square: 0.0 }
    }

    /// Moves `param` against `gradient`.
    pub(crate) fn step(&mut self, param: &mut f64, gradient: f64) {
        self.step += 1;
        self.mean += (1.0 - DECAY_MEAN) * (gradient - self.mean);
        self.square = DECAY_SQUARE * self.square + (1.0 - DECAY_SQUARE) * gradient * gradient;
        let (mean, square) = bias_corrections(self.step);
        *param -= self.learning_rate / mean * self.mean / ((self.square / square).sqrt() + EPSILON);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Adam written down plainly, in double precision.
    fn reference(steps: &[f64], learning_rate: f64) -> f64 {
        let (mut p, mut m, mut v) = (0.5, 0.0, 0.0);
        for (t, g) in (1..).zip(steps) {
            m = 0.9 * m + 0.1 * g;
            v = 0.999 * v + 0.001 * g * g;
            let (m_hat, v_hat) = (m / (1.0 - 0.9_f64.powi(t)), v / (1.0 - 0.999_f64.powi(t)));
            p -= learning_rate * m_hat / (v_hat.sqrt() + 1e-8);
        }
        p
    }

    #[test]
    fn both_optimisers_follow_the_algorithm() {
        for gradients in [[1.0, -2.0, 0.5, 0.1], [1e-9, 3e-9, -1e-8, 0.0], [100.0, 1e-6, 0.0, -5.0]] {
            let (mut scalar, mut number) = (ScalarAdam::new(0.01), 0.5);
            let (mut vector, mut params) = (Adam::new(5, 0.01), [0.5; 5]);
            for g in gradients {
                scalar.step(&mut number, g);
                vector.step(&mut params, &[g as f32; 5]);
            }
            let truth = reference(&gradients, 0.01);
            assert!((number - truth).abs() < 1e-15, "{number} {truth}");
            assert!(params.iter().all(|p| (f64::from(*p) - truth).abs() < 2e-7), "{params:?} {truth}");
        }
    }

    #[test]
    fn the_target_follows_the_parameters_after_their_step() {
        let (mut plain, mut tracked) = (Adam::new(1, 0.1), Adam::new(1, 0.1));
        let (mut p, mut q, mut target) = ([1.0], [1.0], [3.0]);
        plain.step(&mut p, &[2.0]);
        tracked.step_and_track(&mut q, &[2.0], &mut target, 0.25);
        assert_eq!(p, q);
        assert!((target[0] - (0.75 * 3.0 + 0.25 * p[0])).abs() < 1e-6);
    }

    #[test]
    fn decay_adds_to_the_gradient_of_its_part() {
        let (mut plain, mut decaying) = (Adam::new(3, 0.1), Adam::new(3, 0.1));
        let (mut p, mut q) = ([1.0, -2.0, 3.0], [1.0, -2.0, 3.0]);
        for _ in 0..3 {
            let gradients = [0.5 + 2.0 * p[0], 0.5 + 2.0 * p[1], 0.5];
            plain.step(&mut p, &gradients);
            decaying.step_decaying(&mut q, &[0.5; 3], [(2, 2.0), (1, 0.0)].into_iter());
            assert_eq!(p, q);
        }
    }

    #[test]
    fn a_unit_that_fell_silent_leaves_no_subnormal_numbers() {
        let (mut adam, mut p) = (Adam::new(1, 0.1), [1.0]);
        adam.step(&mut p, &[1.0]);
        for _ in 0..2000 {
            adam.step(&mut p, &[0.0]);
        }
        assert_eq!(adam.mean, [0.0]);
        assert!(adam.square[0].is_normal());
    }
}
