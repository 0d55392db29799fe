//! results/paper.json and docs/paper.md.

use std::fs;

use serde::{Deserialize, Serialize};
use sindyna_bench::study::{Document, Page, Result, count, median, root};
use sindyna_core::number::fixed;

/// Updates of a run at most.
pub(crate) const MAX_UPDATES: u64 = 20_000;

/// N where real episodes follow: so large that none comes before the policy is optimal in the model.
pub(crate) const FINITE: &str = "1000000";

/// Arora, da Silva, Moss (2022): Table 1, and the text on collecting policy and fine-tuning.
pub(crate) struct Paper {
    pub(crate) task: &'static str,
    pub(crate) libraries: &'static [&'static str],
    pub(crate) real_steps: usize,
    parameters: usize,
    nonzero: &'static str,
    pub(crate) explorer: &'static str,
    pub(crate) fine_tuning: usize,
}

const fn row(
    task: &'static str,
    libraries: &'static [&'static str],
    (real_steps, parameters, nonzero): (usize, usize, &'static str),
    explorer: &'static str,
    fine_tuning: usize,
) -> Paper {
    Paper { task, libraries, real_steps, parameters, nonzero, explorer, fine_tuning }
}

pub(crate) const PAPER: [Paper; 4] = [
    row("cart-pole", &["paper"], (30, 164, "~70"), "alternating", 2),
    row("mountain-car", &["paper"], (50, 50, "7"), "random", 0),
    row("pendulum", &["paper", "paper-degree2"], (20, 99, "10"), "random", 0),
    row("inverted-pendulum", &["paper"], (30, 164, "50"), "alternating", 1),
];

/// Variants of SINDy, and what is fitted.
pub(crate) const VARIANTS: [(&str, &str); 3] =
    [("continuous", "ẋ by central differences"), ("smoothed", "ẋ after Savitzky–Golay smoothing"), ("discrete", "x⁺")];

/// The result file.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct Figures {
    pub(crate) version: String,
    pub(crate) seeds: Vec<u64>,
    pub(crate) runs: Vec<Run>,
}

/// One run.
#[derive(Debug, Default, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct Run {
    pub(crate) task: String,
    pub(crate) library: String,
    pub(crate) variant: String,
    pub(crate) imagined_rollouts: String,
    pub(crate) seed: u64,
    pub(crate) solved: bool,
    /// Why there is no model.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) error: Option<String>,
    pub(crate) parameters: Option<usize>,
    pub(crate) nonzero_paper: Option<usize>,
    pub(crate) mean_return: Option<f64>,
    pub(crate) model_return: Option<f64>,
    pub(crate) real_steps: Option<usize>,
    pub(crate) real_episodes: Option<usize>,
    pub(crate) fine_tuning_episodes: Option<usize>,
    pub(crate) equations: Option<Vec<String>>,
    pub(crate) diverged: Option<u64>,
    pub(crate) left_region: Option<u64>,
}

impl Run {
    /// What is the same in a line of the table.
    fn key(&self) -> [&str; 4] {
        [&self.task, &self.library, &self.variant, &self.imagined_rollouts]
    }

    fn variant(&self) -> &'static str {
        VARIANTS.iter().find(|(name, _)| *name == self.variant).map_or("", |(_, what)| *what)
    }

    fn paper(&self) -> Option<&'static Paper> {
        PAPER.iter().find(|paper| paper.task == self.task)
    }

    /// Whether the run is solved with no more real episodes than the paper needed.
    fn generalises(&self) -> bool {
        let most = self.paper().map_or(0, |paper| paper.fine_tuning);
        self.solved && self.fine_tuning_episodes.is_some_and(|episodes| episodes <= most)
    }
}

/// docs/STEM.md.
pub(crate) fn page(document: &Document<Figures>, stem: &str) -> Result<String> {
    let Figures { version, seeds, runs } = &document.figures;
    let mut lines: Vec<[&str; 4]> = Vec::new();
    for paper in &PAPER {
        for run in runs.iter().filter(|run| run.task == paper.task) {
            if !lines.contains(&run.key()) {
                lines.push(run.key());
            }
        }
    }
    let of = |key: &[&str; 4]| runs.iter().filter(|run| run.key() == *key).collect::<Vec<&Run>>();
    let first = seeds.iter().min();
    let shown = runs.iter().filter(|run| Some(&run.seed) == first && run.imagined_rollouts == "inf");
    let mut page = Page::new("The paper's method, reproduced")
        .list(PAPER.iter().filter_map(|paper| finding(paper, runs)))
        .table(&HEAD, lines.iter().filter_map(|key| table_row(&of(key))))
        .text("*Solved*: the mean return of 100 evaluation episodes reaches the task's threshold, after no more real episodes than the paper needed.")
        .section("How it was measured")
        .text(&format!(
            "Each line: {} seeds, STLSQ with threshold 0.0009 and ridge 0.05, one rollout of R real steps, at most {MAX_UPDATES} updates; from task to task only what the \
             paper changes (R, the collecting policy, fine-tuning). {version}.",
            seeds.len()
        ))
        .text(&document.made.origin(stem))
        .section("Equations found")
        .text("The first seed of each line; at full length in the result file.");
    for run in shown {
        let none = || vec![run.error.clone().unwrap_or_else(|| "no model".into())];
        let equations = run.equations.clone().unwrap_or_else(none);
        let cut = |equation: &String| match equation.char_indices().nth(157) {
            Some((end, _)) if equation.chars().count() >= 160 => equation[..end].to_owned() + "…",
            _ => equation.clone(),
        };
        page = page
            .text(&format!("**{}**, `{}`, {}", run.task, run.library, run.variant()))
            .code(&equations.iter().map(cut).collect::<Vec<_>>());
    }
    let readings = fs::read_to_string(root().join("docs/paper-readings.md"))?;
    Ok(page.text(readings.trim_end()).markdown())
}

/// What comes of one task.
fn finding(paper: &Paper, runs: &[Run]) -> Option<String> {
    let runs: Vec<&Run> = runs.iter().filter(|run| run.task == paper.task).collect();
    let solved = runs.iter().filter(|run| run.generalises()).count();
    let without = runs.iter().filter(|run| run.error.is_some()).count();
    let none = if without > 0 { format!("; {without} runs find no model") } else { String::new() };
    (!runs.is_empty()).then(|| {
        format!(
            "{}: {solved} of {} runs solve the task from {} real steps{none}. In the paper the model generalises.",
            paper.task,
            runs.len(),
            paper.real_steps
        )
    })
}

const HEAD: [&str; 16] = [
    "task",
    "library",
    "variant",
    "N",
    "R",
    "P",
    "paper's P",
    "P′, median",
    "paper's P′",
    "solved (generalises)",
    "the paper",
    "episodes of fine-tuning, median",
    "the paper's",
    "return in the model, median",
    "return on the system, median",
    "no model",
];

fn table_row(rows: &[&Run]) -> Option<Vec<String>> {
    let (first, paper) = (rows.first()?, rows.first()?.paper()?);
    let middle = |of: fn(&Run) -> Option<f64>, digits: usize| {
        median(rows.iter().filter_map(|run| of(run))).map_or_else(|| "–".into(), |value| fixed(value, digits))
    };
    Some(vec![
        first.task.clone(),
        format!("`{}`", first.library),
        first.variant().into(),
        if first.imagined_rollouts == "inf" { "∞" } else { "finite" }.into(),
        paper.real_steps.to_string(),
        middle(|run| Some(run.parameters? as f64), 0),
        paper.parameters.to_string(),
        middle(|run| Some(run.nonzero_paper? as f64), 0),
        paper.nonzero.into(),
        format!("{} of {}", count(rows, |run| run.generalises()), rows.len()),
        "yes".into(),
        middle(|run| Some(run.fine_tuning_episodes? as f64), 0),
        paper.fine_tuning.to_string(),
        middle(|run| run.model_return, 1),
        middle(|run| run.mean_return, 1),
        count(rows, |run| run.error.is_some()).to_string(),
    ])
}
