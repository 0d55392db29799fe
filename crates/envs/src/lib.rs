//! The true systems of sindyna and the tasks on them: number for number those of Gymnasium 1.4, and a cart-pole to be
//! swung up.
//!
//! Every system comes in two parts that do not know each other: its *dynamics*, with all walls, friction and speed
//! limits, and its *task*: start states, reward, termination and what is declared about the channels. A learned
//! model takes the place of the dynamics; the task stays the same object.
//!
//! ```
//! use sindyna_core::{Environment as _, Seed};
//!
//! let pendulum = sindyna_envs::find("Pendulum-v1").expect("it is registered");
//! let mut env = pendulum.environment();
//! let mut rng = Seed::new(0).numpy();
//! env.reset(&mut rng)?;
//! let outcome = env.step(&[0.5], &mut rng)?;
//! assert!(outcome.reward < 0.0);
//! # Ok::<(), sindyna_core::EnvError>(())
//! ```
//!
//! Beside them stands a laboratory of systems without a task, [`fields`], for identification alone.
//!
//! Not here: anything learned, any policy, any file.
//!
//! # References
//! Towers et al. (2024), Gymnasium: a standard interface for reinforcement learning environments, arXiv:2407.17032.

#![cfg_attr(test, allow(clippy::float_cmp, reason = "tests compare exact numbers on purpose"))]

mod cart_pole;
mod cart_pole_swing_up;
mod float32;
mod inverted_pendulum;
mod laboratory;
mod mountain_car;
mod pendulum;
mod registry;
mod system;
mod uniform;

pub use laboratory::{fields, find_field};
pub use registry::{find, systems};
pub use system::System;
