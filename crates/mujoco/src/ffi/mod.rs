//! The only unsafe code: MuJoCo's functions and memory, behind types that cannot be misused from safe Rust.

mod api;
mod data;
mod guard;
mod model;

pub(crate) use api::{Api, OpenError, Signature};
pub(crate) use data::DataHandle;
pub(crate) use guard::{Raised, take_warnings};
pub(crate) use model::{LoadError, ModelHandle};
