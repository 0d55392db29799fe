//! Sections on sindyna beside its peers, measured by the program `peers`.

use std::collections::BTreeMap;

use serde::Deserialize;
use sindyna_bench::study::{Document, Result, Spread, load};
use sindyna_core::number::significant;

use crate::section::Section;

/// What was measured beside peers, and with which packages.
#[derive(Debug, Deserialize)]
struct Measured<T> {
    versions: BTreeMap<String, String>,
    #[serde(flatten)]
    figures: T,
}

impl<T> Measured<T> {
    /// Command, commit, day, machine, versions.
    fn origin(document: &Document<Self>) -> String {
        let versions = document.figures.versions.iter().map(|(name, version)| format!("{name} {version}"));
        let versions: Vec<String> = versions.collect();
        format!("{}; {}.", super::ours::origin(&document.made), versions.join(", "))
    }
}

#[derive(Debug, Deserialize)]
struct WholeJob {
    cap_seconds: f64,
    tasks: Vec<Job>,
}

#[derive(Debug, Deserialize)]
struct Job {
    task: String,
    ours: Solved,
    peers: BTreeMap<String, Solved>,
    better_peer: String,
    ratio: Spread,
    ratio_is_at_least: bool,
    parts_of_ours: BTreeMap<String, Spread>,
    updates_of_ours: Spread,
    equal: Equal,
}

/// Seconds until solved; none where more than half of the runs did not solve the task in time.
#[derive(Debug, Deserialize)]
struct Solved {
    #[serde(flatten)]
    seconds: Spread,
    solved: usize,
    runs: usize,
    more_than: Option<f64>,
}

#[derive(Debug, Deserialize)]
struct Equal {
    hidden: [usize; 2],
    batch: usize,
    #[serde(flatten)]
    seconds: Spread,
    ratio: Spread,
    updates: Spread,
}

impl Job {
    fn ratio(&self, ratio: &Spread) -> String {
        let whole = |value: Option<f64>| value.map_or_else(|| "∞".into(), |v| format!("{v:.0}"));
        let least = if self.ratio_is_at_least { "≥ " } else { "" };
        format!("{least}{} ({}–{})", whole(ratio.median), whole(ratio.least), whole(ratio.largest))
    }
}

pub(crate) fn whole_job() -> Result<Option<Section>> {
    let Some(document) = load::<Document<Measured<WholeJob>>>("whole-job")? else { return Ok(None) };
    let WholeJob { cap_seconds, tasks } = &document.figures.figures;
    let peer = |(name, entry): (&String, &Solved)| {
        let seconds = match entry.seconds.median {
            None => format!("> {:.0}", entry.more_than.unwrap_or(*cap_seconds)),
            Some(median) => format!("{median:.1}"),
        };
        format!("{name} {seconds} ({} of {} solved)", entry.solved, entry.runs)
    };
    let row = |t: &Job| {
        let [a, b] = t.equal.hidden;
        vec![
            t.task.clone(),
            t.ours.seconds.shown(3),
            format!("{} of {}", t.ours.solved, t.ours.runs),
            t.peers.iter().map(peer).collect::<Vec<_>>().join("; "),
            t.better_peer.clone(),
            t.ratio(&t.ratio),
            format!("{} ({a}×{b}, {})", t.ratio(&t.equal.ratio), t.equal.batch),
        ]
    };
    let number =
        |spread: Option<&Spread>| spread.and_then(|s| s.median).map_or_else(String::new, |v| significant(v, 3));
    let parts = |t: &Job| {
        let part = |name: &str| number(t.parts_of_ours.get(name));
        let whole = |value: Option<f64>| value.map_or_else(String::new, |v| format!("{v:.0}"));
        let equal = format!("{}, {}", whole(t.equal.updates.median), number(Some(&t.equal.seconds)));
        let own = [part("identify"), part("train"), part("evaluate"), whole(t.updates_of_ours.median), equal];
        [t.task.clone()].into_iter().chain(own).collect()
    };
    let ratios: Vec<String> = tasks.iter().map(|t| format!("{} on {}", t.ratio(&t.ratio), t.task)).collect();
    let finding = format!(
        "From nothing to a policy that solves the task, the better of two pipelines in Python takes as many times as long as sindyna: {}.",
        ratios.join(", ")
    );
    let head =
        ["task", "ours [s]", "solved", "peers [s], median", "better peer", "ratio", "at equal networks and batch"];
    let split = ["task", "identification", "training", "evaluation", "updates", "at equal networks: updates, seconds"];
    Ok(Some(Section::new("The whole job", [finding]).with(|page| {
        page.text("From nothing to a policy that solves the system, one core: a rollout, identification, training in the model.")
            .table(&head, tasks.iter().map(row))
            .text(&format!(
                "Ours is the whole process with an evaluation of 100 real episodes. A peer's seconds leave out imports and real evaluations and end at the first evaluation that \
                 reaches the threshold; it is given up after {cap_seconds:.0} s, which then stands in the ratio (≥). Ratios are of neighbours in time, their median taken over \
                 seeds. Peers have 200 real steps, ours 10. At equal networks all else is ours: learning rate, targets' rate, updates per imagined step, stopping rule. So that last \
                 column is what the kernel and the settings give without smaller networks and batches."
            ))
            .text("Where our seconds go (medians):")
            .table(&split, tasks.iter().map(parts))
            .text(&Measured::origin(&document))
    })))
}

#[derive(Debug, Deserialize)]
struct Updates {
    sizes: Vec<Size>,
}

#[derive(Debug, Deserialize)]
struct Size {
    width: usize,
    mflop_per_update: f64,
    ours_over_sbx: Spread,
    ours_over_sb3: Spread,
    share_of_fastest_products: Shares,
    in_turn_in_one_process: serde_json::Map<String, serde_json::Value>,
}

#[derive(Debug, Deserialize)]
struct Shares {
    median: Spread,
    best: Spread,
}

pub(crate) fn updates() -> Result<Option<Section>> {
    let Some(document) = load::<Document<Measured<Updates>>>("updates")? else { return Ok(None) };
    let sizes = &document.figures.figures.sizes;
    let rows = sizes.iter().flat_map(|size| {
        let share = &size.share_of_fastest_products;
        let lines = [
            ("share of the fastest bare products, by medians", &share.median),
            ("the same by the best window of each", &share.best),
            ("times SBX's scan", &size.ours_over_sbx),
            ("times Stable-Baselines3", &size.ours_over_sb3),
        ];
        lines.map(|(name, measured)| vec![format!("{0}×{0}", size.width), name.into(), measured.shown(3)])
    });
    let mut detail = Vec::new();
    for size in sizes {
        for (name, rate) in &size.in_turn_in_one_process {
            let rate: Spread = serde_json::from_value(rate.clone())?;
            let speed = rate.median.unwrap_or(0.0) * size.mflop_per_update / 1e3;
            let row = vec![format!("{0}×{0}", size.width), name.clone(), rate.shown(4), format!("{speed:.0}")];
            detail.push((size.width, speed, row));
        }
    }
    // The fastest first.
    detail.sort_by(|a, b| a.0.cmp(&b.0).then(b.1.total_cmp(&a.1)));
    let detail = detail.into_iter().map(|(_, _, row)| row);
    let finding = |size: &Size| {
        let times = |spread: &Spread| spread.median.map_or_else(String::new, |v| significant(v, 3));
        format!(
            "An update of SAC with networks of {0}×{0} is {1} times as fast as in SBX and {2} times as fast as in Stable-Baselines3.",
            size.width,
            times(&size.ours_over_sbx),
            times(&size.ours_over_sb3)
        )
    };
    Ok(Some(Section::new("Updates of SAC", sizes.iter().map(finding)).with(|page| {
        page.text("Batch 256, one thread.")
            .table(&["networks", "ours", "median (least–largest)"], rows)
            .text(
                "*Bare products* are the matrix products of one update whose results are used, in the same order and on the same shapes, by other libraries, in turn with whole updates \
                 in one process (`product_ceiling`):",
            )
            .table(&["networks", "what", "per second", "GFLOP/s"], detail)
            .text(
                "MKL chooses slower paths on this maker's processors than on another's; there this table has to be made anew. What an update is besides products, and what was tried: \
                 [notes](notes/2026-11-21-update-kernel.md). Kernels for 64-bit Arm are tested by emulation (`scripts/arm`), and were not timed on such a machine.",
            )
            .text(&Measured::origin(&document))
    })))
}

#[derive(Debug, Deserialize)]
struct Ensembles {
    presets: Vec<Preset>,
}

#[derive(Debug, Deserialize)]
struct Preset {
    preset: String,
    members: usize,
    parameters: usize,
    examples_per_second: BTreeMap<String, Spread>,
    ours_over_torch_plain: Spread,
    ours_over_torch_fused: Spread,
    microseconds_per_imagined_step: Spread,
}

pub(crate) fn ensemble() -> Result<Option<Section>> {
    let Some(document) = load::<Document<Measured<Ensembles>>>("ensemble")? else { return Ok(None) };
    let presets = &document.figures.figures.presets;
    let row = |p: &Preset| {
        let rate = |who: &str| p.examples_per_second.get(who).map_or_else(String::new, |rate| rate.shown(4));
        vec![
            p.preset.clone(),
            p.members.to_string(),
            p.parameters.to_string(),
            rate("ours"),
            rate("torch_plain"),
            rate("torch_fused"),
            p.ours_over_torch_plain.shown(3),
            p.ours_over_torch_fused.shown(3),
            p.microseconds_per_imagined_step.shown(3),
        ]
    };
    let finding = |p: &Preset| {
        let times = p.ours_over_torch_plain.median.map_or_else(String::new, |v| significant(v, 3));
        format!("An ensemble of {} networks (`{}`) trains {times} times as fast as in PyTorch.", p.members, p.preset)
    };
    let head = [
        "preset",
        "networks",
        "parameters",
        "ours [examples/s]",
        "PyTorch [examples/s]",
        "its fused Adam [examples/s]",
        "times PyTorch",
        "times its fused Adam",
        "an imagined step of ours [µs]",
    ];
    Ok(Some(Section::new("Ensembles of networks", presets.iter().map(finding)).with(|page| {
        page.text("Training, batch 256, one thread.")
            .table(&head, presets.iter().map(row))
            .text(
                "PyTorch has all networks in one batched product, and Adam as it comes or fused (`benches/peers/torch_ensemble.py`). An example is a row of one batch, of which every \
                 network sees one of its own.",
            )
            .text(&Measured::origin(&document))
    })))
}

#[derive(Debug, Deserialize)]
struct Steps {
    tasks: Vec<StepsOf>,
}

#[derive(Debug, Deserialize)]
struct StepsOf {
    task: String,
    nanoseconds: BTreeMap<String, Spread>,
    million_steps_per_second: Spread,
    gymnasium_over_ours: Spread,
    pysindy_over_ours: Spread,
    pysindy_of_10000_over_ours_many: Spread,
}

pub(crate) fn model_steps() -> Result<Option<Section>> {
    let Some(document) = load::<Document<Measured<Steps>>>("model-steps")? else { return Ok(None) };
    let tasks = &document.figures.figures.tasks;
    let row = |t: &StepsOf| {
        let ns = |what: &str| t.nanoseconds.get(what).map_or_else(String::new, |spread| spread.shown(3));
        vec![
            t.task.clone(),
            ns("ours_one"),
            ns("ours_many"),
            t.million_steps_per_second.shown(3),
            t.gymnasium_over_ours.shown(3),
            t.pysindy_over_ours.shown(3),
            t.pysindy_of_10000_over_ours_many.shown(3),
        ]
    };
    let finding = tasks.first().map(|t| {
        let number =
            |spread: Option<&Spread>| spread.and_then(|s| s.median).map_or_else(String::new, |v| significant(v, 3));
        format!(
            "A step of the identified {} takes {} ns, {} side by side.",
            t.task,
            number(t.nanoseconds.get("ours_one")),
            number(t.nanoseconds.get("ours_many"))
        )
    });
    let head = [
        "model of",
        "one after the other [ns]",
        "side by side [ns]",
        "million/s side by side",
        "times Gymnasium's step",
        "times PySINDy's predict of one",
        "times its predict of 10,000, per state",
    ];
    Ok(Some(Section::new("Steps of the model", finding).with(|page| {
        page.table(&head, tasks.iter().map(row))
            .text("*Side by side* is a loop of single calls over independent states.")
            .text(&Measured::origin(&document))
    })))
}
