//! Letters of a planar arm: its equations from twenty samples with accelerations, and the torques that they give.
//!
//! Runs `sindyna identify` on twenty consecutive samples of a letter, for every letter and several beginnings, and compares the inverse dynamics of the equations with the torques of three other
//! letters, in all and by what they are for. Writes results/delan.json and docs/delan.md.

mod page;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;

use anyhow::{Context as _, bail};
use clap::Parser;
use page::{Errors, Figures, Run};
use sindyna_bench::study::{Result, Sindyna, each, root, study};
use sindyna_sindy::Model;

#[derive(Debug, Parser)]
struct Options {
    /// Samples of each log.
    #[arg(long, default_value_t = 20)]
    samples: usize,
    /// Rows of a letter at which logs begin.
    #[arg(long, value_delimiter = ',', default_values_t = [0, 40, 80])]
    beginnings: Vec<usize>,
    /// Write the page from the results that are there, and run nothing.
    #[arg(long)]
    page_only: bool,
    /// Stem of the files in results and docs.
    #[arg(long, default_value = "delan")]
    out: String,
}

/// Rows of a table of numbers, by the letter in its first column.
struct Table {
    header: String,
    rows: Vec<(String, String)>,
}

impl Table {
    fn read(path: &Path) -> Result<Self> {
        let text = fs::read_to_string(path).with_context(|| format!("no {}", path.display()))?;
        let mut lines = text.lines();
        let header = lines.next().context("an empty table")?.to_owned();
        let row = |line: &str| {
            let (letter, _) = line.split_once(',').context("a line without columns")?;
            Ok((letter.to_owned(), line.to_owned()))
        };
        Ok(Self { header, rows: lines.map(row).collect::<Result<_>>()? })
    }

    fn letters(&self) -> Vec<String> {
        let mut letters: Vec<String> = self.rows.iter().map(|(letter, _)| letter.clone()).collect();
        letters.dedup();
        letters
    }
}

fn main() -> Result {
    let options = Options::parse();
    study((&options.out, &format!("docs/{}.md", options.out)), options.page_only, || measure(&options), page::page)
}

fn measure(options: &Options) -> Result<Figures> {
    let sindyna = Sindyna::build()?;
    let data = root().join("crates/bench/data/delan");
    let (train, test) = (Table::read(&data.join("train.csv"))?, Table::read(&data.join("test.csv"))?);
    let truth = samples(&test)?;
    let folder = tempfile::tempdir()?;
    let rows = |letter: &str| train.rows.iter().filter(|(of, _)| of == letter).count();
    let cases: Vec<(String, usize)> = train
        .letters()
        .iter()
        .flat_map(|letter| options.beginnings.iter().map(|from| (letter.clone(), *from)))
        .filter(|(letter, from)| from + options.samples <= rows(letter))
        .collect();
    let mut runs = each(1, &cases, |(letter, from)| {
        let rows = train.rows.iter().filter(|(of, _)| of == letter).skip(*from).take(options.samples);
        let log = folder.path().join(format!("{letter}-{from}.csv"));
        fs::write(
            &log,
            [train.header.clone()].into_iter().chain(rows.map(|(_, row)| row.clone())).collect::<Vec<_>>().join("\n")
                + "\n",
        )?;
        run(sindyna.path(), (letter, *from), &log, &truth)
    })?;
    runs.push(run(sindyna.path(), ("all", 0), &data.join("train.csv"), &truth)?);
    Ok(Figures { samples: options.samples, runs })
}

/// One log.
fn run(program: &Path, (letter, from): (&str, usize), log: &Path, truth: &[Sample]) -> Result<Run> {
    let out: PathBuf = tempfile::tempdir()?.path().join("model");
    let start = Instant::now();
    let done = Command::new(program)
        .args(["identify", "--no-report", "--quiet", "--strict", "--out"])
        .args([&out, log])
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .output()?;
    let seconds = start.elapsed().as_secs_f64();
    let run = Run { letter: letter.to_owned(), from, adequate: false, errors: None, seconds };
    match done.status.code() {
        Some(0 | 1) => {}
        Some(_) => return Ok(run),
        None => bail!("a run of {} was killed", log.display()),
    }
    let model = Model::from_json(&fs::read_to_string(out.join("model.json"))?)?;
    fs::remove_dir_all(&out)?;
    Ok(Run { adequate: done.status.code() == Some(0), errors: errors(&model, truth), ..run })
}

/// What was measured at one time, and what the torques are for.
struct Sample {
    q: [f64; 2],
    dq: [f64; 2],
    ddq: [f64; 2],
    torque: [f64; 2],
    inertial: [f64; 2],
    coriolis: [f64; 2],
    gravity: [f64; 2],
}

fn samples(table: &Table) -> Result<Vec<Sample>> {
    let sample = |(_, row): &(String, String)| {
        let values = row.split(',').skip(2).map(str::parse).collect::<std::result::Result<Vec<f64>, _>>()?;
        let pair = |at: usize| {
            Ok::<_, anyhow::Error>([
                *values.get(at).context("too few columns")?,
                *values.get(at + 1).context("too few columns")?,
            ])
        };
        Ok(Sample {
            q: pair(0)?,
            dq: pair(2)?,
            ddq: pair(4)?,
            torque: pair(6)?,
            inertial: pair(8)?,
            coriolis: pair(10)?,
            gravity: pair(12)?,
        })
    };
    table.rows.iter().map(sample).collect()
}

/// Mean squared errors of the torques that `model` gives; `None` if it gives none.
fn errors(model: &Model, truth: &[Sample]) -> Option<Errors> {
    let torques =
        |q: [f64; 2], dq: [f64; 2], ddq: [f64; 2]| model.inverse_dynamics(&[q, dq].concat(), &[dq, ddq].concat());
    let (mut sums, none) = ([0.0; 4], [0.0; 2]);
    for sample in truth {
        let (gravity, all) = (torques(sample.q, none, none)?, torques(sample.q, sample.dq, sample.ddq)?);
        let (still, steady) = (torques(sample.q, none, sample.ddq)?, torques(sample.q, sample.dq, none)?);
        for i in 0..2 {
            sums[0] += (all[i] - sample.torque[i]).powi(2);
            sums[1] += (still[i] - gravity[i] - sample.inertial[i]).powi(2);
            sums[2] += (steady[i] - gravity[i] - sample.coriolis[i]).powi(2);
            sums[3] += (gravity[i] - sample.gravity[i]).powi(2);
        }
    }
    let [torque, inertial, coriolis, gravity] = sums.map(|sum| sum / truth.len() as f64);
    Some(Errors { torque, inertial, coriolis, gravity })
}
