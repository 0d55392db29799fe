//! The inverted pendulum on MuJoCo.

use std::sync::Arc;

use sindyna_core::Task;
use sindyna_envs::System;

use crate::environment::MujocoEnvironment;
use crate::error::MujocoError;
use crate::library::Library;
use crate::model::MujocoModel;

const MODEL: &str = include_str!("inverted_pendulum.xml");
/// MuJoCo's steps in one control interval.
const FRAME_SKIP: usize = 2;

/// The system `inverted-pendulum` of `sindyna-envs` with MuJoCo as its physics (Gymnasium's `InvertedPendulum-v5`).
///
/// Task and sensors are those of the native system; the first call must be a reset.
///
/// # Errors
/// [`MujocoError::Raised`] if there is no memory for it.
pub fn inverted_pendulum(library: &Library) -> Result<MujocoEnvironment<Arc<dyn Task>>, MujocoError> {
    let system = sindyna_envs::find("inverted-pendulum").expect("sindyna-envs registers it");
    inverted_pendulum_of(library, &system)
}

/// [`inverted_pendulum`] with the task and sensors of `system`: the native system, with noise perhaps.
///
/// # Errors
/// [`MujocoError::Mismatch`] or [`MujocoError::Interval`] if `system` is another one, [`MujocoError::Raised`] if there is
/// no memory for it.
pub fn inverted_pendulum_of(
    library: &Library,
    system: &System,
) -> Result<MujocoEnvironment<Arc<dyn Task>>, MujocoError> {
    let model = MujocoModel::from_xml(library, MODEL)?;
    MujocoEnvironment::new(&model, FRAME_SKIP, system.task(), system.sensors())
}
