//! Recorded states with nothing between them but the equations of motion.

use ndarray::{Array2, ArrayView1, s};
use sindyna_core::{Dataset, Kind, Precision, Spec};

use crate::coordinates::Coordinates;

/// Consecutive samples of one rollout.
#[derive(Debug, Clone)]
pub(crate) struct Run {
    /// States (T + 1, n).
    pub(crate) x: Array2<f64>,
    /// Controls (T, k), each held from one sample to the next.
    pub(crate) u: Array2<f64>,
    /// Standard deviation of the error of each state (T + 1, n).
    pub(crate) sigma: Array2<f64>,
    /// Standard deviation of the error of each control (k): they were rounded too.
    pub(crate) of_inputs: Vec<f64>,
    /// The same if they were rounded to the digits that they are written with, which they may not have been (k).
    pub(crate) written: Vec<f64>,
}

impl Run {
    /// Number of steps.
    pub(crate) fn len(&self) -> usize {
        self.u.nrows()
    }

    /// Steps `first` to `last`, that one excluded.
    pub(crate) fn part(&self, first: usize, last: usize) -> Self {
        Self {
            x: self.x.slice(s![first..=last, ..]).to_owned(),
            u: self.u.slice(s![first..last, ..]).to_owned(),
            sigma: self.sigma.slice(s![first..=last, ..]).to_owned(),
            of_inputs: self.of_inputs.clone(),
            written: self.written.clone(),
        }
    }
}

/// Errors smaller than this part of the rounding of a channel's largest value are not believed: a state that is exactly
/// zero has been computed from others that were rounded.
const LEAST_ROUNDING: f64 = 0.1;

/// The runs of `data`, and the number of steps left out because they end at a declared limit: what happens there (a stop,
/// a clip) is not dynamics.
///
/// `noise` (m) are standard deviations of the noise of the observations, by which a limit may seem farther than it is.
pub(crate) fn runs(spec: &Spec, coordinates: &Coordinates, data: &Dataset, noise: &[f64]) -> (Vec<Run>, usize) {
    let n = coordinates.n_states();
    let mut found = Vec::new();
    let mut at_limits = 0;
    for rollout in data.rollouts() {
        let x = coordinates.states(rollout.observations);
        let mut sigma = Array2::from_shape_fn(x.dim(), |(t, i)| coordinates.error(i, rollout.observations.row(t)));
        for i in 0..n {
            let largest = (0..x.nrows()).map(|t| sigma[[t, i]]).fold(0.0, f64::max);
            sigma.column_mut(i).mapv_inplace(|v| v.max(LEAST_ROUNDING * largest));
        }
        let steps = rollout.controls.nrows();
        let of_inputs = spec.control.iter().map(|c| c.prior.resolution / 12_f64.sqrt()).collect();
        let written = written(spec);
        let whole = Run { x, u: rollout.controls.to_owned(), sigma, of_inputs, written };
        let mut first = 0;
        for t in 0..=steps {
            let broken = t < steps && at_limit(spec, rollout.observations.row(t + 1), noise);
            if broken || t == steps {
                if t > first {
                    found.push(whole.part(first, t));
                }
                at_limits += usize::from(broken);
                first = t + 1;
            }
        }
    }
    (found, at_limits)
}

/// Standard deviations of the errors of controls (k) that were rounded to the digits that they are written with.
pub(crate) fn written(spec: &Spec) -> Vec<f64> {
    spec.control.iter().map(|c| c.prior.written / 12_f64.sqrt()).collect()
}

/// Standard deviations of noise within which of a limit a state may be at it.
const NEAR: f64 = 3.0;

/// Whether an observation sits at a declared limit, or may do so but for noise.
pub(crate) fn at_limit(spec: &Spec, observation: ArrayView1<'_, f64>, noise: &[f64]) -> bool {
    observation.iter().zip(&spec.observation).zip(noise).any(|((&value, channel), noise)| {
        // Cosine and sine reach their bounds on any turn.
        if matches!(channel.kind, Kind::CosOf(_) | Kind::SinOf(_)) {
            return false;
        }
        let declared =
            spec.state.iter().find(|s| s.name == channel.name).map_or(channel.prior.bounds, |s| s.prior.bounds);
        let rounding = match spec.precision {
            Precision::F32 => 1.5 * f64::from(f32::EPSILON),
            Precision::F64 => 1e-9,
        };
        let near = |bound: f64| rounding * bound.abs() + NEAR * noise;
        [channel.prior.bounds, declared].into_iter().any(|(low, high)| {
            (low.is_finite() && value <= low + near(low)) || (high.is_finite() && value >= high - near(high))
        })
    })
}
