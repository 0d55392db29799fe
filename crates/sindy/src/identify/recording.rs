//! Recordings as people have them: arrays with times.

use ndarray::{Array2, Axis, s};
use sindyna_core::{Dataset, FitError, InterSample, Rollout, Spec};

use super::Identifier;
use crate::coordinates::Coordinates;
use crate::data::{Ramp, Segment};
use crate::model::Inputs;

/// One uninterrupted recording, sampled at any times.
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    /// Times of the samples \[s\] (T + 1), increasing.
    pub times: Vec<f64>,
    /// What the sensors show at these times (T + 1, m). The rate of a state that was not measured is NaN in every row: it is found with the equations.
    pub states: Array2<f64>,
    /// Controls (T, k) at all samples but the last.
    pub controls: Array2<f64>,
    /// What controls are between these samples. Unless they are held the last step is not used: what they were at its end is not known.
    pub intersample: InterSample,
}

impl Recording {
    /// Recordings of the system `spec` as rollouts, whatever the times of their samples.
    ///
    /// # Errors
    /// [`FitError::Regression`] if a value is not finite.
    pub fn dataset(recordings: &[Self], spec: &Spec) -> Result<Dataset, FitError> {
        dataset(spec, recordings)
    }

    /// The rollouts of `data`, as they were observed.
    #[must_use]
    pub fn of(data: &Dataset) -> Vec<Self> {
        let of = |rollout: Rollout<'_>| {
            Self::even(data.dt(), rollout.observations.to_owned(), Some(rollout.controls.to_owned()))
                .with_intersample(data.intersample())
        };
        data.rollouts().map(of).collect()
    }

    /// Samples `states` (T + 1, m) at `times` \[s\] (T + 1), with controls (T, k) held from one to the next.
    #[must_use]
    pub fn new(times: Vec<f64>, states: Array2<f64>, controls: Array2<f64>) -> Self {
        Self { times, states, controls, intersample: InterSample::Zoh }
    }

    /// Samples `states` (T + 1, m) every `dt` \[s\], from time 0 on, with controls (T, k) held from one to the next; none for a
    /// system without any.
    #[must_use]
    pub fn even(dt: f64, states: Array2<f64>, controls: Option<Array2<f64>>) -> Self {
        let steps = states.nrows().saturating_sub(1);
        let times = (0..states.nrows()).map(|t| dt * t as f64).collect();
        Self::new(times, states, controls.unwrap_or_else(|| Array2::zeros((steps, 0))))
    }

    /// Refuses what does not fit the spec or itself.
    pub(super) fn check(&self, spec: &Spec) -> Result<(), FitError> {
        let shape = |what, expected, got| {
            if expected == got { Ok(()) } else { Err(FitError::Shape { what, expected, got }) }
        };
        shape("observed values", spec.observation_dim(), self.states.ncols())?;
        shape("controls", spec.control_dim(), self.controls.ncols())?;
        shape("times", self.states.nrows(), self.times.len())?;
        shape("rows of controls", self.states.nrows().saturating_sub(1), self.controls.nrows())?;
        let failed = |reason: String| Err(FitError::Regression { reason });
        if let Some(at) =
            self.times.windows(2).position(|t| t[1].partial_cmp(&t[0]) != Some(std::cmp::Ordering::Greater))
        {
            return failed(format!(
                "the time must increase: {} s in row {} follows {} s",
                self.times[at + 1],
                at + 1,
                self.times[at]
            ));
        }
        let measured = self.states.columns().into_iter().filter(|c| !c.iter().all(|v| v.is_nan()));
        let values = measured.flatten().chain(&self.controls).chain(&self.times);
        match values.copied().find(|v| !v.is_finite()) {
            Some(value) => failed(format!("a recorded value is {value}, which is not finite")),
            None => Ok(()),
        }
    }

    /// Whether the samples are `dt` \[s\] apart.
    pub(super) fn is_even(&self, dt: f64) -> bool {
        self.times.windows(2).all(|t| (t[1] - t[0] - dt).abs() <= 1e-9 * dt.max(t[1].abs()))
    }

    /// The same with controls that are `intersample` between samples.
    #[must_use]
    pub fn with_intersample(self, intersample: InterSample) -> Self {
        Self { intersample, ..self }
    }

    /// Number of steps over which controls are known.
    #[must_use]
    pub fn steps(&self) -> usize {
        self.controls.nrows().saturating_sub(usize::from(!self.intersample.is_held()))
    }

    /// Controls over the steps `from` to `to`, that one excluded, at most [`Self::steps`].
    #[must_use]
    pub fn inputs(&self, from: usize, to: usize) -> Inputs<'_> {
        let start = self.controls.slice(s![from..to, ..]);
        let end = (!self.intersample.is_held()).then(|| self.controls.slice(s![from + 1..=to, ..]));
        Inputs { start, end, intersample: self.intersample }
    }

    /// By how much controls change over each step (T, k), by nothing over the last one; `None` if they are held.
    fn ramp(&self) -> Option<Ramp> {
        if self.intersample.is_held() {
            return None;
        }
        let mut by = Array2::zeros(self.controls.dim());
        let last = self.controls.nrows().saturating_sub(1);
        by.slice_mut(s![..last, ..])
            .assign(&(&self.controls.slice(s![1.., ..]) - &self.controls.slice(s![..last, ..])));
        Some(Ramp { by, intersample: self.intersample })
    }

    /// Its samples. The inputs of the last step are held.
    pub(super) fn segment(&self, coordinates: &Coordinates) -> Segment {
        let (x, relative) = marked(coordinates.states(self.states.view()));
        let dt = self.times.windows(2).map(|t| t[1] - t[0]).collect();
        Segment {
            x,
            u: self.controls.clone(),
            ramp: self.ramp(),
            dt,
            relative,
            of_inputs: Vec::new(),
            corrections: None,
        }
    }

    /// Its samples up to the last one to which inputs are known.
    pub(super) fn known(&self, coordinates: &Coordinates) -> Segment {
        let segment = self.segment(coordinates);
        if self.steps() < segment.len() { segment.part(0, self.steps()) } else { segment }
    }
}

impl Identifier {
    /// The rollouts of `data` as recordings of the states that the model is about.
    ///
    /// # Errors
    /// [`FitError`] if the data do not have the spec's shape, or show not every state.
    pub fn recordings(&self, data: &Dataset) -> Result<Vec<Recording>, FitError> {
        self.check(data)?;
        self.in_states(Recording::of(data))
    }

    /// The same `recordings` with states (T + 1, n) in place of observations (T + 1, m): cosine and sine of an angle are one state.
    ///
    /// # Errors
    /// [`FitError`] if the recordings do not have the spec's shape, or show not every state.
    pub fn in_states(&self, recordings: Vec<Recording>) -> Result<Vec<Recording>, FitError> {
        let coordinates = Coordinates::new(&self.spec, self.coordinates)
            .map_err(|state| FitError::Regression { reason: format!("no observation shows the state `{state}`") })?;
        let of = |recording: Recording| {
            recording.check(&self.spec)?;
            Ok(Recording { states: coordinates.states(recording.states.view()), ..recording })
        };
        recordings.into_iter().map(of).collect()
    }
}

/// Even recordings as rollouts.
pub(super) fn dataset(spec: &Spec, recordings: &[Recording]) -> Result<Dataset, FitError> {
    let failed = |e: &dyn std::fmt::Display| FitError::Regression { reason: e.to_string() };
    let intersample = recordings.first().map_or(InterSample::Zoh, |r| r.intersample);
    let mut data = Dataset::new(spec.observation_dim(), spec.control_dim(), spec.control_dim(), spec.dt)
        .with_intersample(intersample);
    for recording in recordings {
        let mut rows = recording.states.axis_iter(Axis(0)).map(|row| row.to_vec());
        let Some(first) = rows.next() else { continue };
        data.begin(&first).map_err(|e| failed(&e))?;
        for (next, u) in rows.zip(recording.controls.rows()) {
            let u = u.to_vec();
            data.push(&u, &u, 0.0, &next).map_err(|e| failed(&e))?;
        }
    }
    Ok(data)
}

/// `x` (T + 1, n) with zeros in columns that are NaN, and the relative errors of all samples, which are infinite there.
fn marked(mut x: Array2<f64>) -> (Array2<f64>, Option<Array2<f64>>) {
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
