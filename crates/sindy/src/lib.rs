//! Sparse identification of nonlinear dynamics (SINDy): equations of motion from little data.
//!
//! Data flows one way: rollouts → coordinates → target (ẋ, x⁺ or Δx/Δt) → library Θ → [`Triangle`] → solver →
//! [`Model`]. [`Identifier`] runs all of it for a system that a [`Spec`](sindyna_core::Spec) declares, [`Sindy`] for plain
//! arrays.
//!
//! ```
//! use ndarray::Array2;
//! use sindyna_sindy::{Identifier, Recording, Signals};
//!
//! // A decay, ẋ = −2 x, sampled every 0.01 s.
//! let x = Array2::from_shape_fn((200, 1), |(i, _)| (-2.0 * 0.01 * i as f64).exp());
//! let signals = Signals::new(&["x"], &[]);
//! let found = Identifier::of_signals(&signals, 0.01)?.identify_recordings(&[Recording::even(0.01, x, None)])?;
//! assert_eq!(found.model.equations(), ["x\u{307} = −2 x"]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Not here: agents, tasks, rewards; files, clocks, the terminal.

mod chain;
mod coordinates;
mod data;
mod design;
mod differentiate;
mod error;
mod estimate;
pub mod export;
mod expr;
mod identify;
mod library;
mod mechanics;
mod model;
mod motion;
mod names;
mod pieces;
mod plain;
mod regression;
mod shooting;
mod solve;
mod triangle;
mod watch;

pub use coordinates::CoordinateMode;
pub use data::LONGEST_CHAIN;
pub use differentiate::{Differentiated, Differentiator, FiniteDifference, SavitzkyGolay, TooShort};
pub use error::{InvalidParam, UnknownName};
pub use estimate::Doubt;
pub use expr::{Compiled, Expr, Function, ParseError, Pretty, Printed, parse};
pub use identify::{
    Derived, Disturbances, EquationConstraint, EquationConstraintError, EquationReport, Identified, Identifier,
    InsideParameter, LibraryChoice, Models, Noise, NoiseChoice, Recording, Refitted, Report, Signals, SignalsError,
    SolverChoice, Target,
};
pub use library::{Input, Library, LibraryError, Role, Term};
pub use model::{AnalysisError, Entry, Form, Inputs, Model, ModelError, ModelParts, Reading};
pub use plain::{Regressed, Sindy, SindyError, SindyFit, Trajectory};
pub use solve::{
    BestSubset, Bound, Columns, ConstraintError, Constraints, Finish, Path, Selected, Selection, SizeReport,
    SizeResult, SparseFit, Stlsq, Subset, SubsetPath,
};
pub use triangle::{Triangle, TriangleError};
pub use watch::{Stage, Watch};
