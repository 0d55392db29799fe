//! The steps of MuJoCo's integrator.

/// The integrator's step \[s\].
pub(super) const TIMESTEP: f64 = 0.02;
/// Integrator steps in one control interval.
pub(super) const SUBSTEPS: usize = 2;
/// Control interval \[s\].
pub(super) const DT: f64 = TIMESTEP * SUBSTEPS as f64;
