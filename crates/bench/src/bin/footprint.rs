//! What sindyna costs besides time: peak memory of `train`, size of the binary, a build from clean, and which crates they are.
//!
//! The clean build goes to a folder of its own and takes minutes; `--no-build` leaves it out. Writes results/OUT.json; the program `performance` makes the page. Needs Linux; nm
//! (binutils) for the sizes by crate.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};
use std::{env, fs, thread};

use anyhow::{Context as _, bail};
use clap::Parser;
use serde::Serialize;
use serde_json::Value;
use sindyna_bench::study::{Result, Sindyna, ended_seconds, root, rounded, store};

const TASKS: [&str; 4] = ["pendulum", "mountain-car", "inverted-pendulum", "cart-pole"];

/// How many crates are told.
const LARGEST: usize = 15;

/// Time between two looks at the process.
const LOOK: Duration = Duration::from_millis(5);

/// Numbers by name.
type Named = BTreeMap<String, Option<f64>>;

#[derive(Debug, Parser)]
struct Options {
    /// Leave the clean build out.
    #[arg(long)]
    no_build: bool,
    /// Jobs of the clean build.
    #[arg(long, default_value_t = 2)]
    jobs: usize,
    /// Stem of the file in results.
    #[arg(long, default_value = "footprint")]
    out: String,
}

#[derive(Debug, Serialize)]
struct Figures {
    peak_memory_mib: BTreeMap<String, Named>,
    binary_mb: Option<f64>,
    binary_kib_by_crate: Option<Named>,
    clean_build: Option<Build>,
}

#[derive(Debug, Serialize)]
struct Build {
    jobs: usize,
    wall_seconds: Option<f64>,
    processor_seconds: Option<f64>,
    crates: usize,
    slowest_crates_seconds: Named,
}

fn main() -> Result {
    let options = Options::parse();
    let folder = tempfile::tempdir()?;
    let (clean_build, sindyna) = if options.no_build {
        (None, Sindyna::build()?)
    } else {
        let build = clean_build(options.jobs, folder.path())?;
        (Some(build), Sindyna::at(&folder.path().join("release/sindyna")))
    };
    let mut peak_memory_mib = BTreeMap::new();
    for task in TASKS {
        let mut of_task = Named::new();
        for threads in [1_usize, 2] {
            let out = folder.path().join(format!("{task}-{threads}"));
            let threads = threads.to_string();
            let train = sindyna.training(task, 0, &out, &["--threads", &threads]);
            of_task.insert(format!("{threads} threads"), rounded(peak_memory(train)?));
        }
        peak_memory_mib.insert(task.to_owned(), of_task);
    }
    let binary_mb = rounded(fs::metadata(sindyna.path())?.len() as f64 / 1e6);
    let binary_kib_by_crate = sizes_by_crate(&root().join("target/unstripped"))?;
    store(&options.out, Figures { peak_memory_mib, binary_mb, binary_kib_by_crate, clean_build })
}

/// MiB the process held at most, as the system told the last time it was asked.
fn peak_memory(mut command: Command) -> Result<f64> {
    let mut child = command.stderr(Stdio::null()).spawn()?;
    let status = format!("/proc/{}/status", child.id());
    let mut peak = 0.0;
    while child.try_wait()?.is_none() {
        // The process may have ended since.
        let text = fs::read_to_string(&status).unwrap_or_default();
        let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:")?.trim().strip_suffix(" kB")?.parse().ok());
        peak = line.map_or(peak, |kib: f64| kib / 1024.0);
        thread::sleep(LOOK);
    }
    Ok(peak)
}

/// The largest, from all.
fn largest(values: BTreeMap<String, f64>) -> Named {
    let mut pairs: Vec<(String, f64)> = values.into_iter().collect();
    pairs.sort_by(|a, b| b.1.total_cmp(&a.1));
    pairs.into_iter().take(LARGEST).map(|(name, value)| (name, rounded(value))).collect()
}

/// KiB of code and data per crate of a binary built with its symbols in `folder`; what a generic became counts where its symbol says. None without nm.
fn sizes_by_crate(folder: &Path) -> Result<Option<Named>> {
    if Command::new("nm").arg("--version").output().is_err() {
        return Ok(None);
    }
    let built = cargo()
        .args(["build", "--release", "--quiet", "--config", "profile.release.strip=false", "--target-dir"])
        .arg(folder)
        .status()?;
    if !built.success() {
        bail!("cargo build failed");
    }
    let listed =
        Command::new("nm").args(["--demangle", "--print-size"]).arg(folder.join("release/sindyna")).output()?;
    let mut sizes = BTreeMap::new();
    for line in String::from_utf8_lossy(&listed.stdout).lines() {
        let mut words = line.splitn(4, ' ').skip(1);
        let (Some(size), Some(kind), Some(symbol)) = (words.next(), words.next(), words.next()) else { continue };
        let Ok(size) = u64::from_str_radix(size, 16) else { continue };
        if kind.len() == 1 && "tTrRdDbBwWvV".contains(kind) {
            *sizes.entry(of_crate(symbol).unwrap_or("other (C, tables)").to_owned()).or_insert(0.0) +=
                size as f64 / 1024.0;
        }
    }
    Ok(Some(largest(sizes)))
}

/// The first crate that a symbol names.
fn of_crate(symbol: &str) -> Option<&str> {
    let (path, _) = symbol.split_once("::")?;
    let name = path.rsplit(['<', '&', ' ', '(']).next()?;
    let name = name.split('[').next()?;
    let is_name = name.starts_with(|c: char| c.is_ascii_lowercase() || c == '_');
    (is_name && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')).then_some(name)
}

fn cargo() -> Command {
    let mut cargo = Command::new(env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    cargo.current_dir(root()).env_remove("CARGO_BUILD_JOBS");
    cargo
}

/// A build from nothing in `folder`: wall and processor seconds, and seconds per crate.
fn clean_build(jobs: usize, folder: &Path) -> Result<Build> {
    let (before, begun) = (ended_seconds()?, Instant::now());
    let mut build = cargo();
    build
        .args(["build", "--release", "--quiet", "--timings", "--jobs", &jobs.to_string()])
        .env("CARGO_TARGET_DIR", folder);
    if !build.stdout(Stdio::null()).status()?.success() {
        bail!("cargo build failed");
    }
    let (wall, processor) = (begun.elapsed().as_secs_f64(), ended_seconds()? - before);
    let page = fs::read_to_string(folder.join("cargo-timings/cargo-timing.html"))?;
    let units = page.split_once("UNIT_DATA = ").and_then(|(_, rest)| Some(rest.split_once(";\n")?.0));
    let units: Vec<Value> = serde_json::from_str(units.context("cargo's page of times has no units")?)?;
    let mut seconds = BTreeMap::new();
    for unit in &units {
        let name = unit["name"].as_str().unwrap_or_default().to_owned();
        *seconds.entry(name).or_insert(0.0) += unit["duration"].as_f64().unwrap_or(0.0);
    }
    Ok(Build {
        jobs,
        wall_seconds: rounded(wall),
        processor_seconds: rounded(processor),
        crates: seconds.len(),
        slowest_crates_seconds: largest(seconds),
    })
}

#[cfg(test)]
mod tests {
    #[test]
    fn a_symbol_counts_for_the_crate_it_names_first() {
        let found = [
            "sindyna_sindy::identify::run",
            "<sindyna_core::Seed as core::fmt::Display>::fmt",
            "core::ptr::drop_in_place<alloc::string::String>",
            "memcpy",
        ]
        .map(super::of_crate);
        assert_eq!(found, [Some("sindyna_sindy"), Some("sindyna_core"), Some("core"), None]);
    }
}
