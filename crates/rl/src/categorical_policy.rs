//! A trained policy over numbered actions.

use ndarray::{ArrayView2, ArrayViewMut2};
use rand::RngExt as _;
use sindyna_core::{Mode, Policy, Rng};

use crate::{Scaling, scaled_net::ScaledNet};

/// A policy over actions 0, 1, …, n - 1: network and scaling of the observations. An action is its number, as an f64.
///
/// [`Mode::Exploit`] gives the action of the largest output z, the lowest of equal ones; [`Mode::Explore`] draws from
/// π = softmax z, with one random number per observation. An observation's action depends neither on the other rows of
/// its batch nor on the number of threads. Outputs that are no number give NaN, which is no action.
#[derive(Debug, Clone, PartialEq)]
pub struct CategoricalPolicy {
    pub(crate) net: ScaledNet,
}

impl CategoricalPolicy {
    /// Number of observed values m.
    #[must_use]
    pub fn observation_dim(&self) -> usize {
        self.net.scaling.width()
    }

    /// Number of actions n.
    #[must_use]
    pub fn n_actions(&self) -> usize {
        self.net.net.outputs()
    }

    /// How observations are scaled before the network sees them.
    #[must_use]
    pub fn scaling(&self) -> &Scaling {
        &self.net.scaling
    }

    /// Widths of the network's layers, from the observation (m) to the outputs (n).
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

impl Policy for CategoricalPolicy {
    /// # Panics
    /// If the width of `observations` is not the policy's, or `actions` are not one value for each of them.
    fn act_batch(
        &self,
        observations: ArrayView2<'_, f64>,
        mode: Mode,
        rng: &mut Rng,
        mut actions: ArrayViewMut2<'_, f64>,
    ) {
        assert_eq!(actions.dim(), (observations.nrows(), 1), "rows and values of the actions");
        let heads = self.net.heads(observations);
        for (head, action) in heads.chunks_exact(self.n_actions()).zip(actions.iter_mut()) {
            let chosen = match mode {
                Mode::Exploit => Some(best(head)),
                Mode::Explore => draw(head, rng.random()),
            };
            let is_number = !head.iter().any(|z| z.is_nan());
            *action = chosen.filter(|_| is_number).map_or(f64::NAN, |a| a as f64);
        }
    }
}

/// The first of the largest outputs.
fn best(head: &[f32]) -> usize {
    (1..head.len()).fold(0, |best, a| if head[a] > head[best] { a } else { best })
}

/// The action whose part of 0..1, cut in proportion to exp z, holds `uniform`; `None` where the parts are no numbers.
fn draw(head: &[f32], uniform: f64) -> Option<usize> {
    let largest = f64::from(head[best(head)]);
    let weight = |z: &f32| (f64::from(*z) - largest).exp();
    let mut left = uniform * head.iter().map(weight).sum::<f64>();
    if !left.is_finite() {
        return None;
    }
    for (a, z) in head.iter().enumerate() {
        left -= weight(z);
        if left < 0.0 {
            return Some(a);
        }
    }
    // Rounding can leave a little; it belongs to the most probable action as well as to any.
    Some(best(head))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lowest_of_equal_actions_is_the_best() {
        assert_eq!([best(&[1.0, 1.0]), best(&[0.0, 2.0, 2.0]), best(&[-1.0, -3.0])], [0, 1, 0]);
    }

    #[test]
    fn actions_are_drawn_with_their_probability() {
        let head = [0.0, 3_f32.ln(), f32::NEG_INFINITY, 0.0];
        let mut counts = [0; 4];
        (0..1000).for_each(|i| counts[draw(&head, (f64::from(i) + 0.5) / 1000.0).expect("numbers")] += 1);
        assert_eq!(counts, [200, 600, 0, 200]);
        assert_eq!(draw(&[1e30, 0.0], 0.999), Some(0));
        assert_eq!(draw(&[f32::NAN, 0.0], 0.5), None);
        assert_eq!(draw(&[f32::INFINITY, 0.0], 0.5), None);
    }
}
