//! Kills a long training at random moments and resumes it: is the record the same, and how much of the time is lost?
//!
//! A run that is never stopped is the measure. Each of the others is killed at a moment drawn uniformly over that time, then resumed from its checkpoint with `sindyna train
//! --resume`. All files of the two records but timing.json must be the same, byte for byte. Time is processor time of both processes over that of the run that was never
//! stopped: it does not depend on what else the machine does. Writes results/OUT.json.

use std::collections::BTreeMap;
use std::io::{self, Write as _};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};
use std::{fs, thread};

use clap::Parser;
use rand::RngExt as _;
use serde::Serialize;
use sindyna_bench::study::{Result, Sindyna, count, ended_seconds, median, rounded, store};
use sindyna_core::Seed;

/// A training of more than half a minute.
const LONG: [&str; 7] =
    ["cart-pole-swing-up", "--noise", "0.01", "--real-steps", "300", "--set", "sac.hidden=[256,256]"];

/// Time between two looks at the process.
const LOOK: Duration = Duration::from_millis(1);

#[derive(Debug, Parser)]
struct Options {
    /// How often.
    #[arg(long, default_value_t = 20)]
    kills: usize,
    /// Seed of the moments.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Stem of the file in results.
    #[arg(long, default_value = "resume")]
    out: String,
    /// Task and options of `sindyna train`, after --.
    #[arg(last = true)]
    train: Vec<String>,
}

#[derive(Debug, Serialize)]
struct Figures {
    train: Vec<String>,
    wall_seconds: Option<f64>,
    cpu_seconds: Option<f64>,
    same: usize,
    of: usize,
    lost_median: Option<f64>,
    lost_most: Option<f64>,
    kills: Vec<Kill>,
}

/// One run that was killed.
#[derive(Debug, Serialize)]
struct Kill {
    after_seconds: Option<f64>,
    /// Or had ended before.
    killed: bool,
    checkpoint_bytes: u64,
    /// Whether the record is that of the run that was never stopped.
    same: bool,
    /// Processor time more than that of the run that was never stopped, as a part of it.
    lost: f64,
}

fn main() -> Result {
    let options = Options::parse();
    let train = if options.train.is_empty() { LONG.map(str::to_owned).to_vec() } else { options.train.clone() };
    let (sindyna, work) = (Sindyna::build()?, tempfile::tempdir()?);
    let begin = |folder: &Path| {
        let mut command = Command::new(sindyna.path());
        command.arg("train").args(&train).args(["--quiet", "--out"]).arg(folder);
        command
    };
    let folder = work.path().join("whole");
    let (cpu, wall, _) = run(&mut begin(&folder), None)?;
    let whole = record(&folder)?;
    let mut moments = Seed::new(options.seed).stream("moments", 0);
    let mut kills = Vec::new();
    for number in 0..options.kills {
        let (moment, folder) = (moments.random_range(0.0..wall), work.path().join(number.to_string()));
        let (first, _, killed) = run(&mut begin(&folder), Some(Duration::from_secs_f64(moment)))?;
        let checkpoint_bytes = fs::metadata(folder.join("checkpoint.bin")).map_or(0, |file| file.len());
        let mut again = 0.0;
        if killed {
            // Before the record began there is nothing to resume.
            let mut resume = Command::new(sindyna.path());
            resume.args(["train", "--quiet", "--resume"]).arg(&folder);
            let resumable = folder.join("config.toml").exists();
            again = run(&mut if resumable { resume } else { begin(&folder) }, None)?.0;
        }
        let (same, lost) = (record(&folder)? == whole, (first + again) / cpu - 1.0);
        let bytes = if same { "same" } else { "OTHER" };
        writeln!(io::stderr(), "{moment:6.2} s of {wall:.1}: {bytes} bytes, {:+.1} % of the time", 100.0 * lost)?;
        kills.push(Kill { after_seconds: rounded(moment), killed, checkpoint_bytes, same, lost });
        fs::remove_dir_all(folder)?;
    }
    let lost = || kills.iter().filter(|kill| kill.killed).map(|kill| kill.lost);
    let (lost_median, lost_most) = (median(lost()).and_then(rounded), lost().max_by(f64::total_cmp).and_then(rounded));
    let (same, of) = (count(&kills, |kill| kill.same), kills.len());
    writeln!(io::stdout(), "{same} of {of} the same, lost {lost_median:?}, most {lost_most:?}")?;
    let (wall_seconds, cpu_seconds) = (rounded(wall), rounded(cpu));
    store(&options.out, Figures { train, wall_seconds, cpu_seconds, same, of, lost_median, lost_most, kills })
}

/// Processor and wall seconds of the command, which is killed after so long if it still runs; and whether it was.
fn run(command: &mut Command, kill_after: Option<Duration>) -> Result<(f64, f64, bool)> {
    let (before, begun) = (ended_seconds()?, Instant::now());
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn()?;
    let mut killed = false;
    if let Some(limit) = kill_after {
        while child.try_wait()?.is_none() {
            if begun.elapsed() > limit {
                child.kill()?;
                killed = true;
                break;
            }
            thread::sleep(LOOK);
        }
    }
    child.wait()?;
    Ok((ended_seconds()? - before, begun.elapsed().as_secs_f64(), killed))
}

/// All files of a record but the times.
fn record(folder: &Path) -> Result<BTreeMap<String, Vec<u8>>> {
    let mut files = BTreeMap::new();
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let name = entry.file_name().to_string_lossy().into_owned();
        if name != "timing.json" {
            files.insert(name, fs::read(entry.path())?);
        }
    }
    Ok(files)
}
