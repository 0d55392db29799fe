//! The page of one record: an identification, or a run.

mod animation;
mod controller;
mod equations;
mod mathml;
mod most;
mod series;
mod verdict;

use sindyna_envs::System;
use sindyna_record::run::{ChannelRange, Coverage, Moment, Summary};
use sindyna_record::{ModelRecord, RunRecord};

use crate::Page;
use crate::document::Block;
use crate::figure::plots;
use crate::numbers::{fixed, plural, significant};
use crate::thin::Point;
use most::MOST_ROWS;

/// The page of an identification from `source`.
#[must_use]
pub fn model_page(record: &ModelRecord, source: &str) -> Page {
    let mut blocks = verdict::blocks(&record.account);
    blocks.extend(identified(record, None));
    let mut missing = Vec::new();
    if record.prediction.is_none() {
        missing.push("prediction.csv");
    }
    blocks.extend(left_out(&missing));
    Page { title: format!("Identification of {}", source.chars().take(120).collect::<String>()), blocks }
}

/// The page of a run; `system` is the true one, if it is known.
#[must_use]
pub fn run_page(record: &RunRecord, system: Option<&System>) -> Page {
    let summary = &record.summary;
    let mut blocks = result(summary);
    let mut missing = Vec::new();
    if let Some(episode) = record.episode.as_ref().filter(|episode| episode.rows.len() > 1) {
        blocks.push(Block::Section("Episode".into()));
        // Shapes are those of our own systems: another of the same name is only plotted.
        let shape = system.and_then(|_| animation::Shape::of(&summary.task, &episode.states));
        if let Some(html) = shape.and_then(|shape| animation::html(episode, shape)) {
            blocks.push(Block::Markup { html, text: String::new() });
        }
        blocks.extend(series::episode(episode));
    } else if summary.evaluation.is_some() {
        missing.push("episode.csv");
    }
    blocks.extend(training(summary, &record.moments));
    match &record.identified {
        Some(identified_model) => {
            blocks.push(Block::Section("Identification".into()));
            blocks.extend(verdict::blocks(&identified_model.account));
            blocks.extend(identified(identified_model, system));
            if identified_model.prediction.is_none() {
                missing.push("prediction.csv");
            }
        }
        None => {
            if let Some(model) = &record.model {
                blocks.extend(equations::equations(model, None));
                blocks.extend(equations::coefficients(None, model, system));
                missing.push("identify.json");
            }
        }
    }
    blocks.extend(left_out(&missing));
    Page { title: format!("{}, seed {}", summary.task, summary.seed), blocks }
}

/// What is left out of a page because the record does not have it.
fn left_out(missing: &[&str]) -> Option<Block> {
    let names = missing.join(", ");
    (!missing.is_empty()).then(|| Block::text(format!("Left out: the record has no {names}.")))
}

/// Equations, coefficients, predictions and all else about a model.
fn identified(record: &ModelRecord, system: Option<&System>) -> Vec<Block> {
    let account = &record.account;
    let mut blocks = Vec::new();
    if let Some(model) = &record.model {
        blocks.extend(equations::equations(model, Some(account)));
    }
    let predicted = record.prediction.as_ref();
    blocks.extend(predicted.map_or_else(Vec::new, |table| series::predictions(table, &account.unmeasured)));
    if let Some(model) = &record.model {
        blocks.extend(equations::coefficients(Some(account), model, system));
    }
    blocks.push(Block::Section("Residuals and noise".into()));
    blocks.push(verdict::quality(account));
    let condition = account.condition.map_or_else(|| "infinite".to_owned(), |c| significant(c, 2));
    let excluded = account.rows_at_limit + account.rows_astray;
    let excluded = if excluded > 0 { format!(" {excluded} steps are excluded.") } else { String::new() };
    blocks.push(Block::text(format!(
        "{} are fitted.{excluded} {}; condition number {condition}.",
        plural(account.rows, "step"),
        plural(account.features.len(), "candidate term")
    )));
    blocks.extend(account.held_out.iter().flat_map(verdict::held_out));
    blocks.extend(equations::sizes(account));
    blocks.extend(predicted.map_or_else(Vec::new, series::coverages));
    blocks.extend(equations::equally_good(account));
    blocks
}

/// What came of a run, in the first lines.
fn result(summary: &Summary) -> Vec<Block> {
    let threshold = summary.threshold.map_or_else(String::new, |t| format!(" (threshold {})", fixed(t, 0)));
    let text = match (&summary.evaluation, summary.solved) {
        (Some(e), solved) => {
            let solved = match solved {
                Some(true) => "Solved: mean return",
                Some(false) => "Not solved: mean return",
                None => "Mean return",
            };
            format!(
                "{solved} {} ± {} over {}{threshold}.",
                fixed(e.mean_return, 1),
                fixed(e.std_return, 1),
                plural(e.episodes, "episode")
            )
        }
        (None, _) if summary.interrupted => "Interrupted before the evaluation.".into(),
        (None, _) if summary.from_log => {
            "Not evaluated: the data are a log, there is no system. The return below is predicted.".into()
        }
        (None, _) => "No policy was evaluated.".into(),
    };
    let mut blocks = vec![Block::Verdict { good: summary.solved, text }];
    let steps = plural(summary.real_steps, "step");
    let episodes = plural(summary.real_episodes, "episode");
    blocks.push(Block::text(format!(
        "Data: {steps} on the system in {episodes}. Controller: {}.",
        controller::name(&summary.training)
    )));
    if let Some(failure) = &summary.training.refit_failure {
        blocks.push(Block::text(format!("All {steps} do not fit one model ({failure}): the equations may be wrong.")));
    }
    if let Some(failure) = &summary.training.failure {
        blocks.push(Block::text(format!("Training stopped early: {failure}.")));
    }
    blocks
}

/// The training curve and the returns of the evaluation.
fn training(summary: &Summary, moments: &[Moment]) -> Vec<Block> {
    let (mut trials, mut fits, mut real): (Vec<Point>, Vec<f64>, Vec<Point>) = Default::default();
    for moment in moments {
        match *moment {
            Moment::Trial { updates, model_return } => trials.push((updates as f64, model_return)),
            Moment::Fitted { updates } => fits.push(updates as f64),
            Moment::Confirmed { updates, real_return } => real.push((updates as f64, real_return)),
            _ => {}
        }
    }
    // Before the first update is nothing to see: the first model is not one that is identified again.
    fits.retain(|updates| *updates > 0.0);
    fits.dedup();
    let mut figures = Vec::new();
    // A planner has no updates to draw its return by.
    if !trials.is_empty() && summary.training.planners.is_empty() {
        figures.push(plots::training(&trials, &fits, &real, summary.threshold));
    }
    let prediction = summary.training.prediction.as_ref();
    if let Some(evaluation) = &summary.evaluation {
        let interval = prediction.map(|p| (p.low, p.high));
        figures.push(plots::returns(&evaluation.returns, evaluation.mean_return, interval, summary.threshold));
    }
    let mut blocks = vec![Block::Section("Training and evaluation".into())];
    let of = &summary.training;
    blocks.push(Block::text(controller::told(of)));
    let approximate = summary.identification.as_ref().is_some_and(|i| i.explained == Some(false));
    if let Some(p) = prediction {
        let level = 100.0 * p.level;
        blocks.push(Block::text(format!(
            "Predicted mean return{} {}, {level:.0} % interval {} to {}{}.",
            if summary.input_delay_seconds.is_some() { " without the delay of the inputs" } else { "" },
            fixed(p.mean, 1),
            fixed(p.low, 1),
            fixed(p.high, 1),
            if approximate { "; parameter uncertainty only, the equations are an approximation" } else { "" }
        )));
    }
    if let Some(c) = &of.confirmation {
        blocks.push(Block::text(format!(
            "Confirmation episode: return {}, predicted {} ± {}.",
            fixed(c.real, 1),
            fixed(c.predicted, 1),
            fixed(c.spread, 1)
        )));
    }
    blocks.push(Block::Figures(figures));
    blocks.extend(of.coverage.iter().flat_map(coverage));
    blocks
}

/// Where the policy goes in the model, and where the data were.
fn coverage(coverage: &Coverage) -> Vec<Block> {
    let range = |(low, high): (f64, f64)| format!("{} to {}", significant(low, 3), significant(high, 3));
    let row = |r: &ChannelRange| {
        let beyond = if r.is_beyond() { "yes" } else { "no" };
        [r.channel.clone(), r.unit.clone(), range(r.data), range(r.policy), beyond.into()]
    };
    vec![
        Block::text(format!(
            "In {} of the policy in the model, {} % of the steps are beyond the range of the data, where the model was not compared with the system.",
            plural(coverage.episodes, "episode"),
            fixed(100.0 * coverage.share_outside, 0)
        )),
        Block::table(
            2,
            ["state or control", "unit", "data", "policy", "beyond the data"],
            coverage.states.iter().chain(&coverage.controls).take(MOST_ROWS).map(row).collect(),
        ),
    ]
}
