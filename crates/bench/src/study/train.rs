//! Runs of `sindyna train`, and what their records say.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{Context as _, bail};
use sindyna_record::run::{Summary, Timing};

use super::record::{Result, built};

/// The command, built.
#[derive(Debug, Clone)]
pub struct Sindyna(PathBuf);

/// What came of a run.
pub enum Trained {
    /// It came to its end, and left this.
    Done(Box<Summary>, Timing),
    /// It could not be run, for this reason.
    Refused(String),
}

impl Sindyna {
    /// Builds the command.
    ///
    /// # Errors
    /// If it cannot be built.
    pub fn build() -> Result<Self> {
        Ok(Self(built(&["-p", "sindyna"])?.join(format!("sindyna{}", std::env::consts::EXE_SUFFIX))))
    }

    /// The program that lies at `path`.
    #[must_use]
    pub fn at(path: &Path) -> Self {
        Self(path.to_owned())
    }

    /// `train` of a task, or of a task file, with `options`, which leaves its record in `out`.
    #[must_use]
    pub fn training<S: AsRef<str>>(&self, task: &str, seed: u64, out: &Path, options: &[S]) -> Command {
        let mut command = Command::new(&self.0);
        let file = Path::new(task).extension().is_some_and(|end| end == "toml").then_some("--task-file");
        command.arg("train").args(file).args([task, "--seed", &seed.to_string(), "--quiet", "--out"]).arg(out);
        command.args(options.iter().map(AsRef::as_ref)).stdout(Stdio::null()).stdin(Stdio::null());
        command
    }

    /// Trains, or reads the record that an earlier run left in `out`.
    ///
    /// # Errors
    /// If no process can be started, or if the record cannot be read.
    pub fn train<S: AsRef<str>>(&self, task: &str, seed: u64, out: &Path, options: &[S]) -> Result<Trained> {
        let read =
            |name: &str| fs::read_to_string(out.join(name)).with_context(|| format!("no {name} in {}", out.display()));
        if read("summary.json").and_then(|text| Ok(Summary::from_json(&text)?)).is_ok_and(|s| !s.interrupted) {
            return recorded(&read);
        }
        if out.exists() {
            fs::remove_dir_all(out)?;
        }
        let done = self.training(task, seed, out, options).stderr(Stdio::piped()).output()?;
        match done.status.code() {
            // 1: ran, and missed its target.
            Some(0 | 1) => recorded(&read),
            Some(_) => Ok(Trained::Refused(String::from_utf8_lossy(&done.stderr).trim().to_owned())),
            None => bail!("a run of {task} with seed {seed} was killed"),
        }
    }

    /// Name and version.
    ///
    /// # Errors
    /// If the program cannot be started.
    pub fn version(&self) -> Result<String> {
        let said = Command::new(&self.0).arg("--version").output()?.stdout;
        Ok(String::from_utf8_lossy(&said).trim().to_owned())
    }

    /// Where the program lies.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.0
    }
}

fn recorded(read: &dyn Fn(&str) -> Result<String>) -> Result<Trained> {
    let timing = serde_json::from_str(&read("timing.json")?)?;
    Ok(Trained::Done(Box::new(Summary::from_json(&read("summary.json")?)?), timing))
}
