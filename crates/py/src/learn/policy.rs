//! Trained policies.

use ndarray::Array2;
use numpy::{IntoPyArray as _, PyArray2, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use sindyna::core::{Mode, Policy as _, Seed};
use sindyna::rl::SavedPolicy;

use super::system::refused;

/// A trained policy: the best action for each observation.
#[pyclass(frozen, module = "sindyna._sindyna")]
pub(crate) struct Policy {
    inner: SavedPolicy,
    bytes: Vec<u8>,
}

impl Policy {
    pub(crate) fn read(bytes: Vec<u8>) -> PyResult<Self> {
        Ok(Self { inner: SavedPolicy::from_safetensors(&bytes).map_err(refused)?, bytes })
    }

    pub(crate) fn inner(&self) -> &SavedPolicy {
        &self.inner
    }
}

#[pymethods]
impl Policy {
    /// Reads the bytes of `policy.safetensors`.
    #[staticmethod]
    fn from_bytes(bytes: Vec<u8>) -> PyResult<Self> {
        Self::read(bytes)
    }

    /// The policy as safetensors.
    fn to_bytes<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        PyBytes::new(py, &self.bytes)
    }

    fn __reduce__(&self, py: Python<'_>) -> PyResult<(Py<PyAny>, (Vec<u8>,))> {
        Ok((py.get_type::<Self>().getattr("from_bytes")?.unbind(), (self.bytes.clone(),)))
    }

    /// Values of an observation.
    #[getter]
    fn n_observations(&self) -> usize {
        self.inner.observation_dim()
    }

    /// Number of actions of a policy that numbers them.
    #[getter]
    fn n_numbered(&self) -> Option<usize> {
        match &self.inner {
            SavedPolicy::Categorical(policy) => Some(policy.n_actions()),
            SavedPolicy::Gaussian(_) => None,
        }
    }

    /// Actions (N, values) for observations (N, m); one value, its number, where actions are numbered.
    fn act<'py>(
        &self,
        py: Python<'py>,
        observations: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let observations = observations.as_array();
        let (expected, got) = (self.inner.observation_dim(), observations.ncols());
        if expected != got {
            return Err(refused(format!("the policy observes {expected} values, got {got}")));
        }
        let values = match &self.inner {
            SavedPolicy::Categorical(_) => 1,
            SavedPolicy::Gaussian(policy) => policy.action_dim(),
        };
        let mut actions = Array2::zeros((observations.nrows(), values));
        py.detach(|| {
            // The best action draws no random number.
            self.inner.act_batch(observations, Mode::Exploit, &mut Seed::new(0).numpy(), actions.view_mut());
        });
        Ok(actions.into_pyarray(py))
    }
}
