//! How far an identified model is from the true system.
//!
//! Nothing here knows a term or a coefficient of any system: what is true is asked of [`sindyna_envs::System::rates`].

mod rates;
mod structure;

pub use rates::{Deviation, Truth};
pub use structure::{Structure, Terms, compare, structure};
