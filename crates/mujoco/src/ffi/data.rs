//! The state of one simulation.

#![allow(unsafe_code, reason = "owns MuJoCo's mjData")]

use std::ptr::NonNull;
use std::sync::Arc;

use super::api::RawData;
use super::guard::{Raised, guarded};
use super::model::ModelHandle;
use crate::layout::Field;

/// What of a simulation is read or written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Part {
    /// qpos, then qvel.
    State,
    /// ctrl.
    Control,
}

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

    /// One step of the simulation. `Some(i)` if MuJoCo found state i, or the acceleration of velocity i, to be no finite
    /// number or a huge one; it then began anew from the rest position.
    pub(crate) fn step(&mut self) -> Result<Option<usize>, Raised> {
        let before = self.bad_counts();
        // SAFETY: as in `reset`.
        guarded(|| unsafe { (self.model.api().step)(self.model.as_ptr(), self.data.as_ptr()) })?;
        let after = self.bad_counts();
        // Beginning anew sets the other counts to zero, so a count can also fall.
        let risen = before.iter().zip(&after).position(|(b, a)| a > b).or_else(|| {
            let fell = before.iter().zip(&after).any(|(b, a)| a < b);
            if fell { after.iter().position(|&a| a > 0) } else { None }
        });
        Ok(risen.map(|kind| self.bad_index(kind)))
    }

    /// Contact forces and accelerations of the bodies, which MuJoCo computes on demand only.
    pub(crate) fn post_constraint(&mut self) -> Result<(), Raised> {
        // SAFETY: as in `reset`.
        guarded(|| unsafe { (self.model.api().rne_post_constraint)(self.model.as_ptr(), self.data.as_ptr()) })
    }

    /// Number of values in `part`.
    pub(crate) fn len(&self, part: Part) -> usize {
        let [nq, nv, nu] = self.model.sizes();
        match part {
            Part::State => nq + nv,
            Part::Control => nu,
        }
    }

    fn signature(&self, part: Part) -> u32 {
        let layout = &self.model.api().layout;
        match part {
            Part::State => layout.state_qpos | layout.state_qvel,
            Part::Control => layout.state_ctrl,
        }
    }

    /// Copies `part` into `values`, which has its length.
    pub(crate) fn get(&self, part: Part, values: &mut [f64]) -> Result<(), Raised> {
        assert_eq!(values.len(), self.len(part), "{part:?} has another length");
        let (api, signature) = (self.model.api(), self.signature(part));
        // SAFETY: as in `reset`, and `values` has the length MuJoCo gave for this signature.
        guarded(|| unsafe {
            (api.get_state)(self.model.as_ptr(), self.data.as_ptr(), values.as_mut_ptr(), signature);
        })
    }

    /// Copies `values` into `part`, whose length they have.
    pub(crate) fn set(&mut self, part: Part, values: &[f64]) -> Result<(), Raised> {
        assert_eq!(values.len(), self.len(part), "{part:?} has another length");
        let (api, signature) = (self.model.api(), self.signature(part));
        // SAFETY: as in `get`.
        guarded(|| unsafe { (api.set_state)(self.model.as_ptr(), self.data.as_ptr(), values.as_ptr(), signature) })
    }

    /// How often positions, velocities and accelerations were bad.
    fn bad_counts(&self) -> [i32; 3] {
        let layout = &self.model.api().layout;
        [0, 1, 2].map(|kind| self.warning(kind, layout.warning_count))
    }

    /// Index into (qpos, qvel) of what was bad last.
    fn bad_index(&self, kind: usize) -> usize {
        let index = usize::try_from(self.warning(kind, self.model.api().layout.warning_index)).unwrap_or(0);
        if kind == 0 { index } else { self.model.sizes()[0] + index }
    }

    /// A field of the statistics of one kind of bad numbers.
    fn warning(&self, kind: usize, field: Field) -> i32 {
        let layout = &self.model.api().layout;
        let row = [layout.bad_qpos, layout.bad_qvel, layout.bad_qacc][kind];
        let offset = layout.warnings.offset + row * layout.warning_bytes + field.offset;
        // SAFETY: the offset lies inside mjData, and any bytes are a valid integer.
        unsafe { self.read(offset) }
    }

    /// A copy of what lies `offset` bytes into `mjData`.
    ///
    /// # Safety
    /// A `V` must lie there.
    unsafe fn read<V: Copy>(&self, offset: usize) -> V {
        // SAFETY: as demanded of the caller.
        unsafe { self.data.as_ptr().byte_add(offset).cast::<V>().read_unaligned() }
    }

    /// qpos and qvel where the offsets say they are, for comparison with what `get` copies; `None` if that is not in the
    /// memory of this simulation.
    pub(crate) fn at_offsets(&self) -> Option<Vec<f64>> {
        let layout = &self.model.api().layout;
        let [nq, nv, _] = self.model.sizes();
        // SAFETY: the offsets lie inside mjData, and any bytes are valid integers.
        let (buffer, bytes): (usize, u64) =
            unsafe { (self.read(layout.buffer.offset), self.read(layout.buffer_len.offset)) };
        let end = buffer.checked_add(usize::try_from(bytes).ok()?)?;
        let mut values = Vec::with_capacity(nq + nv);
        for (field, len) in [(layout.qpos, nq), (layout.qvel, nv)] {
            // SAFETY: as above.
            let start: usize = unsafe { self.read(field.offset) };
            let array_end = start.checked_add(len * size_of::<f64>())?;
            if buffer == 0 || start < buffer || array_end > end || !start.is_multiple_of(align_of::<f64>()) {
                return None;
            }
            let array = std::ptr::with_exposed_provenance::<f64>(start);
            // SAFETY: the array lies in the simulation's own memory, and the caller checks what it holds.
            values.extend_from_slice(unsafe { std::slice::from_raw_parts(array, len) });
        }
        Some(values)
    }
}

impl Drop for DataHandle {
    fn drop(&mut self) {
        // SAFETY: owned; the model it was made from is still alive.
        let _ = guarded(|| unsafe { (self.model.api().delete_data)(self.data.as_ptr()) });
    }
}
