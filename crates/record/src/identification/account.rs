//! The account of an identification: the JSON of `identify.json`.

use serde::{Deserialize, Serialize};
use sindyna_core::{Certainty, Channel, Spec};
use sindyna_sindy::{Form, Identified, Noise};

use super::{Equation, HeldOut, PredictionTable, StateQuality, Stepping};
use crate::{RecordError, format};

/// What was identified and how far to believe it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Account {
    /// Version of the format; not written while it is 1.
    #[serde(default = "format::first", skip_serializing_if = "format::is_first")]
    pub format: u32,
    /// Steps the equations were fitted to.
    pub rows: usize,
    /// Steps left out because a channel sat at its declared bound.
    pub rows_at_limit: usize,
    /// Steps left out because they do not follow the equations of all the others.
    pub rows_astray: usize,
    /// Condition number of the columns of the regression, each scaled to unit length: of all candidate terms, or for
    /// equations of motion of the terms found. `null` with fewer rows than columns.
    pub condition: Option<f64>,
    /// Candidate terms.
    pub features: Vec<String>,
    /// How the equations are stepped.
    pub stepping: Stepping,
    /// What is added to an angle before the terms are computed, where that is not zero.
    pub offsets: Vec<Offset>,
    /// Whether the residual of every equation is no more than the measurement errors explain; `null` where that is not known.
    pub explained: Option<bool>,
    /// The equations, one per state.
    pub equations: Vec<Equation>,
    /// Where the size of the measurement errors comes from.
    pub noise: NoiseSource,
    /// Measurement noise of each state, where it was estimated.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub noise_deviations: Vec<StateNoise>,
    /// States that were not measured: their values follow from the equations.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub unmeasured: Vec<String>,
    /// Whether the search for terms tried all it would.
    pub search_complete: bool,
    /// What the data do not show.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<String>,
    /// How well the model predicts the samples it was fitted to, one step and in a free run.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub quality: Vec<StateQuality>,
    /// How well the model predicts a part of the data that it was not fitted to.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub held_out: Option<HeldOut>,
}

/// Where the size of the measurement errors comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum NoiseSource {
    /// From the digits of the numbers.
    Rounding,
    /// From the user.
    Declared,
    /// From the data.
    Estimated,
}

/// The measurement noise of one state, as estimated.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StateNoise {
    /// The state.
    pub state: String,
    /// RMS difference of the state as measured and as it follows from the equations.
    pub sigma: f64,
    /// Unit of `sigma`.
    pub unit: String,
    /// Share of the noise's variance that grows with the square of the state.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub growing: f64,
    /// 100 (1 − NRMSE) of the state simulated along each recording.
    pub fit_percent: Option<f64>,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde asks so")]
fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

/// What is added to a state before the terms are computed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Offset {
    /// The state.
    pub state: String,
    /// What is added, in its unit.
    pub offset: f64,
}

impl Account {
    /// The account of `found`, identified in data of the system `spec`.
    #[must_use]
    pub fn new(found: &Identified, spec: &Spec) -> Self {
        let (model, report) = (&found.model, &found.report);
        let noisy = spec.noise > 0.0;
        let noise = if noisy && report.noise == Noise::Rounding { Noise::Declared } else { report.noise };
        // Of increments and next states it is only known what rounding does to them.
        let judged = !noisy || !matches!(model.form(), Form::Increment | Form::Discrete);
        let equation = |i: usize| {
            let name = &model.states()[i];
            let channel = |list: &[Channel]| list.iter().find(|c| c.name == *name).map(|c| c.unit.clone());
            let unit = channel(&spec.state).or_else(|| channel(&spec.observation)).unwrap_or_default();
            Equation::new(found, i, &unit, judged)
        };
        let unit = |name: &String| spec.state.iter().find(|c| c.name == *name).map(|c| c.unit.clone());
        let deviation = |(((state, &sigma), &fit), &growing): (((&String, &f64), &f64), &f64)| StateNoise {
            state: state.clone(),
            sigma,
            unit: unit(state).unwrap_or_default(),
            growing,
            fit_percent: Some(100.0 * fit).filter(|f| f.is_finite()),
        };
        let equations: Vec<Equation> = (0..report.equations.len()).map(equation).collect();
        let named = model.states().iter().zip(model.offsets());
        let offset = |(state, &offset): (&String, &f64)| Offset { state: state.clone(), offset };
        Self {
            format: format::CURRENT,
            rows: report.rows,
            rows_at_limit: report.rows_at_limit,
            rows_astray: report.rows_astray,
            condition: Some(report.condition).filter(|c| c.is_finite()),
            features: report.features.clone(),
            stepping: Stepping::of(model),
            offsets: named.filter(|(_, v)| **v != 0.0).map(offset).collect(),
            explained: equations
                .iter()
                .map(Equation::is_explained)
                .try_fold(true, |all, one| one.map(|explained| all && explained)),
            equations,
            noise: match noise {
                Noise::Rounding => NoiseSource::Rounding,
                Noise::Declared => NoiseSource::Declared,
                Noise::Estimated => NoiseSource::Estimated,
            },
            noise_deviations: {
                let states = model.states().iter().zip(&report.noise_deviations);
                let all = states.zip(&report.fit).zip(&report.noise_growing).enumerate();
                all.filter(|(i, _)| !report.unmeasured.contains(i)).map(|(_, noise)| deviation(noise)).collect()
            },
            unmeasured: report.unmeasured.iter().filter_map(|&i| model.states().get(i).cloned()).collect(),
            search_complete: report.search_complete,
            warnings: report.warnings.clone(),
            quality: Vec::new(),
            held_out: None,
        }
    }

    /// Standard deviation of the measurement noise of each of `states`, 0 for those that were not measured; none where it was not estimated, or is nothing
    /// but rounding.
    #[must_use]
    pub fn noise_of(&self, states: &[Channel]) -> Vec<f64> {
        if self.noise_deviations.is_empty() || self.certainty() == Some(Certainty::Exact) {
            return Vec::new();
        }
        let of =
            |state: &Channel| self.noise_deviations.iter().find(|n| n.state == state.name).map_or(0.0, |n| n.sigma);
        states.iter().map(of).collect()
    }

    /// How well all equations together explain the data; `None` where no size of errors is known.
    #[must_use]
    pub fn certainty(&self) -> Option<Certainty> {
        let only_rivals = || self.equations.iter().all(|e| e.reached_floor || e.has_rivals());
        Some(match (self.explained?, self.noise) {
            (true, NoiseSource::Rounding) => Certainty::Exact,
            (true, _) => Certainty::Adequate,
            (false, _) if only_rivals() => Certainty::Ambiguous,
            (false, _) => Certainty::Doubted,
        })
    }

    /// The same, with how well the model predicts the samples that `predicted` has, if it has any.
    #[must_use]
    pub fn with_predictions(self, predicted: Option<&PredictionTable>) -> Self {
        let quality = predicted.map_or_else(Vec::new, |table| table.quality(&self.unmeasured));
        Self { quality, ..self }
    }

    /// Reads an `identify.json`; fields of the log it was made of are left aside.
    ///
    /// # Errors
    /// [`RecordError::Json`] for any other text, [`RecordError::Format`] for a version that is not known.
    pub fn from_json(text: &str) -> Result<Self, RecordError> {
        let account: Self = serde_json::from_str(text)?;
        format::check("identify.json", account.format)?;
        Ok(account)
    }
}
