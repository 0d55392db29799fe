//! results/odebench.json and docs/odebench.md.

use serde::{Deserialize, Serialize};
use sindyna_bench::child::Outcome;
use sindyna_bench::odebench::{Problem, Spoilt};
use sindyna_bench::study::{Document, Page, Result, short};
use sindyna_core::number::significant;

/// The result file.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct Figures {
    /// Seconds a run may take.
    pub(crate) limit: f64,
    pub(crate) summaries: Vec<Summary>,
    pub(crate) runs: Vec<Run>,
}

/// All problems with one kind of data.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct Summary {
    pub(crate) noise: f64,
    pub(crate) dropped: f64,
    pub(crate) problems: usize,
    pub(crate) reconstruction_accurate: f64,
    pub(crate) generalisation_accurate: f64,
    pub(crate) recovered: usize,
    pub(crate) adequate: usize,
    pub(crate) adequate_but_not_recovered: usize,
    pub(crate) refused: usize,
    pub(crate) timed_out: usize,
    pub(crate) crashed: usize,
    pub(crate) seconds: f64,
    pub(crate) wall_seconds: f64,
    pub(crate) jobs: usize,
}

/// One problem.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Run {
    pub(crate) noise: f64,
    pub(crate) dropped: f64,
    pub(crate) id: u32,
    pub(crate) description: String,
    pub(crate) outcome: Outcome,
    /// Whether the method claims that nothing is left to explain.
    pub(crate) adequate: bool,
    /// Whether the true rates satisfy the equations found.
    pub(crate) recovered: bool,
    /// R² of the trajectory identified from; none where the simulation does not stay finite.
    pub(crate) reconstruction: Option<f64>,
    /// R² of the other.
    pub(crate) generalisation: Option<f64>,
    /// RMS error of the rates over the box of both trajectories, as part of their spread, in the worst equation.
    pub(crate) deviation: Option<f64>,
    /// Processor time of the identification.
    pub(crate) seconds: Option<f64>,
}

impl Run {
    /// A run without equations.
    pub(crate) fn without(problem: &Problem, spoilt: Spoilt, outcome: Outcome) -> Self {
        Self {
            noise: spoilt.noise,
            dropped: spoilt.dropped,
            id: problem.id,
            description: problem.description.clone(),
            outcome,
            adequate: false,
            recovered: false,
            reconstruction: None,
            generalisation: None,
            deviation: None,
            seconds: None,
        }
    }
}

/// docs/odebench.md.
pub(crate) fn page(document: &Document<Figures>) -> Result<String> {
    let Figures { limit, summaries, runs } = &document.figures;
    let percent = |share: f64| format!("{:.0} %", 100.0 * share);
    let kind = |s: &Summary| match (s.noise, s.dropped) {
        (0.0, 0.0) => "Clean, all samples".to_owned(),
        (noise, 0.0) => format!("{} noise, all samples", percent(noise)),
        (0.0, dropped) => format!("Clean, {} of the samples dropped", percent(dropped)),
        (noise, dropped) => format!("{} noise, {} of the samples dropped", percent(noise), percent(dropped)),
    };
    let finding = |s: &Summary| {
        format!(
            "{}: R² > 0.9 for {} of the equations from the same start and {} from another one; the true terms for {} of {}; {} of {} equations that are \
             called adequate have other terms.",
            kind(s),
            percent(s.reconstruction_accurate),
            percent(s.generalisation_accurate),
            s.recovered,
            s.problems,
            s.adequate_but_not_recovered,
            s.adequate
        )
    };
    let totals = summaries.iter().map(|s| {
        vec![
            percent(s.noise),
            percent(s.dropped),
            percent(s.reconstruction_accurate),
            percent(s.generalisation_accurate),
            s.recovered.to_string(),
            s.adequate.to_string(),
            s.adequate_but_not_recovered.to_string(),
            s.timed_out.to_string(),
            short(Some(s.seconds)),
            short(Some(s.wall_seconds)),
        ]
    });
    let yes = |holds: bool| if holds { "yes" } else { "" }.to_owned();
    let row = |run: &Run| {
        let time = match run.seconds {
            None => format!("{:?}", run.outcome).to_lowercase(),
            seconds => short(seconds),
        };
        vec![
            run.id.to_string(),
            run.description.clone(),
            short(run.reconstruction),
            short(run.generalisation),
            yes(run.recovered),
            yes(run.adequate),
            short(run.deviation),
            time,
        ]
    };
    let clean = runs.iter().filter(|run| run.noise == 0.0 && run.dropped == 0.0).map(row);
    let jobs = summaries.iter().map(|s| s.jobs).max().unwrap_or(1);
    let head = [
        "noise",
        "dropped",
        "reconstruction R² > 0.9",
        "generalisation R² > 0.9",
        "recovered",
        "called adequate",
        "adequate, not recovered",
        "over the limit",
        "processor time of all, s",
        "wall time, s",
    ];
    Ok(Page::new("ODEBench")
        .text("63 published ordinary differential equations, identified from one start and judged from another.")
        .list(summaries.iter().map(finding).chain(["ODEFormer's paper prints 66 % for the same start and 33 % for another one.".into()]))
        .table(&head, totals)
        .section("Clean, all samples")
        .table(&["", "", "R² same start", "R² other start", "recovered", "adequate", "deviation", "s"], clean)
        .section("How it was measured")
        .text(
            "63 equations of one to four dimensions (ODEFormer, d'Ascoli et al., 2024; crates/bench/data), 512 samples over 10 s from the first start, equations \
             judged by the motion they predict from the first start (*reconstruction*) and from the second, which was not seen (*generalisation*). Noise \
             multiplies each sample by 1 + σ ε; samples are dropped at random. The method knows only the names.",
        )
        .text(&format!(
            "*Recovered*: exactly the true terms. An adequate equation that is not recovered may have the true rates in other terms; its deviation, the RMS \
             error of its rates over their spread, tells. Seconds of a problem are processor time; problems at a time: {jobs}, each on one core. A run over {} s \
             counts as failed.",
            significant(*limit, 6)
        ))
        .text(&document.made.origin("odebench"))
        .markdown())
}
