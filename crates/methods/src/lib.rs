//! Methods side by side: which needs how many real steps.
//!
//! A [`Job`] is one run of a [`Method`], or of a [`Variant`] of `sindy`, on one task with one seed; [`Store`] is the directory where the outcomes of a comparison lie.
//! [`Known`] tells `sindyna-report` what no record says.

mod catalog;
mod error;
mod method;
mod pace;
mod paper;
mod presets;
mod run;
mod store;
mod variant;

pub use catalog::Known;
pub use error::MethodError;
pub use method::Method;
pub use pace::Pace;
pub use presets::first_check;
pub use run::Job;
pub use store::Store;
pub use variant::{Contender, Variant};
