//! States that nobody measured: rates of states that were.

use sindyna_core::{FitError, Scheme};

use super::Identifier;
use super::recording::Recording;
use super::refitted::terms_of;
use crate::CoordinateMode;
use crate::coordinates::Coordinates;
use crate::data::{LONGEST_CHAIN, Segment, Smoother};
use crate::model::{Form, Model};
use crate::motion::Stepping;
use crate::shooting::{self, Bounds, Flow, Work};

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
                let reason = format!("`{name}` was not measured and is not the rate of a measured state");
                return Err(FitError::Regression { reason });
            }
        }
        let longest =
            (0..rates.len()).map(|i| std::iter::successors(Some(i), |&i| rates[i]).take(rates.len()).count()).max();
        if !found.is_empty() && longest.is_some_and(|longest| longest > LONGEST_CHAIN) {
            let reason = format!("a chain of rates with unmeasured states has at most {LONGEST_CHAIN} states");
            return Err(FitError::Regression { reason });
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

impl Identifier {
    /// `recordings` with the states that were not measured, as `model` and the states that were tell them: the path that follows both best.
    ///
    /// # Errors
    /// [`FitError`] if the recordings do not have the spec's shape, or a state that was not measured is no rate of one that was.
    pub fn filled(&self, model: &Model, recordings: &[Recording]) -> Result<Vec<Recording>, FitError> {
        recordings.iter().try_for_each(|r| r.check(&self.spec))?;
        let unmeasured = self.unmeasured(recordings)?;
        let coordinates = Coordinates::new(&self.spec, CoordinateMode::Recognised)
            .map_err(|state| FitError::Regression { reason: format!("no observation shows the state `{state}`") })?;
        let segments: Vec<Segment> = recordings.iter().map(|r| r.segment(&coordinates)).collect();
        let (rates, floor) = (self.rates(), self.smallest_errors(&coordinates, recordings));
        let smoother = Smoother::new(&segments, &rates, &floor, &|| true);
        let signals = smoother.signals(&floor);
        let flow = flow(model, &rates, self.spec.control_dim());
        let bounds = Bounds { floor: &floor, shape: &signals.sigma };
        let start = (&[][..], &signals.x[..]);
        let fitted =
            shooting::fit(&flow, &segments, start, &signals.sigma, bounds, FOLLOWED, (&Work::default(), &|| true));
        let x = fitted.map_or(signals.x.clone(), |fit| fit.x);
        let mut filled = recordings.to_vec();
        for (recording, x) in filled.iter_mut().zip(&x) {
            for &o in &unmeasured {
                let state = self.spec.state.iter().position(|s| s.name == self.spec.observation[o].name);
                state.into_iter().for_each(|i| recording.states.column_mut(o).assign(&x.column(i)));
            }
        }
        Ok(filled)
    }

    /// The smallest error of each state (n) that is believed: that of its rounding.
    pub(super) fn smallest_errors(&self, coordinates: &Coordinates, recordings: &[Recording]) -> Vec<f64> {
        let error = |i: usize| {
            let rows = recordings.iter().flat_map(|r| r.states.rows());
            // Of a state that was not measured the errors are NaN, and the largest is that of none.
            rows.map(|o| coordinates.error(i, o)).fold(0.0, f64::max)
        };
        (0..self.spec.state_dim()).map(error).collect()
    }
}

/// How closely the states follow the equations in the end: a model that is nearly right leads them no further than the data allow.
const FOLLOWED: std::ops::Range<usize> = 0..3;

/// The equations of `model`, all of whose coefficients are given.
fn flow(model: &Model, rates: &[Option<usize>], n_controls: usize) -> Flow {
    let (terms, given) = terms_of(model, rates);
    let stepping = match model.form() {
        Form::SemiImplicit { substeps } => Stepping::SemiImplicit { substeps },
        Form::Continuous(Scheme::Euler) => Stepping::Euler,
        Form::Continuous(Scheme::Rk4 { substeps }) => Stepping::Continuous { substeps },
        _ => Stepping::Continuous { substeps: 1 },
    };
    Flow::new(&terms, (&vec![Vec::new(); rates.len()], &given, &[]), rates, n_controls, stepping)
}
