//! The state of one simulation.

#![allow(unsafe_code, reason = "owns MuJoCo's mjData")]

use std::ptr::NonNull;
use std::sync::Arc;

use super::api::{RawData, Signature};
use super::guard::{Raised, guarded};
use super::model::ModelHandle;

/// Owns an `mjData`.
pub(crate) struct DataHandle {
    data: NonNull<RawData>,
    model: Arc<ModelHandle>,
}

// SAFETY: an mjData belongs to no thread, and all access goes through this handle, which is not `Sync`.
unsafe impl Send for DataHandle {}

impl DataHandle {
    /// A simulation of `model` in its rest position.
    pub(crate) fn new(model: &Arc<ModelHandle>) -> Result<Self, Raised> {
        // SAFETY: the model is alive.
        let data = guarded(|| unsafe { (model.api().make_data)(model.as_ptr()) })?;
        let data = NonNull::new(data).ok_or_else(|| Raised("no memory for the simulation".into()))?;
        Ok(Self { data, model: Arc::clone(model) })
    }

    /// Back to the rest position; also what makes a simulation usable again after an error.
    pub(crate) fn reset(&mut self) -> Result<(), Raised> {
        // SAFETY: both are alive and belong together.
        guarded(|| unsafe { (self.model.api().reset_data)(self.model.as_ptr(), self.data.as_ptr()) })
    }

    /// Computes everything that follows from state and control.
    pub(crate) fn forward(&mut self) -> Result<(), Raised> {
        // SAFETY: as in `reset`.
        guarded(|| unsafe { (self.model.api().forward)(self.model.as_ptr(), self.data.as_ptr()) })
    }

    /// One step of the simulation. Where MuJoCo finds a number that is not finite, or huge, it warns of that and begins
    /// anew from the rest position.
    pub(crate) fn step(&mut self) -> Result<(), Raised> {
        // SAFETY: as in `reset`.
        guarded(|| unsafe { (self.model.api().step)(self.model.as_ptr(), self.data.as_ptr()) })
    }

    /// Contact forces and accelerations of the bodies, which MuJoCo computes on demand only.
    pub(crate) fn post_constraint(&mut self) -> Result<(), Raised> {
        // SAFETY: as in `reset`.
        guarded(|| unsafe { (self.model.api().rne_post_constraint)(self.model.as_ptr(), self.data.as_ptr()) })
    }

    /// Copies the parts of the state in `signature` into `values`, which has their length.
    pub(crate) fn get(&self, signature: Signature, values: &mut [f64]) -> Result<(), Raised> {
        let api = self.model.api();
        guarded(|| {
            self.model.demand_len(signature, values.len())?;
            // SAFETY: as in `reset`, and `values` has the length that MuJoCo writes.
            unsafe { (api.get_state)(self.model.as_ptr(), self.data.as_ptr(), values.as_mut_ptr(), signature) };
            Ok(())
        })?
    }

    /// Copies `values` into the parts of the state in `signature`, whose length they have.
    pub(crate) fn set(&mut self, signature: Signature, values: &[f64]) -> Result<(), Raised> {
        let api = self.model.api();
        guarded(|| {
            self.model.demand_len(signature, values.len())?;
            // SAFETY: as in `reset`, and `values` has the length that MuJoCo reads.
            unsafe { (api.set_state)(self.model.as_ptr(), self.data.as_ptr(), values.as_ptr(), signature) };
            Ok(())
        })?
    }
}

impl Drop for DataHandle {
    fn drop(&mut self) {
        // SAFETY: owned; the model it was made from is still alive.
        let _ = guarded(|| unsafe { (self.model.api().delete_data)(self.data.as_ptr()) });
    }
}
