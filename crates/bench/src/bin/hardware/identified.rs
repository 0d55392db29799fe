//! Equations that `sindyna identify` finds in logs of a machine, and what it says of others.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;

use anyhow::{Context as _, bail};
use serde::{Deserialize, Serialize};
use sindyna_bench::study::Result;
use sindyna_core::InterSample;
use sindyna_record::identification::{Equation, HeldOut};

/// A machine, and how its columns are named.
pub(crate) struct Machine {
    pub(crate) folder: &'static str,
    pub(crate) columns: &'static [&'static str],
}

impl Machine {
    /// The file of a log.
    pub(crate) fn path(&self, data: &Path, log: &str) -> PathBuf {
        data.join(self.folder).join(log).with_extension("csv")
    }
}

/// One command.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Run {
    /// The logs that the equations are of.
    pub(crate) logs: Vec<String>,
    /// The beginning of them that is used \[s\], where that is not all.
    pub(crate) part: Option<f64>,
    pub(crate) rows: usize,
    /// Wall time of the command on one thread.
    pub(crate) seconds: f64,
    pub(crate) equations: Vec<String>,
    pub(crate) coefficients: Vec<Coefficient>,
    /// The model, as it is written.
    pub(crate) model: String,
    /// Whether inputs are linear between rows.
    pub(crate) linear: bool,
    /// Rows by which inputs act later.
    pub(crate) delay: f64,
    pub(crate) held_out: Vec<String>,
    pub(crate) predictions: Vec<Prediction>,
}

/// A coefficient of an equation that was fitted.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Coefficient {
    pub(crate) state: String,
    pub(crate) term: String,
    pub(crate) value: f64,
    pub(crate) standard_error: f64,
}

/// What is predicted of a state of the logs held out.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Prediction {
    pub(crate) state: String,
    /// How far ahead \[s\].
    pub(crate) ahead: f64,
    pub(crate) windows: usize,
    pub(crate) diverged: usize,
    /// Root mean square of the error in each window: the median over windows.
    pub(crate) median: f64,
}

impl Run {
    /// What it is called.
    pub(crate) fn name(&self) -> String {
        let logs = self.logs.join(", ");
        self.part.map_or_else(|| logs.clone(), |seconds| format!("first {seconds} s of {logs}"))
    }

    /// The coefficient of a term of an equation.
    pub(crate) fn coefficient(&self, state: &str, term: &str) -> Option<&Coefficient> {
        self.coefficients.iter().find(|c| c.state == state && c.term == term)
    }

    /// The prediction of a state so far ahead.
    pub(crate) fn prediction(&self, state: &str, ahead: f64) -> Option<&Prediction> {
        self.predictions.iter().find(|p| p.state == state && (p.ahead - ahead).abs() < 1e-9)
    }
}

/// The part of identify.json that is read.
#[derive(Deserialize)]
struct Account {
    rows: usize,
    #[serde(default)]
    input_delay: f64,
    #[serde(default)]
    intersample: Option<InterSample>,
    equations: Vec<Equation>,
    #[serde(default)]
    held_out: Option<HeldOut>,
}

/// Equations of `logs`, or of so many seconds of them, and predictions of those `held_out`.
pub(crate) fn run(
    program: &Path,
    (data, machine): (&Path, &Machine),
    (logs, part): (&[&str], Option<f64>),
    held_out: &[&str],
) -> Result<Run> {
    let folder = tempfile::tempdir()?;
    let out = folder.path().join("model");
    let mut files = Vec::new();
    for log in logs {
        let path = machine.path(data, log);
        files.push(match part {
            Some(seconds) => beginning(&path, seconds, folder.path())?,
            None => path,
        });
    }
    let mut command = Command::new(program);
    command.args(["identify", "--no-report", "--quiet", "--threads", "1", "--out"]).arg(&out).args(machine.columns);
    for log in held_out {
        command.arg("--holdout").arg(machine.path(data, log));
    }
    let start = Instant::now();
    let done = command.args(&files).stdout(Stdio::null()).stderr(Stdio::piped()).output()?;
    let seconds = start.elapsed().as_secs_f64();
    if !done.status.success() {
        bail!("{} {}: {}", machine.folder, logs.join(", "), String::from_utf8_lossy(&done.stderr));
    }
    let read = |name: &str| fs::read_to_string(out.join(name)).with_context(|| format!("no {name}"));
    let account: Account = serde_json::from_str(&read("identify.json")?)?;
    let coefficients = account.equations.iter().flat_map(|equation| {
        equation.terms.iter().filter_map(|term| {
            Some(Coefficient {
                state: equation.state.clone(),
                term: term.term.clone(),
                value: term.coefficient,
                standard_error: term.standard_error?,
            })
        })
    });
    let predictions = account.held_out.iter().flat_map(|held_out| &held_out.predictions).flat_map(|ahead| {
        ahead.median_rmse.iter().filter_map(|(state, median)| {
            Some(Prediction {
                state: state.clone(),
                ahead: ahead.seconds?,
                windows: ahead.windows,
                diverged: ahead.diverged,
                median: median.unwrap_or(f64::INFINITY),
            })
        })
    });
    Ok(Run {
        logs: logs.iter().map(ToString::to_string).collect(),
        part,
        rows: account.rows,
        seconds,
        equations: account.equations.iter().map(|equation| equation.equation.clone()).collect(),
        coefficients: coefficients.collect(),
        model: read("model.json")?,
        linear: account.intersample.is_some_and(|intersample| !intersample.is_held()),
        delay: account.input_delay,
        held_out: held_out.iter().map(ToString::to_string).collect(),
        predictions: predictions.collect(),
    })
}

/// A file in `folder` with the rows of the first `seconds` of the log at `path`, whose first column is the time.
fn beginning(path: &Path, seconds: f64, folder: &Path) -> Result<PathBuf> {
    let text = fs::read_to_string(path).with_context(|| format!("no {}", path.display()))?;
    let mut lines = text.lines();
    let header = lines.next().context("an empty log")?;
    let time = |line: &&str| line.split(',').next().and_then(|field| field.parse::<f64>().ok());
    let begun = lines.clone().find_map(|line| time(&line)).context("a log without times")?;
    let rows = lines.take_while(|line| time(line).is_some_and(|t| t - begun <= seconds));
    let to = folder.join(path.file_name().context("a log without a name")?);
    fs::write(&to, std::iter::once(header).chain(rows).collect::<Vec<_>>().join("\n") + "\n")?;
    Ok(to)
}
