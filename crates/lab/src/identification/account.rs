//! What was found and how far to believe it, for people and as JSON.

use std::fmt::Write as _;

use serde::{Deserialize, Serialize};
use sindyna_core::{Channel, Spec};
use sindyna_sindy::{AnalysisError, Form, Identified, Model, Noise, Recording};

use super::Stepping;
use super::equation::{ESTIMATED, Equation};
use crate::number::significant;

/// The account of an identification.
#[derive(Debug, Serialize)]
pub(crate) struct Account {
    /// Steps the equations were fitted to.
    pub(crate) rows: usize,
    /// Steps left out because a channel sat at its declared bound.
    pub(crate) rows_at_limit: usize,
    /// Steps left out because they do not follow the equations of all the others.
    pub(crate) rows_astray: usize,
    /// Condition number of the columns of the regression, each scaled to unit length: of all candidate terms, or for
    /// equations of motion of the terms found. `null` with fewer rows than columns.
    condition: Option<f64>,
    /// Candidate terms.
    pub(crate) features: Vec<String>,
    pub(crate) stepping: Stepping,
    /// What is added to an angle before the terms are computed, where that is not zero.
    pub(crate) offsets: Vec<Offset>,
    /// Whether the residual of every equation is no more than the sensors explain; `null` where that is not known.
    pub(crate) explained: Option<bool>,
    pub(crate) equations: Vec<Equation>,
    /// Where the size of the samples' errors comes from: `rounding`, `declared` or `estimated`.
    noise: &'static str,
    /// RMS difference of each state as measured and as it follows from the equations, where it was estimated.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    noise_deviations: Vec<Deviation>,
    /// Whether the search for terms tried all it would.
    search_complete: bool,
    /// What the data do not show.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    warnings: Vec<String>,
    /// How well the model predicts a part of the log that it was not fitted to.
    #[serde(skip_serializing_if = "Option::is_none")]
    held_out: Option<HeldOut>,
}

/// Predictions of samples that the equations were not fitted to.
#[derive(Debug, Serialize)]
struct HeldOut {
    steps: usize,
    /// Why there are none.
    #[serde(skip_serializing_if = "Option::is_none")]
    failed: Option<String>,
    predictions: Vec<Prediction>,
}

/// 100 (1 − NRMSE) of each state, predicted so many steps ahead; from the first sample where there is no number.
#[derive(Debug, Serialize)]
struct Prediction {
    horizon: Option<usize>,
    fit_percent: Vec<(String, Option<f64>)>,
}

/// Steps ahead that are predicted of samples held out; `None` is all the way from the first.
const HORIZONS: [Option<usize>; 3] = [Some(1), Some(10), None];

/// The noise of one state.
#[derive(Debug, Serialize)]
struct Deviation {
    state: String,
    sigma: f64,
    unit: String,
    /// Share of the noise's variance that grows with the square of the state.
    #[serde(skip_serializing_if = "is_zero")]
    growing: f64,
    /// 100 (1 − NRMSE) of the state simulated along each recording.
    fit_percent: Option<f64>,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde asks so")]
fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

/// What is added to a state before the terms are computed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Offset {
    state: String,
    offset: f64,
}

impl Account {
    /// The account of `found`, identified in data of the system `spec`.
    pub(crate) fn new(found: &Identified, spec: &Spec) -> Self {
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
        let deviation = |(((state, &sigma), &fit), &growing): (((&String, &f64), &f64), &f64)| Deviation {
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
                Noise::Rounding => "rounding",
                Noise::Declared => "declared",
                Noise::Estimated => "estimated",
            },
            noise_deviations: {
                let states = model.states().iter().zip(&report.noise_deviations);
                states.zip(&report.fit).zip(&report.noise_growing).map(deviation).collect()
            },
            search_complete: report.search_complete,
            warnings: report.warnings.clone(),
            held_out: None,
        }
    }

    /// Adds how well `model` predicts `recordings` that it was not fitted to.
    pub(crate) fn judge(&mut self, model: &Model, recordings: &[Recording]) {
        let steps = recordings.iter().map(|r| r.controls.nrows()).sum();
        let of = |horizon: &Option<usize>| {
            let fit = model.compare(recordings, *horizon)?;
            let percent = fit.iter().map(|f| Some(100.0 * f).filter(|f| f.is_finite()));
            let fit_percent = model.states().iter().cloned().zip(percent).collect();
            Ok::<_, AnalysisError>(Prediction { horizon: *horizon, fit_percent })
        };
        let (predictions, failed): (Vec<_>, Vec<_>) = HORIZONS.iter().map(of).partition(Result::is_ok);
        self.held_out = Some(HeldOut {
            steps,
            predictions: predictions.into_iter().flatten().collect(),
            failed: failed.into_iter().filter_map(Result::err).map(|e| e.to_string()).next(),
        });
    }

    /// What was held out, and how well it is predicted.
    fn held_out_lines(&self) -> String {
        let Some(held_out) = &self.held_out else { return String::new() };
        let mut text = format!("\nheld out: {} steps", held_out.steps);
        for prediction in &held_out.predictions {
            let how = match prediction.horizon {
                Some(1) => "1 step ahead".to_owned(),
                Some(steps) => format!("{steps} steps ahead"),
                None => "from the first sample".to_owned(),
            };
            let fit = |(state, fit): &(String, Option<f64>)| match fit {
                Some(fit) => format!("{state} {fit:.1} %"),
                None => format!("{state} —"),
            };
            let all: Vec<String> = prediction.fit_percent.iter().map(fit).collect();
            let _ = write!(text, "\n  fit of predictions {how}: {}", all.join(", "));
        }
        if let Some(failed) = &held_out.failed {
            let _ = write!(text, "\n  no more predictions: {failed}");
        }
        text
    }

    /// The equations, each with its terms, and what speaks for them.
    pub(crate) fn text(&self) -> String {
        let approximation = if self.explained == Some(false) { "an approximation, " } else { "" };
        let mut text = format!("equations: {approximation}{}\n", self.stepping);
        for equation in &self.equations {
            let _ = writeln!(text, "  {}", equation.text());
        }
        text += &self.offset_lines();
        for warning in &self.warnings {
            let _ = writeln!(text, "warning: {warning}");
        }
        for equation in &self.equations {
            text.push('\n');
            text.push_str(&equation.table(self.sensors()));
        }
        let _ = write!(text, "\nsteps used: {}", self.steps());
        let condition = match self.condition {
            Some(condition) => significant(condition, 2),
            None => "infinite (fewer steps than terms)".into(),
        };
        if !self.noise_deviations.is_empty() {
            let sigma = |d: &Deviation| {
                let grows = if d.growing > 0.0 { ", growing with it" } else { "" };
                let sigma = format!("{} {} {}", d.state, significant(d.sigma, 2), d.unit);
                let sigma = sigma.trim_end().to_owned() + grows;
                d.fit_percent.map_or_else(|| sigma.clone(), |fit| format!("{sigma} (fit {fit:.1} %)"))
            };
            let all: Vec<String> = self.noise_deviations.iter().map(sigma).collect();
            let _ = write!(text, "\nnoise, estimated: {}", all.join(", "));
        }
        text += &self.held_out_lines();
        if !self.search_complete {
            text +=
                "\nthe search for terms ended before all proposals were tried: fewer rows or states make it complete";
        }
        let _ = writeln!(text, "\ncandidate terms: {}; condition number: {condition}", self.features.len());
        text
    }

    /// How the equations are stepped, and whether they are all there is: lines below them.
    pub(crate) fn verdict(&self) -> String {
        let mut text = format!("{}\n", self.stepping);
        text += &self.offset_lines();
        if self.rows_at_limit + self.rows_astray > 0 {
            let _ = writeln!(text, "steps used: {}", self.steps());
        }
        if self.explained == Some(true) {
            let _ = writeln!(text, "what is left of every fitted equation is as small as {} explains", self.sensors());
        }
        let missed: Vec<String> = self.equations.iter().filter_map(|e| e.excess(self.sensors())).collect();
        for excess in &missed {
            let _ = writeln!(text, "not exact: {excess}");
        }
        if !missed.is_empty() {
            text +=
                "more real steps (--real-steps), another --library or a --term of your own may find what is missing\n";
        }
        text
    }

    /// How many steps were used, and how many were not.
    fn steps(&self) -> String {
        let left_out = |count: usize, why: &str| match count {
            0 => String::new(),
            _ => format!(", left out {why}: {count}"),
        };
        let (at_limit, astray) = (self.rows_at_limit, self.rows_astray);
        self.rows.to_string() + &left_out(at_limit, "at a limit") + &left_out(astray, "as unlike all others")
    }

    fn offset_lines(&self) -> String {
        let line = |Offset { state, offset }: &Offset| {
            format!("angle offset: the zero of {state} is taken to be at {}\n", significant(-offset, 6))
        };
        self.offsets.iter().map(line).collect()
    }

    /// What is known to be wrong with what sensors say.
    fn sensors(&self) -> &'static str {
        match self.noise {
            "estimated" => ESTIMATED,
            "declared" => "noise",
            _ => "rounding",
        }
    }
}
