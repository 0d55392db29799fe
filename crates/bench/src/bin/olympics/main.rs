//! The simulation boards of the AI Olympics: a double pendulum whose elbow or shoulder is driven swings up and stays there.
//!
//! For each robot and seed, `sindyna identify` reads two seconds of noisy samples, a planner swings up in its equations, and what it does in the boards' own simulator is scored by
//! their rules. Of the machine only the limit of the torque and, for the height of the tip, the lengths of the links are told. The published runs of the best controllers are scored as
//! well. Writes results/olympics.json and docs/olympics.md.

mod control;
mod learn;
mod page;
mod plant;
mod score;
mod task;

use std::fs;
use std::io::{self, Write as _};
use std::time::Instant;

use anyhow::Context as _;
use clap::Parser;
use sindyna_bench::study::{Result, Sindyna, root, study};
use sindyna_record::comparison::Seeds;

use control::{controlled, planner};
use learn::learn;
use page::{Figures, Published, Swing};
use plant::{Plant, Robot, STEPS, stepped};
use score::Score;

#[derive(Debug, Parser)]
struct Options {
    /// Seeds of the logs.
    #[arg(long, default_value = "0-4")]
    seeds: Seeds,
    /// Write the page from the results that are there, and run nothing.
    #[arg(long)]
    page_only: bool,
    /// Stem of the files in results and docs.
    #[arg(long, default_value = "olympics")]
    out: String,
}

fn main() -> Result {
    let options = Options::parse();
    study(
        (&options.out, &format!("docs/{}.md", options.out)),
        options.page_only,
        || measure(&options),
        |document| page::page(document, &options.out),
    )
}

fn measure(options: &Options) -> Result<Figures> {
    let sindyna = Sindyna::build()?;
    let published = Robot::ALL.into_iter().map(published).collect::<Result<_>>()?;
    let mut swings = Vec::new();
    for robot in Robot::ALL {
        for seed in options.seeds.iter() {
            let swing = swing(&sindyna, robot, seed)?;
            let (name, Swing { adequate, score, .. }) = (robot.name(), &swing);
            let _ = writeln!(io::stderr(), "{name} {seed}: adequate {adequate}, score {:.3}", score.score);
            swings.push(swing);
        }
    }
    Ok(Figures { published, swings })
}

/// One log, and the swing-up that was planned in its equations.
fn swing(sindyna: &Sindyna, robot: Robot, seed: u64) -> Result<Swing> {
    let learned = learn(sindyna.path(), robot, seed)?;
    let start = Instant::now();
    let planner = planner(&learned.model, robot)?;
    let seconds = start.elapsed().as_secs_f64();
    let run = controlled(&stepped(Plant::NOMINAL), robot, &planner)?;
    Ok(Swing {
        robot: robot.name().to_owned(),
        seed,
        adequate: learned.adequate,
        identification_seconds: learned.seconds,
        planning_seconds: seconds,
        score: Score::of(&run.x[..STEPS], &run.torque),
    })
}

/// The published run of the best controller of a board, scored again.
fn published(robot: Robot) -> Result<Published> {
    let path = root().join("crates/bench/data/olympics").join(format!("{}.csv", robot.name()));
    let text = fs::read_to_string(&path).with_context(|| format!("no {}", path.display()))?;
    let (mut x, mut torque) = (Vec::new(), Vec::new());
    for line in text.lines().skip(1) {
        let row = line.split(',').map(str::parse).collect::<std::result::Result<Vec<f64>, _>>()?;
        let [q1, q2, v1, v2, tau] = row[..] else { anyhow::bail!("{} has a line of {}", path.display(), row.len()) };
        x.push([q1, q2, v1, v2]);
        let mut both = [0.0; 2];
        both[robot.joint()] = tau;
        torque.push(both);
    }
    Ok(Published { robot: robot.name().to_owned(), score: Score::of(&x, &torque) })
}
