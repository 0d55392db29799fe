//! How often the equations found are the true ones, from clean data.
//!
//! Identifies every task from several numbers of real steps with the defaults, and other systems, and holds what was found against 10,000 true rates. Writes
//! results/exact.json, docs/exact.md and docs/exact.svg. What was run before is taken from runs/exact; delete that folder after a change of the identifier.

mod page;

use std::io::{self, Write as _};
use std::path::PathBuf;

use clap::Parser;
use page::{Figures, Group, Row};
use sindyna_bench::study::{Result, each, kept, study};
use sindyna_bench::{measure, rivals, system, warm_up};
use sindyna_core::Seed;
use sindyna_record::comparison::Seeds;
use sindyna_sindy::Identifier;
use sindyna_truth::Truth;

/// Points of the box over which exactness is judged.
const POINTS: usize = 10_000;

#[derive(Debug, Parser)]
struct Options {
    /// Tasks.
    #[arg(long, value_delimiter = ',', default_value = "cart-pole,mountain-car,pendulum,inverted-pendulum")]
    tasks: Vec<String>,
    /// Numbers of real steps.
    #[arg(long, value_delimiter = ',', default_value = "5,6,8,10,15,20,30,50")]
    steps: Vec<usize>,
    /// Seeds, such as 100 or 0-9,100-199.
    #[arg(long, default_value = "100")]
    seeds: Seeds,
    /// Other systems.
    #[arg(
        long,
        value_delimiter = ',',
        default_value = "cart-pole-swing-up,driven-pendulum,van-der-pol,lorenz,lotka-volterra,two-link-arm,rotary-pendulum"
    )]
    others: Vec<String>,
    /// Samples of the other systems.
    #[arg(long, value_delimiter = ',', default_value = "100,200")]
    other_steps: Vec<usize>,
    /// Seeds of the other systems.
    #[arg(long, default_value = "5")]
    other_seeds: Seeds,
    /// Runs at a time; times are those of one.
    #[arg(long, default_value_t = 1)]
    jobs: usize,
    /// Write the page from the results that are there, and run nothing.
    #[arg(long)]
    page_only: bool,
    /// Stem of the files in results and docs.
    #[arg(long, default_value = "exact")]
    out: String,
}

fn main() -> Result {
    let options = Options::parse();
    study(
        (&options.out, &format!("docs/{}.md", options.out)),
        options.page_only,
        || figures(&options),
        |document| page::page(document, &options.out),
    )
}

fn figures(options: &Options) -> Result<Figures> {
    let of = |systems: &[String], steps: &[usize], seeds: &Seeds| {
        let all = systems.iter().flat_map(|name| steps.iter().map(|r| (name.clone(), *r, seeds.clone())));
        all.collect::<Vec<_>>()
    };
    let cases = [
        of(&options.tasks, &options.steps, &options.seeds),
        of(&options.others, &options.other_steps, &options.other_seeds),
    ];
    let groups = each(options.jobs, &cases.concat(), |(name, steps, seeds)| {
        let stem = format!("{name}-{steps}-{seeds}.json");
        let rows = kept(PathBuf::from("exact").join(stem), || rows(name, *steps, seeds))?;
        let group = Group::of(name, *steps, &rows);
        writeln!(io::stderr(), "{name}, {steps} steps: {} of {} exact", group.exact, group.seeds)?;
        Ok(group)
    })?;
    Ok(Figures { exact_below: page::EXACT, groups })
}

/// One system from so many steps, for each seed.
fn rows(name: &str, steps: usize, seeds: &Seeds) -> Result<Vec<Row>> {
    let system = system(name)?;
    let identifier = Identifier::new(system.spec());
    let truth = Truth::of(&system, POINTS);
    let row = |seed| {
        let data = warm_up(&system, steps, Seed::new(seed))?;
        let measured = measure(&truth, &identifier, &data).ok().map(|(measured, _)| measured);
        Ok(Row { seed, resets: data.n_rollouts(), measured, rivals: rivals(&truth, &identifier, &data) })
    };
    seeds.iter().map(row).collect()
}
