//! States that nobody measured: rates of states that were.

use ndarray::Array2;
use sindyna_core::FitError;

use super::Identifier;
use super::recording::Recording;
use crate::data::{Segment, Smoother};

impl Identifier {
    /// Numbers of the observed values that are NaN in all `recordings`: they were not measured.
    ///
    /// # Errors
    /// [`FitError::Regression`] if such a state is not the rate of another one, or that of one that was not measured either.
    pub(super) fn unmeasured(&self, recordings: &[Recording]) -> Result<Vec<usize>, FitError> {
        let (spec, rates) = (&self.spec, self.rates());
        let never = |o: &usize| recordings.iter().all(|r| r.states.column(*o).iter().all(|v| v.is_nan()));
        let found: Vec<usize> = (0..spec.observation_dim()).filter(never).collect();
        for &o in &found {
            let name = &spec.observation[o].name;
            let state = spec.state.iter().position(|s| s.name == *name);
            let is_rate = state.is_some_and(|i| rates.contains(&Some(i)));
            if !is_rate {
                let reason = format!("`{name}` was never measured, and is no rate of a state that was");
                return Err(FitError::Regression { reason });
            }
        }
        Ok(found)
    }
}

/// `segments` in which states that were not measured are the derivatives of those they are the rates of, after smoothing, as a beginning; `floor` (n) are
/// the smallest errors believed.
pub(super) fn begun(mut segments: Vec<Segment>, rates: &[Option<usize>], floor: &[f64]) -> Vec<Segment> {
    let signals = Smoother::new(&segments, rates, floor, &|| true).signals(floor);
    for (segment, x) in segments.iter_mut().zip(&signals.x) {
        for i in (0..rates.len()).filter(|&i| !segment.measures(i)).collect::<Vec<_>>() {
            segment.x.column_mut(i).assign(&x.column(i));
        }
    }
    segments
}

/// `x` (T + 1, n) with zeros in columns that are NaN, and the relative errors of all samples, which are infinite there.
pub(super) fn marked(mut x: Array2<f64>) -> (Array2<f64>, Option<Array2<f64>>) {
    let all = |i: &usize| x.column(*i).iter().all(|v| v.is_nan());
    let unmeasured: Vec<usize> = (0..x.ncols()).filter(all).collect();
    if unmeasured.is_empty() {
        return (x, None);
    }
    let mut relative = Array2::ones(x.dim());
    for i in unmeasured {
        x.column_mut(i).fill(0.0);
        relative.column_mut(i).fill(f64::INFINITY);
    }
    (x, Some(relative))
}

