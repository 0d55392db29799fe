//! What models and training cost.

use sindyna_record::comparison::Digest;

use super::findings::seconds;
use crate::Comparison;
use crate::document::Block;
use crate::groups::Group;
use crate::names::method_name;
use crate::numbers::{fixed, or_none, rough};
use crate::stats::median;

pub(super) fn costs(comparison: &Comparison<'_>) -> Vec<Block> {
    let Comparison { digest, groups, .. } = comparison;
    let row = |group: &Group| {
        let seconds = seconds(comparison, group);
        let count = |value: Option<f64>| or_none(value.map(|v| fixed(v, 0)));
        [
            group.task.clone(),
            method_name(&group.method),
            count(group.parameters_median),
            count(group.updates_median),
            count(group.model_steps_median),
            or_none(median(&seconds).map(rough)),
        ]
    };
    let head = ["task", "method", "parameters of the model", "updates", "steps of the model", "wall-clock time [s]"];
    vec![
        Block::Section("Models and costs".into()),
        Block::text(format!(
            "Medians over seeds. Parameters: coefficients that were fitted and are not zero, or weights of networks. Wall-clock time: \
             a whole run with all its checks on one core, which other programs may have used too, so it shows orders of magnitude only. Added up: {}.",
            totals(digest)
        )),
        Block::table(2, head, groups.iter().map(row).collect()),
    ]
}

/// Real steps beside wall-clock time, for each task.
pub(super) fn against_time(comparison: &Comparison<'_>) -> Vec<Block> {
    let tasks = comparison.digest.tasks();
    let figures: Vec<_> = tasks.into_iter().filter_map(|task| super::findings::costs(comparison, task)).collect();
    if figures.is_empty() {
        return Vec::new();
    }
    vec![
        Block::Section("Real steps and wall-clock time".into()),
        Block::text(
            "Real steps until a run solves its task, and the wall-clock time of the whole run with all its checks on one core. A run of a method that learns on the system \
             ends when it has solved its task, unless the whole budget was asked for. Records have one time for a run, so there is no curve against time.",
        ),
        Block::Figures(figures),
    ]
}

/// The time that all runs of each method took together.
fn totals(digest: &Digest) -> String {
    let hours = |method: &str| {
        let seconds: f64 = digest.times.iter().filter(|t| t.method == method).map(|t| t.wall_seconds).sum();
        format!(
            "{} {}",
            method_name(method),
            if seconds < 3600.0 { format!("{seconds:.0} s") } else { format!("{:.1} h", seconds / 3600.0) }
        )
    };
    digest.methods().into_iter().map(hours).collect::<Vec<_>>().join(", ")
}
