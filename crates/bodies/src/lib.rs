//! Rigid bodies on a tree of joints: inertial parameters, friction and armature from recorded motions.
//!
//! A file gives the arrangement: which joint sits where, with which axis ([`Urdf`], [`Mjcf`]). The forces of the joints are linear in all parameters ([`inverse_dynamics`]), so that [`calibrate`]
//! is a linear regression without start values. Only some combinations of parameters have an effect ([`Base`]); of all parameters with these, those are chosen that bodies can have.
//! Names of columns and files of logs are not known here.

mod base;
mod calibrate;
mod consistent;
mod error;
mod inertia;
mod mjcf;
mod output_error;
mod regression;
mod regressor;
mod rows;
mod simulate;
mod tree;
mod urdf;
mod xml;

pub use base::Base;
pub use calibrate::{Calibration, Prediction, calibrate, predict};
pub use error::BodiesError;
pub use inertia::Inertia;
pub use mjcf::Mjcf;
pub use regressor::{forces, inverse_dynamics, momenta};
pub use rows::Motion;
pub use simulate::{accelerations, simulated};
pub use tree::{Drive, Joint, JointParameters, Kind, Tree};
pub use urdf::Urdf;

pub use nalgebra;
