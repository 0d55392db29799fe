//! What was found and how far to believe it, for people and as JSON.

use std::fmt::Write as _;

use serde::{Deserialize, Serialize};
use sindyna_core::{Channel, Spec};
use sindyna_sindy::{Form, Identified, Noise};

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
}

/// The noise of one state.
#[derive(Debug, Serialize)]
struct Deviation {
    state: String,
    sigma: f64,
    unit: String,
    /// 100 (1 − NRMSE) of the state simulated along each recording.
    fit_percent: Option<f64>,
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
        let deviation = |((state, &sigma), &fit): ((&String, &f64), &f64)| Deviation {
            state: state.clone(),
            sigma,
            unit: unit(state).unwrap_or_default(),
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
                states.zip(&report.fit).map(deviation).collect()
            },
            search_complete: report.search_complete,
        }
    }

    /// The equations, each with its terms, and what speaks for them.
    pub(crate) fn text(&self) -> String {
        let approximation = if self.explained == Some(false) { "an approximation, " } else { "" };
        let mut text = format!("equations: {approximation}{}\n", self.stepping);
        for equation in &self.equations {
            let _ = writeln!(text, "  {}", equation.text());
        }
        text += &self.offset_lines();
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
                let sigma = format!("{} {} {}", d.state, significant(d.sigma, 2), d.unit).trim_end().to_owned();
                d.fit_percent.map_or_else(|| sigma.clone(), |fit| format!("{sigma} (fit {fit:.1} %)"))
            };
            let all: Vec<String> = self.noise_deviations.iter().map(sigma).collect();
            let _ = write!(text, "\nnoise, estimated: {}", all.join(", "));
        }
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
