//! results/OUT.json and docs/OUT.md.

use serde::{Deserialize, Serialize};
use sindyna_bench::study::{Document, Page, Result, by, percent, plain, share, short};
use sindyna_core::number::plural;

/// The result file.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct Figures {
    pub(crate) stem: String,
    /// Options of `train`.
    pub(crate) options: Vec<String>,
    pub(crate) groups: Vec<Group>,
    /// What is to be said of these runs alone.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) notes: Vec<String>,
}

/// One task, noise and number of first real steps.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct Group {
    pub(crate) task: String,
    pub(crate) noise: f64,
    pub(crate) steps: usize,
    pub(crate) seeds: usize,
    pub(crate) refused: usize,
    pub(crate) solved: usize,
    /// Whether there is a return from which the task counts as solved.
    #[serde(default = "yes")]
    pub(crate) target: bool,
    pub(crate) failed_without_a_word: Vec<u64>,
    pub(crate) failed: Vec<u64>,
    pub(crate) median_return: Option<f64>,
    pub(crate) lowest_return: Option<f64>,
    pub(crate) real_steps: Middle,
    pub(crate) real_episodes: Middle,
    pub(crate) predicted: usize,
    pub(crate) held: usize,
    #[serde(alias = "promises")]
    pub(crate) confirmations: usize,
    #[serde(alias = "kept")]
    pub(crate) agreed: usize,
    pub(crate) median_updates: Option<f64>,
    pub(crate) median_seconds: Option<f64>,
    pub(crate) runs: Vec<Run>,
}

fn yes() -> bool {
    true
}

/// Of counts.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct Middle {
    pub(crate) median: Option<f64>,
    pub(crate) most: Option<usize>,
}

impl Middle {
    fn shown(&self) -> String {
        match (self.median, self.most) {
            (Some(median), Some(most)) => format!("{median} ({most})"),
            _ => "—".into(),
        }
    }
}

/// One run.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct Run {
    pub(crate) seed: u64,
    /// Why there was none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) refused: Option<String>,
    /// Of the evaluation.
    #[serde(rename = "return")]
    pub(crate) mean_return: Option<f64>,
    pub(crate) solved: Option<bool>,
    #[serde(skip)]
    pub(crate) threshold: Option<f64>,
    pub(crate) real_steps: usize,
    pub(crate) real_episodes: usize,
    pub(crate) updates: u64,
    /// Mean and ends of the interval.
    pub(crate) prediction: Option<[f64; 3]>,
    /// Whether the interval holds the return.
    pub(crate) held: bool,
    /// Whether the confirmation episode agreed with its prediction, if there was one.
    #[serde(alias = "kept")]
    pub(crate) agrees: Option<bool>,
    #[serde(skip)]
    pub(crate) seconds: f64,
}

/// What is measured: the task, if it is one, the first steps, if all have the same, and the noise.
fn title(groups: &[Group]) -> String {
    let only = |mut names: Vec<String>| {
        names.dedup();
        if names.len() == 1 { names.pop() } else { None }
    };
    let task = only(groups.iter().map(|g| g.task.clone()).collect());
    let steps = only(groups.iter().map(|g| g.steps.to_string()).collect());
    let noises: Vec<f64> =
        by(groups, |g| g.noise).into_iter().map(|(noise, _)| noise).filter(|noise| *noise > 0.0).collect();
    let noise = match noises[..] {
        [] => String::new(),
        [one] => format!(" under {} noise", percent(one)),
        [one, other] => format!(" under {} and {} noise", percent(one), percent(other)),
        _ => format!(" under noise of up to {}", percent(noises.iter().copied().fold(0.0, f64::max))),
    };
    let of = task.map_or_else(String::new, |task| format!(" for {task}"));
    let from = steps.map_or_else(String::new, |steps| format!(" from {steps} steps"));
    format!("Controllers{of}{from}{noise}")
}

/// docs/OUT.md.
pub(crate) fn page(document: &Document<Figures>) -> Result<String> {
    let Figures { stem, options, groups, notes } = &document.figures;
    let sum = |of: &dyn Fn(&Group) -> usize| groups.iter().map(of).sum::<usize>();
    let (predicted, held) = (sum(&|g| g.predicted), sum(&|g| g.held));
    let (failed, silent) = (sum(&|g| g.failed.len()), sum(&|g| g.failed_without_a_word.len()));
    let of_noise = by(groups, |g| g.noise).into_iter().filter_map(|(noise, of)| {
        let of = || of.iter().filter(|g| g.target);
        let runs = of().map(|g| g.seeds).sum::<usize>();
        let solved = of().map(|g| g.solved).sum::<usize>();
        let level = if noise == 0.0 { "Without noise".to_owned() } else { format!("With {} noise", percent(noise)) };
        (runs > 0).then(|| format!("{level} {solved} of {runs} runs solve their task ({}).", share(solved, runs)))
    });
    let interval = format!(
        "The predicted 90 % interval contains the mean return of the evaluation in **{held} of {predicted}** runs ({}).",
        share(held, predicted)
    );
    let warned = (failed > 0).then(|| {
        format!(
            "{} did not solve the task. In {} of these the run had warned: the interval reached below the threshold, or a real episode disagreed with its \
             prediction.",
            plural(failed, "run"),
            failed - silent
        )
    });
    let row = |g: &Group| {
        let solved = if g.target {
            format!("**{}** of {}", g.solved, g.seeds)
        } else {
            format!("{} of {} ended", g.seeds - g.refused, g.seeds)
        };
        vec![
            g.task.clone(),
            percent(g.noise),
            g.steps.to_string(),
            solved,
            format!("{} ({})", plain(g.median_return), plain(g.lowest_return)),
            g.real_steps.shown(),
            g.real_episodes.shown(),
            format!("{} of {}", g.held, g.predicted),
            short(g.median_seconds),
        ]
    };
    let head = [
        "task",
        "noise",
        "first real steps",
        "solved",
        "return, median (lowest)",
        "real steps, median (maximum)",
        "episodes",
        "interval holds",
        "seconds, median",
    ];
    let with =
        if options.is_empty() { String::new() } else { format!(" Options of `train`: `{}`.", options.join(" ")) };
    Ok(Page::new(&title(groups))
        .list(of_noise.chain([interval]).chain(warned))
        .table(&head, groups.iter().map(row))
        .text(notes.join("\n").trim())
        .section("How it was measured")
        .text(&format!(
            "Noise is Gaussian, independent from step to step, on every observation of the system, in training and in evaluation; its standard deviation is the given \
             part of each channel's scale. The learner knows neither the noise nor the scales nor the threshold of the task. All settings are the defaults: equations with residuals \
             at the level of rounding are trusted; while there is a doubt about them, the number of real steps is doubled, and a policy that is optimal in the model has a \
             confirmation episode. *Real steps* and *episodes* count all of that, before the evaluation of 100 episodes. *Seconds* are wall-clock times of one thread, on a \
             machine that did other work as well.{with}"
        ))
        .text(&document.made.origin(stem))
        .markdown())
}
