//! Running what is measured.

use std::path::PathBuf;
use std::process::Command;

use anyhow::{Context as _, bail};
use serde::Serialize;
use serde_json::Value;
use sindyna_bench::study::{Result, pinned, root, store};

/// How peers are run.
#[derive(Debug, Clone, clap::Args)]
pub(crate) struct Peers {
    /// The Python with the peers.
    #[arg(long, default_value = ".venv-peers/bin/python")]
    python: PathBuf,
    /// The core on which all runs.
    #[arg(long, default_value_t = 1)]
    pub(crate) core: usize,
}

impl Peers {
    /// The last line of JSON that a peer prints.
    pub(crate) fn ask(&self, arguments: &[&str]) -> Result<Value> {
        let mut command = Command::new(root().join(&self.python));
        command.args(["-m", "peers"]).args(arguments);
        let text = self.run(&command)?;
        let line = text.lines().rfind(|line| line.starts_with('{')).context("the peer said nothing")?;
        Ok(serde_json::from_str(line)?)
    }

    /// Standard output of `command` on one core and one thread.
    pub(crate) fn run(&self, command: &Command) -> Result<String> {
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
    pub(crate) fn store<T: Serialize>(&self, stem: &str, figures: T) -> Result {
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
pub(crate) fn number(value: &Value, name: &str) -> Result<f64> {
    value[name].as_f64().with_context(|| format!("no number `{name}` in {value}"))
}
