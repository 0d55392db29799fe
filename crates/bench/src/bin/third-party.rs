//! Writes THIRD-PARTY.md: the crates that are compiled into the command, with their licences, and what else is not ours.
//!
//! `--check` writes nothing; it fails if the file is out of date or a licence is none that deny.toml allows.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::process::Command;

use anyhow::{Context as _, bail};
use clap::Parser;
use serde::Deserialize;
use sindyna_bench::study::{Result, root};
use sindyna_record::save;

/// What stands above the list of crates.
const HEAD: &str = include_str!("../../data/third-party.md");

#[derive(Debug, Parser)]
struct Options {
    /// Write nothing, and fail if the file is out of date.
    #[arg(long)]
    check: bool,
}

#[derive(Debug, Deserialize)]
struct Metadata {
    packages: Vec<Package>,
    resolve: Resolve,
}

#[derive(Debug, Deserialize)]
struct Package {
    id: String,
    name: String,
    version: String,
    license: Option<String>,
    source: Option<String>,
}

#[derive(Debug, Deserialize)]
struct Resolve {
    nodes: Vec<Node>,
}

#[derive(Debug, Deserialize)]
struct Node {
    id: String,
    deps: Vec<Dependency>,
}

#[derive(Debug, Deserialize)]
struct Dependency {
    pkg: String,
    dep_kinds: Vec<Kind>,
}

#[derive(Debug, Deserialize)]
struct Kind {
    kind: Option<String>,
}

fn main() -> Result {
    let options = Options::parse();
    let packages = compiled(metadata()?);
    let deny: toml::Table = fs::read_to_string(root().join("deny.toml"))?.parse()?;
    let allowed: Vec<String> = deny["licenses"]["allow"].clone().try_into()?;
    let licence = |package: &Package| package.license.as_deref().unwrap_or("none").replace('/', " OR ");
    for package in &packages {
        let expression = spdx::Expression::parse(&licence(package)).with_context(|| package.name.clone())?;
        if !expression.evaluate(|wanted| allowed.contains(&wanted.to_string())) {
            bail!("{}: deny.toml does not allow {expression}", package.name);
        }
    }
    let rows = packages.iter().map(|p| format!("| {} | {} | {} |\n", p.name, p.version, licence(p)));
    let page = HEAD.to_owned() + &rows.collect::<String>();
    let path = root().join("THIRD-PARTY.md");
    if !options.check {
        return Ok(save(&path, page.as_bytes())?);
    }
    if fs::read_to_string(&path)? != page {
        bail!("THIRD-PARTY.md is out of date: run `cargo run -p sindyna-bench --bin third-party`");
    }
    Ok(())
}

/// The packages of the workspace and how they depend on each other.
fn metadata() -> Result<Metadata> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let told =
        Command::new(cargo).args(["metadata", "--format-version", "1", "--locked"]).current_dir(root()).output()?;
    if !told.status.success() {
        bail!("cargo metadata failed: {}", String::from_utf8_lossy(&told.stderr));
    }
    Ok(serde_json::from_slice(&told.stdout)?)
}

/// The packages of others that the command `sindyna` is compiled from, or with.
fn compiled(graph: Metadata) -> Vec<Package> {
    let nodes: BTreeMap<&str, &[Dependency]> =
        graph.resolve.nodes.iter().map(|n| (n.id.as_str(), &n.deps[..])).collect();
    let command = graph.packages.iter().filter(|p| p.name == "sindyna" && p.source.is_none()).map(|p| p.id.as_str());
    let mut open: Vec<&str> = command.collect();
    let mut seen: BTreeSet<&str> = open.iter().copied().collect();
    while let Some(package) = open.pop() {
        for dependency in nodes.get(package).copied().unwrap_or_default() {
            let tests_alone = dependency.dep_kinds.iter().all(|kind| kind.kind.as_deref() == Some("dev"));
            if !tests_alone && seen.insert(&dependency.pkg) {
                open.push(&dependency.pkg);
            }
        }
    }
    let seen: BTreeSet<String> = seen.into_iter().map(str::to_owned).collect();
    let mut found: Vec<Package> =
        graph.packages.into_iter().filter(|p| p.source.is_some() && seen.contains(&p.id)).collect();
    found.sort_by(|a, b| (&a.name, &a.version).cmp(&(&b.name, &b.version)));
    found
}
