//! Environments on the MuJoCo physics engine.
//!
//! Nothing of MuJoCo is needed to build this crate. A [`Search`] finds the shared library at run time (the one inside
//! the Python package does), [`Library`] loads and checks it, [`MujocoModel`] compiles an MJCF file, and
//! [`MujocoEnvironment`] puts a task on it, with a state that moves bit for bit as it does under Python.
//!
//! ```no_run
//! use sindyna_core::{Environment as _, Seed};
//! use sindyna_mujoco::{Library, Search, inverted_pendulum};
//!
//! let library = Library::load(&Search::from_environment())?;
//! let mut env = inverted_pendulum(&library)?;
//! let mut rng = Seed::new(0).numpy();
//! env.reset(&mut rng)?;
//! let outcome = env.step(&[0.1], &mut rng)?;
//! println!("{:?} earned {}", env.state(), outcome.reward);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! MuJoCo never takes the process down: its errors unwind into [`MujocoError`] or `EnvError`, and its warnings are
//! kept instead of printed and logged to a file. (A program compiled with `panic = "abort"` still stops at the rare
//! errors MuJoCo raises in the middle of a step, such as running out of the memory its model declares.)
//!
//! Not here: rewards and start states (tasks bring them), rendering, changing a model after it is compiled.
//!
//! # References
//! Todorov, Erez, Tassa (2012), MuJoCo: a physics engine for model-based control, IROS,
//! doi:10.1109/IROS.2012.6386109.

#![cfg_attr(test, allow(clippy::float_cmp, reason = "tests compare exact numbers on purpose"))]

mod compile;
mod elf;
mod environment;
mod error;
mod ffi;
mod inverted_pendulum;
mod library;
mod model;
mod probe;
mod search;
mod tree;

pub use environment::MujocoEnvironment;
pub use error::{Attempt, MujocoError};
pub use inverted_pendulum::{inverted_pendulum, inverted_pendulum_of};
pub use library::Library;
pub use model::MujocoModel;
pub use search::{Place, Search};
pub use tree::{Body, Joint, JointKind, Site, Tree};
