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
//! Not here: any physics, any regression, any network, any file, clock or terminal.

mod bounds;
mod checkpoint;
mod contract;
mod dataset;
mod dynamics;
mod environment;
mod event;
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

pub use bounds::Bounded;
pub use checkpoint::{Checkpoint, CheckpointError, decode, encode};
pub use contract::{ContractError, check_agent, check_dynamics, check_environment, check_spec};
pub use dataset::{Dataset, DatasetError, End, Rollout};
pub use dynamics::{Diverged, Dynamics, Held, Jacobians, Scheme, VectorField};
pub use environment::{EnvError, Environment, Outcome};
pub use event::{Event, Observer};
pub use inverse::{Inverse, Unseen};
pub use learner::{Certainty, DynamicsLearner, FitError, Knowledge, NoModel, Posterior};
pub use policy::{Agent, AgentError, Explorer, Mode, Policy, TrainedPolicy};
pub use region::Region;
pub use replay::{Batch, Replay, Transition};
pub use seed::{Rng, Seed};
pub use sensors::{Observe, Sensors};
pub use simulated::Simulated;
pub use spec::{Channel, Kind, Precision, Space, Spec};
pub use support::Support;
pub use task::{Redeclared, Task};
