//! A network that sees observations scaled: what every policy is, before its outputs mean anything.

use ndarray::ArrayView2;

use crate::{Scaling, mlp::Mlp};

/// A network and how the observations are scaled before it sees them.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ScaledNet {
    pub(crate) net: Mlp,
    pub(crate) scaling: Scaling,
}

impl ScaledNet {
    /// The network's outputs (B, outputs) for `observations` (B, m), row by row the same bits on every machine.
    ///
    /// # Panics
    /// If `observations` are not as wide as the scaling.
    pub(crate) fn heads(&self, observations: ArrayView2<'_, f64>) -> Vec<f32> {
        assert_eq!(observations.ncols(), self.scaling.width(), "observed values");
        let mut inputs = vec![0.0; observations.len()];
        self.scaling.apply(observations, &mut inputs);
        let mut heads = vec![0.0; observations.nrows() * self.net.outputs()];
        self.net.evaluate_rows(&inputs, &mut heads);
        heads
    }

    /// Weights (inputs, outputs) and biases (outputs) of layer `l`; `None` beyond the last.
    pub(crate) fn layer(&self, l: usize) -> Option<(&[f32], &[f32])> {
        (l < self.net.depth()).then(|| self.net.layer(l).of(&self.net.params))
    }
}
