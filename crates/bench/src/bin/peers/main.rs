//! sindyna beside its peers in Python, in turn on one core: ratios of neighbours in time, since what else the machine does cancels in them.
//!
//! What a peer does is in `benches/peers`, which is run by the Python that `scripts/peers_install` makes. Each measurement writes its file in results; the program
//! `performance` makes the page.

mod baselines;
mod speed;
mod whole_job;

use std::path::PathBuf;
use std::process::Command;

use anyhow::{Context as _, bail};
use clap::{Parser, Subcommand};
use serde::Serialize;
use serde_json::Value;
use sindyna_bench::study::{Result, pinned, root, store};

#[derive(Debug, Parser)]
struct Options {
    #[command(subcommand)]
    what: What,
}

#[derive(Debug, Subcommand)]
enum What {
    /// From nothing to a policy that solves the task, beside PySINDy with an agent of Stable-Baselines3 or SBX
    WholeJob(whole_job::Options),
    /// Updates of SAC beside SBX's scan, Stable-Baselines3's, and the matrix products of an update by other libraries
    Updates(speed::Options),
    /// Training of an ensemble of networks beside PyTorch's
    Ensemble(speed::Options),
    /// A step of the learned model beside PySINDy's predict and the step of Gymnasium's environment
    ModelSteps(speed::Options),
    /// Our model-free baseline beside Stable-Baselines3's SAC with the same settings
    Baselines(baselines::Options),
}

/// How peers are run.
#[derive(Debug, Clone, clap::Args)]
struct Peers {
    /// The Python with the peers.
    #[arg(long, default_value = ".venv-peers/bin/python")]
    python: PathBuf,
    /// The core on which all runs.
    #[arg(long, default_value_t = 1)]
    core: usize,
}

fn main() -> Result {
    match Options::parse().what {
        What::WholeJob(options) => whole_job::measure(&options),
        What::Updates(options) => speed::updates(&options),
        What::Ensemble(options) => speed::ensemble(&options),
        What::ModelSteps(options) => speed::model_steps(&options),
        What::Baselines(options) => baselines::measure(&options),
    }
}

impl Peers {
    /// The last line of JSON that a peer prints.
    fn ask(&self, arguments: &[&str]) -> Result<Value> {
        let mut command = Command::new(root().join(&self.python));
        command.args(["-m", "peers"]).args(arguments);
        let text = self.run(&command)?;
        let line = text.lines().rfind(|line| line.starts_with('{')).context("the peer said nothing")?;
        Ok(serde_json::from_str(line)?)
    }

    /// Standard output of `command` on one core and one thread.
    fn run(&self, command: &Command) -> Result<String> {
        let mut command = pinned(command, self.core);
        for name in ["OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"] {
            command.env(name, "1");
        }
        command.env("XLA_FLAGS", "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1");
        command.envs(self.mkl().map(|path| ("MKL_RT", path)));
        let done = command.current_dir(root().join("benches")).output()?;
        if !done.status.success() {
            bail!("{command:?} failed: {}", String::from_utf8_lossy(&done.stderr));
        }
        Ok(String::from_utf8(done.stdout)?)
    }

    /// Intel's library beside the Python, if it is there.
    fn mkl(&self) -> Option<PathBuf> {
        let libraries = std::fs::read_dir(root().join(self.python.parent()?.parent()?).join("lib")).ok()?;
        let is_mkl = |path: &PathBuf| path.file_name().is_some_and(|n| n.to_string_lossy().starts_with("libmkl_rt.so"));
        libraries.flatten().map(|entry| entry.path()).filter(is_mkl).max()
    }

    /// Writes a result file with the versions of the peers.
    fn store<T: Serialize>(&self, stem: &str, figures: T) -> Result {
        #[derive(Serialize)]
        struct Beside<T> {
            versions: Value,
            #[serde(flatten)]
            figures: T,
        }
        store(stem, Beside { versions: self.ask(&["versions"])?, figures })
    }
}

/// A number in what a peer said.
fn number(value: &Value, name: &str) -> Result<f64> {
    value[name].as_f64().with_context(|| format!("no number `{name}` in {value}"))
}
