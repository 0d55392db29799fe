//! Soft actor-critic on small networks.
//!
//! [`Sac`] is an [`Agent`](sindyna_core::Agent) for real actions, [`SacDiscrete`] one for numbered actions. The
//! [`GaussianPolicy`] or [`CategoricalPolicy`] they hand over is all that is needed to act, and can be written to a file;
//! [`SavedPolicy`] reads either. Networks are f32 inside and f64 at the border; an update is
//! single-threaded and after the first allocates nothing, so independent runs scale with the cores.
//!
//! [`EnsembleLearner`] learns the model of MBPO on the same kernels: probabilistic networks in observation space.
//!
//! ```
//! use sindyna_core::{Agent as _, Batch, Seed};
//! use sindyna_rl::{Sac, SacConfig, Scaling};
//!
//! let mut rng = Seed::new(0).stream("example", 0);
//! // Three observed values, one action from −2 to 2.
//! let mut agent = Sac::new(SacConfig::default(), Scaling::identity(3), &[-2.0], &[2.0], &mut rng)?;
//! agent.update(&Batch::zeros(64, 3, 1), &mut rng)?;
//! let policy = agent.policy();
//! # drop(policy);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Not here: data (replay belongs to core), environments, models, loops, files on disk.

#![cfg_attr(test, allow(clippy::float_cmp, reason = "where tests compare exactly, the bits are the claim"))]

mod adam;
mod affine;
mod buffer;
mod categorical;
mod categorical_policy;
mod checkpoint;
mod columns;
mod config;
mod critic;
mod ensemble;
mod gaussian;
mod interface;
mod isa;
mod kernel;
mod learner;
mod mlp;
mod pass;
mod policy;
mod policy_file;
mod real;
mod sac;
mod sac_discrete;
mod saved_policy;
mod scaled_net;
mod temperature;
#[cfg(test)]
mod tests;
mod thin;

pub use categorical_policy::CategoricalPolicy;
pub use config::{SacConfig, SacError};
pub use ensemble::{
    Activation, Ensemble, EnsembleConfig, EnsembleError, EnsembleLearner, EnsembleModel, EnsembleTrainer, FitReport,
    Prediction, RewardHead, TargetScale,
};
pub use interface::Scaling;
pub use isa::{Isa, IsaError};
pub use learner::Losses;
pub use policy::GaussianPolicy;
pub use policy_file::PolicyFileError;
pub use sac::Sac;
pub use sac_discrete::SacDiscrete;
pub use saved_policy::SavedPolicy;
