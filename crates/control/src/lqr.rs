//! A regulator as a policy.

use ndarray::{ArrayView2, ArrayViewMut2};
use sindyna_core::{Dynamics, Inverse, Mode, Policy, Rng, Space, Spec};

use crate::{ControlError, Costs, Linear, Regulator, regulate};

/// The linear-quadratic regulator: u = u₀ − K (x − x₀), within what may be applied.
///
/// Real actions are clipped to their bounds; of numbered ones the nearest is taken, in units of the control's scales. An
/// angle that is seen by its cosine and sine is taken less than half a turn from the equilibrium. Acts alike in both modes.
///
/// # References
/// Kalman (1960), Bol. Soc. Mat. Mexicana 5, "Contributions to the theory of optimal control".
#[derive(Debug, Clone)]
pub struct Lqr {
    regulator: Regulator,
    inverse: Inverse,
    equilibrium: (Vec<f64>, Vec<f64>),
    space: Space,
    /// Scale of every control, by which numbered ones are compared.
    scales: Vec<f64>,
}

impl Lqr {
    /// The regulator of `dynamics`, whose channels are those of `spec`, around the equilibrium `(x, u)` (n, k).
    ///
    /// # Errors
    /// [`ControlError`] if a step near the equilibrium diverges, no gain stabilises it, or a state is not observed.
    pub fn around(
        dynamics: &dyn Dynamics,
        spec: &Spec,
        (x, u): (&[f64], &[f64]),
        costs: &Costs,
        rng: &mut Rng,
    ) -> Result<Self, ControlError> {
        let linear = Linear::around(dynamics, (x, u), rng)?;
        Self::new(regulate(&linear, costs)?, spec, (x, u))
    }

    /// The policy of a `regulator` around `(x, u)` for the sensors and actions of `spec`.
    ///
    /// # Errors
    /// [`ControlError::Unseen`] if a state is not observed, [`ControlError::Shape`] if the gain does not fit.
    pub fn new(regulator: Regulator, spec: &Spec, (x, u): (&[f64], &[f64])) -> Result<Self, ControlError> {
        let (expected, got) = ((spec.control_dim(), spec.state_dim()), regulator.gain.dim());
        if expected != got || (u.len(), x.len()) != expected {
            return Err(ControlError::Shape { what: "the gain", expected, got });
        }
        Ok(Self {
            inverse: Inverse::of(spec)?,
            regulator,
            equilibrium: (x.to_vec(), u.to_vec()),
            space: spec.action_space.clone(),
            scales: spec.control.iter().map(|c| c.prior.scale).collect(),
        })
    }

    /// The gain, its value and how fast it is.
    #[must_use]
    pub fn regulator(&self) -> &Regulator {
        &self.regulator
    }

    /// The action for a control `u` (k) the gain asks for.
    fn action(&self, u: &[f64], mut action: ndarray::ArrayViewMut1<'_, f64>) {
        match &self.space {
            Space::Box { low, high } => {
                for (((a, u), &low), &high) in action.iter_mut().zip(u).zip(low).zip(high) {
                    *a = u.clamp(low, high);
                }
            }
            Space::Discrete { controls } => {
                let distance = |row: usize| -> f64 {
                    let parts = controls.row(row).into_iter().zip(u).zip(&self.scales);
                    parts.map(|((c, u), scale)| ((c - u) / scale).powi(2)).sum()
                };
                let nearest = (0..controls.nrows()).min_by(|&i, &j| distance(i).total_cmp(&distance(j)));
                action[0] = nearest.unwrap_or(0) as f64;
            }
        }
    }
}

impl Policy for Lqr {
    fn act_batch(
        &self,
        observations: ArrayView2<'_, f64>,
        _mode: Mode,
        _rng: &mut Rng,
        mut actions: ArrayViewMut2<'_, f64>,
    ) {
        let (x0, u0) = &self.equilibrium;
        let (mut o, mut x, mut u) = (vec![0.0; observations.ncols()], vec![0.0; x0.len()], vec![0.0; u0.len()]);
        for (row, action) in observations.rows().into_iter().zip(actions.rows_mut()) {
            o.iter_mut().zip(row).for_each(|(o, shown)| *o = *shown);
            self.inverse.state(&o, x0, &mut x);
            for ((u, gains), u0) in u.iter_mut().zip(self.regulator.gain.rows()).zip(u0) {
                *u = u0 - gains.iter().zip(&x).zip(x0).map(|((k, x), x0)| k * (x - x0)).sum::<f64>();
            }
            self.action(&u, action);
        }
    }
}
