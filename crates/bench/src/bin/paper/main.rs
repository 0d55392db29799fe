//! Judges the paper's own method as it stands.
//!
//! Runs `sindyna train TASK --library paper --solver stlsq` (threshold 0.0009, ridge 0.05) with the paper's numbers of real steps R, one warm-up rollout and the paper's
//! collecting policy, for each variant of SINDy, and tabulates the outcome beside Table 1 of Arora, da Silva and Moss (2022): with imagined rollouts without end (N = ∞),
//! and where the paper speaks of fine-tuning with real episodes after them too. A run that cannot identify a model counts as not solved. Writes results/paper.json and
//! docs/paper.md. What was run before is taken from runs/paper; delete that folder after a change.

mod page;

use std::fs;
use std::io::{self, Write as _};

use clap::Parser;
use page::{Figures, PAPER, Paper, Run, VARIANTS};
use sindyna_bench::study::{Result, Sindyna, Trained, each, root, study};
use sindyna_record::comparison::Seeds;

#[derive(Debug, Parser)]
struct Options {
    /// Only these tasks.
    #[arg(long, value_delimiter = ',')]
    tasks: Vec<String>,
    /// Seeds, such as 10 or 0-9,100-199.
    #[arg(long, default_value = "10")]
    seeds: Seeds,
    /// Runs at a time, a thread each.
    #[arg(long, default_value_t = 2)]
    jobs: usize,
    /// Updates of a run at most.
    #[arg(long, default_value_t = page::MAX_UPDATES)]
    max_updates: u64,
    /// Write the page from the results that are there, and run nothing.
    #[arg(long)]
    page_only: bool,
    /// Stem of the files in results and docs.
    #[arg(long, default_value = "paper")]
    out: String,
}

fn main() -> Result {
    let options = Options::parse();
    let path = format!("docs/{}.md", options.out);
    study((&options.out, &path), options.page_only, || measure(&options), |document| page::page(document, &options.out))
}

/// What is run with each seed.
struct Setting {
    paper: &'static Paper,
    library: &'static str,
    variant: &'static str,
    imagined: &'static str,
}

fn settings() -> Vec<Setting> {
    let mut settings = Vec::new();
    for paper in &PAPER {
        for library in paper.libraries {
            for (variant, _) in VARIANTS {
                settings.push(Setting { paper, library, variant, imagined: "inf" });
                if paper.fine_tuning > 0 {
                    settings.push(Setting { paper, library, variant, imagined: page::FINITE });
                }
            }
        }
    }
    settings
}

fn measure(options: &Options) -> Result<Figures> {
    let sindyna = Sindyna::build()?;
    let mut settings = settings();
    settings.retain(|s| options.tasks.is_empty() || options.tasks.iter().any(|task| task == s.paper.task));
    let cases: Vec<(&Setting, u64)> =
        options.seeds.iter().flat_map(|seed| settings.iter().map(move |setting| (setting, seed))).collect();
    let runs = each(options.jobs, &cases, |(setting, seed)| {
        let run = train(&sindyna, setting, *seed, options.max_updates)?;
        let Run { task, library, variant, solved, .. } = &run;
        writeln!(io::stderr(), "{task} {library} {variant} {} seed {seed}: solved {solved}", setting.imagined)?;
        Ok(run)
    })?;
    Ok(Figures { version: sindyna.version()?, seeds: options.seeds.iter().collect(), runs })
}

fn train(sindyna: &Sindyna, setting: &Setting, seed: u64, max_updates: u64) -> Result<Run> {
    let Setting { paper, library, variant, imagined } = setting;
    let out = root().join("runs/paper").join(format!("{}-{library}-{variant}-{imagined}-{seed}", paper.task));
    let (steps, updates) = (paper.real_steps.to_string(), max_updates.to_string());
    let options = [
        ["--library", library],
        ["--solver", "stlsq"],
        ["--target", variant],
        ["--real-steps", &steps],
        ["--explorer", paper.explorer],
        ["--imagined-rollouts", imagined],
        ["--max-updates", &updates],
        ["--threads", "1"],
    ];
    let run = Run {
        task: paper.task.into(),
        library: (*library).into(),
        variant: (*variant).into(),
        imagined_rollouts: (*imagined).into(),
        seed,
        ..Run::default()
    };
    let summary = match sindyna.train(paper.task, seed, &out, &options.concat())? {
        Trained::Refused(reason) => return Ok(Run { error: Some(reason), ..run }),
        Trained::Done(summary, _) => *summary,
    };
    let found = summary.identification;
    Ok(Run {
        solved: summary.solved == Some(true),
        parameters: found.as_ref().map(|f| f.parameters),
        nonzero_paper: found.as_ref().map(|f| f.nonzero_paper),
        mean_return: summary.evaluation.map(|e| e.mean_return),
        model_return: summary.training.model_return,
        real_steps: Some(summary.real_steps),
        real_episodes: Some(summary.real_episodes),
        fine_tuning_episodes: Some(summary.real_episodes - collected(&fs::read_to_string(out.join("events.jsonl"))?)?),
        equations: found.map(|f| f.equations),
        diverged: Some(summary.training.diverged),
        left_region: Some(summary.training.left_region),
        ..run
    })
}

/// Real episodes before the first model.
fn collected(events: &str) -> Result<usize> {
    for line in events.lines() {
        let event: serde_json::Value = serde_json::from_str(line)?;
        if event["event"] == "collected" {
            return Ok(serde_json::from_value(event["real_episodes"].clone())?);
        }
    }
    anyhow::bail!("nothing was collected")
}
