//! Sections on sindyna alone.

use std::collections::BTreeMap;

use serde::Deserialize;
use sindyna_bench::study::{Document, Made, Result, Spread, load};
use sindyna_core::number::{fixed, significant};

use crate::section::Section;

/// Command, commit, day and machine.
pub(crate) fn origin(made: &Made) -> String {
    let known = [&made.date, &made.machine, &made.rustc].into_iter().flatten();
    let known: String = known.map(|what| format!(", {}", what.split(" (").next().unwrap_or(what))).collect();
    format!("`{}`; figures of commit {}{known}", made.command.trim(), made.commit)
}

#[derive(Debug, Deserialize)]
struct Parts {
    seeds: usize,
    tasks: Vec<Shares>,
}

#[derive(Debug, Deserialize)]
struct Shares {
    task: String,
    shares: serde_json::Map<String, serde_json::Value>,
}

pub(crate) fn parts() -> Result<Option<Section>> {
    let Some(document) = load::<Document<Parts>>("parts")? else { return Ok(None) };
    let Parts { seeds, tasks } = &document.figures;
    let share = |t: &Shares, name: &str| t.shares.get(name).and_then(serde_json::Value::as_f64).unwrap_or(0.0);
    // The largest first.
    let mut names: Vec<&String> = tasks.first().map(|t| t.shares.keys().collect()).unwrap_or_default();
    let of_first = |name: &String| tasks.first().map_or(0.0, |t| share(t, name));
    names.sort_by(|a, b| of_first(b).total_cmp(&of_first(a)));
    let head: Vec<&str> = ["task"].into_iter().chain(names.iter().map(|name| name.as_str())).collect();
    let row = |t: &Shares| {
        let shares = names.iter().map(|name| format!("{:.1} %", 100.0 * share(t, name)));
        [t.task.clone()].into_iter().chain(shares).collect()
    };
    let products = tasks.iter().map(|t| format!("{:.0} % on {}", 100.0 * share(t, "products of updates"), t.task));
    let finding =
        format!("Matrix products of updates take this share of a run: {}.", products.collect::<Vec<_>>().join(", "));
    Ok(Some(Section::new("Parts of a run", [finding]).with(|page| {
        page.text(&format!("Where the time of `train` goes, whole process on one thread, medians of {seeds} seeds."))
            .table(&head, tasks.iter().map(row))
            .text(
                "*Model* is imagination, trials of the policy in the model, and what little identification steps; of these, trials are by far the most: a turn of imagination pays for \
                 an update, a trial is 100 whole episodes after every 250 updates. They step 25 at a time and in as many groups as there are threads. *Loops over networks' numbers* are \
                 Adam, what a policy draws, and policies acting in trials. What imagination alone takes: [notes](notes/2026-11-21-parts-of-a-run.md).",
            )
            .text(&format!("{}.", origin(&document.made)))
    })))
}

#[derive(Debug, Deserialize)]
struct SolveRate {
    runs: Vec<Run>,
}

#[derive(Debug, Deserialize)]
struct Run {
    task: String,
    solved: Option<bool>,
    mean_return: Option<f64>,
}

pub(crate) fn solved() -> Result<Option<Section>> {
    let Some(document) = load::<Document<SolveRate>>("solve-rate-100")? else { return Ok(None) };
    let runs = &document.figures.runs;
    let mut tasks: Vec<&str> = runs.iter().map(|run| run.task.as_str()).collect();
    tasks.dedup();
    let solved = |runs: &[&Run]| runs.iter().filter(|run| run.solved == Some(true)).count();
    let row = |task: &&str| {
        let of: Vec<&Run> = runs.iter().filter(|run| run.task == *task).collect();
        let returns: Vec<f64> = of.iter().filter_map(|run| run.mean_return).collect();
        let mean = fixed(returns.iter().sum::<f64>() / returns.len() as f64, 1);
        let lowest = returns.iter().copied().min_by(f64::total_cmp).map_or_else(String::new, |r| fixed(r, 1));
        vec![(*task).to_owned(), format!("{} of {}", solved(&of), of.len()), format!("{mean} ({lowest})")]
    };
    let all: Vec<&Run> = runs.iter().collect();
    let finding = format!("From ten real steps {} of {} runs solve their task.", solved(&all), all.len());
    Ok(Some(Section::new("Solved", [finding]).with(|page| {
        page.text("Real evaluation of 100 episodes, 10 real steps each:")
            .table(&["task", "solved", "return, mean (lowest)"], tasks.iter().map(row))
            .text(&format!("{}.", origin(&document.made)))
    })))
}

#[derive(Debug, Deserialize)]
struct Growth {
    updates: Vec<Update>,
    model_steps: Vec<ModelStep>,
    seeds: Vec<Together>,
}

#[derive(Debug, Deserialize)]
struct Update {
    width: usize,
    batch: usize,
    microseconds: Spread,
}

#[derive(Debug, Deserialize)]
struct ModelStep {
    terms: usize,
    nanoseconds: Spread,
}

#[derive(Debug, Deserialize)]
struct Together {
    seeds: usize,
    at_once: usize,
    seconds: Spread,
}

/// Hidden width and batch to which the others are related.
const BASE: (usize, usize) = (64, 128);

pub(crate) fn growth() -> Result<Option<Section>> {
    let Some(document) = load::<Document<Growth>>("growth")? else { return Ok(None) };
    let Growth { updates, model_steps, seeds } = &document.figures;
    let middle = |spread: &Spread| spread.median.unwrap_or(f64::INFINITY);
    let base = updates.iter().find(|u| (u.width, u.batch) == BASE).map_or(f64::NAN, |u| middle(&u.microseconds));
    let row = |of: usize, u: &Update| {
        let time = middle(&u.microseconds);
        vec![of.to_string(), format!("{time:.0}"), format!("{:.2}", time / base)]
    };
    let widths = updates.iter().filter(|u| u.batch == BASE.1).map(|u| row(u.width, u));
    let mut batches: Vec<&Update> = updates.iter().filter(|u| u.width == BASE.0).collect();
    batches.sort_by_key(|u| u.batch);
    let alone = |at_once: usize| {
        let one = seeds.iter().find(|s| s.seeds == 1 && s.at_once == at_once);
        one.map_or(f64::NAN, |s| middle(&s.seconds))
    };
    let many = |s: &Together| {
        let times = format!("{:.1}", middle(&s.seconds) / alone(s.at_once));
        vec![s.seeds.to_string(), s.at_once.to_string(), s.seconds.shown(3), times]
    };
    let step = |s: &ModelStep| vec![s.terms.to_string(), s.nanoseconds.shown(3)];
    let finding = match (model_steps.first(), model_steps.last()) {
        (Some(few), Some(most)) => Some(format!(
            "A model step of {} terms takes {} times as long as one of {}.",
            most.terms,
            significant(middle(&most.nanoseconds) / middle(&few.nanoseconds), 2),
            few.terms
        )),
        _ => None,
    };
    Ok(Some(Section::new("How cost grows", finding).with(|page| {
        page.text("An update, batch 128, against the width of both hidden layers; and at 64×64 against the batch:")
            .table(&["width", "µs", "times 64×64"], widths)
            .table(&["batch", "µs", "times batch 128"], batches.iter().map(|u| row(u.batch, u)))
            .text("A model step (two states, sines and cosines) against the number of terms:")
            .table(&["terms", "ns"], model_steps.iter().map(step))
            .text("Runs of `train pendulum` with so many seeds, a process on one thread each, all seeds together against one alone:")
            .table(&["seeds", "at once", "seconds", "times one seed"], seeds.iter().map(many))
            .text(&format!("{}.", origin(&document.made)))
    })))
}

#[derive(Debug, Deserialize)]
struct Footprint {
    peak_memory_mib: BTreeMap<String, BTreeMap<String, f64>>,
    binary_mb: f64,
    binary_kib_by_crate: Option<BTreeMap<String, f64>>,
    clean_build: Option<Build>,
}

#[derive(Debug, Deserialize)]
struct Build {
    jobs: usize,
    wall_seconds: f64,
    processor_seconds: f64,
    crates: usize,
    slowest_crates_seconds: BTreeMap<String, f64>,
}

/// From the largest.
fn ordered(values: &BTreeMap<String, f64>) -> Vec<(&String, f64)> {
    let mut pairs: Vec<_> = values.iter().map(|(name, value)| (name, *value)).collect();
    pairs.sort_by(|a, b| b.1.total_cmp(&a.1));
    pairs
}

pub(crate) fn footprint() -> Result<Option<Section>> {
    let Some(document) = load::<Document<Footprint>>("footprint")? else { return Ok(None) };
    let found = &document.figures;
    let memory = found.peak_memory_mib.values().flat_map(BTreeMap::values).copied().fold(0.0, f64::max);
    let finding = format!(
        "At commit {} `train` took {memory:.0} MiB of memory, and the binary had {:.1} MB.",
        document.made.commit, found.binary_mb
    );
    let build = found.clean_build.as_ref().map(|b| {
        format!(
            "A build from clean with {} jobs: {:.0} s, {:.0} s of processor time; {} crates. The machine was shared with other work, which processor time leaves out.",
            b.jobs, b.wall_seconds, b.processor_seconds, b.crates
        )
    });
    let points = [
        format!("Peak memory of `train`, the largest of all tasks on one and two threads: {memory:.0} MiB."),
        format!("The binary with default features: {:.1} MB.", found.binary_mb),
    ];
    let row = |(name, value): (&String, f64)| vec![format!("`{name}`"), format!("{value:.0}")];
    let sizes = found.binary_kib_by_crate.as_ref().map(ordered).unwrap_or_default();
    let seconds = found.clean_build.as_ref().map(|b| ordered(&b.slowest_crates_seconds)).unwrap_or_default();
    Ok(Some(Section::new("Footprint", [finding]).with(|page| {
        page.list(points.into_iter().chain(build))
            .table(&["crate", "KiB in the binary"], sizes.into_iter().map(row))
            .table(&["crate", "seconds of the build"], seconds.into_iter().map(row))
            .text(&format!("{}. Names of crates are those of that commit.", origin(&document.made)))
    })))
}
