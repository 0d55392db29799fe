//! Soft actor-critic on small networks.
//!
//! [`Sac`] is an [`Agent`](sindyna_core::Agent) for continuous actions; the [`GaussianPolicy`] it hands over is all
//! that is needed to act, and can be written to a file. Networks are f32 inside and f64 at the border; an update is
//! single-threaded and allocates nothing that grows, so independent runs scale with the cores.
//!
//! Not here: data (replay belongs to core), environments, models, loops, files on disk.

#![cfg_attr(test, allow(clippy::float_cmp, reason = "where tests compare exactly, the bits are the claim"))]

mod adam;
mod affine;
mod config;
mod critic;
mod gaussian;
mod interface;
mod matmul;
mod mlp;
mod pass;
mod policy;
mod policy_file;
mod sac;
mod simd;
mod temperature;
#[cfg(test)]
mod tests;
mod thin;

pub use config::{SacConfig, SacError};
pub use interface::Scaling;
pub use policy::GaussianPolicy;
pub use policy_file::PolicyFileError;
pub use sac::Sac;
