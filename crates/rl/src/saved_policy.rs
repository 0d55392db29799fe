//! A policy from a file, whichever kind it is of.

use ndarray::{ArrayView2, ArrayViewMut2};
use sindyna_core::{Mode, Policy, Rng, TrainedPolicy};

use crate::{
    CategoricalPolicy, GaussianPolicy, PolicyFileError, Scaling,
    policy_file::{CATEGORICAL, GAUSSIAN, declared_format},
};

/// One of the policies that can be written to a file.
#[derive(Debug, Clone, PartialEq)]
pub enum SavedPolicy {
    /// Of real actions.
    Gaussian(GaussianPolicy),
    /// Of numbered actions.
    Categorical(CategoricalPolicy),
}

impl SavedPolicy {
    /// The policy as a safetensors file; equal policies give equal bytes.
    #[must_use]
    pub fn to_safetensors(&self) -> Vec<u8> {
        match self {
            Self::Gaussian(policy) => policy.to_safetensors(),
            Self::Categorical(policy) => policy.to_safetensors(),
        }
    }

    /// The policy of a file made by any policy's `to_safetensors`.
    ///
    /// # Errors
    /// [`PolicyFileError`] if the bytes are no such file, whatever is wrong with them.
    pub fn from_safetensors(bytes: &[u8]) -> Result<Self, PolicyFileError> {
        match declared_format(bytes)? {
            Some(format) if format == GAUSSIAN => GaussianPolicy::from_safetensors(bytes).map(Self::Gaussian),
            Some(format) if format == CATEGORICAL => CategoricalPolicy::from_safetensors(bytes).map(Self::Categorical),
            found => Err(PolicyFileError::Format { found }),
        }
    }

    /// Number of observed values m.
    #[must_use]
    pub fn observation_dim(&self) -> usize {
        self.scaling().width()
    }

    /// Number of values in one action: 1, the number of the action, where actions are numbered.
    #[must_use]
    pub fn action_dim(&self) -> usize {
        match self {
            Self::Gaussian(policy) => policy.action_dim(),
            Self::Categorical(_) => 1,
        }
    }

    /// How observations are scaled before the network sees them.
    #[must_use]
    pub fn scaling(&self) -> &Scaling {
        match self {
            Self::Gaussian(policy) => policy.scaling(),
            Self::Categorical(policy) => policy.scaling(),
        }
    }
}

impl From<GaussianPolicy> for SavedPolicy {
    fn from(policy: GaussianPolicy) -> Self {
        Self::Gaussian(policy)
    }
}

impl From<CategoricalPolicy> for SavedPolicy {
    fn from(policy: CategoricalPolicy) -> Self {
        Self::Categorical(policy)
    }
}

impl Policy for SavedPolicy {
    /// # Panics
    /// If the widths of `observations` or `actions` are not the policy's, or their rows differ in number.
    fn act_batch(&self, observations: ArrayView2<'_, f64>, mode: Mode, rng: &mut Rng, actions: ArrayViewMut2<'_, f64>) {
        match self {
            Self::Gaussian(policy) => policy.act_batch(observations, mode, rng, actions),
            Self::Categorical(policy) => policy.act_batch(observations, mode, rng, actions),
        }
    }
}

impl TrainedPolicy for SavedPolicy {
    fn to_bytes(&self) -> Vec<u8> {
        self.to_safetensors()
    }
}

impl TrainedPolicy for GaussianPolicy {
    fn to_bytes(&self) -> Vec<u8> {
        self.to_safetensors()
    }
}

impl TrainedPolicy for CategoricalPolicy {
    fn to_bytes(&self) -> Vec<u8> {
        self.to_safetensors()
    }
}
