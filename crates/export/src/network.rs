//! A policy as numbers.

use sindyna_rl::SavedPolicy;

/// A network with what stands before and after it.
pub struct Network {
    /// Subtracted from each observed value (m).
    pub(super) center: Vec<f64>,
    /// What the difference is divided by (m).
    pub(super) scale: Vec<f64>,
    pub(super) layers: Vec<Layer>,
    pub(super) head: Head,
}

/// Weights (inputs, outputs), row-major, and biases (outputs); every layer but the last is followed by ReLU.
pub(super) struct Layer {
    pub(super) inputs: usize,
    pub(super) outputs: usize,
    pub(super) weights: Vec<f32>,
    pub(super) biases: Vec<f32>,
}

/// What the outputs mean.
pub(super) enum Head {
    /// The first (k) are actions before tanh, which goes from `low` to `high`.
    Squashed { low: Vec<f64>, high: Vec<f64> },
    /// The largest is that of the action taken.
    Largest,
}

impl Network {
    pub(super) fn of(policy: &SavedPolicy) -> Self {
        let (sizes, head) = match policy {
            SavedPolicy::Gaussian(p) => {
                (p.layer_sizes(), Head::Squashed { low: p.action_low().to_vec(), high: p.action_high().to_vec() })
            }
            SavedPolicy::Categorical(p) => (p.layer_sizes(), Head::Largest),
        };
        let parts = |l: usize| match policy {
            SavedPolicy::Gaussian(p) => p.layer(l),
            SavedPolicy::Categorical(p) => p.layer(l),
        };
        let layer = |(l, pair): (usize, &[usize])| {
            let (weights, biases) = parts(l)?;
            Some(Layer { inputs: pair[0], outputs: pair[1], weights: weights.to_vec(), biases: biases.to_vec() })
        };
        let mut layers: Vec<Layer> = sizes.windows(2).enumerate().filter_map(layer).collect();
        if let (Head::Squashed { low, .. }, Some(last)) = (&head, layers.last_mut()) {
            // Deviations are for learning alone.
            last.keep(low.len());
        }
        let scaling = policy.scaling();
        Self { center: scaling.center.clone(), scale: scaling.scale.clone(), layers, head }
    }

    /// Observed values m.
    pub(super) fn observed(&self) -> usize {
        self.center.len()
    }

    /// Values of an action.
    pub(super) fn actions(&self) -> usize {
        match &self.head {
            Head::Squashed { low, .. } => low.len(),
            Head::Largest => 1,
        }
    }

    /// Values that the last layer gives.
    pub(super) fn outputs(&self) -> usize {
        self.layers.last().map_or(0, |layer| layer.outputs)
    }

    /// The widest layer, observations among them.
    pub(super) fn widest(&self) -> usize {
        self.layers.iter().flat_map(|layer| [layer.inputs, layer.outputs]).max().unwrap_or(0)
    }
}

impl Layer {
    /// Leaves the first `outputs` alone.
    fn keep(&mut self, outputs: usize) {
        let all = self.outputs;
        let kept = self.weights.chunks(all).flat_map(|row| row.iter().take(outputs).copied()).collect();
        (self.weights, self.outputs) = (kept, outputs);
        self.biases.truncate(outputs);
    }
}
