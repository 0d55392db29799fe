//! Files of a study: `results/STEM.json`, and `docs/STEM.md`, which follows from it.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs};

use anyhow::{Context as _, bail};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use sindyna_record::{json, save};

/// What a study comes to.
pub type Result<T = ()> = anyhow::Result<T>;

/// A result file.
#[derive(Debug, Serialize, Deserialize)]
pub struct Document<T> {
    /// By what it was made.
    #[serde(flatten)]
    pub made: Made,
    /// The figures.
    #[serde(flatten)]
    pub figures: T,
}

/// By what figures were made.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Made {
    /// The command that makes them.
    #[serde(default)]
    pub command: String,
    /// What was checked out when they were made; a plus where it had been changed.
    #[serde(default)]
    pub commit: String,
    /// The day.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub date: Option<String>,
    /// Processor, cores and system.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub machine: Option<String>,
    /// The compiler.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rustc: Option<String>,
}

impl Made {
    /// By this program, now.
    #[must_use]
    pub fn now() -> Self {
        let changed = said("git", &["status", "--porcelain", "--untracked-files=no", "crates", "Cargo.lock"]);
        let commit = said("git", &["rev-parse", "--short=12", "HEAD"]).unwrap_or_default();
        Self {
            command: command(),
            commit: commit + if changed.is_some_and(|c| !c.is_empty()) { "+" } else { "" },
            date: said("date", &["-u", "+%F"]),
            machine: Some(machine()),
            rustc: said("rustc", &["--version"]),
        }
    }

    /// The last paragraph of a page: the command, and what is known of the run.
    #[must_use]
    pub fn origin(&self, stem: &str) -> String {
        let known = [&self.date, &self.machine, &self.rustc].into_iter().flatten();
        let known: String = known.map(|what| format!(", {}", what.split(" (").next().unwrap_or(what))).collect();
        format!(
            "Made by `{}`, which writes [results/{stem}.json](../results/{stem}.json) and this page; with `--page-only` it writes the page from that file. \
             The figures are of commit {}{known}.",
            self.command, self.commit
        )
    }
}

/// The command line that started this program, as one gives it in the repository; of files elsewhere their names.
#[must_use]
pub fn command() -> String {
    let mut words = env::args();
    let program = words.next().unwrap_or_default();
    let name = Path::new(&program).file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let named = |word: String| match Path::new(&word) {
        path if path.is_absolute() => path.file_name().unwrap_or_default().to_string_lossy().into_owned(),
        _ => word,
    };
    let quoted = |word: String| if word.contains([' ', '"', '[']) { format!("'{word}'") } else { word };
    let arguments: Vec<String> = words.map(named).map(quoted).collect();
    let own = format!("cargo run --release -p sindyna-bench --bin {name}");
    if arguments.is_empty() { own } else { format!("{own} -- {}", arguments.join(" ")) }
}

/// Processor, vector instructions, cores and system.
fn machine() -> String {
    let info = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let field = |name: &str| {
        let line = info.lines().find(|line| line.starts_with(name))?;
        Some(line.split_once(':')?.1.trim().to_owned())
    };
    let has = field("flags").unwrap_or_default();
    let vectors = [("avx2", ", AVX2"), ("avx512f", ", AVX-512")];
    let vectors: String =
        vectors.iter().filter(|(flag, _)| has.split(' ').any(|f| f == *flag)).map(|(_, name)| *name).collect();
    let cores = std::thread::available_parallelism().map_or(0, usize::from);
    let model = field("model name").unwrap_or_else(|| env::consts::ARCH.to_owned());
    let family = field("cpu family").map_or(String::new(), |number| format!(", family {number}"));
    format!("{model}{family}{vectors}, {cores} cores, {}", env::consts::OS)
}

/// What a command says, in the repository; none if it cannot.
fn said(program: &str, arguments: &[&str]) -> Option<String> {
    let done = Command::new(program).args(arguments).current_dir(root()).output().ok()?;
    done.status.success().then(|| String::from_utf8_lossy(&done.stdout).trim().to_owned())
}

/// The root of the repository.
#[must_use]
pub fn root() -> PathBuf {
    let given = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    given.canonicalize().unwrap_or(given)
}

/// The folder with what `cargo build --release` makes of `options`, built.
///
/// # Errors
/// If it cannot be built.
pub fn built(options: &[&str]) -> Result<PathBuf> {
    let cargo = env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let built =
        Command::new(cargo).args(["build", "--release", "--quiet"]).args(options).current_dir(root()).status()?;
    if !built.success() {
        bail!("`cargo build --release {}` failed", options.join(" "));
    }
    let target = env::var_os("CARGO_TARGET_DIR").map_or_else(|| root().join("target"), PathBuf::from);
    Ok(root().join(target).join("release"))
}

/// The figures in `results/STEM.json`; none if there is no such file.
///
/// # Errors
/// If the file is another.
pub fn load<T: DeserializeOwned>(stem: &str) -> Result<Option<T>> {
    let path = root().join("results").join(format!("{stem}.json"));
    let Ok(text) = fs::read_to_string(&path) else { return Ok(None) };
    Ok(Some(serde_json::from_str(&text).with_context(|| format!("{} is no result of this study", path.display()))?))
}

/// Measures, writes `results/STEM.json`, and writes the page `path` of what stands in it. Nothing is measured for the page alone.
///
/// # Errors
/// Whatever goes wrong in measuring, reading and writing.
pub fn study<T: Serialize + DeserializeOwned>(
    (stem, path): (&str, &str),
    page_only: bool,
    measure: impl FnOnce() -> Result<T>,
    page: impl FnOnce(&Document<T>) -> Result<String>,
) -> Result {
    if !page_only {
        // What is checked out may be changed while it runs.
        let made = Made::now();
        write(stem, &Document { made, figures: measure()? })?;
    }
    let document = load(stem)?.with_context(|| format!("there is no results/{stem}.json"))?;
    Ok(save(&root().join(path), page(&document)?.as_bytes())?)
}

/// Writes `results/STEM.json`.
///
/// # Errors
/// If it cannot be written.
pub fn store<T: Serialize>(stem: &str, figures: T) -> Result {
    write(stem, &Document { made: Made::now(), figures })
}

fn write<T: Serialize>(stem: &str, document: &Document<T>) -> Result {
    Ok(save(&root().join("results").join(format!("{stem}.json")), &json(document)?)?)
}
