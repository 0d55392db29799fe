//! results/OUT.json and docs/OUT.md.

use serde::{Deserialize, Serialize};
use sindyna_bench::study::{Document, Page, Result, count, median, short};

/// Difference of the steps, as part of their spread, below which equations are exact.
const EXACT: f64 = 1e-4;

/// The result file.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct Figures {
    pub(crate) groups: Vec<Group>,
}

/// One task.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct Group {
    pub(crate) task: String,
    pub(crate) controller: String,
    pub(crate) steps: usize,
    /// Noise of the sensors, as a part of the scales of their channels; none where the real steps were limited.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) noise: Option<f64>,
    pub(crate) runs: Vec<Run>,
}

/// One run.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(crate) struct Run {
    pub(crate) seed: u64,
    /// Why there was none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) refused: Option<String>,
    pub(crate) real_steps: usize,
    /// Whether the record says that the equations leave rounding alone.
    pub(crate) claimed: Option<bool>,
    /// The largest difference of what a step changes of a rate, as part of its spread.
    pub(crate) deviation: Option<f64>,
    pub(crate) returns: Vec<f64>,
    pub(crate) planner: String,
    pub(crate) identify_seconds: f64,
    pub(crate) train_seconds: f64,
    pub(crate) act_seconds: Option<f64>,
    pub(crate) slowest_act_seconds: Option<f64>,
    pub(crate) wall_seconds: f64,
}

impl Run {
    fn is_exact(&self) -> bool {
        self.deviation.is_some_and(|deviation| deviation < EXACT)
    }
}

impl Group {
    fn mean(&self) -> Option<f64> {
        let all: Vec<f64> = self.runs.iter().flat_map(|run| run.returns.iter().copied()).collect();
        (!all.is_empty()).then(|| all.iter().sum::<f64>() / all.len() as f64)
    }

    fn lowest(&self) -> Option<f64> {
        self.runs.iter().flat_map(|run| run.returns.iter().copied()).min_by(f64::total_cmp)
    }

    fn middle(&self, of: impl Fn(&Run) -> Option<f64>) -> Option<f64> {
        median(self.runs.iter().filter_map(of))
    }

    fn most_steps(&self) -> usize {
        self.runs.iter().map(|run| run.real_steps).max().unwrap_or(0)
    }

    fn row(&self) -> Vec<String> {
        let exact = count(&self.runs, Run::is_exact);
        let worst = self.runs.iter().filter_map(|run| run.deviation).max_by(f64::total_cmp);
        let noise = self.noise.map(|noise| vec![short(Some(100.0 * noise))]).unwrap_or_default();
        let rest = vec![
            self.controller.clone(),
            self.steps.to_string(),
            self.most_steps().to_string(),
            format!("{exact} of {}", self.runs.len()),
            short(worst),
            format!("{} ({})", short(self.mean()), short(self.lowest())),
            short(self.middle(|run| Some(run.identify_seconds))),
            short(self.middle(|run| run.act_seconds.map(|s| 1e3 * s))),
            short(self.middle(|run| run.slowest_act_seconds)),
            short(self.middle(|run| Some(run.wall_seconds))),
        ];
        [vec![self.task.replace('_', " ")], noise, rest].concat()
    }
}

/// docs/OUT.md.
pub(crate) fn page(document: &Document<Figures>, stem: &str) -> Result<String> {
    let groups = &document.figures.groups;
    let runs = || groups.iter().flat_map(|group| &group.runs);
    let exact = runs().filter(|run| run.is_exact()).count();
    let wrong = runs().filter(|run| run.claimed == Some(true) && !run.is_exact()).count();
    let is_noisy = groups.iter().any(|group| group.noise.is_some());
    // With noise no equations are exact; adequate is all that a record says.
    let called = if is_noisy {
        format!(
            "In {wrong} runs the record calls equations adequate that are not as near as that, which noise may not allow."
        )
    } else {
        format!("In {wrong} runs the record calls equations exact that are not.")
    };
    let findings = [format!("In {exact} of {} runs the equations are exact.", runs().count()), called];
    let rest = [
        "planner",
        "first real steps",
        "real steps, maximum",
        "exact",
        "deviation, largest",
        "return, mean (lowest)",
        "identification [s]",
        "an action [ms]",
        "the slowest [s]",
        "all [s]",
    ];
    let head = [&["task"][..], if is_noisy { &["noise [%]"] } else { &[] }, &rest].concat();
    let steps = if is_noisy {
        "so many real steps at first, to which it may add, with Gaussian noise of so many percent of the scale of each channel, in the data and in the evaluation, \
         which it is not told; all else default"
    } else {
        "so many real steps, which it may not add to (`--max-real-steps`), all else default"
    };
    Ok(Page::new("Planning on identified equations")
        .list(findings)
        .table(&head, groups.iter().map(Group::row))
        .section("How it was measured")
        .text(&format!(
            "Every run is `sindyna train` of a task file in examples/planning with the given planner and {steps}, on MuJoCo. *Exact*: from 1,000 \
             states and controls (angles within 3 rad, rates within 3, positions within 0.5 m) what a step changes of each rate differs from MuJoCo's own step by less than \
             1e-4 of the standard deviation of that, in every rate and at every place. What no step shows is left out: joints at or beyond their stops, and rates \
             of targets, which stay at rest. *Real steps* count all before the evaluation. Returns are those on MuJoCo, over \
             all episodes of all seeds. Times are medians over the seeds, wall clock, one thread, on a machine that \
             did other work as well."
        ))
        .text(&document.made.origin(stem))
        .markdown())
}
