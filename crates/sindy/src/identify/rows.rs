//! Rows of the regression from recorded rollouts.

use ndarray::{Array2, ArrayView1};
use sindyna_core::{Dataset, Rollout, Spec};

use super::Target;
use crate::coordinates::Coordinates;
use crate::differentiate::TooShort;
use crate::motion::at_limit;

/// Variables and targets, one row per usable step.
#[derive(Debug, Clone)]
pub(crate) struct Rows {
    /// z = (x; u) at which the terms are evaluated (N, n + k).
    pub(crate) z: Array2<f64>,
    /// What they are to explain (N, n).
    pub(crate) targets: Array2<f64>,
    /// Rows left out because an observation sat at a declared limit.
    pub(crate) at_limit: usize,
    /// RMS error that rounding leaves on each target (n); zero where it is not known.
    pub(crate) floor: Vec<f64>,
}

/// Rounding errors also enter through the terms; this factor allows for them.
const THROUGH_TERMS: f64 = 4.0;

impl Rows {
    /// The rows of `data`. Nothing is computed across the border of a rollout; the last sample of a rollout has no
    /// control and makes no row.
    ///
    /// # Errors
    /// [`TooShort`] if every rollout is too short for the differentiator; a single one is passed over.
    pub(crate) fn new(
        spec: &Spec,
        coordinates: &Coordinates,
        target: &Target,
        data: &Dataset,
    ) -> Result<Self, TooShort> {
        let mut rows = Collected::default();
        let mut too_short = None;
        for rollout in data.rollouts().filter(|r| r.controls.nrows() > 0) {
            too_short = rows.add(spec, coordinates, target, &rollout).err().or(too_short);
        }
        if let Some(too_short) = too_short.filter(|_| rows.targets.is_empty()) {
            return Err(too_short);
        }
        let n = coordinates.n_states();
        let count = rows.targets.len() / n.max(1);
        let width = rows.z.len().checked_div(count).unwrap_or(n + data.control_dim());
        let floor = rows.floor.iter().map(|sum| THROUGH_TERMS * (sum / count.max(1) as f64).sqrt());
        Ok(Self {
            floor: floor.collect(),
            z: Array2::from_shape_vec((count, width), rows.z).expect("rows are pushed whole"),
            targets: Array2::from_shape_vec((count, n), rows.targets).expect("rows are pushed whole"),
            at_limit: rows.at_limit,
        })
    }
}

#[derive(Default)]
struct Collected {
    z: Vec<f64>,
    targets: Vec<f64>,
    at_limit: usize,
    /// Sums of squares.
    floor: Vec<f64>,
}

impl Collected {
    fn add(
        &mut self,
        spec: &Spec,
        coordinates: &Coordinates,
        target: &Target,
        rollout: &Rollout<'_>,
    ) -> Result<(), TooShort> {
        let mut states = coordinates.states(rollout.observations);
        let n = states.ncols();
        let dt = coordinates.dt();
        self.floor.resize(n, 0.0);
        let derivative = match target {
            Target::Continuous { differentiator, .. } => {
                let result = differentiator.differentiate(states.view(), dt)?;
                states = result.x;
                Some(result.x_dot)
            }
            Target::Motion | Target::Increment | Target::Discrete => None,
        };
        let noise: Vec<f64> = spec.noise_deviations().collect();
        for i in 0..rollout.controls.nrows() {
            let (now, next) = (rollout.observations.row(i), rollout.observations.row(i + 1));
            if at_limit(spec, now, &noise) || at_limit(spec, next, &noise) {
                self.at_limit += 1;
                continue;
            }
            self.z.extend(states.row(i).iter().chain(rollout.controls.row(i)));
            for j in 0..n {
                let (x, x_next) = (states[[i, j]], states[[i + 1, j]]);
                let error = |o: ArrayView1<'_, f64>| coordinates.rounding(j, o);
                let (value, spread) = match (&derivative, target) {
                    (Some(x_dot), _) => (x_dot[[i, j]], 0.0),
                    (None, Target::Discrete) => (x_next, error(now).hypot(error(next))),
                    (None, _) => ((x_next - x) / dt, error(now).hypot(error(next)) / dt),
                };
                self.targets.push(value);
                self.floor[j] += spread * spread;
            }
        }
        Ok(())
    }
}
