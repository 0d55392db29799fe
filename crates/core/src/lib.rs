//! The nouns of sindyna: everything two crates need in order to meet without knowing each other.
//!
//! Data flows one way, `Environment → Dataset → DynamicsLearner → Simulated → Agent`, and each of those words
//! is a type or a trait here. Read [`Spec`], [`Dynamics`], [`Task`], [`Environment`], [`DynamicsLearner`],
//! [`Policy`] and [`Agent`] in that order and you know what every other crate implements.
//!
//! Two spaces are never mixed. The *state* x (f64, an angle is an angle) is where dynamics, reward and
//! termination live. The *observation* o is what sensors show (cosines, float32 rounding) and what policies see.
//! Likewise the *action* is what an agent chose and the *control* u what the system received.
//!
//! ```
//! use sindyna_core::{Dynamics as _, Held, Scheme, Seed, VectorField};
//!
//! /// A mass on a spring: ẋ = v, v̇ = u − 4 x.
//! struct Spring;
//! impl VectorField for Spring {
//!     fn eval(&self, x: &[f64], u: &[f64], x_dot: &mut [f64]) {
//!         x_dot.copy_from_slice(&[x[1], u[0] - 4.0 * x[0]]);
//!     }
//! }
//! let dynamics = Held::new(Spring, Scheme::Rk4 { substeps: 10 }, 0.1);
//! let mut next = [0.0; 2];
//! dynamics.step(&[1.0, 0.0], &[0.0], &mut Seed::new(0).stream("spring", 0), &mut next)?;
//! assert!((next[0] - 0.2_f64.cos()).abs() < 1e-9 && (next[1] + 2.0 * 0.2_f64.sin()).abs() < 1e-9);
//! # Ok::<(), sindyna_core::Diverged>(())
//! ```
//!
//! Not here: any physics, any regression, any network, any file, clock or terminal.

mod bounds;
mod checkpoint;
mod contract;
mod dataset;
mod dynamics;
mod environment;
mod event;
mod intersample;
mod inverse;
mod learner;
pub mod number;
mod policy;
mod region;
mod replay;
mod seed;
mod sensors;
mod simulated;
mod spec;
mod support;
mod task;
pub mod turning;
mod vectorized;
mod whitened;

pub use bounds::Bounded;
pub use checkpoint::{Checkpoint, CheckpointError, decode, encode};
pub use contract::{ContractError, check_agent, check_dynamics, check_environment, check_spec};
pub use dataset::{Dataset, DatasetError, End, Rollout};
pub use dynamics::{Diverged, Dynamics, Held, Jacobians, Scheme, VectorField};
pub use environment::{EnvError, Environment, Outcome};
pub use event::{Event, Observer};
pub use intersample::InterSample;
pub use inverse::{Inverse, Unseen};
pub use learner::{Certainty, DynamicsLearner, FitError, Knowledge, NoModel, Posterior};
pub use policy::{Acting, Agent, AgentError, Explorer, Memory, Mode, Policy, TrainedPolicy};
pub use region::Region;
pub use replay::{Batch, Replay, Transition};
pub use seed::{Rng, Seed};
pub use sensors::{Computed, Observe, Sensors};
pub use simulated::Simulated;
pub use spec::{Channel, Kind, Precision, Prior, Protocol, Space, Spec};
pub use support::Support;
pub use task::{Redeclared, Task};
pub use vectorized::vectorized;
